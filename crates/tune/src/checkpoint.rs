//! Searches as bytes, so that they can be resumed.

use serde::Serialize;
use serde::de::DeserializeOwned;
use twinrotor_sim::{Error, Outcome};

/// First bytes of a checkpoint.
const MAGIC: &[u8] = b"twinrotor checkpoint 2\n";

/// The state of the run that `identity` describes: what is sought and how, in words.
///
/// # Panics
///
/// If the state is not plain data.
pub fn encode(identity: &str, state: &impl Serialize) -> Vec<u8> {
    let payload = postcard::to_allocvec(&(identity, state)).expect("a search can be written down");
    let mut bytes = MAGIC.to_vec();
    bytes.extend(crc32fast::hash(&payload).to_le_bytes());
    bytes.extend(payload);
    bytes
}

/// The state of a run; with other words it is another run's.
///
/// # Errors
///
/// If the bytes are no checkpoint of this version, are damaged, or belong to another run.
pub fn decode<T: DeserializeOwned>(bytes: &[u8], identity: &str) -> Outcome<T> {
    let refuse = |why: &str| Error::Unusable(why.to_owned());
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
