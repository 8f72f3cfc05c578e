//! What is wrong with a number, said so that the person at the keyboard can mend it.

use crate::axes::PerAxis;
use crate::real::Real;
use core::fmt;

/// A value that cannot be used: which, what it is, what is allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invalid<R = f64> {
    /// Name of the field as the files spell it, such as `pitch.position`.
    pub field: &'static str,
    /// What was given.
    pub value: R,
    /// What is allowed, such as `a finite number above 0`.
    pub allowed: &'static str,
}

impl<R: fmt::Display> fmt::Display for Invalid<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}; allowed: {}", self.field, self.value, self.allowed)
    }
}

impl<R: fmt::Debug + fmt::Display> core::error::Error for Invalid<R> {}

// None of these is inlined: a board calls them a hundred times at most, once, and its flash is small.

/// Requires a finite number above zero.
#[inline(never)]
pub(crate) fn positive<R: Real<Mask = bool>>(field: &'static str, value: R) -> Result<(), Invalid<R>> {
    require(field, value, R::zero().lt(value), "a finite number above 0")
}

/// Requires a finite number of at least zero.
#[inline(never)]
pub(crate) fn not_negative<R: Real<Mask = bool>>(field: &'static str, value: R) -> Result<(), Invalid<R>> {
    require(field, value, R::zero().le(value), "a finite number of at least 0")
}

/// Requires a finite number for which `holds`.
#[inline(never)]
pub(crate) fn require<R: Real<Mask = bool>>(
    field: &'static str,
    value: R,
    holds: bool,
    allowed: &'static str,
) -> Result<(), Invalid<R>> {
    if value.is_finite() && holds { Ok(()) } else { Err(Invalid { field, value, allowed }) }
}

/// Requires that `check` holds for both, each under its own name.
#[inline(never)]
pub(crate) fn both<R: Real<Mask = bool>>(
    fields: [&'static str; 2],
    values: PerAxis<R>,
    check: fn(&'static str, R) -> Result<(), Invalid<R>>,
) -> Result<(), Invalid<R>> {
    let [pitch, yaw] = fields;
    check(pitch, values.pitch)?;
    check(yaw, values.yaw)
}
