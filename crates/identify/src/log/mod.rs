//! Logs of real rigs: angles and volts over time, from a CSV file, checked for what such files usually have
//! wrong.
//!
//! A log has one row for each sample: time, both angles as measured, and the volts that were sent after
//! reading them, held until the next row. What cannot be mended is refused in one line; what can (repeated
//! rows, gaps) is mended and told in [`Log::notes`].

mod columns;

pub use columns::{COLUMNS, Columns};

use std::io::Read;
use std::ops::Range;
use twinrotor::axes::{PerAxis, PerMotor};
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
/// A step in time longer than this many sample times is a gap.
const GAP: f64 = 1.5;
/// More gaps than this part of all steps is a log that is not sampled evenly.
const MOST_GAPS: f64 = 0.01;
/// \[s\] Sample times outside of this are of no use, or no seconds.
const SAMPLE_TIMES: [f64; 2] = [1e-4, 0.1];
/// \[rad\] A pitch beyond this is upside down, or no radians.
const MOST_PITCH: f64 = std::f64::consts::FRAC_PI_2;
/// \[V\] More than any of these rigs takes.
const MOST_VOLTS: f64 = 60.0;

impl Log {
    /// Reads CSV text whose first row names its columns, called `name` in what is said of it.
    ///
    /// # Errors
    ///
    /// If it is not one of a log, or of one that nothing can be learnt from: the line and what is wrong
    /// there.
    pub fn read(name: &str, source: impl Read, columns: &Columns) -> Outcome<Self> {
        let refuse = |why: String| Error::Unusable(why).within(name);
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(source);
        let header = reader.headers().map_err(|e| refuse(one_line(&e)))?.clone();
        let layout = columns.locate(&header).map_err(refuse)?;
        let mut raw = Raw::default();
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).map_err(|e| refuse(one_line(&e)))? {
            let line = record.position().map_or(0, csv::Position::line);
            raw.push(&layout, &record).map_err(|why| refuse(format!("line {line}: {why}")))?;
            if raw.time.len() > MOST_ROWS {
                return Err(refuse(format!("has more than {MOST_ROWS} rows; cut it into parts")));
            }
        }
        raw.into_log(name, &layout).map_err(refuse)
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

    /// Refuses volts beyond `limit` \[V\]: they are no volts, or of another rig.
    ///
    /// # Errors
    ///
    /// If there are any.
    pub fn check_volts(&self, limit: PerMotor<f64>) -> Outcome<()> {
        let most = self
            .volts
            .iter()
            .fold(PerMotor::zero(), |most: PerMotor<f64>, v| most.zip(*v, |m, v| m.max(v.abs())));
        for (name, most, limit) in [("v0", most.main, limit.main), ("v1", most.tail, limit.tail)] {
            if most > 1.02 * limit {
                return Err(Error::Unusable(format!(
                    "{name} reaches {most} V; allowed: the preset's limit of {limit} V (other units? say so: \
                     columns {name}=NAME:mV)"
                ))
                .within(&self.name));
            }
        }
        Ok(())
    }
}

/// Rows as they stand in the file, in SI units.
#[derive(Debug, Default)]
struct Raw {
    time: Vec<f64>,
    angle: Vec<PerAxis<f64>>,
    volts: Vec<PerMotor<f64>>,
    rotor_speed: Vec<PerMotor<f64>>,
    reference: Vec<PerAxis<f64>>,
    repeated: usize,
}

