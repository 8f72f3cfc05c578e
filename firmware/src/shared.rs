//! What the tick and the thread tell each other, without a lock.

use crate::log::Change;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU16, AtomicU32, Ordering};
use heapless::spsc::Consumer;
use twinrotor::conversation::commands;
use twinrotor::first_power::Verdict;
use twinrotor::telemetry::Frame;

/// Room for 80 ms of telemetry at 200 frames a second.
pub(crate) const FRAMES: usize = 16;
pub(crate) const VERDICTS: usize = 2;
/// Changes of state or conditions for the log; those that find no room are not logged.
pub(crate) const CHANGES: usize = 8;
/// The thread's end of what the tick reports.
pub(crate) struct Reports {
    pub(crate) frames: Consumer<'static, Frame>,
    pub(crate) verdicts: Consumer<'static, Verdict>,
    pub(crate) changes: Consumer<'static, Change>,
    /// \[cycles\] The longest tick that was logged.
    pub(crate) longest_tick: u32,
}
pub(crate) type Commands = commands::Sender<'static>;

/// Something came over the link since the last tick.
pub(crate) static HEARD: AtomicBool = AtomicBool::new(false);
/// The operator wants the motors off; nothing that else comes over the link is in its way.
pub(crate) static DISARM: AtomicBool = AtomicBool::new(false);
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
/// The emergency stop's edge, kept for the next tick.
pub(crate) static STOP_EDGE: AtomicBool = AtomicBool::new(false);
/// The stack has been used further than it should.
pub(crate) static STACK_LOW: AtomicBool = AtomicBool::new(false);
/// What the LED shows, as its own file says.
pub(crate) static LED_PATTERN: AtomicU8 = AtomicU8::new(0);

/// For the tick: takes a flag back that others raise, whom it interrupts and who never interrupt it.
#[inline(always)]
pub(crate) fn take(flag: &AtomicBool) -> bool {
    let raised = flag.load(Ordering::Relaxed);
    if raised {
        flag.store(false, Ordering::Relaxed);
    }
    raised
}
