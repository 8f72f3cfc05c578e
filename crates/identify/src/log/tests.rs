use super::*;
use std::fmt::Write;
use twinrotor::plant::presets::AERO;

/// A run of `rows` rows every 2 ms, with pitch and yaw in counts of the Aero.
fn good(rows: usize) -> Vec<[f64; 5]> {
    let count = std::f64::consts::TAU / 4096.0;
    (0..rows)
        .map(|k| {
            let t = 0.002 * k as f64;
            let volts = if k > rows / 4 { 10.0 } else { 0.0 };
            [t, (0.3 * t.sin() / count).round() * count, (0.5 * t / count).round() * count, volts, -volts]
        })
        .collect()
}

fn csv(rows: &[[f64; 5]]) -> String {
    let mut text = String::from("t,pitch,yaw,v0,v1\n");
    for [t, pitch, yaw, v0, v1] in rows {
        let _ = writeln!(text, "{t},{pitch},{yaw},{v0},{v1}");
    }
    text
}

fn read(text: &str, columns: &str) -> Outcome<Log> {
    Log::read("run.csv", text.as_bytes(), &Columns::parse(columns)?, &AERO)
}

fn refusal(text: &str, columns: &str) -> String {
    let error = read(text, columns).unwrap_err();
    assert!(error.is_input());
    let told = error.to_string();
    assert!(!told.contains('\n'), "{told}");
    told
}

#[test]
fn a_good_log_comes_as_it_is() {
    let rows = good(1000);
    let log = read(&csv(&rows), "").unwrap();
    assert!((log.sample_time - 0.002).abs() < 1e-12 && log.notes.is_empty() && log.stretches.len() == 1);
    assert_eq!(log.angle[700], PerAxis::new(rows[700][1], rows[700][2]));
    assert_eq!(log.volts[700], PerMotor::new(10.0, -10.0));
}

#[test]
fn hostile_files_get_one_line() {
    let rows = good(1000);
    let changed = |index: usize, column: usize, value: f64| {
        let mut rows = rows.clone();
        rows[index][column] = value;
        csv(&rows)
    };
    let column = |column: usize, of: &dyn Fn(f64) -> f64| {
        let mut rows = rows.clone();
        rows.iter_mut().for_each(|r| r[column] = of(r[column]));
        csv(&rows)
    };
    let mut still = rows.clone();
    still.iter_mut().for_each(|r| (r[1], r[2]) = (0.0, 0.0));
    let idle: Vec<[f64; 5]> = rows.iter().map(|r| [r[0], r[1], r[2], 3.0, 0.0]).collect();
    let uneven: Vec<[f64; 5]> =
        rows.iter().enumerate().filter(|(k, _)| k % 40 < 20).map(|(_, r)| *r).collect();
    let good = csv(&rows);
    let cases = [
        (String::new(), "is empty"),
        ("t,pitch,yaw,v0,v1\n".to_owned(), "has 0 rows"),
        (csv(&rows[..1]), "has 1 rows with a time of their own; allowed: at least 20"),
        (changed(500, 1, f64::NAN), "line 502: pitch is 'NaN'; allowed: a finite number"),
        (changed(500, 3, f64::INFINITY), "line 502: v0 is 'inf'"),
        (good.replace("0.5,", "half,"), "t is 'half'"),
        (good.replacen("0.004,", "0.004,7,", 1), "fields"),
        (changed(500, 0, 0.1), "line 502: time runs backwards, from 0.998 s to 0.1 s"),
        (changed(500, 3, 900.0), "line 502: volts of 900"),
        (column(0, &|t| 1e3 * t), "rows are 2 s apart"),
        (column(1, &f64::to_degrees), "degrees; say so: columns pitch=NAME:deg"),
        (column(1, &|p| (p * 4096.0 / std::f64::consts::TAU).round()), "columns pitch=NAME:counts2048"),
        (column(2, &f64::to_degrees), "yaw moves in steps of a whole part of a turn in degrees"),
        (csv(&still), "nothing moves"),
        (csv(&idle), "v0 and v1 are constant"),
        (csv(&uneven), "not sampled evenly"),
        (good.replace("yaw", "psi"), "has no column 'yaw'; it has: t, pitch, psi, v0, v1"),
    ];
    for (text, expected) in cases {
        let told = refusal(&text, "");
        assert!(told.starts_with("run.csv: ") && told.contains(expected), "{told}");
    }
}

#[test]
fn repeated_rows_and_gaps_are_mended_and_told() {
    let mut rows = good(1000);
    rows.insert(300, rows[299]);
    rows.drain(600..650);
    let log = read(&csv(&rows), "").unwrap();
    assert_eq!(log.angle.len(), 950);
    assert_eq!(log.stretches, [0..599, 599..950]);
    assert!(
        log.notes[0].contains("1 rows repeat") && log.notes[1].contains("1 gaps, 0.102 s"),
        "{:?}",
        log.notes
    );
}

