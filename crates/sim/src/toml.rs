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
    let refused = |e: toml::de::Error| {
        let line = e.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        Error::Unusable(e.message().replace('\n', "; ")).within(format_args!("{name}, line {line}"))
    };
    let value = toml::from_str(text).map_err(refused)?;
    // What is read as a pair takes the first two numbers of a longer list, and says nothing of the rest.
    let table: toml::Table = toml::from_str(text).map_err(refused)?;
    // (Matrices are as large as what stands beside them says.)
    let mut lists = table.iter().filter(|(key, _)| *key != crate::state_space::NAME);
    lists.try_for_each(|(key, value)| check_lists(key, value)).map_err(|e| e.within(name))?;
    Ok(value)
}

/// Refuses a list of numbers that are not two: all that files of this project hold are pairs.
fn check_lists(field: &str, value: &toml::Value) -> Outcome<()> {
    match value {
        toml::Value::Table(table) => {
            table.iter().try_for_each(|(key, value)| check_lists(&format!("{field}.{key}"), value))
        }
        toml::Value::Array(list) => {
            let is_number = |v: &toml::Value| v.is_float() || v.is_integer();
            if list.iter().any(is_number) && list.len() != 2 {
                let value = toml::Value::Array(list.clone()).to_string();
                return Err(Error::invalid(field, value, "a list of 2 numbers"));
            }
            let entry = |(k, value): (usize, &toml::Value)| check_lists(&format!("{field}[{k}]"), value);
            list.iter().enumerate().try_for_each(entry)
        }
        _ => Ok(()),
    }
}

/// A value as a TOML text.
///
/// # Panics
///
/// If it is not made of tables and numbers.
pub fn write(value: &impl Serialize) -> String {
    toml::to_string(value).expect("it is made of tables and numbers")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_longer_list_than_is_read_is_refused() {
        #[derive(Debug, serde::Deserialize)]
        struct Window {
            window: [f64; 2],
            #[serde(default)]
            jumps: Vec<[f64; 2]>,
        }
        let good: Window = parse("a.toml", "window = [1, 2]\njumps = [[1, 10], [2, 0], [3, 5]]").unwrap();
        assert_eq!((good.window, good.jumps.len()), ([1.0, 2.0], 3));
        for (text, expected) in [
            ("window = [1, 2, 6, 7]", "a.toml: window is [1, 2, 6, 7]; allowed: a list of 2 numbers"),
            ("window = [1, 2]\njumps = [[1, 10], [2, 0, 4]]", "jumps[1] is [2, 0, 4]"),
        ] {
            let told = parse::<Window>("a.toml", text).unwrap_err().to_string();
            assert!(told.contains(expected), "{told}");
        }
    }
}