impl Raw {
    fn push(&mut self, layout: &columns::Layout, record: &csv::StringRecord) -> Result<(), String> {
        let time = layout.time(record)?;
        if let Some(before) = self.time.last() {
            if time < *before {
                return Err(format!("time runs backwards, from {before} s to {time} s"));
            }
            if time <= *before {
                self.repeated += 1;
                return Ok(());
            }
        }
        let angle = layout.angle(record)?;
        let volts = layout.volts(record)?;
        if volts.main.abs() > MOST_VOLTS || volts.tail.abs() > MOST_VOLTS {
            return Err(format!(
                "volts of {}, {}; allowed: at most {MOST_VOLTS} V (other units? say so: columns v0=NAME:mV)",
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

    fn into_log(mut self, name: &str, layout: &columns::Layout) -> Result<Log, String> {
        let rows = self.time.len();
        if rows < FEWEST_ROWS {
            return Err(format!("has {rows} rows with a time of their own; allowed: at least {FEWEST_ROWS}"));
        }
        let mut notes = Vec::new();
        if self.repeated > 0 {
            notes.push(format!("{} rows repeat the time of the one before; left out", self.repeated));
        }
        let begin = self.time[0];
        self.time.iter_mut().for_each(|t| *t -= begin);
        // To the nanosecond: differences of decimal times have noise in the last digits.
        let sample_time = (1e9 * median(self.time.windows(2).map(|t| t[1] - t[0]))).round() / 1e9;
        let [least, most] = SAMPLE_TIMES;
        if !(least..=most).contains(&sample_time) {
            return Err(format!(
                "rows are {sample_time} s apart; allowed: {least} to {most} s (other units? say so: columns \
                 t=NAME:ms)"
            ));
        }
        let stretches = stretches(&self.time, sample_time);
        let gaps = stretches.len() - 1;
        if gaps as f64 > MOST_GAPS * rows as f64 {
            return Err(format!(
                "has {gaps} gaps in {rows} rows: it is not sampled evenly every {sample_time} s"
            ));
        }
        if gaps > 0 {
            let lost: f64 =
                stretches.windows(2).map(|s| self.time[s[1].start] - self.time[s[0].end - 1]).sum();
            notes.push(format!("{gaps} gaps, {lost:.3} s in all; no window reaches across one"));
        }
        check_pitch(&self.angle)?;
        let reference = (!self.reference.is_empty()).then_some(self.reference);
        let mut log = Log {
            name: name.to_owned(),
            sample_time,
            time: self.time,
            angle: self.angle,
            volts: self.volts,
            rotor_speed: (!self.rotor_speed.is_empty()).then_some(self.rotor_speed),
            reference,
            stretches,
            notes,
        };
        check_motion(&mut log, layout)?;
        Ok(log)
    }
}

fn check_pitch(angle: &[PerAxis<f64>]) -> Result<(), String> {
    let most = angle.iter().fold(0.0_f64, |most, a| most.max(a.pitch.abs()));
    if most <= MOST_PITCH {
        return Ok(());
    }
    let whole = angle.iter().all(|a| a.pitch.fract().abs() < 1e-9);
    let unit = if whole {
        "counts of 2048 a turn? say so: columns pitch=NAME:counts2048"
    } else {
        "degrees? say so: columns pitch=NAME:deg"
    };
    Err(format!("pitch reaches {most}; allowed: within ±{MOST_PITCH:.2} rad ({unit})"))
}

/// Refuses what cannot be identified from, and degrees that are small enough to pass for radians.
fn check_motion(log: &mut Log, layout: &columns::Layout) -> Result<(), String> {
    let moves = log.moves();
    if !moves.pitch && !moves.yaw {
        return Err("nothing moves: pitch and yaw are constant".to_owned());
    }
    if log.volts.iter().all(|v| *v == log.volts[0]) {
        return Err("nothing is asked of the motors: v0 and v1 are constant".to_owned());
    }
    for (axis, moves, other) in [("pitch", moves.pitch, "yaw"), ("yaw", moves.yaw, "pitch")] {
        if !moves {
            log.notes.push(format!("{axis} never changes: taken as locked, only {other} is compared"));
        }
    }
    for (axis, of) in [("pitch", (|a| a.pitch) as fn(&PerAxis<f64>) -> f64), ("yaw", |a| a.yaw)] {
        if layout.is_plain_rad(axis) && looks_like_degrees(log.angle.iter().map(of)) {
            return Err(format!(
                "{axis} moves in steps of a whole part of 360, not of 2 pi: degrees, not rad; say so: \
                 columns {axis}=NAME:deg"
            ));
        }
    }
    Ok(())
}

/// Encoders of these rigs have 500 to 8192 counts a turn. Is every value a multiple of 360/N but not of 2π/N
/// for some N there is?
fn looks_like_degrees(values: impl Iterator<Item = f64> + Clone) -> bool {
    const COUNTS: [f64; 6] = [2000.0, 2048.0, 2880.0, 4000.0, 4096.0, 8192.0];
    let first = values.clone().next().unwrap_or(0.0);
    let fits = |turn: f64| {
        COUNTS.iter().any(|n| {
            values.clone().all(|v| {
                let counts = (v - first) * n / turn;
                (counts - counts.round()).abs() < 0.02
            })
        })
    };
    fits(360.0) && !fits(std::f64::consts::TAU)
}

fn stretches(time: &[f64], sample_time: f64) -> Vec<Range<usize>> {
    let starts =
        time.windows(2).enumerate().filter(|(_, t)| t[1] - t[0] > GAP * sample_time).map(|(k, _)| k + 1);
    let starts: Vec<usize> = std::iter::once(0).chain(starts).collect();
    let ends = starts.iter().skip(1).copied().chain([time.len()]);
    starts.iter().copied().zip(ends).map(|(from, to)| from..to).collect()
}

/// Of what has at least one value.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

fn one_line(error: &csv::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
