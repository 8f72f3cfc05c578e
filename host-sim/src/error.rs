//! Why a command ended without what was asked of it, and the exit status that says so.

use std::fmt;
use std::path::Path;
use twinrotor_identify::log::COLUMNS;
use twinrotor_sim::Error;

/// Why a command ended without what was asked of it.
#[derive(Debug)]
pub enum Failure {
    /// What the user gave cannot be used: one line that names the field, the value and what is allowed. Exit
    /// status 2.
    Input(String),
    /// The run itself failed: disk full, board not answering. Exit status 1.
    Run(String),
    /// The flight left the envelope or a fault stopped it; what was flown is reported. Exit status 3.
    Flight(String),
    /// A signal asked to stop: what is kept. Exit status 130.
    Interrupted(String),
}

impl Failure {
    /// Bad input, in one line.
    pub fn input(message: impl fmt::Display) -> Self {
        Self::Input(message.to_string())
    }

    /// A file that cannot be read because of what the user named.
    pub fn reading(path: &Path, error: &std::io::Error) -> Self {
        Self::Input(format!("{}: cannot be read: {error}", path.display()))
    }

    /// What a library says of a value that came by a flag: the field is the flag.
    pub fn of_flag(error: Error) -> Self {
        let flag = |field: &str| format!("--{}", field.replace('_', "-"));
        Self::from(match error {
            Error::Invalid { field, value, allowed } => {
                // What follows the flag's own name says which part of it.
                let (name, rest) = field.split_at(field.find([' ', '.']).unwrap_or(field.len()));
                Error::Invalid { field: flag(name) + rest, value, allowed }
            }
            Error::In { place, error } => Error::In { place: flag(&place), error },
            Error::Unknown { field, value, nearest, known } => {
                Error::Unknown { field: flag(&field), value, nearest, known }
            }
            other => other,
        })
    }

    /// The process's exit status.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Run(_) => 1,
            Self::Input(_) => 2,
            Self::Flight(_) => 3,
            Self::Interrupted(_) => crate::stop::STATUS,
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let message = as_typed(&error.to_string());
        if error.is_input() { Self::Input(message) } else { Self::Run(message) }
    }
}

/// What a library advises about a log's columns and constants, as it is typed here: there they are fields,
/// here flags.
pub fn as_typed(advice: &str) -> String {
    let advice = advice.replace("(free it", "(--free it");
    COLUMNS.iter().fold(advice, |told, (column, ..)| {
        let field = format!(" columns {column}=");
        told.replace(&field, &format!(" --{}", field.trim_start()))
    })
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(message) | Self::Run(message) | Self::Flight(message) => f.write_str(message),
            Self::Interrupted(kept) => write!(f, "interrupted; {kept}"),
        }
    }
}

impl std::error::Error for Failure {}

/// The shorthand of this crate.
pub type Outcome<T> = Result<T, Failure>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_librarys_field_becomes_the_flag_that_set_it() {
        let told = |field: &str| Failure::of_flag(Error::invalid(field, "x", "y")).to_string();
        assert_eq!(told("at_most"), "--at-most is x; allowed: y");
        assert_eq!(told("at_most failures"), "--at-most failures is x; allowed: y");
        assert_eq!(Failure::of_flag(Error::Failed("no".into())).exit_status(), 1);
        let advice = Error::Unusable("degrees; say so: columns yaw=NAME:deg".into());
        assert_eq!(Failure::from(advice).to_string(), "degrees; say so: --columns yaw=NAME:deg");
    }
}
