//! Searches on disk, so that they can be resumed.

use super::output::{self, Outputs};
use crate::error::{Failure, Outcome};
use std::cell::{Cell, RefCell};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// From one checkpoint to the next.
const EVERY: Duration = Duration::from_secs(3);

/// Keeps a search's state in a file every few seconds. One that cannot be written does not end the search:
/// [`Keeper::done`] tells.
#[derive(Debug)]
pub struct Keeper {
    path: Option<PathBuf>,
    saved: Cell<Instant>,
    failed: RefCell<Option<String>>,
}

impl Keeper {
    /// In this file, if there is to be one.
    pub fn new(path: Option<&Path>) -> Self {
        Self { path: path.map(Path::to_owned), saved: Cell::new(Instant::now()), failed: RefCell::default() }
    }

    /// Writes what `state` gives, if it is time.
    pub fn keep(&self, state: impl FnOnce() -> Vec<u8>) {
        if self.saved.get().elapsed() >= EVERY {
            self.keep_now(state);
        }
    }

    /// Writes what `state` gives.
    pub fn keep_now(&self, state: impl FnOnce() -> Vec<u8>) {
        let Some(path) = &self.path else { return };
        let why = output::replace(path, &state()).err();
        *self.failed.borrow_mut() = why.map(|why| format!("{}: cannot be written: {why}", path.display()));
        self.saved.set(Instant::now());
    }

    /// Where the state is kept, if it is; what went wrong is left to `outputs` to tell.
    pub fn done(self, outputs: &mut Outputs) -> Option<PathBuf> {
        match self.failed.into_inner() {
            Some(why) => {
                outputs.fail(why);
                None
            }
            None => self.path,
        }
    }
}

/// The bytes of a checkpoint.
///
/// # Errors
///
/// If it cannot be read.
pub fn read(path: &Path) -> Outcome<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = super::open(path).and_then(|mut file| file.read_to_end(&mut bytes));
    read.map_err(|e| Failure::reading(path, &e))?;
    Ok(bytes)
}

/// Refuses to write over a checkpoint that nobody asked to resume.
///
/// # Errors
///
/// If there is one.
pub fn check_fresh(path: &Path) -> Outcome<()> {
    if path.exists() {
        return Err(Failure::Input(format!(
            "--checkpoint is '{}', which exists; add --resume to go on from it, or remove it",
            path.display()
        )));
    }
    Ok(())
}
