//! What the firmware takes of the part: bytes, instructions, stack. Kept in a table by compiler, so that it is seen when
//! it grows.

use std::fmt;
use std::path::Path;

use crate::firmware::Firmware;
use crate::station::Station;

/// [%] How much a figure may grow before a test fails.
pub const GROWTH_PERCENT: u64 = 5;

/// A firmware's figures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figures {
    /// The compiler's version, as it wrote it into the ELF.
    pub compiler: String,
    /// Each figure, in the order of [`NAMES`].
    pub values: [u64; 7],
}

/// The figures and their units, and the most that each may be.
pub const NAMES: [(&str, u64); 7] = [
    ("flash_bytes", 64 << 10),
    ("static_ram_bytes", 16 << 10),
    ("tick_instructions_min", 1_500),
    ("tick_instructions_median", 1_000),
    ("tick_instructions_max", 1_500),
    ("stack_bytes_used", 0),
    ("stack_bytes", u64::MAX),
];

const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/figures.txt");

impl Figures {
    /// Measures a firmware that flies at `station`, by a second of it with telemetry every tick.
    ///
    /// # Panics
    ///
    /// If the firmware reaches something that is not modelled.
    pub fn measure(firmware: &Firmware, station: &mut Station) -> Self {
        let before = station.machine.with(|board| board.ticks().len());
        station.run(1_000);
        let mut ticks = station.machine.with(move |board| {
            let flown = board.ticks()[before..].iter();
            flown.map(|tick| tick.instructions).collect::<Vec<u64>>()
        });
        ticks.sort_unstable();
        let (used, size) = station.machine.with(|board| {
            let (low, high) = (board.symbol("_stack_end"), board.symbol("_stack_start"));
            (board.stack_used(low, high), high - low)
        });
        let [least, most] = [ticks[0], ticks[ticks.len() - 1]];
        let values =
            [firmware.flash_size(), firmware.ram_size(), least, ticks[ticks.len() / 2], most, used, size];
        Self { compiler: firmware.compiler().to_owned(), values }
    }

    /// Whether no figure is beyond what the project allows itself.
    ///
    /// # Errors
    ///
    /// Says which is.
    pub fn within_budget(&self) -> Result<(), String> {
        for ((name, most), value) in NAMES.into_iter().zip(self.values) {
            let most = if name == "stack_bytes_used" { self.values[6] / 2 } else { most };
            if value > most {
                return Err(format!("{name} is {value}, allowed are {most}; all of them: {self}"));
            }
        }
        Ok(())
    }

    /// Whether no figure has grown by more than [`GROWTH_PERCENT`] over the one kept.
    ///
    /// # Errors
    ///
    /// Says which has.
    pub fn compare(&self, kept: &Self) -> Result<(), String> {
        for ((name, _), (value, kept)) in NAMES.into_iter().zip(self.values.into_iter().zip(kept.values)) {
            if value * 100 > kept * (100 + GROWTH_PERCENT) {
                return Err(format!("{name} has grown from {kept} to {value}; now: {self}"));
            }
        }
        Ok(())
    }

    /// The figures kept for the compiler that built the released firmware, if there are.
    ///
    /// # Errors
    ///
    /// If the table cannot be read.
    pub fn kept() -> Result<Option<Self>, String> {
        let compiler = Firmware::released().map_err(|why| why.to_string())?.compiler().to_owned();
        let text = std::fs::read_to_string(Path::new(TABLE)).map_err(|why| format!("{TABLE}: {why}"))?;
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
            let found =
                Self::parse(line).ok_or_else(|| format!("{TABLE}: '{line}' is no line of figures"))?;
            if found.compiler == compiler {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    fn parse(line: &str) -> Option<Self> {
        let (compiler, rest) = line.split_once('|')?;
        let numbers: Vec<u64> = rest.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
        Some(Self { compiler: compiler.trim().to_owned(), values: numbers.try_into().ok()? })
    }
}

impl fmt::Display for Figures {
    /// A line of the table.
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{} |", self.compiler)?;
        self.values.iter().try_for_each(|value| write!(to, " {value}"))
    }
}