#[test]
fn a_locked_axis_is_said() {
    let mut rows = good(1000);
    rows.iter_mut().for_each(|r| r[2] = 0.0);
    let log = read(&csv(&rows), "").unwrap();
    assert_eq!(log.moves(), PerAxis { pitch: true, yaw: false });
    assert!(log.notes[0].contains("yaw never changes: taken as locked"));
}

#[test]
fn names_units_and_signs_can_be_mapped() {
    let rows = good(1000);
    let plain = read(&csv(&rows), "").unwrap();
    let mut text = String::from("\u{feff}stamp,theta,psi,um,ut\n");
    for [t, pitch, yaw, v0, v1] in &rows {
        let counts = (yaw * 4096.0 / std::f64::consts::TAU).round();
        let _ = writeln!(text, "{},{},{counts},{},{v1}", 1e3 * t, -pitch.to_degrees(), 1e3 * v0);
    }
    let mapped = read(&text, "t=stamp:ms,pitch=-theta:deg,yaw=psi:counts4096,v0=um:mV,v1=ut").unwrap();
    for (a, b) in plain.angle.iter().zip(&mapped.angle) {
        assert!((a.pitch - b.pitch).abs() < 1e-12 && (a.yaw - b.yaw).abs() < 1e-12);
    }
    assert_eq!(plain.volts, mapped.volts);
    for (columns, expected) in [
        ("pitch", "has no '='"),
        ("roll=x", "names no column of ours; allowed: t, pitch"),
        ("pitch=theta:feet", "unknown unit; allowed: rad, deg, countsN"),
        ("pitch=-", "names no column of the file"),
    ] {
        assert!(refusal(&text, columns).contains(expected), "{columns}");
    }
}

#[test]
fn a_million_rows_are_read() {
    let rows = good(1_000_000);
    // Yaw goes on for a thousand seconds; pitch stays within bounds.
    assert_eq!(read(&csv(&rows), "").unwrap().angle.len(), 1_000_000);
}

/// `good` with one column through `of`, which gets the row's number and value.
fn spoilt(column: usize, of: impl Fn(usize, f64) -> f64) -> String {
    let mut rows = good(3000);
    rows.iter_mut().enumerate().for_each(|(k, row)| row[column] = of(k, row[column]));
    csv(&rows)
}

#[test]
fn whole_numbers_are_counts_on_both_axes() {
    let turn = std::f64::consts::TAU;
    for counts in [1000.0, 2048.0, 4096.0, 8192.0] {
        for (column, advice) in [(1, "pitch=NAME:counts2048"), (2, "yaw=NAME:counts4096")] {
            let told = refusal(&spoilt(column, |_, a| (a * counts / turn).round()), "");
            assert!(told.contains("counts of an encoder, not rad") && told.contains(advice), "{told}");
        }
    }
    // What was said is checked too: against the numbers and against the preset.
    let counted = spoilt(2, |_, a| (a * 4096.0 / turn).round());
    assert_eq!(read(&counted, "yaw=yaw:counts4096").unwrap().notes, Vec::<String>::new());
    let said = read(&counted, "yaw=yaw:counts8192").unwrap().notes.concat();
    assert!(said.contains("8192 counts a turn, the preset's encoder has 4096"), "{said}");
    assert!(refusal(&csv(&good(1000)), "yaw=yaw:counts4096").contains("fractions of a count"));
}

#[test]
fn angles_that_move_too_fast_are_refused_with_the_likely_unit() {
    let to = |factor: f64, digits: f64| move |_: usize, a: f64| (a * factor * digits).round() / digits;
    let cases = [
        (spoilt(2, to(360.0 / std::f64::consts::TAU, 1e2)), "yaw", "degrees? say so: columns yaw=NAME:deg"),
        (spoilt(2, to(360.0 / std::f64::consts::TAU, 1e1)), "yaw", "degrees? say so: columns yaw=NAME:deg"),
        (
            spoilt(1, to(360.0 / std::f64::consts::TAU, 1e2)),
            "pitch",
            "degrees? say so: columns pitch=NAME:deg",
        ),
        (spoilt(2, to(1e3, 1e1)), "yaw", "milliradians: mrad"),
        (spoilt(2, to(1e3, 1e12)), "yaw", "milliradians: mrad"),
        (spoilt(2, to(1.0 / std::f64::consts::TAU, 1e12)), "yaw", "turns; say so: columns yaw=NAME:turn"),
    ];
    for (text, axis, advice) in cases {
        let told = refusal(&text, "");
        assert!(told.contains(axis) && told.contains(advice), "{told}");
    }
    assert!(read(&spoilt(2, to(1e3, 1e12)), "yaw=yaw:mrad").is_ok());
}

