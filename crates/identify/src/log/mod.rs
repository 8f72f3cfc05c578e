//! Logs of real rigs: angles and volts over time, from a CSV file, checked for what such files usually have
//! wrong.
//!
//! A log has one row for each sample: time, both angles as measured, and the volts that were sent after
//! reading them, held until the next row. What cannot be mended is refused in one line; what can is mended
//! and told in [`Log::notes`]: repeated rows, gaps, uneven steps (`time.rs`), wrapped angles and wild rows
//! (`jumps.rs`). Units that were not said are found by `units.rs`, rows that two logs share by `same.rs`.

mod columns;
mod jumps;
mod same;
mod time;
mod units;

pub use columns::{COLUMNS, Columns};

use columns::{Layout, MOST_VOLTS, Moment};
use std::io::Read;
use std::ops::Range;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::presets::Rig;
use twinrotor_sim::{Error, Outcome};

/// A recorded run, SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// The file's path as given.
    pub name: String,
    /// \[s\] From row to row.
    pub sample_time: f64,
    /// \[s\] When each row was taken, from the first row on.
    pub time: Vec<f64>,
    /// \[rad\] As the encoders showed it.
    pub angle: Vec<PerAxis<f64>>,
    /// \[V\] Sent after that row was taken, in effect until the next.
    pub volts: Vec<PerMotor<f64>>,
    /// \[rad/s\] Of the rotors, where there are tachometers.
    pub rotor_speed: Option<Vec<PerMotor<f64>>>,
    /// \[rad\] Where it was meant to be, where that was recorded.
    pub reference: Option<Vec<PerAxis<f64>>>,
    /// Stretches of rows without a gap, in order.
    pub stretches: Vec<Range<usize>>,
    /// What was found and mended.
    pub notes: Vec<String>,
}

/// Most rows: an hour at 1 kHz, and what fits into memory several times over.
const MOST_ROWS: usize = 4_000_000;
/// Fewest rows of which anything can be said.
const FEWEST_ROWS: usize = 20;
/// \[rad\] A pitch beyond this is upside down, or no radians.
const MOST_PITCH: f64 = std::f64::consts::FRAC_PI_2;
/// Part of the rows that may have another one's time and values of their own.
const MOST_DIFFERING: f64 = 0.01;
/// \[V\] Volts that never exceed this on a rig that takes many are parts of a whole.
const DUTY_CYCLE: f64 = 1.0;

impl Log {
    /// Reads CSV text of a run of `rig`, whose first row names its columns, called `name` in what is said of
    /// it.
    ///
    /// # Errors
    ///
    /// If it is not one of a log, or of one that nothing can be learnt from: the line or the column, and what
    /// is wrong there.
    pub fn read(name: &str, source: impl Read, columns: &Columns, rig: &Rig) -> Outcome<Self> {
        let refuse = |why: String| Error::Unusable(why).within(name);
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(source);
        let header = reader.headers().map_err(|e| refuse(one_line(&e)))?.clone();
        let layout = columns.locate(&header).map_err(refuse)?;
        let mut rows = Rows::default();
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).map_err(|e| refuse(one_line(&e)))? {
            let line = record.position().map_or(0, csv::Position::line);
            rows.push(&layout, &record).map_err(|why| refuse(format!("line {line}: {why}")))?;
            if rows.time.len() > MOST_ROWS {
                return Err(refuse(format!("has more than {MOST_ROWS} rows; cut it into parts")));
            }
        }
        rows.into_log(name, &layout, rig).map_err(refuse)
    }

    /// From rows that are known to be sound: one every `sample_time` \[s\], angles \[rad\], volts \[V\].
    pub fn from_rows(name: &str, sample_time: f64, rows: &[(PerAxis<f64>, PerMotor<f64>)]) -> Self {
        Self {
            name: name.to_owned(),
            sample_time,
            time: (0..rows.len()).map(|k| k as f64 * sample_time).collect(),
            angle: rows.iter().map(|r| r.0).collect(),
            volts: rows.iter().map(|r| r.1).collect(),
            rotor_speed: None,
            reference: None,
            stretches: std::iter::once(0..rows.len()).collect(),
            notes: Vec::new(),
        }
    }

    /// \[s\] From the first row to the last.
    pub fn duration(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    /// Of every row, to tell one recording from another of the same name.
    pub fn checksum(&self) -> u32 {
        let mut sum = crc32fast::Hasher::new();
        for ((time, angle), volts) in self.time.iter().zip(&self.angle).zip(&self.volts) {
            for number in [time, &angle.pitch, &angle.yaw, &volts.main, &volts.tail] {
                sum.update(&number.to_le_bytes());
            }
        }
        sum.finalize()
    }

    /// Which axes move at all. One that does not is locked: its angle says nothing, and its body does not
    /// turn.
    pub fn moves(&self) -> PerAxis<bool> {
        let moves = |of: fn(&PerAxis<f64>) -> f64| {
            self.angle.iter().map(of).any(|a| (a - of(&self.angle[0])).abs() > 0.0)
        };
        PerAxis { pitch: moves(|a| a.pitch), yaw: moves(|a| a.yaw) }
    }

    /// \[rad\] Standard deviation of each angle over the log.
    pub fn spread(&self) -> PerAxis<f64> {
        let rows = self.angle.len() as f64;
        let mean =
            self.angle.iter().fold(PerAxis::zero(), |sum: PerAxis<f64>, a| sum.plus(*a)).scaled(1.0 / rows);
        let square = |e: f64| e * e;
        let sum = self
            .angle
            .iter()
            .fold(PerAxis::zero(), |sum: PerAxis<f64>, a| sum.plus(a.minus(mean).map(square)));
        sum.map(|s| (s / rows).sqrt())
    }
}

