//! What numbers of a scenario file may be, refused with field, value and what is allowed.

use crate::error::{Error, Outcome};

/// Requires a number from the least to the most, both allowed.
pub(super) fn within(field: &str, value: f64, [least, most]: [f64; 2], unit: &str) -> Outcome<()> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(Error::invalid(field, value, format_args!("{least} to {most} {unit}")))
}

/// The same of both numbers of a pair.
pub(super) fn pair(field: &str, values: [f64; 2], range: [f64; 2], unit: &str) -> Outcome<()> {
    values.iter().enumerate().try_for_each(|(k, value)| within(&format!("{field}[{k}]"), *value, range, unit))
}

/// Requires times from and to \[s\], the second after the first, neither beyond `most`.
pub(super) fn window(place: &str, [from, to]: [f64; 2], most: f64) -> Outcome<()> {
    within(&format!("{place}.window[0]"), from, [0.0, most], "s")?;
    if to > from && to <= most {
        return Ok(());
    }
    Err(Error::invalid(
        format_args!("{place}.window[1]"),
        to,
        format_args!("above {from} s, where the window begins, to {most} s"),
    ))
}

/// Are both 0?
pub(super) fn are_zero(values: [f64; 2]) -> bool {
    values.iter().all(|value| value.abs() <= 0.0)
}
