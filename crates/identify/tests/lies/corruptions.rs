//! The ways in which a log is spoilt: each a kind, drawn anew for every seed.

use crate::recording::{DURATION, EVERY, Table, even, record};
use rand::{Rng, RngExt};
use std::f64::consts::{PI, TAU};
use twinrotor::plant::PlantParameters;
use twinrotor_tune::optimise::Draws;

/// Logs that somebody gives, and what is said of their columns.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    /// What was done.
    pub(crate) what: String,
    /// To fit.
    pub(crate) logs: Vec<Table>,
    /// Kept out.
    pub(crate) validate: Vec<Table>,
    /// As `--columns` has it.
    pub(crate) columns: String,
    /// Must the constants be right, unless it is refused? True of what can be mended.
    pub(crate) mendable: bool,
}

type Kind = fn(&PlantParameters<f64>, &mut dyn FnMut(f64, f64) -> f64) -> Case;

/// Every kind.
pub(crate) const KINDS: &[Kind] = &[
    other_unit,
    other_unit,
    other_unit,
    rounded_unit,
    counts,
    declared_counts,
    other_volts,
    other_time,
    epoch,
    one_sign,
    one_sign,
    two_signs,
    swapped,
    same_column,
    wrapped,
    wrapped,
    wrapped_counts,
    wrapped_unit,
    jitter,
    jitter,
    two_rates,
    rounded_times,
    lost_rows,
    gaps,
    outliers,
    outliers,
    two_outliers,
    zeroed,
    twice,
    a_part_again,
    tachometers,
    tachometers,
    repeated_rows,
    second_session,
    named_twice,
];

/// The case of a seed: one kind after the other.
pub(crate) fn draw(plant: &PlantParameters<f64>, index: usize, rng: &mut impl Rng) -> Case {
    KINDS[index % KINDS.len()](plant, &mut |from, to| rng.random_range(from..to))
}

type Draw<'a> = &'a mut dyn FnMut(f64, f64) -> f64;

/// One of several.
fn pick<T: Copy>(draw: Draw<'_>, of: &[T]) -> T {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
    let index = draw(0.0, of.len() as f64) as usize;
    of[index.min(of.len() - 1)]
}

/// With the encoders between the same counts each time: what differs from the good log is what was spoilt.
pub(crate) fn flown(plant: &PlantParameters<f64>, times: &[f64]) -> Table {
    Table { speeds: None, ..with_speeds(plant, times) }
}

fn with_speeds(plant: &PlantParameters<f64>, times: &[f64]) -> Table {
    record(plant, times, &mut Draws::new(17).of_move(1))
}

fn good(plant: &PlantParameters<f64>) -> Table {
    flown(plant, &even())
}

fn case(what: impl Into<String>, table: Table, mendable: bool) -> Case {
    Case { what: what.into(), logs: vec![table], validate: Vec::new(), columns: String::new(), mendable }
}

/// The two angles, as places in a row.
const AXES: [(&str, usize); 2] = [("pitch", 0), ("yaw", 1)];
const UNITS: [(&str, f64); 3] = [("deg", 360.0 / TAU), ("mrad", 1e3), ("turn", 1.0 / TAU)];

fn other_unit(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (axis, unit) = (pick(draw, &[0, 1, 2]), pick(draw, &UNITS));
    for (name, k) in AXES {
        if axis == k || axis == 2 {
            table.rows.iter_mut().for_each(|row| row[k] *= unit.1);
            let _ = name;
        }
    }
    case(format!("angle {axis} in {}", unit.0), table, false)
}

fn rounded_unit(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (axis, unit) = (pick(draw, &[0, 1]), pick(draw, &UNITS));
    let digits = pick(draw, &[1.0, 10.0, 100.0, 1000.0]);
    let digits = if unit.0 == "turn" { 1e3 * digits } else { digits };
    table.rows.iter_mut().for_each(|row| row[axis] = (row[axis] * unit.1 * digits).round() / digits);
    case(format!("angle {axis} in {} to a part in {digits}", unit.0), table, false)
}

fn counts(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (axis, turn) = (pick(draw, &[0, 1]), pick(draw, &[1000.0, 2048.0, 4096.0, 8192.0]));
    table.rows.iter_mut().for_each(|row| row[axis] = (row[axis] * turn / TAU).round());
    case(format!("angle {axis} in counts of {turn}"), table, false)
}

fn declared_counts(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let said = pick(draw, &["deg", "counts1000", "counts8192", "counts4096"]);
    table.rows.iter_mut().for_each(|row| row[1] = (row[1] * 4096.0 / TAU).round());
    let right = said == "counts4096";
    Case {
        columns: format!("yaw=yaw:{said}"),
        ..case(format!("yaw in counts, said to be {said}"), table, right)
    }
}

fn other_volts(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (name, factor) =
        pick(draw, &[("mV", 1e3), ("duty", 1.0 / 24.0), ("percent", 100.0 / 24.0), ("kV", 1e-3)]);
    table.rows.iter_mut().for_each(|row| {
        row[2] *= factor;
        row[3] *= factor;
    });
    case(format!("volts as {name}"), table, false)
}

