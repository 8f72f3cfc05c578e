//! Searches on disk, so that they can be resumed.

use crate::error::{Failure, Outcome};
use crate::output;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::path::Path;

/// First bytes of a checkpoint.
const MAGIC: &[u8] = b"twinrotor checkpoint 2\n";

/// Writes the state of the run that `identity` describes: what is sought and how, in words.
pub fn write(path: &Path, identity: &str, state: &impl Serialize) -> Outcome<()> {
    let payload = postcard::to_allocvec(&(identity, state)).expect("a search can be written down");
    let mut bytes = MAGIC.to_vec();
    bytes.extend(crc32fast::hash(&payload).to_le_bytes());
    bytes.extend(payload);
    output::write(path, &bytes)
}

/// Reads the state of a run; with other words it is another run's.
pub fn read<T: DeserializeOwned>(path: &Path, identity: &str) -> Outcome<T> {
    let bytes = fs::read(path).map_err(|e| Failure::reading(path, &e))?;
    let refuse = |why: &str| Failure::Input(format!("{}: {why}", path.display()));
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| refuse("is no checkpoint of this version"))?;
    let (sum, payload) = rest.split_first_chunk::<4>().ok_or_else(|| refuse("is cut short"))?;
    if crc32fast::hash(payload) != u32::from_le_bytes(*sum) {
        return Err(refuse("is damaged (its checksum does not match)"));
    }
    let (its, state): (String, &[u8]) =
        postcard::take_from_bytes(payload).map_err(|_| refuse("is damaged"))?;
    if its != identity {
        return Err(refuse(&format!("belongs to another run; it is of [{its}], this is [{identity}]")));
    }
    postcard::from_bytes(state).map_err(|_| refuse("is damaged"))
}

/// Refuses to write over a checkpoint that nobody asked to resume.
pub fn check_fresh(path: &Path) -> Outcome<()> {
    output::check("--checkpoint", path)?;
    if path.exists() {
        return Err(Failure::Input(format!(
            "--checkpoint is '{}', which exists; add --resume to go on from it, or remove it",
            path.display()
        )));
    }
    Ok(())
}
