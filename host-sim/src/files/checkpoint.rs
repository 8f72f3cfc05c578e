//! Searches on disk, so that they can be resumed.

use super::output;
use crate::error::{Failure, Outcome};
use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// From one checkpoint to the next.
const EVERY: Duration = Duration::from_secs(3);

/// Keeps a search's state in a file every few seconds.
#[derive(Debug)]
pub struct Keeper {
    path: Option<PathBuf>,
    saved: Cell<Instant>,
}

impl Keeper {
    /// In this file, if there is to be one.
    pub fn new(path: Option<&Path>) -> Self {
        Self { path: path.map(Path::to_owned), saved: Cell::new(Instant::now()) }
    }

    /// Writes what `state` gives, if it is time.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    pub fn keep(&self, state: impl FnOnce() -> Vec<u8>) -> Outcome<()> {
        if self.saved.get().elapsed() < EVERY { Ok(()) } else { self.keep_now(state) }
    }

    /// Writes what `state` gives.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    pub fn keep_now(&self, state: impl FnOnce() -> Vec<u8>) -> Outcome<()> {
        let Some(path) = &self.path else { return Ok(()) };
        output::write(path, &state())?;
        self.saved.set(Instant::now());
        Ok(())
    }
}

/// The bytes of a checkpoint.
///
/// # Errors
///
/// If it cannot be read.
pub fn read(path: &Path) -> Outcome<Vec<u8>> {
    fs::read(path).map_err(|e| Failure::reading(path, &e))
}

/// Refuses to write over a checkpoint that nobody asked to resume.
///
/// # Errors
///
/// If there is one.
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