/// Rows in SI units, as the file has them until they are mended.
#[derive(Debug, Default)]
struct Rows {
    origin: Option<Moment>,
    time: Vec<f64>,
    angle: Vec<PerAxis<f64>>,
    volts: Vec<PerMotor<f64>>,
    rotor_speed: Vec<PerMotor<f64>>,
    reference: Vec<PerAxis<f64>>,
    repeated: usize,
    differing: usize,
}

impl Rows {
    fn push(&mut self, layout: &Layout, record: &csv::StringRecord) -> Result<(), String> {
        let time = layout.time(record, &mut self.origin)?;
        if let Some(before) = self.time.last()
            && time < *before
        {
            return Err(format!(
                "time runs backwards, from {before} s to {time} s after the first row; allowed: rows in \
                     the order in which they were taken (a second run? give it as a file of its own)"
            ));
        }
        let angle = layout.angle(record)?;
        let volts = layout.volts(record)?;
        if self.time.last().is_some_and(|before| time <= *before) {
            self.repeated += 1;
            let same = self.angle.last() == Some(&angle) && self.volts.last() == Some(&volts);
            self.differing += usize::from(!same);
            return Ok(());
        }
        if volts.main.abs() > MOST_VOLTS || volts.tail.abs() > MOST_VOLTS {
            return Err(format!(
                "volts of {}, {}; allowed: at most {MOST_VOLTS} V (other units? say so: columns v0=NAME:mV, \
                 or \
                 NAME:duty0.24 for percent of 24 V)",
                volts.main, volts.tail
            ));
        }
        self.time.push(time);
        self.angle.push(angle);
        self.volts.push(volts);
        self.rotor_speed.extend(layout.rotor_speed(record)?);
        self.reference.extend(layout.reference(record)?);
        Ok(())
    }

    fn into_log(mut self, name: &str, layout: &Layout, rig: &Rig) -> Result<Log, String> {
        let rows = self.time.len();
        if rows < FEWEST_ROWS {
            return Err(format!("has {rows} rows with a time of their own; allowed: at least {FEWEST_ROWS}"));
        }
        if self.differing as f64 > MOST_DIFFERING * rows as f64 {
            return Err(format!(
                "t: {} of {} rows have the time of the one before, and other angles or volts; allowed: a \
                 time \
                 for each row (are times written with too few digits?)",
                self.differing,
                rows + self.repeated
            ));
        }
        let mut notes = layout.alone();
        if self.repeated > 0 {
            notes.push(format!("{} rows repeat the time of the one before; left out", self.repeated));
        }
        check_volts(&self.volts, rig, &mut notes)?;
        time::check_unit(&self.time)?;
        self.mend_angles(layout, rig, &mut notes)?;
        let clock = time::even_out(&mut self)?;
        notes.extend(clock.notes);
        let log = Log {
            name: name.to_owned(),
            sample_time: clock.sample_time,
            time: self.time,
            angle: self.angle,
            volts: self.volts,
            rotor_speed: (!self.rotor_speed.is_empty()).then_some(self.rotor_speed),
            reference: (!self.reference.is_empty()).then_some(self.reference),
            stretches: clock.stretches,
            notes,
        };
        check_motion(log)
    }

