//! What differs from one part, board and laboratory to the next, and what the manual leaves open: a firmware
//! must do with every one of them.

use super::parts::Part;
use crate::wiring::Wiring;
use twinrotor::board::{self, Board};

/// Where in its tolerance the supply's voltage detector lies, datasheet DS8626 table 19.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tolerance {
    /// It trips at the lowest voltage it may.
    Minimum,
    /// As most do.
    #[default]
    Typical,
    /// It trips at the highest.
    Maximum,
}

/// What a DMA stream does when it is stopped and started again, which RM0090 says in two ways and parts do in
/// more. Both `true` is the manual's plain text, 10.3.14 and 10.5.6.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamStop {
    /// `TCIF` is set when `EN` is cleared, as if the block had ended.
    pub completes: bool,
    /// `NDTR` has the programmed count again when `EN` is set; otherwise what was left of it, and the
    /// programmed count from the next lap on. The memory pointer starts at `M0AR` either way.
    pub reloads: bool,
}

impl StreamStop {
    /// Every reading of the manual.
    pub const READINGS: [Self; 4] = [
        Self { completes: true, reloads: true },
        Self { completes: true, reloads: false },
        Self { completes: false, reloads: true },
        Self { completes: false, reloads: false },
    ];
}

impl Default for StreamStop {
    fn default() -> Self {
        Self::READINGS[0]
    }
}

/// What the part is like, and what is soldered beside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Which one it is.
    pub part: Part,
    /// \[mV\] The part's own rail, which its voltage detector watches; 1,800 to 3,600.
    pub rail_millivolts: u32,
    /// Where the voltage detector lies.
    pub detector: Tolerance,
    /// \[Hz\] The crystal, or zero for none, or a dead one.
    pub crystal_hz: u64,
    /// \[Hz\] The internal low-speed oscillator behind the watchdog; 17,000 to 47,000, DS8626 table 35.
    pub lsi_hz: u64,
    /// What a stopped DMA stream does.
    pub stream_stop: StreamStop,
    /// The user button's port (A is 0) and pin, which it connects to ground.
    pub button: Option<(usize, u8)>,
    /// What is connected where.
    pub wiring: &'static Wiring,
}

impl Settings {
    /// A board as it is sold: UM1724, 6.6 and 6.7 of the Nucleo boards, whose clock an ST-LINK feeds in; the
    /// Black Pill's schematic.
    pub fn of(known: Board) -> Self {
        let (crystal_hz, button) = match known {
            board::FEATHER_F405 => (12_000_000, None),
            board::BLACK_PILL => (25_000_000, Some((0, 0))),
            board::NUCLEO_F411 | board::NUCLEO_F446 => (8_000_000, Some((2, 13))),
            _ => (8_000_000, None),
        };
        let wiring = Wiring::of(known);
        Self { part: Part::of(known), crystal_hz, button, wiring, ..Self::default() }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            part: Part::default(),
            rail_millivolts: 3300,
            detector: Tolerance::default(),
            crystal_hz: 8_000_000,
            lsi_hz: 32_000,
            stream_stop: StreamStop::default(),
            button: None,
            wiring: Wiring::of(Board::default()),
        }
    }
}
