//! Rigs by name or from a file.

use crate::error::{Error, Outcome, known_name};
use crate::{Read, is_text, toml};
use twinrotor::plant::presets::{self, Rig};

/// A rig and what it is called.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedRig {
    /// The preset's name, or the file's path as given.
    pub name: String,
    /// The machine.
    pub rig: Rig,
}

/// The preset called `name`, or the one in the text of that name ([`is_text`]).
///
/// # Errors
///
/// If there is none, or the text is not one of a rig that could be.
pub fn load(name: &str, read: Read<'_>) -> Outcome<NamedRig> {
    let rig =
        if is_text(name) { parse(name, &read(name)?)? } else { *known_name("preset", name, &presets::ALL)? };
    Ok(NamedRig { name: name.to_owned(), rig })
}

/// A rig from the text of a preset file, called `name` in what is said of it.
///
/// # Errors
///
/// If it is not one of a rig that could be.
pub fn parse(name: &str, text: &str) -> Outcome<Rig> {
    let rig: Rig = toml::parse(name, text)?;
    rig.validate().map_err(|e| Error::from(e).within(name))?;
    Ok(rig)
}

/// A rig as a preset file.
pub fn to_toml(rig: &Rig) -> String {
    toml::write(rig)
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

    /// The board's, since there are boards; the files stay good.
    #[test]
    fn a_file_with_the_steps_of_a_pwm_is_read() {
        let former = |steps: &str| format!("pwm_steps = {steps}\n{}", to_toml(&presets::AERO));
        assert_eq!(parse("mine.toml", &former("2100")).unwrap(), presets::AERO);
        let error = parse("mine.toml", &former("0")).unwrap_err().to_string();
        assert!(error.contains("pwm_steps is 0; allowed: 16 to 65535"), "{error}");
    }

    #[test]
    fn a_bad_file_is_told_in_one_line_with_its_field() {
        let good = to_toml(&presets::AERO);
        let cases = [
            (good.replace("mass = 1.075", "mass = -1.0"), "mass is -1; allowed: 0.001 to 100.0 kg"),
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
        let error = load("aero-la", &|_| panic!("a name, no file")).unwrap_err().to_string();
        assert!(error.contains("did you mean 'aero-lab'?"), "{error}");
    }
}
