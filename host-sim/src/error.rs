//! What can go wrong, and the exit status that says so.

use std::fmt;
use std::path::Path;

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
    /// Ctrl-C; the best so far is written. Exit status 130.
    Interrupted,
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

    /// The process's exit status.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Run(_) => 1,
            Self::Input(_) => 2,
            Self::Flight(_) => 3,
            Self::Interrupted => 130,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(message) | Self::Run(message) | Self::Flight(message) => f.write_str(message),
            Self::Interrupted => f.write_str("interrupted; the best so far is kept"),
        }
    }
}

impl std::error::Error for Failure {}

/// The shorthand of this crate.
pub type Outcome<T> = Result<T, Failure>;

/// Picks `name` out of `known`, or says which comes nearest.
pub fn known_name<'a, T>(what: &str, name: &str, known: &'a [(&'a str, T)]) -> Outcome<&'a T> {
    if let Some((_, found)) = known.iter().find(|(n, _)| *n == name) {
        return Ok(found);
    }
    let names: Vec<&str> = known.iter().map(|(n, _)| *n).collect();
    let nearest =
        names.iter().max_by(|a, b| strsim::jaro_winkler(a, name).total_cmp(&strsim::jaro_winkler(b, name)));
    Err(Failure::Input(format!(
        "unknown {what} '{name}'; did you mean '{}'? There are: {}",
        nearest.copied().unwrap_or_default(),
        names.join(", ")
    )))
}

/// Requires a finite number of at least `least` (or above it, with `strictly`).
pub fn at_least(field: &str, value: f64, least: f64, strictly: bool) -> Outcome<f64> {
    if value.is_finite() && (value > least || (!strictly && value >= least)) {
        return Ok(value);
    }
    let relation = if strictly { "above" } else { "of at least" };
    Err(Failure::Input(format!("{field} is {value}; allowed: a finite number {relation} {least}")))
}
