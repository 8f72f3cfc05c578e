//! Where a tick's instructions go: some ticks followed instruction by instruction, each instruction told by
//! the source it was compiled from, inlined or not.

use std::collections::BTreeMap;

use addr2line::Context;
use addr2line::gimli::{Dwarf, EndianSlice, LittleEndian, SectionId};
use object::{Object, ObjectSection};

use crate::figures::GROWTH_PERCENT;
use crate::firmware::Firmware;
use crate::station::Station;

type Reader<'a> = EndianSlice<'a, LittleEndian>;

/// The steps of a tick in their order, and the functions that each begins with. The last one takes what no
/// other has.
pub const STEPS: [(&str, &[&str]); 10] = [
    ("encoders", &["ControlLoop::read_encoders"]),
    ("estimator", &["Pipeline::believe"]),
    ("model", &["Belief::new"]),
    ("supervisor", &["ControlLoop::find_conditions", "ControlLoop::supervise"]),
    ("reference", &["ControlLoop::follow", "CommandFilter::step"]),
    ("law", &["Pipeline::decide"]),
    (
        "allocation",
        &[
            "Allocator::demand",
            "Allocator::allocate",
            "Lead::apply",
            "CurrentLimit::range",
            "Allocation::clipped",
        ],
    ),
    ("drive", &["Drive::duty", "Drive::volts"]),
    ("telemetry", &["ControlLoop::frame", "Tick::report"]),
    ("interrupt, pins, the rest", &[]),
];

/// Instructions of one tick, step by step as in [`STEPS`].
pub type Spent = [u64; STEPS.len()];

/// The table of steps: for each compiler and step, the instructions with the paper's law and with the
/// built-in controller.
const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../firmware/steps.csv");
const COLUMNS: &str = "compiler,step,paper,rig";
/// \[instructions\] A step of a few may grow by as many.
const A_FEW: u64 = 5;

/// Whether no step has grown by more than [`GROWTH_PERCENT`] over the table, with the paper's law and with
/// the built-in controller.
///
/// # Errors
///
/// Says which has, or what the table lacks.
pub fn compare(compiler: &str, [paper, rig]: &[Spent; 2]) -> Result<(), String> {
    let text = std::fs::read_to_string(TABLE).map_err(|why| format!("{TABLE}: {why}"))?;
    if text.lines().next() != Some(COLUMNS) {
        return Err(format!("{TABLE}: the first line is not '{COLUMNS}'"));
    }
    let mut trouble = String::new();
    for ((step, _), (paper, rig)) in STEPS.iter().zip(paper.iter().zip(rig)) {
        let step = step.replace(',', "");
        let mine = format!("{compiler},{step},{paper},{rig}");
        let kept = text.lines().find_map(|line| line.strip_prefix(&format!("{compiler},{step},")));
        let kept: Option<Vec<u64>> =
            kept.map(|line| line.split(',').filter_map(|n| n.parse().ok()).collect());
        let grown = |now: u64, then: u64| now > (then * (100 + GROWTH_PERCENT) / 100).max(then + A_FEW);
        let fine = matches!(kept.as_deref(), Some(&[p, r]) if !grown(*paper, p) && !grown(*rig, r));
        if !fine {
            trouble += &format!("\n  {mine} (kept: {kept:?})");
        }
    }
    if trouble.is_empty() {
        Ok(())
    } else {
        Err(format!(
            "{TABLE} lacks steps, or they have grown by over {GROWTH_PERCENT} %; the lines would be:{trouble}"
        ))
    }
}

/// The source of a firmware's instructions.
pub struct Source<'a> {
    context: Context<Reader<'a>>,
}

impl<'a> Source<'a> {
    /// From the firmware's debug information.
    ///
    /// # Errors
    ///
    /// If it has none.
    pub fn new(firmware: &'a Firmware) -> Result<Self, String> {
        let bytes = firmware.bytes();
        let elf = object::File::parse(&**bytes).map_err(|why| why.to_string())?;
        let section = |id: SectionId| -> Result<Reader<'a>, addr2line::gimli::Error> {
            let data = elf.section_by_name(id.name()).and_then(|section| section.data().ok());
            Ok(Reader::new(data.unwrap_or_default(), LittleEndian))
        };
        let dwarf = Dwarf::load(section).map_err(|why| why.to_string())?;
        let context = Context::from_dwarf(dwarf).map_err(|why| why.to_string())?;
        Ok(Self { context })
    }

    /// The functions that `address` was compiled from, the innermost first, each as `Type::function`, with
    /// the line in it.
    pub fn frames(&self, address: u64) -> Vec<(String, u32)> {
        let mut found = Vec::new();
        let Ok(mut frames) = self.context.find_frames(address).skip_all_loads() else {
            return found;
        };
        while let Ok(Some(frame)) = frames.next() {
            let name = frame.function.and_then(|name| Some(name.demangle().ok()?.into_owned()));
            let line = frame.location.and_then(|place| place.line).unwrap_or(0);
            found.push((short(&name.unwrap_or_default()), line));
        }
        found
    }

    fn step(&self, address: u64) -> Option<usize> {
        self.frames(address)
            .iter()
            .find_map(|(name, _)| STEPS.iter().position(|(_, functions)| functions.contains(&name.as_str())))
    }
}

