//! Searches as bytes, so that they can be resumed.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt::{Display, Write};
use twinrotor_sim::{Error, Outcome};

/// First bytes of a checkpoint.
const MAGIC: &[u8] = b"twinrotor checkpoint 3\n";
/// Characters of a value that are told of a run that differs.
const MOST_CHARACTERS: usize = 60;

/// What a run is: everything that decides what comes out of it, by name.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Identity(Vec<(String, String)>);

impl Identity {
    /// Of a run of which nothing is said.
    pub fn new() -> Self {
        Self::default()
    }

    /// And its `field` is `value`.
    #[must_use]
    pub fn with(mut self, field: &str, value: impl Display) -> Self {
        self.0.push((field.to_owned(), value.to_string()));
        self
    }

    /// And it has these numbers of a TOML document, each by its own name.
    #[must_use]
    pub fn with_toml(mut self, toml: &str) -> Self {
        let mut table = String::new();
        for line in toml.lines().map(str::trim) {
            if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
                table = format!("{name}.");
            } else if let Some((key, value)) = line.split_once('=') {
                self = self.with(&format!("{table}{}", key.trim()), value.trim());
            }
        }
        self
    }

    /// In which field a run of identity `there` differs, with both values; nothing if it does not.
    fn difference(&self, there: &Self) -> Option<String> {
        let value = |of: &Self, field: &str| of.0.iter().find(|(f, _)| f == field).map(|(_, v)| v.clone());
        let only_there = there.0.iter().filter(|(field, _)| value(self, field).is_none());
        let fields: Vec<&String> = self.0.iter().chain(only_there).map(|(field, _)| field).collect();
        let mut others = fields.into_iter().filter(|field| value(self, field) != value(there, field));
        let field = others.next()?;
        let told = |value: Option<String>| value.map_or_else(|| "not given".to_owned(), |v| shortened(&v));
        let mut text =
            format!("{field} is {} there, {} here", told(value(there, field)), told(value(self, field)));
        match others.count() {
            0 => {}
            more => {
                let _ = write!(text, ", and {more} more differ");
            }
        }
        Some(text)
    }
}

fn shortened(value: &str) -> String {
    if value.chars().count() <= MOST_CHARACTERS {
        return value.to_owned();
    }
    value.chars().take(MOST_CHARACTERS).chain("...".chars()).collect()
}

/// What is said of bytes that are no state of any search.
pub fn damaged() -> Error {
    Error::Unusable("is damaged".to_owned())
}

/// The state of the run that `identity` describes.
///
/// # Panics
///
/// If the state is not plain data.
pub fn encode(identity: &Identity, state: &impl Serialize) -> Vec<u8> {
    with_payload(&postcard::to_allocvec(&(identity, state)).expect("a search can be written down"))
}

/// A checkpoint around what it holds.
pub fn with_payload(payload: &[u8]) -> Vec<u8> {
    [MAGIC, &crc32fast::hash(payload).to_le_bytes(), payload].concat()
}

/// What a checkpoint holds.
///
/// # Errors
///
/// If the bytes are no checkpoint of this version or are damaged.
pub fn payload(bytes: &[u8]) -> Outcome<&[u8]> {
    let refuse = |why: &str| Error::Unusable(why.to_owned());
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| refuse("is no checkpoint of this version"))?;
    let (sum, payload) = rest.split_first_chunk::<4>().ok_or_else(|| refuse("is cut short"))?;
    if crc32fast::hash(payload) != u32::from_le_bytes(*sum) {
        return Err(refuse("is damaged (its checksum does not match)"));
    }
    Ok(payload)
}

/// The run that a checkpoint belongs to.
///
/// # Errors
///
/// If the bytes are no checkpoint of this version or are damaged.
pub fn identity(bytes: &[u8]) -> Outcome<Identity> {
    let (identity, _): (Identity, &[u8]) =
        postcard::take_from_bytes(payload(bytes)?).map_err(|_| damaged())?;
    Ok(identity)
}

/// The state of a run. That it is one which a search can go on from is for the search to say.
///
/// # Errors
///
/// If the bytes are no checkpoint of this version, are damaged, or belong to another run.
pub fn decode<T: DeserializeOwned>(bytes: &[u8], identity: &Identity) -> Outcome<T> {
    let (its, state): (Identity, &[u8]) =
        postcard::take_from_bytes(payload(bytes)?).map_err(|_| damaged())?;
    if let Some(difference) = identity.difference(&its) {
        return Err(Error::Unusable(format!("belongs to another run: {difference}")));
    }
    postcard::from_bytes(state).map_err(|_| damaged())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_run_is_told_by_what_differs() {
        let run = |seed: u64| {
            let run = Identity::new().with("preset", "mine").with_toml("mass = 1.0\n[inertia]\nyaw = 2.5\n");
            run.with("seed", seed)
        };
        let bytes = encode(&run(1), &7_u8);
        assert_eq!(decode::<u8>(&bytes, &run(1)), Ok(7));
        let told = |other: Identity| decode::<u8>(&bytes, &other).unwrap_err().to_string();
        assert_eq!(told(run(2)), "belongs to another run: seed is 1 there, 2 here");
        assert_eq!(
            told(run(2).with("plants", 3)),
            "belongs to another run: seed is 1 there, 2 here, and 1 more differ"
        );
        let heavier = Identity::new().with("preset", "mine").with_toml("mass = 1.0\n[inertia]\nyaw = 3.5\n");
        assert!(told(heavier.with("seed", 1)).contains("inertia.yaw is 2.5 there, 3.5 here"));
        let long = Identity::new().with("preset", "x".repeat(3000));
        assert!(told(long).len() < 200);
    }
}
