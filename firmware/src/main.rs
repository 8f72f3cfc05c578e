//! Twinrotor on an STM32: the 1 kHz tick, and everything that must not delay it.
//!
//! The tick is an interrupt of the highest priority, raised by the timer that also makes the PWM ([`tick`]).
//! It alone drives the motors, through [`port`]. All else is in the thread: the serial link ([`serial`]), the
//! parameters in flash ([`storage`]), the status LED. The two share lock-free queues and atomics
//! ([`shared`]), and no critical section of the thread masks the tick ([`critical`]); what must, waits until
//! the tick has stood aside with the motors off ([`quiesce`]).

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod boards;
#[cfg(target_os = "none")]
mod clock;
#[cfg(target_os = "none")]
mod critical;
#[cfg(all(target_os = "none", not(feature = "simulated")))]
mod emergency_stop;
#[cfg(target_os = "none")]
mod family;
#[cfg(target_os = "none")]
mod flash_cache;
#[cfg(target_os = "none")]
mod led;
#[cfg(target_os = "none")]
mod log;
#[cfg(target_os = "none")]
mod nonce;
#[cfg(target_os = "none")]
mod pins;
#[cfg(target_os = "none")]
mod port;
#[cfg(target_os = "none")]
mod quiesce;
#[cfg(target_os = "none")]
mod receiver;
#[cfg(target_os = "none")]
mod reset_record;
#[cfg(target_os = "none")]
mod serial;
#[cfg(target_os = "none")]
mod shared;
#[cfg(target_os = "none")]
mod slot;
#[cfg(target_os = "none")]
mod stack;
#[cfg(target_os = "none")]
mod storage;
#[cfg(target_os = "none")]
mod tick;
#[cfg(target_os = "none")]
mod wake;
#[cfg(target_os = "none")]
mod watchdog;

#[cfg(target_os = "none")]
use defmt_rtt as _;

#[cfg(target_os = "none")]
#[embassy_executor::main]
async fn main(spawner: embassy_executor::Spawner) {
    critical::lower_all_interrupts();
    stack::guard();
    watchdog::start();
    let reset = reset_record::read_and_clear();
    let board = board::start();
    reset_record::listen_to_supply();
    let (storage, parameters, provenance) = storage::Storage::load(board.flash);
    let (reports, commands) = tick::start(
        board.clock,
        board.port,
        board.standing,
        (&parameters, provenance),
        reset.map(|r| r.cause),
    );
    log::boot(boards::BOARD.known.name, reset, provenance);
    let line = (board.serial_in, board.serial_out);
    serial::start(spawner, line, storage, (parameters, provenance), reset, reports, commands);
    spawner.spawn(led::show(board.led).expect("spawned once"));
}

/// The host has no helicopter: `cargo fw` builds for the board.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This program runs on the board: build it with `cargo fw`, flash it with `cargo fw-run`.");
    std::process::exit(2);
}
