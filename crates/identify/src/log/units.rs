//! Angles in a unit that nobody said: whole numbers, the steps of an encoder in another unit, and motion that
//! is too fast for the rig.

use super::columns::Layout;
use std::f64::consts::TAU;
use twinrotor::plant::presets::Rig;

/// Rows of the shortest piece that a pace is taken over, and how many of its steps are left out of it: a wrap
/// or a wild row is no pace.
const PIECE: [usize; 2] = [12, 4];
/// \[s\] The same in time, where rows lie close.
const PIECE_TIME: f64 = 0.05;
/// Counts a turn of encoders that there are, beside the rig's own.
const COUNTS: [f64; 6] = [2000.0, 2048.0, 2880.0, 4000.0, 4096.0, 8192.0];
/// What a number in a file may be that was taken for rad: its name, and how many of them make a turn.
const UNITS: [(&str, f64, &str); 3] =
    [("deg", 360.0, "degrees"), ("mrad", 1e3 * TAU, "milliradians"), ("turn", 1.0, "turns")];

/// Refuses the angles \[rad\] of one axis, taken at `time` \[s\], that are in another unit than was said;
/// gives what is odd about them.
pub(super) fn check(
    axis: &str,
    angle: &[f64],
    time: &[f64],
    layout: &Layout,
    rig: &Rig,
) -> Result<Vec<String>, String> {
    let (encoder, fastest) = match axis {
        "pitch" => (rig.encoder_counts.pitch, rig.envelope.rate.pitch),
        _ => (rig.encoder_counts.yaw, rig.envelope.rate.yaw),
    };
    let (factor, _) = layout.unit(axis);
    let written = || angle.iter().map(|a| a / factor);
    let (least, most) = written().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let whole = most - least >= 3.0 && written().all(|x| (x - x.round()).abs() < 1e-6);
    let counts = format!("columns {axis}=NAME:counts{encoder}");
    let mut notes = Vec::new();
    match layout.counts(axis) {
        Some(_) if written().any(|x| (x - x.round()).abs() > 1e-3) => {
            return Err(format!(
                "{axis} has fractions of a count; allowed: whole numbers (rad, or another unit? say so: \
                 columns \
                 {axis}=NAME:UNIT)"
            ));
        }
        Some(said) if (said - f64::from(encoder)).abs() > 0.5 => notes
            .push(format!("{axis} is said to have {said} counts a turn, the preset's encoder has {encoder}")),
        Some(_) => {}
        None if whole && (factor - 1.0).abs() < 1e-12 => {
            return Err(format!(
                "{axis} holds whole numbers alone, {least} to {most}: counts of an encoder, not rad; say so: \
                 {counts} (N as your encoder has it; whole degrees would be {axis}=NAME:deg)"
            ));
        }
        None if whole => notes.push(format!(
            "{axis} holds whole numbers alone, {least} to {most}: if these are counts of an encoder, say so: \
             {counts}"
        )),
        None => {}
    }
    if (factor - 1.0).abs() < 1e-12
        && let Some((unit, _, name)) = other_lattice(angle, f64::from(encoder))
    {
        return Err(format!(
            "{axis} moves in steps of a whole part of a turn in {name}, not in rad: {name}; say so: columns \
             {axis}=NAME:{unit}"
        ));
    }
    let pace = fastest_pace(angle, time);
    if pace > fastest {
        return Err(format!(
            "{axis} moves at {pace:.1} rad/s; allowed: the preset's envelope.rate, {fastest} rad/s \
             ({})",
            likely(axis, pace, fastest, whole, encoder)
        ));
    }
    Ok(notes)
}

/// The units in which a motion this fast is one that the rig could make, the likeliest first.
fn likely(axis: &str, pace: f64, fastest: f64, whole: bool, encoder: u32) -> String {
    let mut could: Vec<(String, &str)> = UNITS
        .iter()
        .filter(|(_, turn, _)| *turn > TAU && pace * TAU / turn <= fastest)
        .map(|(unit, _, name)| ((*unit).to_owned(), *name))
        .collect();
    if whole || could.is_empty() {
        could.insert(0, (format!("counts{encoder}"), "counts"));
    }
    let (unit, name) = &could[0];
    let others: Vec<String> = could[1..].iter().map(|(unit, name)| format!(", {name}: {unit}")).collect();
    format!("{name}? say so: columns {axis}=NAME:{unit}{}", others.concat())
}

/// Refuses a pitch beyond `most` \[rad\], with the unit that would bring it within.
pub(super) fn check_pitch(angle: &[f64], most: f64) -> Result<(), String> {
    let reaches = angle.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    if reaches <= most {
        return Ok(());
    }
    let fits = |(_, turn, _): &&(&str, f64, &str)| *turn > TAU && reaches * TAU / turn <= most;
    let hint = UNITS.iter().find(fits).map_or_else(
        || "is it the right column?".to_owned(),
        |(unit, _, name)| format!("{name}? say so: columns pitch=NAME:{unit}"),
    );
    Err(format!("pitch reaches {reaches:.4}; allowed: within ±{most:.2} rad ({hint})"))
}

/// Is every value a whole number of counts in another unit, for an encoder that there is, but not in rad? In
/// degrees of any usual encoder; in the others of the rig's own.
fn other_lattice(values: &[f64], own: f64) -> Option<&'static (&'static str, f64, &'static str)> {
    let first = values.first()?;
    let reach = values.iter().fold(0.0_f64, |most, v| most.max((v - first).abs()));
    let on = |turn: f64, n: f64| {
        let counts = |v: f64| (v - first) * n / turn;
        // Within a step or two everything is a whole number of them.
        counts(first + reach).abs() > 3.0
            && values.iter().all(|v| (counts(*v) - counts(*v).round()).abs() < 0.02)
    };
    let any = |turn: f64| COUNTS.iter().chain([&own]).any(|n| on(turn, *n));
    let found =
        UNITS.iter().find(|(unit, turn, _)| if *unit == "deg" { any(360.0) } else { on(*turn, own) })?;
    (!any(TAU)).then_some(found)
}

/// \[rad/s\] The fastest that an angle moves on, single jumps left out.
fn fastest_pace(angle: &[f64], time: &[f64]) -> f64 {
    let rows = angle.len();
    let usual = time[rows - 1] / (rows - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number of rows")]
    let steps = PIECE[0].max((PIECE_TIME / usual) as usize).min(rows - 1);
    let pace = |first: usize| {
        let mut parts: Vec<[f64; 2]> =
            (first..first + steps).map(|k| [angle[k + 1] - angle[k], time[k + 1] - time[k]]).collect();
        parts.sort_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
        let [moved, took] = parts[..steps.saturating_sub(PIECE[1]).max(1)]
            .iter()
            .fold([0.0, 0.0], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
        moved.abs() / took
    };
    (0..rows - steps).step_by((steps / 2).max(1)).map(pace).fold(0.0, f64::max)
}
