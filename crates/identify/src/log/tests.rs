use super::*;
use std::fmt::Write;

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
    Log::read("run.csv", text.as_bytes(), &Columns::parse(columns)?)
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
        rows.iter().enumerate().filter(|(k, _)| k % 7 != 3).map(|(_, r)| *r).collect();
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
        (column(1, &f64::to_degrees), "degrees? say so: columns pitch=NAME:deg"),
        (column(1, &|p| (p * 4096.0 / std::f64::consts::TAU).round()), "columns pitch=NAME:counts2048"),
        (column(2, &f64::to_degrees), "yaw moves in steps of a whole part of 360"),
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

#[test]
fn volts_beyond_the_rigs_are_refused() {
    let log = read(&csv(&good(1000)), "").unwrap();
    let told = log.check_volts(PerMotor::new(9.0, 24.0)).unwrap_err().to_string();
    assert!(told.contains("v0 reaches 10 V; allowed: the preset's limit of 9 V"), "{told}");
}
