//! A run of a firmware on the board, in lock-step with a rig.
//!
//! The emulator runs on a thread of its own, and stops once a virtual millisecond: there the board's
//! outputs are taken, the rig is stepped by a millisecond with them, and its inputs go to the pins.
//! The stops keep half-way between two control ticks, so that a tick finds the rig as it was left half
//! a millisecond before, and what it writes is in effect, or not, well before it is looked at.
//!
//! Whatever the firmware reaches that the board does not model ends the run with a [`Failure`] that says
//! what, and from where in the firmware.

mod emulator;
mod gaps;
mod idle;
mod live;
mod lockstep;
mod rig;

use std::fmt;
use std::sync::mpsc::sync_channel;

use rigless::session::Reset;
use rigless::time::VirtualNanos;

use crate::board::Outputs;
use crate::chip::Settings;
use crate::firmware::Firmware;
use crate::serial::Flaw;
use crate::wiring::Amplifiers;
use emulator::Emulator;
pub use live::Live;
pub use lockstep::TickRecord;
use lockstep::{Command, Until};
pub use rig::{AtRest, Rig};

/// One millisecond of virtual time.
pub const MILLISECOND: u64 = 1_000_000;

/// Where the factory has put a part's unique number: RM0090, 39.1.
const SERIAL_ADDRESS: u64 = 0x1FFF_7A10;
/// This part's.
pub const SERIAL: [u8; 12] = *b"virtualboard";

/// Why a run ended before it was asked to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure(pub String);

impl fmt::Display for Failure {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&self.0)
    }
}

impl std::error::Error for Failure {}

/// What a run starts from.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The firmware.
    pub firmware: Firmware,
    /// Bytes put into the flash beside it, and into the part's own memory, by address: a gains image, the
    /// part's unique number.
    pub images: Vec<(u64, Vec<u8>)>,
    /// How the amplifiers are connected.
    pub amplifiers: Amplifiers,
    /// The name of the function that is the control tick's interrupt.
    pub tick: &'static str,
    /// What the part and the board around it are like.
    pub settings: Settings,
    /// Decides what chance decides: the RAM at power-on, the bits of a cut-off flash operation.
    pub seed: u64,
    /// Accesses that the part refuses, with a bus error or because an instance's clock is off, are no
    /// failure: for a firmware that is being wronged.
    pub refusals_allowed: bool,
    /// The core's memory protection unit takes effect: see [`Board::new`](crate::board::Board::new).
    pub protects_memory: bool,
}

impl Setup {
    /// `firmware` alone, on its board.
    pub fn new(firmware: Firmware) -> Self {
        let settings = Settings::of(firmware.board());
        Self {
            firmware,
            images: vec![(SERIAL_ADDRESS, SERIAL.to_vec())],
            amplifiers: Amplifiers::default(),
            tick: settings.wiring.tick,
            settings,
            seed: 1,
            refusals_allowed: false,
            protects_memory: false,
        }
    }

    /// With `bytes` in the flash from `address` on.
    #[must_use]
    pub fn with_image(mut self, address: u64, bytes: Vec<u8>) -> Self {
        self.images.push((address, bytes));
        self
    }

    /// On a part and a board like `settings`.
    #[must_use]
    pub fn with_settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// With another `seed`.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }
}

/// A board that runs.
#[derive(Debug)]
pub struct Machine {
    /// There until it is dropped.
    emulator: Option<Emulator>,
    /// Of one that another run may go on with.
    shared: Option<Setup>,
}

impl Machine {
    /// Switches the board on, with `rig` connected. Nothing has run yet.
    ///
    /// # Panics
    ///
    /// If the firmware cannot be loaded.
    pub fn start(setup: Setup, rig: impl Rig) -> Self {
        Self { emulator: Some(Emulator::start(setup, Box::new(rig))), shared: None }
    }