fn other_time(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (unit, factor) = pick(draw, &[("ms", 1e3), ("us", 1e6), ("ns", 1e9), ("minutes", 1.0 / 60.0)]);
    table.time = table.seconds().iter().map(|t| format!("{}", t * factor)).collect();
    case(format!("time in {unit}"), table, false)
}

fn epoch(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (unit, parts) = pick(draw, &[("s", 0_u32), ("ms", 3), ("us", 6), ("ns", 9)]);
    let ms: Vec<i128> = table.seconds().iter().map(|t| (1e3 * t).round() as i128).collect();
    let since = 1_700_000_000_000_i128;
    table.time = ms
        .iter()
        .map(|t| match parts {
            0 => format!("{}.{:03}", (since + t) / 1000, (since + t) % 1000),
            _ => format!("{}", (since + t) * 10_i128.pow(parts) / 1000),
        })
        .collect();
    Case { columns: format!("t=t:{unit}"), ..case(format!("epoch in {unit}"), table, true) }
}

fn one_sign(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let column = pick(draw, &[0, 1, 2, 3]);
    table.rows.iter_mut().for_each(|row| row[column] = -row[column]);
    case(format!("sign of column {column}"), table, false)
}

fn two_signs(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let [a, b] = pick(draw, &[[2, 3], [0, 1], [0, 2], [1, 3], [0, 3], [1, 2]]);
    table.rows.iter_mut().for_each(|row| (row[a], row[b]) = (-row[a], -row[b]));
    case(format!("signs of columns {a} and {b}"), table, false)
}

fn swapped(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let [a, b] = pick(draw, &[[2, 3], [0, 1], [0, 2], [1, 3]]);
    table.rows.iter_mut().for_each(|row| row.swap(a, b));
    case(format!("columns {a} and {b} swapped"), table, false)
}

fn same_column(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let [a, b] = pick(draw, &[[2, 3], [3, 2], [0, 1]]);
    table.rows.iter_mut().for_each(|row| row[a] = row[b]);
    case(format!("column {b} in the place of {a}"), table, false)
}

fn wrapped(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (bias, low) = (draw(-3.0, 3.0), pick(draw, &[-PI, 0.0]));
    table.rows.iter_mut().for_each(|row| row[1] = (row[1] + bias - low).rem_euclid(TAU) + low);
    if low == 0.0 {
        table.rows.iter_mut().for_each(|row| row[0] = row[0].rem_euclid(TAU));
    }
    case(format!("yaw + {bias:.2} wrapped from {low:.2} rad on"), table, true)
}

fn wrapped_counts(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (begin, of) = (draw(-800.0, 800.0).round(), pick(draw, &[4096.0, 65_536.0]));
    table.rows.iter_mut().for_each(|row| {
        row[1] = ((row[1] * 4096.0 / TAU).round() + begin).rem_euclid(of);
    });
    Case {
        columns: "yaw=yaw:counts4096".to_owned(),
        ..case(format!("counts that wrap at {of}"), table, true)
    }
}

fn wrapped_unit(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (bias, low, said) = (draw(-170.0, 170.0), pick(draw, &[-180.0, 0.0]), pick(draw, &["deg", "rad"]));
    table.rows.iter_mut().for_each(|row| row[1] = (row[1].to_degrees() + bias - low).rem_euclid(360.0) + low);
    let what = format!("yaw in degrees from {low} on, said to be {said}");
    Case { columns: format!("yaw=yaw:{said}"), ..case(what, table, said == "deg") }
}

/// Rows a random step after one another.
fn steps(mut step: impl FnMut(f64) -> f64) -> Vec<f64> {
    let mut times = vec![0.0];
    while let Some(last) = times.last().copied().filter(|last| *last < DURATION) {
        times.push(last + step(last).max(0.001));
    }
    times
}

fn jitter(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let (part, late) = (draw(0.0, 0.9), draw(0.1, 0.9));
    let one_sided = draw(0.0, 1.0) < 0.5;
    let times = steps(|_| {
        let off = if one_sided { f64::from(draw(0.0, 1.0) < late) } else { draw(-1.0, 1.0) };
        EVERY * (1.0 + part * off)
    });
    case(format!("jitter of {part:.2}, one-sided: {one_sided}"), flown(plant, &times), true)
}

fn two_rates(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let (at, factor) = (draw(4.0, 20.0), draw(1.1, 5.0));
    let times = steps(|t| if t < at { EVERY } else { EVERY * factor });
    case(format!("{factor:.1} times the step from {at:.0} s on"), flown(plant, &times), true)
}

fn rounded_times(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let every = pick(draw, &[0.008, 0.011, 0.015, 0.017]);
    let mut table = flown(plant, &steps(|_| every));
    table.time = table.seconds().iter().map(|t| format!("{:.2}", t)).collect();
    case(format!("every {every} s, times to a hundredth"), table, true)
}

fn lost_rows(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let part = draw(0.001, 0.2);
    let mut table = good(plant);
    keep(&mut table, |_| draw(0.0, 1.0) > part);
    case(format!("{:.1} % of the rows lost", 100.0 * part), table, true)
}

