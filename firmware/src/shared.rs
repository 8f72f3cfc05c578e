//! What the tick and the thread tell each other, without a lock.

use core::sync::atomic::{AtomicU8, AtomicU16, AtomicU32, Ordering};
use heapless::spsc::Consumer;
use twinrotor::conversation::commands;
use twinrotor::first_power::Verdict;
use twinrotor::supervisor::{ArmState, Conditions};
use twinrotor::telemetry::Frame;

/// Room for 80 ms of telemetry at 200 frames a second.
pub(crate) const FRAMES: usize = 16;
pub(crate) const VERDICTS: usize = 2;
/// Changes of state or conditions for the log; those that find no room are not logged.
pub(crate) const CHANGES: usize = 8;
/// From this tick on, another state or other conditions.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Change {
    pub(crate) tick: u32,
    pub(crate) state: ArmState,
    pub(crate) conditions: Conditions,
}

/// The thread's end of what the tick reports.
pub(crate) struct Reports {
    pub(crate) frames: Consumer<'static, Frame>,
    pub(crate) verdicts: Consumer<'static, Verdict>,
    pub(crate) changes: Consumer<'static, Change>,
    /// \[cycles\] The longest tick that was logged.
    pub(crate) longest_tick: u32,
}
pub(crate) type Commands = commands::Sender<'static>;

/// The [`Flag`]s that are raised.
static FLAGS: AtomicU8 = AtomicU8::new(0);
/// \[ticks\] From one frame of telemetry to the next.
pub(crate) static FRAME_EVERY: AtomicU16 = AtomicU16::new(5);
/// Frames that found the queue full.
pub(crate) static FRAMES_DROPPED: AtomicU32 = AtomicU32::new(0);
/// \[counts of the stopwatch\] Longest tick.
pub(crate) static TICK_COUNTS_MAX: AtomicU32 = AtomicU32::new(0);
/// Ticks since boot.
pub(crate) static TICKS: AtomicU32 = AtomicU32::new(0);
/// [`twinrotor::control_loop::Status`] as a word, whenever it may have changed.
pub(crate) static STATUS: AtomicU32 = AtomicU32::new(0);
/// What the LED shows, as its own file says.
pub(crate) static LED_PATTERN: AtomicU8 = AtomicU8::new(0);

/// What the next tick is to know.
#[derive(Clone, Copy)]
#[repr(u8)]
pub(crate) enum Flag {
    /// Something came over the link since the last tick.
    Heard = 1,
    /// The operator wants the motors off; nothing that else comes over the link is in its way.
    Disarm = 2,
    /// The emergency stop's edge.
    StopEdge = 4,
    /// The stack has been used further than it should: stays raised.
    StackLow = 8,
}

impl Flag {
    /// Until a tick takes it.
    pub(crate) fn raise(self) {
        FLAGS.fetch_or(self as u8, Ordering::Relaxed);
    }
}

/// The flags that a tick has taken.
#[derive(Clone, Copy)]
pub(crate) struct Flags(u8);

impl Flags {
    /// For the tick, which interrupts all who raise flags, or waits for them, and is not interrupted.
    #[inline(always)]
    pub(crate) fn take() -> Self {
        let raised = FLAGS.load(Ordering::Relaxed);
        if raised != 0 {
            FLAGS.store(raised & Flag::StackLow as u8, Ordering::Relaxed);
        }
        Self(raised)
    }

    #[inline(always)]
    pub(crate) fn contain(self, flag: Flag) -> bool {
        self.0 & flag as u8 != 0
    }
}
