//! A controller's settings as data: one declaration of each gives the structure, its way through `map` and
//! `validate`, and a table of name, unit, range, default and meaning that programs can go through.
//!
//! - `settings!` declares a structure of numbers, `table!` the table alone, `choice!` an enum of kinds
//!   each of which has a table of its own.
//! - [`ControllerSettings::visit`](crate::controller::ControllerSettings::visit), `get` and `set` go through
//!   a controller by name; its [`CHOICES`](crate::controller::CHOICES) and
//!   [`PARTS`](crate::controller::PARTS) are all there is to choose from.
//!
//! Names are those of a gains file without the kind of a choice: `pitch.position`, `estimator.bandwidth.yaw`,
//! `filter.damping.pitch`. Each name means the same number whichever kind it belongs to.

#[macro_use]
mod declare;
mod leaves;
#[cfg(test)]
mod tests;
pub use leaves::{Build, Fixed, Leaves};

use crate::axes::PerAxis;
use crate::real::Real;
use crate::validate::Invalid;

/// One number of a controller that a person may choose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// As gains files spell it, without the kind of a choice: `estimator.bandwidth.yaw`.
    pub name: &'static str,
    /// SI, `-` for a ratio.
    pub unit: &'static str,
    /// What is allowed.
    pub range: Range,
    /// What a slider may offer, both ends within the range: most rigs' good values lie here.
    pub typical: [f64; 2],
    /// What a new controller begins with, or what leaving the field out means. A start, not a tuned value:
    /// those of the presets are in [`crate::defaults`].
    pub default: f64,
    /// What it is, in one line.
    pub doc: &'static str,
}

/// What a number may be. All of them are finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Any number.
    Finite,
    /// Zero and above.
    AtLeastZero,
    /// Above zero.
    AboveZero,
    /// Within two bounds.
    Between(&'static Interval),
    /// A choice of two: 0 for no, 1 for yes.
    Switch,
}

/// Most that any number of a controller may be, either way: beyond it products of a few of them leave single
/// precision, and a law's demand would be no number.
pub const LARGEST: f64 = 1e9;

/// Two bounds, both allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The lower.
    pub least: f64,
    /// The upper.
    pub most: f64,
    /// Both in words, such as `0.1 to 10`.
    pub text: &'static str,
    /// Both in tenths: a board, which has no arithmetic of `f64`, makes them from integers.
    tenths: [i32; 2],
}

impl Interval {
    /// Bounds that are whole tenths.
    #[expect(clippy::cast_possible_truncation, reason = "anything but whole tenths does not compile")]
    #[expect(clippy::float_cmp, reason = "the bounds are to be met exactly")]
    pub(crate) const fn new(least: f64, most: f64, text: &'static str) -> Self {
        let tenths = [(least * 10.0) as i32, (most * 10.0) as i32];
        let [low, high] = tenths;
        assert!(low as f64 / 10.0 == least && high as f64 / 10.0 == most);
        Self { least, most, text, tenths }
    }

    fn bounds<R: Real>(&self) -> [R; 2] {
        self.tenths.map(|tenths| R::from_i32(tenths) / R::from_i32(10))
    }
}

impl Range {
    /// The lower bound; minus infinity where there is none.
    pub const fn least(&self) -> f64 {
        match self {
            Self::Finite => f64::NEG_INFINITY,
            Self::AtLeastZero | Self::AboveZero | Self::Switch => 0.0,
            Self::Between(interval) => interval.least,
        }
    }

    /// The upper bound; infinity where there is none.
    pub const fn most(&self) -> f64 {
        match self {
            Self::Finite | Self::AtLeastZero | Self::AboveZero => f64::INFINITY,
            Self::Between(interval) => interval.most,
            Self::Switch => 1.0,
        }
    }

    /// In words, for an error or a table.
    pub const fn allowed(&self) -> &'static str {
        match self {
            Self::Finite => "a finite number",
            Self::AtLeastZero => "a finite number of at least 0",
            Self::AboveZero => "a finite number above 0",
            Self::Between(interval) => interval.text,
            Self::Switch => "0 or 1",
        }
    }

    /// Is `value` within it?
    #[inline(never)]
    pub fn allows<R: Real<Mask = bool>>(&self, value: R) -> bool {
        let zero = R::zero();
        is_small(value)
            && match self {
                Self::Finite => true,
                Self::AtLeastZero => zero.le(value),
                Self::AboveZero => zero.lt(value),
                Self::Between(interval) => {
                    let [least, most] = interval.bounds::<R>();
                    least.le(value) && value.le(most)
                }
                Self::Switch => value == zero || value == R::one(),
            }
    }
}

/// What validation needs of a [`Field`]: a board, whose flash is small, holds no more of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// See [`Field::name`].
    pub name: &'static str,
    /// See [`Field::range`].
    pub range: Range,
}

/// Whatever has a table: its fields in the order of its numbers, those of pitch before those of yaw.
pub trait Table {
    /// All of it.
    const FIELDS: &'static [Field];
    /// The same for validation.
    const RULES: &'static [Rule];
}

impl<T: Table> Table for PerAxis<T> {
    const FIELDS: &'static [Field] = T::FIELDS;
    const RULES: &'static [Rule] = T::RULES;
}

impl Table for () {
    const FIELDS: &'static [Field] = &[];
    const RULES: &'static [Rule] = &[];
}

/// One kind of a choice, such as a law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kind {
    /// As gains files spell it.
    pub name: &'static str,
    /// What it is, in one line.
    pub doc: &'static str,
    /// Its numbers.
    pub fields: &'static [Field],
}

/// Each of `values` through `f`, with its field, in the order of the table.
pub fn change<R: Real, T: Leaves<R>>(
    values: &mut T,
    fields: &'static [Field],
    f: &mut impl FnMut(&'static Field, R) -> R,
) {
    values.change(0, &mut |index, value| match fields.get(index) {
        Some(field) => f(field, value),
        None => value,
    });
}

/// Requires that every one of `values` keeps its rule.
///
/// # Errors
/// Names the first field that does not.
pub fn check<R: Real<Mask = bool>, T: Leaves<R>>(
    values: &T,
    rules: &'static [Rule],
) -> Result<(), Invalid<R>> {
    let mut outcome = Ok(());
    let mut copy = *values;
    copy.change(0, &mut |index, value| {
        judge(rules, index, value, &mut outcome);
        value
    });
    outcome
}

fn is_small<R: Real<Mask = bool>>(value: R) -> bool {
    value.is_finite() && value.abs().le(R::from_f64(LARGEST))
}

#[inline(never)]
fn judge<R: Real<Mask = bool>>(
    rules: &'static [Rule],
    index: usize,
    value: R,
    outcome: &mut Result<(), Invalid<R>>,
) {
    if let (Ok(()), Some(Rule { name, range })) = (&outcome, rules.get(index))
        && !range.allows(value)
    {
        let too_large = value.is_finite() && !is_small(value);
        let allowed = if too_large { "at most 1e9 in size" } else { range.allowed() };
        *outcome = Err(Invalid { field: name, value, allowed });
    }
}

/// The values that a table begins with.
pub(crate) fn defaults<R: Real, T: Build<R>>(fields: &'static [Field]) -> T {
    T::build(0, &mut |index| fields.get(index).map_or(R::zero(), |field| R::from_f64(field.default))).0
}
