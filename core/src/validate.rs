//! What is wrong with a number, said so that the person at the keyboard can mend it.

use core::fmt;

/// A value that cannot be used: which, what it is, what is allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invalid {
    /// Name of the field as the files spell it, such as `pitch.position`.
    pub field: &'static str,
    /// What was given.
    pub value: f64,
    /// What is allowed, such as `a finite number above 0`.
    pub allowed: &'static str,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}; allowed: {}", self.field, self.value, self.allowed)
    }
}

impl core::error::Error for Invalid {}

/// Requires a finite number above zero.
pub(crate) fn positive(field: &'static str, value: f64) -> Result<(), Invalid> {
    require(field, value, value > 0.0, "a finite number above 0")
}

/// Requires a finite number of at least zero.
pub(crate) fn not_negative(field: &'static str, value: f64) -> Result<(), Invalid> {
    require(field, value, value >= 0.0, "a finite number of at least 0")
}

/// Requires a finite number.
pub(crate) fn finite(field: &'static str, value: f64) -> Result<(), Invalid> {
    require(field, value, true, "a finite number")
}

/// Requires a finite number for which `holds`.
pub(crate) fn require(
    field: &'static str,
    value: f64,
    holds: bool,
    allowed: &'static str,
) -> Result<(), Invalid> {
    if value.is_finite() && holds { Ok(()) } else { Err(Invalid { field, value, allowed }) }
}
