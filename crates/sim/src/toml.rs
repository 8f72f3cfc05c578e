//! TOML texts as values.

use crate::error::{Error, Outcome};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Reads a TOML text that is called `name`.
///
/// # Errors
///
/// What is wrong with it, in one line with its place.
pub fn parse<T: DeserializeOwned>(name: &str, text: &str) -> Outcome<T> {
    toml::from_str(text).map_err(|e| {
        let line = e.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        Error::Unusable(e.message().replace('\n', "; ")).within(format_args!("{name}, line {line}"))
    })
}

/// A value as a TOML text.
///
/// # Panics
///
/// If it is not made of tables and numbers.
pub fn write(value: &impl Serialize) -> String {
    toml::to_string(value).expect("it is made of tables and numbers")
}
