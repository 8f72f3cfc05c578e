//! What the firmware takes of the part: bytes, instructions, stack; compared with the table that is kept by compiler, so
//! that it is seen when they grow.

use std::fmt;

use crate::firmware::Firmware;
use crate::station::Station;

/// \[%\] How much a figure may grow before a test fails.
pub const GROWTH_PERCENT: u64 = 5;

/// A firmware's figures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figures {
    /// What the image takes of the flash.
    pub loadable_bytes: u64,
    /// What its statics take of the RAM, the stack aside.
    pub static_ram_bytes: u64,
    /// From the entry of the tick's interrupt to its return, armed.
    pub tick_instructions_min: u64,
    /// See [`Figures::tick_instructions_min`].
    pub tick_instructions_median: u64,
    /// The same, of every tick since boot.
    pub tick_instructions_max: u64,
    /// The most of the stack that was ever used.
    pub stack_bytes_used: u64,
    /// All of the stack.
    pub stack_bytes: u64,
}

/// The table: a line for each compiler, named as in the ELF.
const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../firmware/figures.csv");
/// The table's columns.
const COLUMNS: &str =
    "compiler,loadable_bytes,static_ram_bytes,tick_instructions_median,tick_instructions_max";

impl Figures {
    /// Measures a firmware that flies at `station`, by two seconds of it.
    ///
    /// # Panics
    ///
    /// If the firmware reaches something that is not modelled.
    pub fn measure(firmware: &Firmware, station: &mut Station) -> Self {
        let before = station.machine.with(|board| board.ticks().len());
        station.run(2_000);
        let (_, ticks) = station.machine.trace();
        let instructions = |from: usize| {
            let mut counts: Vec<u64> = ticks[from..].iter().map(|tick| tick.instructions).collect();
            counts.sort_unstable();
            counts
        };
        let (all, flown) = (instructions(0), instructions(before));
        let (used, size) = station.machine.with(|board| {
            let (low, high) = (board.symbol("_stack_end"), board.symbol("_stack_start"));
            (board.stack_used(low, high), high - low)
        });
        Self {
            loadable_bytes: firmware.flash_size(),
            static_ram_bytes: firmware.ram_size(),
            tick_instructions_min: flown[0],
            tick_instructions_median: flown[flown.len() / 2],
            tick_instructions_max: all[all.len() - 1],
            stack_bytes_used: used,
            stack_bytes: size,
        }
    }

    /// Whether every figure is within what the project allows itself.
    ///
    /// # Errors
    ///
    /// Says which is not.
    pub fn within_budget(&self) -> Result<(), String> {
        let budget = [
            ("loadable_bytes", self.loadable_bytes, 64 << 10),
            ("static_ram_bytes", self.static_ram_bytes, 16 << 10),
            // The goal is 1,000 and 1,500 with the paper's law. With every law and observer aboard the pipeline's choices
            // cost a few instructions a tick, and building them at arming makes the longest one.
            ("tick_instructions_median", self.tick_instructions_median, 1_050),
            ("tick_instructions_max", self.tick_instructions_max, 1_800),
            ("stack_bytes_used", self.stack_bytes_used, self.stack_bytes / 2),
        ];
        let over = budget.into_iter().find(|(_, value, most)| value > most);
        over.map_or(Ok(()), |(name, value, most)| {
            Err(format!("{name} is {value}, allowed are {most}; {self}"))
        })
    }

    /// Whether no figure has grown by more than [`GROWTH_PERCENT`] over that kept for the firmware's compiler.
    ///
    /// # Errors
    ///
    /// Says which has, or that the table cannot be read or has no such line.
    pub fn compare(&self, firmware: &Firmware) -> Result<(), String> {
        let text = std::fs::read_to_string(TABLE).map_err(|why| format!("{TABLE}: {why}"))?;
        let mut lines = text.lines();
        if lines.next() != Some(COLUMNS) {
            return Err(format!("{TABLE}: the first line is not '{COLUMNS}'"));
        }
        let compiler = firmware.compiler();
        let mine = format!("{compiler},{}", self.columns().map(|(_, value)| value.to_string()).join(","));
        let kept = lines.find_map(|line| line.strip_prefix(compiler)?.strip_prefix(','));
        let kept =
            kept.ok_or_else(|| format!("{TABLE} has no line for this compiler; it would be: {mine}"))?;
        let kept: Vec<u64> = kept.split(',').filter_map(|number| number.parse().ok()).collect();
        if kept.len() != self.columns().len() {
            return Err(format!(
                "{TABLE}: the line for {compiler} does not have {} numbers",
                self.columns().len()
            ));
        }
        for ((name, value), kept) in self.columns().into_iter().zip(kept) {
            if value * 100 > kept * (100 + GROWTH_PERCENT) {
                return Err(format!(
                    "{name} has grown from {kept} to {value}, allowed are {GROWTH_PERCENT} %; the line would be: {mine}"
                ));
            }
        }
        Ok(())
    }

    /// The figures that are kept, by the names of [`COLUMNS`].
    fn columns(&self) -> [(&'static str, u64); 4] {
        [
            ("loadable_bytes", self.loadable_bytes),
            ("static_ram_bytes", self.static_ram_bytes),
            ("tick_instructions_median", self.tick_instructions_median),
            ("tick_instructions_max", self.tick_instructions_max),
        ]
    }
}

impl fmt::Display for Figures {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            to,
            "{} bytes of flash, {} of static RAM; a tick takes {} to {} instructions, {} by the median; {} of {} \
             bytes of stack used",
            self.loadable_bytes,
            self.static_ram_bytes,
            self.tick_instructions_min,
            self.tick_instructions_max,
            self.tick_instructions_median,
            self.stack_bytes_used,
            self.stack_bytes
        )
    }
}