    /// Refuses angles in other units than was said, and mends those that jump.
    fn mend_angles(&mut self, layout: &Layout, rig: &Rig, notes: &mut Vec<String>) -> Result<(), String> {
        let mut of_axis = |axis: &str, angle: &mut Vec<f64>| {
            notes.extend(units::check(axis, angle, &self.time, layout, rig)?);
            let counts = layout.counts(axis);
            notes.extend(jumps::mend(axis, angle, &self.time, counts)?);
            Ok::<(), String>(())
        };
        let mut pitch: Vec<f64> = self.angle.iter().map(|a| a.pitch).collect();
        let mut yaw: Vec<f64> = self.angle.iter().map(|a| a.yaw).collect();
        of_axis("pitch", &mut pitch)?;
        units::check_pitch(&pitch, MOST_PITCH)?;
        of_axis("yaw", &mut yaw)?;
        self.angle = pitch.into_iter().zip(yaw).map(|(pitch, yaw)| PerAxis { pitch, yaw }).collect();
        Ok(())
    }
}

/// Refuses volts beyond what the rig's motors are given: they are no volts, or of another rig. Tells what
/// looks like a duty cycle, and one column for both motors.
fn check_volts(volts: &[PerMotor<f64>], rig: &Rig, notes: &mut Vec<String>) -> Result<(), String> {
    let most =
        volts.iter().fold(PerMotor::zero(), |most: PerMotor<f64>, v| most.zip(*v, |m, v| m.max(v.abs())));
    let limit = rig.volts_limit;
    for (name, most, limit) in [("v0", most.main, limit.main), ("v1", most.tail, limit.tail)] {
        if most > 1.02 * limit {
            return Err(format!(
                "{name} reaches {most} V; allowed: the preset's limit of {limit} V (other units? say so: \
                 columns {name}=NAME:mV, or NAME:duty{} for percent of {limit} V)",
                limit / 100.0
            ));
        }
    }
    if volts.iter().all(|v| *v == volts[0]) {
        return Err("nothing is asked of the motors: v0 and v1 are constant".to_owned());
    }
    if most.main.max(most.tail) <= DUTY_CYCLE {
        notes.push(format!(
            "v0 and v1 stay within ±{DUTY_CYCLE} on a rig of {}/{} V: if they are duty cycles, say so: \
             columns \
             v0=NAME:duty{},v1=NAME:duty{}",
            limit.main, limit.tail, limit.main, limit.tail
        ));
    }
    if volts.iter().all(|v| (v.main - v.tail).abs() <= f64::EPSILON * v.main.abs()) {
        notes.push(
            "v0 and v1 are the same in every row: one column twice? Which motor does what, such a log cannot \
             tell"
                .to_owned(),
        );
    }
    Ok(())
}

/// Refuses what cannot be identified from, and tells of an axis that stands still.
fn check_motion(mut log: Log) -> Result<Log, String> {
    let moves = log.moves();
    if !moves.pitch && !moves.yaw {
        return Err("nothing moves: pitch and yaw are constant".to_owned());
    }
    if log.angle.iter().all(|a| (a.pitch - a.yaw).abs() <= f64::EPSILON * a.yaw.abs()) {
        return Err("pitch and yaw are the same in every row; allowed: a column for each".to_owned());
    }
    for (axis, moves, other) in [("pitch", moves.pitch, "yaw"), ("yaw", moves.yaw, "pitch")] {
        if !moves {
            log.notes.push(format!("{axis} never changes: taken as locked, only {other} is compared"));
        }
    }
    Ok(log)
}

fn one_line(error: &csv::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
