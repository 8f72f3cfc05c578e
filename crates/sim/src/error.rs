//! What can go wrong, said so that whoever asked can mend it: which field, what its value is, what is
//! allowed. Flags, files and exit status are the business of the program that asks.

use std::fmt;
use twinrotor::settings::LARGEST;
use twinrotor::validate::Invalid;

/// Why something could not be done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Error {
    /// A value that is not allowed.
    Invalid {
        /// Which, as files and programs spell it.
        field: String,
        /// What was given.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// A name that is none of those there are.
    Unknown {
        /// What it should name.
        field: String,
        /// What was given.
        value: String,
        /// The name that is most like it.
        nearest: String,
        /// All that there are.
        known: Vec<String>,
    },
    /// Something given that is of no use as a whole, and why.
    Unusable(String),
    /// The computation itself came to no end, and why.
    Failed(String),
    /// The same, in a file or another text.
    In {
        /// Which, and the line if it is known.
        place: String,
        /// What is wrong there.
        error: Box<Self>,
    },
}

/// The shorthand of this crate and of those that build on it.
pub type Outcome<T> = Result<T, Error>;

/// A number with more digits than this is told by its exponent.
const MOST_DIGITS: usize = 22;

impl Error {
    /// A value that is not allowed.
    pub fn invalid(field: impl fmt::Display, value: impl fmt::Display, allowed: impl fmt::Display) -> Self {
        let mut value = value.to_string();
        // All digits of a number such as 1e300 would fill the screen.
        if value.len() > MOST_DIGITS
            && let Ok(number) = value.parse::<f64>()
        {
            value = format!("{number:e}");
        }
        Self::Invalid { field: field.to_string(), value, allowed: allowed.to_string() }
    }

    /// The same, found at `place`.
    #[must_use]
    pub fn within(self, place: impl fmt::Display) -> Self {
        Self::In { place: place.to_string(), error: Box::new(self) }
    }

    /// Is it what was given that is wrong, and not the run?
    pub fn is_input(&self) -> bool {
        match self {
            Self::Failed(_) => false,
            Self::In { error, .. } => error.is_input(),
            Self::Invalid { .. } | Self::Unknown { .. } | Self::Unusable(_) => true,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid { field, value, allowed } => write!(f, "{field} is {value}; allowed: {allowed}"),
            Self::Unknown { field, value, nearest, known } => write!(
                f,
                "unknown {field} '{value}'; did you mean '{nearest}'? There are: {}",
                known.join(", ")
            ),
            Self::Unusable(why) | Self::Failed(why) => f.write_str(why),
            Self::In { place, error } => write!(f, "{place}: {error}"),
        }
    }
}

impl std::error::Error for Error {}

impl<R: fmt::Display> From<Invalid<R>> for Error {
    fn from(invalid: Invalid<R>) -> Self {
        Self::invalid(invalid.field, invalid.value, invalid.allowed)
    }
}

/// Picks `name` out of `known`.
///
/// # Errors
///
/// If it is not there, with the one that comes nearest.
pub fn known_name<'a, T>(field: &str, name: &str, known: &'a [(&'a str, T)]) -> Outcome<&'a T> {
    if let Some((_, found)) = known.iter().find(|(n, _)| *n == name) {
        return Ok(found);
    }
    let names = known.iter().map(|(n, _)| *n);
    let nearest = names
        .clone()
        .max_by(|a, b| strsim::jaro_winkler(a, name).total_cmp(&strsim::jaro_winkler(b, name)))
        .unwrap_or_default();
    Err(Error::Unknown {
        field: field.to_owned(),
        value: name.to_owned(),
        nearest: nearest.to_owned(),
        known: names.map(str::to_owned).collect(),
    })
}

/// Requires a finite number of at least `least` (or above it, with `strictly`), and of a size that single
/// precision can reckon with ([`LARGEST`]).
///
/// # Errors
///
/// If it is not.
pub fn at_least(field: &str, value: f64, least: f64, strictly: bool) -> Outcome<f64> {
    if value.is_finite() && value.abs() > LARGEST {
        return Err(Error::invalid(field, value, format_args!("at most {LARGEST:e} in size")));
    }
    if value.is_finite() && (value > least || (!strictly && value >= least)) {
        return Ok(value);
    }
    let relation = if strictly { "above" } else { "of at least" };
    Err(Error::invalid(field, value, format_args!("a finite number {relation} {least}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_field_value_and_what_is_allowed() {
        let told = at_least("range", 0.5, 1.0, true).unwrap_err().within("mine.toml");
        assert_eq!(told.to_string(), "mine.toml: range is 0.5; allowed: a finite number above 1");
        assert!(told.is_input() && !Error::Failed("diverged".into()).within("x").is_input());
    }

    /// What f64 holds and the board's f32 does not, and digits that nobody reads.
    #[test]
    fn numbers_beyond_single_precision_are_refused_in_few_digits() {
        for value in [1e300, -1e300, f64::MAX, 4e38] {
            let told = at_least("angle", value, f64::MIN, false).unwrap_err().to_string();
            assert!(told.contains("allowed: at most 1e9 in size") && told.len() < 80, "{told}");
        }
        let told = at_least("duration", 1e-320, 1.0, false).unwrap_err().to_string();
        assert!(told.len() < 80 && told.contains("e-320"), "{told}");
        assert_eq!(at_least("angle", -35_000.0, f64::MIN, false), Ok(-35_000.0));
    }

    #[test]
    fn an_unknown_name_comes_with_its_nearest() {
        let told = known_name("preset", "aero-la", &[("aero", 1), ("aero-lab", 2)]).unwrap_err().to_string();
        assert_eq!(told, "unknown preset 'aero-la'; did you mean 'aero-lab'? There are: aero, aero-lab");
    }
}