#[test]
fn wrapped_angles_are_unwrapped_and_told() {
    use std::f64::consts::{PI, TAU};
    let plain = read(&csv(&good(3000)), "").unwrap();
    let turned = |log: &Log, k: usize| log.angle[k].yaw - log.angle[0].yaw;
    let cases = [
        (spoilt(2, |_, a| (a + 2.0 + PI).rem_euclid(TAU) - PI), "yaw=yaw", "yaw wraps at 6.2832 rad"),
        (spoilt(2, |_, a| (a + 6.0).rem_euclid(TAU)), "yaw=yaw", "yaw wraps at 6.2832 rad"),
        (spoilt(2, |_, a| (a.to_degrees() + 250.0).rem_euclid(360.0) - 180.0), "yaw=yaw:deg", "yaw wraps"),
        (spoilt(2, |_, a| (a * 4096.0 / TAU).round().rem_euclid(1000.0)), "yaw=yaw:counts4096", ""),
        (
            spoilt(2, |_, a| ((a * 4096.0 / TAU).round() + 65_000.0).rem_euclid(65_536.0)),
            "yaw=yaw:counts4096",
            "yaw wraps at 100.5310 rad",
        ),
        (spoilt(1, |_, a| a.rem_euclid(TAU)), "yaw=yaw", "pitch wraps at 6.2832 rad"),
    ];
    for (text, columns, expected) in cases {
        if expected.is_empty() {
            assert!(refusal(&text, columns).contains("yaw jumps by"));
            continue;
        }
        let log = read(&text, columns).unwrap();
        assert!(log.notes.iter().any(|note| note.contains(expected)), "{expected}: {:?}", log.notes);
        for k in 0..3000 {
            assert!((turned(&log, k) - turned(&plain, k)).abs() < 1e-6);
            assert!((log.angle[k].pitch - plain.angle[k].pitch).abs() < 1e-6);
        }
    }
}

#[test]
fn wild_rows_are_taken_from_their_neighbours_and_told() {
    let plain = read(&csv(&good(3000)), "").unwrap();
    for (column, row, size) in [(2, 1200, 50.0), (1, 1200, -7.0), (2, 0, 4.0), (2, 2999, 1e6)] {
        let log = read(&spoilt(column, |k, a| if k == row { a + size } else { a }), "").unwrap();
        assert!(log.notes.len() == 1 && log.notes[0].contains("such rows are taken"), "{:?}", log.notes);
        let off = log.angle[row].minus(plain.angle[row]);
        assert!(off.pitch.abs() < 0.01 && off.yaw.abs() < 0.01, "{off:?}");
    }
    let told = refusal(&spoilt(2, |k, a| if k > 1200 { a + 2.0 } else { a }), "");
    assert!(told.contains("yaw jumps by 2.00") && told.contains("at 2.402 s and stays there"), "{told}");
}

/// Rows of a slow sine of yaw at these times, volts that switch once.
fn at(times: &[f64]) -> String {
    let row = |t: &f64| [*t, 0.2 * t.sin(), 0.7 * (0.8 * t).sin(), if *t < 5.0 { 10.0 } else { -6.0 }, 3.0];
    csv(&times.iter().map(row).collect::<Vec<_>>())
}

#[test]
fn every_row_has_its_own_time() {
    let run = |mut step: Box<dyn FnMut(usize) -> f64>| {
        let mut times = vec![0.0];
        while times.len() < 1500 {
            times.push(times[times.len() - 1] + step(times.len()));
        }
        times
    };
    let cases: [(Vec<f64>, bool); 5] = [
        (run(Box::new(|_| 0.01)), false),
        (run(Box::new(|k| if k * 7919 % 10 < 6 { 0.010 } else { 0.014 })), true),
        (run(Box::new(|k| if k < 700 { 0.010 } else { 0.014 })), true),
        (run(Box::new(|k| 0.008 + 0.001 * (k * 31 % 5) as f64)), true),
        (run(Box::new(|k| if k % 16 == 0 { 0.011 } else { 0.010 })), true),
    ];
    for (times, uneven) in cases {
        let log = read(&at(&times), "").unwrap();
        assert_eq!(log.notes.iter().any(|n| n.contains("resampled every")), uneven, "{:?}", log.notes);
        assert!((log.duration() - times[times.len() - 1]).abs() < log.sample_time, "{}", log.duration());
        for (k, (time, angle)) in log.time.iter().zip(&log.angle).enumerate() {
            assert!((time - k as f64 * log.sample_time).abs() < 1e-6);
            assert!((angle.yaw - 0.7 * (0.8 * time).sin()).abs() < 1e-4);
        }
        // What the volts give in all, which rotors turn into motion, stays.
        let given: f64 = log.volts.iter().map(|v| v.main * log.sample_time).sum();
        let held = |t: &[f64]| (t[1] - t[0]) * if t[0] < 5.0 { 10.0 } else { -6.0 };
        let sent: f64 = times.windows(2).map(held).sum();
        assert!((given - sent).abs() < 0.2, "{given} {sent}");
    }
}

