//! Rigs by name or from a file.

use crate::error::{Failure, Outcome, known_name};
use std::fs;
use std::path::Path;
use twinrotor::plant::presets::{self, Rig};

/// A rig and what it is called.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedRig {
    /// The preset's name, or the file's path as given.
    pub name: String,
    /// The machine.
    pub rig: Rig,
}

/// The preset called `name`, or the one in the TOML file of that path (anything that ends in `.toml`).
pub fn load(name: &str) -> Outcome<NamedRig> {
    let rig = if Path::new(name).extension().is_some_and(|e| e == "toml") {
        parse(name, &fs::read_to_string(name).map_err(|e| Failure::reading(Path::new(name), &e))?)?
    } else {
        *known_name("preset", name, &presets::ALL)?
    };
    Ok(NamedRig { name: name.to_owned(), rig })
}

fn parse(path: &str, text: &str) -> Outcome<Rig> {
    let rig: Rig = from_toml(path, text)?;
    rig.validate().map_err(|e| Failure::Input(format!("{path}: {e}")))?;
    Ok(rig)
}

/// Reads a TOML text; what is wrong comes as one line with its place.
pub fn from_toml<T: serde::de::DeserializeOwned>(path: &str, text: &str) -> Outcome<T> {
    toml::from_str(text).map_err(|e| {
        let line = e.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        let message = e.message().replace('\n', "; ");
        Failure::Input(format!("{path}, line {line}: {message}"))
    })
}

/// A rig as a preset file.
pub fn to_toml(rig: &Rig) -> String {
    toml::to_string(rig).expect("a rig is made of tables and numbers")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_survives_its_file() {
        for (name, rig) in presets::ALL {
            assert_eq!(parse(name, &to_toml(&rig)).unwrap(), rig);
        }
    }

    #[test]
    fn a_bad_file_is_told_in_one_line_with_its_field() {
        let good = to_toml(&presets::AERO);
        let cases = [
            (good.replace("mass = 1.075", "mass = -1.0"), "mass is -1; allowed: a finite number above 0"),
            (good.replace("mass = 1.075", "mass = nan"), "mass is NaN"),
            (good.replace("mass = 1.075", "mas = 1.075"), "unknown field `mas`"),
            (good.replace("mass = 1.075", ""), "missing field `mass`"),
            (good.replace("mass = 1.075", "mass = \"heavy\""), "invalid type"),
            ("[[".to_owned(), "line 1"),
        ];
        for (text, expected) in cases {
            let error = parse("mine.toml", &text).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
            assert!(!error.contains('\n') && error.starts_with("mine.toml"), "{error}");
        }
    }

    #[test]
    fn an_unknown_preset_names_the_nearest() {
        let error = load("aero-la").unwrap_err().to_string();
        assert!(error.contains("did you mean 'aero-lab'?"), "{error}");
    }
}
