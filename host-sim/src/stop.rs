//! Signals that ask the program to end: Ctrl-C (SIGINT), SIGTERM and SIGHUP.
//!
//! Where nothing is lost that a user waits for, one ends the program at once. What has something to keep, or
//! a board in its hands, [listens](listen): then the first one only asks, and [`requested`] tells. A hang-up
//! that was ignored from the start, as under `nohup`, stays ignored.

use crate::files::output;
use std::io::Write;
use std::process::exit;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// The exit status of a run that was interrupted.
pub const STATUS: u8 = 130;

static REQUESTED: AtomicBool = AtomicBool::new(false);
static MODE: AtomicU8 = AtomicU8::new(AT_ONCE);

const AT_ONCE: u8 = 0;
const FIRST_ASKS: u8 = 1;
const ALL_ASK: u8 = 2;

/// What a second signal does to those who [`listen`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Second {
    /// It ends the program at once.
    Ends,
    /// It asks again: for what must not be left as it is, such as a board that is armed.
    Asks,
}

/// As long as it lives, a signal asks before it ends the program.
#[derive(Debug)]
pub struct Listening(());

/// From now on a signal only asks, until what is given is dropped.
#[must_use]
pub fn listen(second: Second) -> Listening {
    let mode = if second == Second::Ends { FIRST_ASKS } else { ALL_ASK };
    MODE.store(mode, Ordering::SeqCst);
    Listening(())
}

impl Drop for Listening {
    fn drop(&mut self) {
        MODE.store(AT_ONCE, Ordering::SeqCst);
    }
}

/// Did a signal ask to stop?
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}

/// What a signal does, whichever it is.
fn heard() {
    let again = REQUESTED.swap(true, Ordering::SeqCst);
    match MODE.load(Ordering::SeqCst) {
        ALL_ASK => {}
        FIRST_ASKS if !again => {}
        _ => leave(),
    }
}

/// Ends the program at once. No file that is being written is left half-written.
fn leave() -> ! {
    output::abandon();
    let _ = writeln!(std::io::stderr(), "error: interrupted");
    exit(STATUS.into())
}

/// From now on signals are heard; called once, before any other thread is made. Where the system allows no
/// thread to hear them, they end the program as they do any other.
#[cfg(unix)]
pub fn watch() {
    use nix::sys::signal::{SigSet, Signal};
    let mut signals = SigSet::empty();
    signals.add(Signal::SIGINT);
    signals.add(Signal::SIGTERM);
    if !hang_up_is_ignored() {
        signals.add(Signal::SIGHUP);
    }
    // Threads take over what their maker blocks, so that signals wait for the one that asks for them.
    if signals.thread_block().is_err() {
        return;
    }
    let hear = move || {
        while signals.wait().is_ok() {
            heard();
        }
    };
    if std::thread::Builder::new().name("signals".to_owned()).spawn(hear).is_err() {
        let _ = signals.thread_unblock();
    }
}

/// Linux tells what a process ignores as a number with a bit for each signal, the first being SIGHUP's.
#[cfg(unix)]
fn hang_up_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).is_some_and(|bits| bits & 1 == 1)
}

/// From now on signals are heard; called once. Where the system allows no thread to hear them, they end the
/// program as they do any other.
#[cfg(not(unix))]
pub fn watch() {
    let _ = ctrlc::set_handler(heard);
}