#[test]
fn times_since_1970_and_in_other_units_are_read_or_named() {
    let rows = good(1000);
    let with = |time: &dyn Fn(i64) -> String| {
        let mut text = String::from("t,pitch,yaw,v0,v1\n");
        for (k, [_, pitch, yaw, v0, v1]) in (0..).zip(&rows) {
            let _ = writeln!(text, "{},{pitch},{yaw},{v0},{v1}", time(k));
        }
        text
    };
    let since = 1_700_000_000_i64;
    let cases = [
        (with(&|k| format!("{}.{:03}", since + 2 * k / 1000, 2 * k % 1000)), "s"),
        (with(&|k| format!("{}", 1000 * since + 2 * k)), "ms"),
        (with(&|k| format!("{}", 1_000_000 * since + 2000 * k)), "us"),
        (with(&|k| format!("{}", 1_000_000_000 * since + 2_000_000 * k)), "ns"),
    ];
    for (text, unit) in &cases {
        let log = read(text, &format!("t=t:{unit}")).unwrap();
        assert!((log.sample_time - 0.002).abs() < 1e-15 && log.notes.is_empty(), "{unit} {log:?}");
        assert!((log.duration() - 1.998).abs() < 1e-9, "{unit} {}", log.duration());
        if *unit != "s" {
            assert!(refusal(text, "").contains(&format!("columns t=NAME:{unit}")), "{}", refusal(text, ""));
        }
    }
}

#[test]
fn columns_named_twice_or_without_their_partner_are_said() {
    let good = csv(&good(1000));
    for (text, columns, expected) in [
        (good.replace("v1\n", "v1,yaw\n").replace("0\n", "0,1\n"), "", "has 2 columns called 'yaw'"),
        (good.clone(), "yaw=pitch", "'pitch' would be both pitch and yaw"),
        (good.clone(), "yaw=a,yaw=b", "names yaw a second time"),
        (good.clone(), "v0=v1", "'v1' would be both v0 and v1"),
    ] {
        let told = refusal(&text, columns);
        assert!(told.contains(expected), "{told}");
    }
    let alone = good.replace("v1\n", "v1,w0,ref_yaw\n").replace("0\n", "0,1,2\n");
    let log = read(&alone, "").unwrap();
    assert!(log.rotor_speed.is_none() && log.notes[0].contains("w0 is there without w1"), "{:?}", log.notes);
    assert!(log.notes[1].contains("ref_yaw is there without ref_pitch"), "{:?}", log.notes);
}

#[test]
fn volts_in_another_unit_are_refused_or_told() {
    let volts = |factor: f64| {
        let mut rows = good(1000);
        rows.iter_mut().for_each(|r| (r[3], r[4]) = (r[3] * factor, r[4] * factor));
        csv(&rows)
    };
    assert!(refusal(&volts(1e3), "").contains("columns v0=NAME:mV"));
    assert!(refusal(&volts(4.0), "").contains("v0 reaches 40 V; allowed: the preset's limit of 24 V"));
    let told = read(&volts(1.0 / 24.0), "").unwrap().notes.concat();
    assert!(told.contains("duty cycles, say so: columns v0=NAME:duty24"), "{told}");
    let log = read(&volts(1.0 / 24.0), "v0=v0:duty24,v1=v1:duty24").unwrap();
    assert!((log.volts[900].main - 10.0).abs() < 1e-9 && log.notes.is_empty());
}

#[test]
fn rows_that_two_logs_share_are_found() {
    // Random steps, so that no two pieces are alike.
    let text = spoilt(1, |k, _| 0.0001 * (k * k * 7919 % 97) as f64);
    let (log, mut part) = (read(&text, "").unwrap(), read(&text, "").unwrap());
    assert!(log.shared_with(&log) > 0.99);
    part.angle.drain(..1000);
    part.volts.drain(..1000);
    assert!(part.shared_with(&log) > 0.99);
    assert_eq!(read(&csv(&good(3000)), "").unwrap().shared_with(&log), 0.0);
}
