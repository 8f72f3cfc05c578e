//! What the firmware takes of the part: bytes, instructions, stack; compared with the table that is kept by
//! compiler, so that it is seen when they grow.

use std::fmt;
use std::ops::Range;

use twinrotor::supervisor::Request;

use crate::firmware::Firmware;
use crate::station::Station;

/// \[%\] How much a figure may grow before a test fails.
pub const GROWTH_PERCENT: u64 = 5;

/// What the tick and the stack take while a controller flies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InFlight {
    /// From the entry of the tick's interrupt to its return, armed, every tick's telemetry captured.
    pub tick_min: u64,
    /// See [`InFlight::tick_min`].
    pub tick_median: u64,
    /// The same, of every tick since boot.
    pub tick_max: u64,
    /// \[%\] Of the instructions that the core had time for, those that it did not need.
    pub idle_percent: f64,
    /// The most of the stack that was ever used.
    pub stack_bytes_used: u64,
    /// All of the stack.
    pub stack_bytes: u64,
}

impl InFlight {
    /// Measures the firmware that flies at `station`, by two seconds of it; then disarms and arms it until
    /// its longest tick must have come, which is one that arms.
    ///
    /// # Panics
    ///
    /// If the firmware reaches something that is not modelled.
    pub fn measure(station: &mut Station) -> Self {
        const MILLISECONDS: u64 = 2_000;
        #[expect(clippy::cast_possible_truncation, reason = "a few thousand")]
        const TICKS: usize = MILLISECONDS as usize;
        let before = station.machine.with(|board| board.ticks().len());
        let core_hz = station.machine.with(|live| live.board().chip().part().core_hz());
        let (_, executed) = station.machine.now();
        station.run(MILLISECONDS);
        let (_, all) = station.machine.now();
        // Some work is done every fourth tick, some every fifth: all of it comes together once in 20 times 21
        // ticks.
        for _ in 0..20 {
            station.request(Request::Disarm);
            station.run(10);
            station.request(Request::Arm);
            station.run(11);
        }
        let (_, ticks) = station.machine.trace();
        let instructions = |range: Range<usize>| {
            let mut counts: Vec<u64> = ticks[range].iter().map(|tick| tick.instructions).collect();
            counts.sort_unstable();
            counts
        };
        let (since_boot, flown) = (instructions(0..ticks.len()), instructions(before..before + TICKS));
        let (used, size) = station.machine.with(|board| {
            let (low, high) = (board.symbol("_stack_end"), board.symbol("_stack_start"));
            (board.stack_used(low, high), high - low)
        });
        #[expect(clippy::cast_precision_loss, reason = "a share")]
        let busy = (all - executed) as f64 / (core_hz / 1_000 * MILLISECONDS) as f64;
        Self {
            tick_min: flown[0],
            tick_median: flown[flown.len() / 2],
            tick_max: since_boot[since_boot.len() - 1],
            idle_percent: 100.0 * (1.0 - busy),
            stack_bytes_used: used,
            stack_bytes: size,
        }
    }
}

/// A firmware's figures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// What the image takes of the flash.
    pub loadable_bytes: u64,
    /// What its statics take of the RAM, the stack aside.
    pub static_ram_bytes: u64,
    /// With the paper's law.
    pub papers: InFlight,
    /// With the controller that is built in, tuned for a rig.
    pub rigs: InFlight,
}

/// The table: a line for each compiler, named as in the ELF.
const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../firmware/figures.csv");
/// The table's columns.
const COLUMNS: &str = "compiler,loadable_bytes,static_ram_bytes,tick_instructions_median,\
                       tick_instructions_max,rig_tick_instructions_median,rig_tick_instructions_max";

impl Figures {
    /// Of a firmware that flew so.
    pub fn new(firmware: &Firmware, papers: InFlight, rigs: InFlight) -> Self {
        Self { loadable_bytes: firmware.flash_size(), static_ram_bytes: firmware.ram_size(), papers, rigs }
    }

    /// Whether every figure is within what the project allows itself.
    ///
    /// # Errors
    ///
    /// Says which is not.
    pub fn within_budget(&self) -> Result<(), String> {
        let (papers, rigs) = (&self.papers, &self.rigs);
        // The paper's median tick: 749 before link version 3, 786 at most for that alone (784); a trial's
        // part of each tick and frame came later.
        let budget = [
            ("loadable_bytes", self.loadable_bytes, 192 << 10),
            ("static_ram_bytes", self.static_ram_bytes, 26 << 10),
            ("tick_instructions_median", papers.tick_median, 800),
            ("tick_instructions_max", papers.tick_max, 1_850),
            ("rig_tick_instructions_median", rigs.tick_median, 1_500),
            ("rig_tick_instructions_max", rigs.tick_max, 2_300),
            ("stack_bytes_used", papers.stack_bytes_used.max(rigs.stack_bytes_used), rigs.stack_bytes / 2),
        ];
        if let Some((name, value, most)) = budget.into_iter().find(|(_, value, most)| value > most) {
            return Err(format!("{name} is {value}, allowed are {most}; {self}"));
        }
        let idle = papers.idle_percent.min(rigs.idle_percent);
        // 97 before trials and what the monitor makes of a disturbance.
        if idle < 96.5 {
            Err(format!("the core idles {idle:.1} % of its time, at least 96.5 are wanted"))
        } else {
            Ok(())
        }
    }

    /// Whether no figure has grown by more than [`GROWTH_PERCENT`] over that kept for the firmware's
    /// compiler.
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
                    "{name} has grown from {kept} to {value}, allowed are {GROWTH_PERCENT} %; the line would \
                     be: {mine}"
                ));
            }
        }
        Ok(())
    }

    /// The figures that are kept, by the names of [`COLUMNS`].
    fn columns(&self) -> [(&'static str, u64); 6] {
        [
            ("loadable_bytes", self.loadable_bytes),
            ("static_ram_bytes", self.static_ram_bytes),
            ("tick_instructions_median", self.papers.tick_median),
            ("tick_instructions_max", self.papers.tick_max),
            ("rig_tick_instructions_median", self.rigs.tick_median),
            ("rig_tick_instructions_max", self.rigs.tick_max),
        ]
    }
}

impl fmt::Display for InFlight {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            to,
            "a tick takes {} to {} instructions, {} by the median; the core idles {:.1} %; {} of {} bytes of \
             stack used",
            self.tick_min,
            self.tick_max,
            self.tick_median,
            self.idle_percent,
            self.stack_bytes_used,
            self.stack_bytes
        )
    }
}

impl fmt::Display for Figures {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            to,
            "{} bytes of flash, {} of static RAM\nthe paper's law: {}\nthe built-in controller: {}",
            self.loadable_bytes, self.static_ram_bytes, self.papers, self.rigs
        )
    }
}