fn gaps(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let many = draw(1.0, 6.0).floor();
    let holes: Vec<[f64; 2]> = (0..)
        .take_while(|k| f64::from(*k) < many)
        .map(|_| {
            let from = draw(1.0, DURATION - 2.0);
            [from, from + draw(0.03, 0.6)]
        })
        .collect();
    let times = table.seconds();
    keep(&mut table, |k| !holes.iter().any(|[from, to]| (*from..*to).contains(&times[k])));
    case(format!("{many} gaps"), table, true)
}

fn keep(table: &mut Table, mut kept: impl FnMut(usize) -> bool) {
    let kept: Vec<bool> = (0..table.rows.len()).map(|k| k == 0 || kept(k)).collect();
    let mut at = kept.iter();
    table.time.retain(|_| *at.next().unwrap_or(&true));
    let mut at = kept.iter();
    table.rows.retain(|_| *at.next().unwrap_or(&true));
}

fn row_of(table: &Table, draw: Draw<'_>) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a row")]
    let row = draw(0.0, table.rows.len() as f64) as usize;
    row.min(table.rows.len() - 1)
}

fn outliers(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (axis, size) = (pick(draw, &[0, 1]), pick(draw, &[0.2, 1.0, 6.2, 50.0, -1.0, -300.0, 1e6]));
    let row = row_of(&table, draw);
    table.rows[row][axis] += size;
    case(format!("row {row} of angle {axis} off by {size}"), table, true)
}

fn two_outliers(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let many = draw(2.0, 9.0).floor();
    for _ in 0..u8::MAX {
        let (axis, row) = (pick(draw, &[0, 1]), row_of(&table, draw));
        table.rows[row][axis] = draw(-9.0, 9.0);
        if table.rows.iter().flatten().count() == 0 || draw(0.0, many) < 1.0 {
            break;
        }
    }
    case(format!("about {many} wild rows"), table, true)
}

fn zeroed(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (from, off) = (row_of(&table, draw), draw(0.9, 3.0));
    table.rows.iter_mut().skip(from).for_each(|row| row[1] += off);
    case(format!("yaw zeroed anew at row {from}, by {off:.1} rad"), table, false)
}

fn twice(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let table = good(plant);
    let mut case = case("the same log twice", table.clone(), false);
    if draw(0.0, 1.0) < 0.5 {
        case.logs.push(table);
        case.mendable = true;
    } else {
        case.validate.push(table);
    }
    case
}

fn a_part_again(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let table = good(plant);
    let (from, to) = (draw(0.0, 8.0), draw(12.0, 23.0));
    let mut part = table.clone();
    let times = table.seconds();
    part.time.clear();
    part.rows.clear();
    for (k, time) in times.iter().enumerate().filter(|(_, t)| (from..to).contains(*t)) {
        part.time.push(format!("{:.3}", time - from));
        part.rows.push(table.rows[k]);
    }
    let mut case = case("a part of a log as another", table, false);
    if draw(0.0, 1.0) < 0.5 { &mut case.logs } else { &mut case.validate }.push(part);
    case
}

fn tachometers(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = with_speeds(plant, &even());
    table.header.push_str(",w0,w1");
    let what = pick(draw, &["right", "unsigned", "swapped", "noise", "negated", "dead", "one alone"]);
    for [w0, w1] in table.speeds.iter_mut().flatten() {
        match what {
            "unsigned" => (*w0, *w1) = (w0.abs(), w1.abs()),
            "swapped" => std::mem::swap(w0, w1),
            "noise" => *w0 = draw(-100.0, 100.0),
            "negated" => *w1 = -*w1,
            "dead" => *w1 = 0.0,
            _ => {}
        }
    }
    if what == "one alone" {
        table.header = table.header.replace("w1", "x");
    }
    case(format!("tachometers: {what}"), table, what == "right")
}

fn repeated_rows(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    for _ in 0..20 {
        let row = row_of(&table, draw);
        let (time, values) = (table.time[row].clone(), table.rows[row]);
        table.time.insert(row, time);
        table.rows.insert(row, values);
    }
    case("rows written twice", table, true)
}

fn second_session(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let mut other = good(plant);
    let off = draw(0.0, 0.3);
    other.rows.iter_mut().for_each(|row| row[1] += off);
    table.time.extend(other.time);
    table.rows.extend(other.rows);
    case("a second session appended", table, false)
}

fn named_twice(plant: &PlantParameters<f64>, draw: Draw<'_>) -> Case {
    let mut table = good(plant);
    let (header, columns) = pick(
        draw,
        &[
            ("t,pitch,yaw,v0,v1,yaw,x", ""),
            ("t,pitch,yaw,v0,v1,x,y", "yaw=pitch"),
            ("t,pitch,yaw,v0,v1,a,b", "yaw=a,yaw=b"),
        ],
    );
    table.header = header.to_owned();
    table.speeds = Some(table.rows.iter().map(|row| [row[0], row[1]]).collect());
    Case { columns: columns.to_owned(), ..case("a column named twice", table, false) }
}