/// The last two names of a path, without generic arguments: `Type::function`.
fn short(name: &str) -> String {
    let mut depth = 0_u32;
    let mut plain = String::new();
    // `<path::Type<f32> as Trait>::function` is `Type::function`, so of a bracket that begins a name the
    // inside stays.
    let name = name.strip_prefix('<').map_or(name.to_owned(), |rest| {
        let end = matching(rest);
        let (inside, after) = rest.split_at(end);
        let inside = inside.split(" as ").next().unwrap_or_default();
        format!("{inside}{}", after.strip_prefix('>').unwrap_or(after))
    });
    for character in name.chars() {
        match character {
            '<' => depth += 1,
            '>' => depth = depth.saturating_sub(1),
            _ if depth == 0 => plain.push(character),
            _ => {}
        }
    }
    let names: Vec<&str> = plain.split("::").filter(|name| !name.is_empty()).collect();
    names[names.len().saturating_sub(2)..].join("::")
}

/// Where the bracket that is open at the beginning of `text` is closed.
fn matching(text: &str) -> usize {
    let mut depth = 1_u32;
    for (at, character) in text.char_indices() {
        match character {
            '<' => depth += 1,
            '>' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

/// Ticks that were followed.
#[derive(Debug, Default)]
pub struct Profile {
    /// Each tick's instructions, step by step.
    pub ticks: Vec<Spent>,
    /// How often each instruction ran, and in which step.
    pub places: BTreeMap<u64, (usize, u64)>,
}

impl Profile {
    /// Follows `ticks` ticks of the board at `station`.
    ///
    /// # Errors
    ///
    /// If the firmware has no debug information.
    ///
    /// # Panics
    ///
    /// If the firmware reaches something that is not modelled.
    pub fn of(
        firmware: &Firmware,
        station: &mut Station,
        tick: &'static str,
        ticks: u64,
    ) -> Result<Self, String> {
        let source = Source::new(firmware)?;
        let instructions = firmware.closure(tick);
        station.machine.with(move |board| board.follow(instructions));
        station.run(ticks);
        let path = station.machine.with(|board| {
            board.follow(std::collections::BTreeSet::new());
            board.take_path()
        });
        let mut profile = Self::default();
        let entry = firmware.address(tick);
        let mut known: BTreeMap<u64, Option<usize>> = BTreeMap::new();
        // Functions under way, each with the step that it serves.
        let mut calls: Vec<(u64, usize)> = Vec::new();
        let rest = STEPS.len() - 1;
        let mut last = rest;
        for &address in &path {
            let Some((start, _)) = firmware.function(address) else { continue };
            if Some(address) == entry {
                calls = vec![(start, rest)];
                profile.ticks.push([0; STEPS.len()]);
            } else if calls.last().is_none_or(|(function, _)| *function != start) {
                match calls.iter().rposition(|(function, _)| *function == start) {
                    Some(depth) => calls.truncate(depth + 1),
                    None => calls.push((start, last)),
                }
            }
            let step = *known.entry(address).or_insert_with(|| source.step(address));
            last = step.or(calls.last().map(|(_, step)| *step)).unwrap_or(rest);
            if let Some(tick) = profile.ticks.last_mut() {
                tick[last] += 1;
            }
            profile.places.entry(address).or_insert((last, 0)).1 += 1;
        }
        Ok(profile)
    }

    /// The tick whose whole is the median, step by step.
    pub fn median(&self) -> Spent {
        let mut ticks = self.ticks.clone();
        ticks.sort_by_key(|tick| tick.iter().sum::<u64>());
        ticks.get(ticks.len() / 2).copied().unwrap_or_default()
    }

    /// From the reference to the volts, as a law in C has it: the model, the law, the allocation.
    pub fn from_reference_to_volts(&self) -> u64 {
        let parts = ["model", "law", "allocation"];
        let of = |(step, _): &&(&str, &[&str])| parts.contains(step);
        STEPS.iter().zip(self.median()).filter(|(step, _)| of(step)).map(|(_, spent)| spent).sum()
    }

    /// The median tick, a line for each step.
    pub fn table(&self) -> String {
        let median = self.median();
        let lines = STEPS.iter().zip(median).map(|((step, _), spent)| format!("{spent:6}  {step}\n"));
        let whole: u64 = median.iter().sum();
        format!("{}{whole:6}  in all", lines.collect::<String>())
    }
}