    /// As [`Machine::start`], but for the virtual time, which does not begin at zero: a board of the same
    /// `setup` that another run of this process is done with is switched off and on again, with a new rig and
    /// new contents of its parameter sectors. All else is as a power-on leaves it, and what the emulator has
    /// translated of the firmware stays, which takes longer than most runs.
    ///
    /// # Panics
    ///
    /// If the firmware cannot be loaded.
    pub fn switch_on(setup: Setup, rig: impl Rig) -> Self {
        let Some(sectors) = idle::parameter_sectors(&setup) else {
            return Self::start(setup, rig);
        };
        let emulator = match idle::take(&setup) {
            Some(mut emulator) => {
                emulator.again(sectors, Box::new(rig));
                emulator
            }
            None => Emulator::start(setup.clone(), Box::new(rig)),
        };
        Self { emulator: Some(emulator), shared: Some(setup) }
    }

    fn command(&mut self, command: Command) -> Result<bool, Failure> {
        self.emulator.as_mut().expect("there until it is dropped").command(command)
    }

    /// Runs for `milliseconds`.
    ///
    /// # Errors
    ///
    /// If the firmware reached something that is not modelled.
    pub fn try_run(&mut self, milliseconds: u64) -> Result<(), Failure> {
        self.command(Command::Run(milliseconds, None)).map(|_| ())
    }

    /// Runs for `milliseconds`.
    ///
    /// # Panics
    ///
    /// If the firmware reached something that is not modelled.
    #[track_caller]
    pub fn run(&mut self, milliseconds: u64) {
        if let Err(failure) = self.try_run(milliseconds) {
            panic!("{failure}");
        }
    }

    /// Runs until `reached` says so at a millisecond's end, at most `milliseconds`. Answers whether it
    /// did.
    ///
    /// # Panics
    ///
    /// If the firmware reached something that is not modelled.
    #[track_caller]
    pub fn run_until(
        &mut self,
        milliseconds: u64,
        reached: impl FnMut(&mut Live<'_>) -> bool + Send + 'static,
    ) -> bool {
        let until: Until = Box::new(reached);
        match self.command(Command::Run(milliseconds, Some(until))) {
            Ok(reached) => reached,
            Err(failure) => panic!("{failure}"),
        }
    }

    /// Looks at the board, or changes it, while it stands between two milliseconds.
    ///
    /// # Panics
    ///
    /// If the run has ended.
    pub fn with<T: Send + 'static>(&mut self, act: impl FnOnce(&mut Live<'_>) -> T + Send + 'static) -> T {
        let (result, taken) = sync_channel(1);
        let act = Box::new(move |live: &mut Live<'_>| {
            // The one that asked waits for it.
            let _ = result.send(act(live));
        });
        if let Err(failure) = self.command(Command::With(act)) {
            panic!("{failure}");
        }
        taken.recv().expect("answered before the command was")
    }

    /// The rig, as the type it was connected as.
    ///
    /// # Panics
    ///
    /// If it is another type, or the run has ended.
    pub fn rig<R: Rig, T: Send + 'static>(&mut self, act: impl FnOnce(&mut R) -> T + Send + 'static) -> T {
        self.with(move |live| act(live.rig()))
    }

    /// Puts bytes on the serial line to the board.
    pub fn say(&mut self, bytes: &[u8]) {
        let bytes = bytes.to_vec();
        self.with(move |live| live.line().say(&bytes));
    }

    /// Puts one byte on the serial line to the board that arrives with `flaw`.
    pub fn say_flawed(&mut self, byte: u8, flaw: Flaw) {
        self.with(move |live| live.line().say_flawed(byte, flaw));
    }

    /// The bytes the board sent since the last call.
    pub fn heard(&mut self) -> Vec<u8> {
        self.with(|live| live.line().take_heard())
    }

    /// The board's outputs now.
    pub fn outputs(&mut self) -> Outputs {
        self.with(|live| live.outputs())
    }

    /// The board's outputs at every millisecond since the start, and where the control ticks were.
    pub fn trace(&mut self) -> (Vec<Outputs>, Vec<TickRecord>) {
        self.with(|live| (live.trace().to_vec(), live.ticks().to_vec()))
    }

    /// Every reset so far.
    pub fn resets(&mut self) -> Vec<Reset> {
        self.with(|live| live.resets().to_vec())
    }

    /// Now, and the instructions the core has retired.
    pub fn now(&mut self) -> (VirtualNanos, u64) {
        self.with(|live| live.now())
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        if let (Some(setup), Some(emulator)) = (self.shared.take(), self.emulator.take()) {
            idle::give_back(setup, emulator);
        }
    }
}
