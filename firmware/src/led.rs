//! The status LED: one slow blink, disarmed; steady, ready; quick, motors may turn; two flashes, fault;
//! three, the board itself is not as it should be, whatever the state. With a simulated rig: one short flash,
//! disarmed; steady with a short gap, ready; half as quick, motors may turn.

use crate::boards::BOARD;
use crate::shared::LED_PATTERN;
use core::sync::atomic::Ordering;
use embassy_stm32::gpio::{Level, Output};
use embassy_time::{Duration, Ticker};
use twinrotor::supervisor::{ArmState, Conditions};

/// \[ms\] One bit of a pattern; a pattern is eight.
const BIT_MS: u64 = 125;
const SIMULATED: bool = cfg!(feature = "simulated");

/// The pattern for a state and what is wrong with the board, a bit at a time from the lowest.
pub(crate) const fn pattern(state: ArmState, board: Conditions) -> u8 {
    match state {
        _ if !board.is_empty() => 0b0001_0101,
        ArmState::Fault(_) => 0b0000_0101,
        ArmState::Disarmed if SIMULATED => 0b0000_0001,
        ArmState::Ready if SIMULATED => 0b0111_1111,
        ArmState::Checking | ArmState::Armed if SIMULATED => 0b0011_0011,
        ArmState::Disarmed => 0b0000_1111,
        ArmState::Ready => 0b1111_1111,
        ArmState::Checking | ArmState::Armed => 0b0101_0101,
    }
}

/// At its pin.
pub(crate) const fn level(on: bool) -> Level {
    if on == BOARD.lit_high { Level::High } else { Level::Low }
}

/// Shows it for ever.
#[embassy_executor::task]
pub(crate) async fn show(mut led: Output<'static>) {
    let mut ticker = Ticker::every(Duration::from_millis(BIT_MS));
    for bit in (0..8).cycle() {
        let on = LED_PATTERN.load(Ordering::Relaxed) >> bit & 1 == 1;
        led.set_level(level(on));
        ticker.next().await;
    }
}
