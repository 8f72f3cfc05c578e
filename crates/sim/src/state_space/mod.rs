//! A law of matrices as a gains file holds it, and whether its loop is stable on a rig.
//!
//! ```toml
//! controller = "state-space"
//!
//! [state-space]
//! inputs = ["angle_error.pitch", "angle_error.yaw"]
//! outputs = ["volts.main", "volts.tail"]
//! sample_time = 0.001
//! A = [[1.0, 0.0], [0.0, 1.0]]
//! B = [[0.001, 0.0], [0.0, 0.001]]
//! C = [[20.0, 0.0], [0.0, 20.0]]
//! D = [[60.0, 0.0], [0.0, 60.0]]
//! saturation = [18.0, 18.0]
//! feed_forward = true
//! anti_windup = "hold"
//! ```
//!
//! The last three may be left out. What they mean is in [`twinrotor::law`]'s `state_space`.

#[cfg(test)]
mod tests;

use crate::flight::Fidelity;
use crate::gains_file::GainsFile;
use crate::margins;
use crate::scenario::SAMPLE_TIME;
use crate::{Error, Outcome};
use serde::{Deserialize, Serialize};
use twinrotor::axes::PerMotor;
use twinrotor::law::{LawSettings, MOST_INPUTS, MOST_STATES, Signal, StateSpaceGains};
use twinrotor::plant::presets::Rig;
use twinrotor::settings::LARGEST;

/// The law's name, and that of its table.
pub(crate) const NAME: &str = "state-space";
/// What an output can be, in the order of the rows of C and D that the board has.
const OUTPUTS: [&str; 2] = ["volts.main", "volts.tail"];
/// The anti-windup that needs no matrix.
const HOLD: &str = "hold";

/// The table, as it is written.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Document {
    inputs: Vec<String>,
    outputs: Vec<String>,
    sample_time: f64,
    #[serde(rename = "A")]
    a: Vec<Vec<f64>>,
    #[serde(rename = "B")]
    b: Vec<Vec<f64>>,
    #[serde(rename = "C")]
    c: Vec<Vec<f64>>,
    #[serde(rename = "D")]
    d: Vec<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    saturation: Option<Vec<f64>>,
    #[serde(default = "yes")]
    feed_forward: bool,
    #[serde(default = "hold")]
    anti_windup: AntiWindup,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged, expecting = "\"hold\", or a matrix with a row for each state and a column for each output")]
enum AntiWindup {
    Named(String),
    Matrix(Vec<Vec<f64>>),
}

fn yes() -> bool {
    true
}

fn hold() -> AntiWindup {
    AntiWindup::Named(HOLD.to_owned())
}

fn invalid(
    field: impl std::fmt::Display,
    value: impl std::fmt::Display,
    allowed: impl std::fmt::Display,
) -> Error {
    Error::invalid(format_args!("{NAME}.{field}"), value, allowed)
}

/// The law that a file's tables beside `controller` hold.
///
/// # Errors
///
/// Names the field, what it is and what is allowed.
pub(crate) fn read(mut tables: toml::Table) -> Result<StateSpaceGains<f64>, String> {
    if MOST_STATES == 0 {
        return Err("a law of matrices flies by host-sim, and not in a page".to_owned());
    }
    let own =
        tables.remove(NAME).ok_or_else(|| format!("missing field `{NAME}`: the table of the matrices"))?;
    if let Some((other, _)) = tables.into_iter().next() {
        return Err(format!("unknown field `{other}`: a law of matrices has the table `{NAME}` alone"));
    }
    let document = Document::deserialize(own).map_err(|e| format!("{NAME}: {}", e.message()))?;
    document.gains().map_err(|e| e.to_string())
}

/// The law as a file's table beside `controller`.
pub(crate) fn write(gains: &StateSpaceGains<f64>) -> toml::Table {
    if MOST_STATES == 0 {
        return toml::Table::new();
    }
    let (n, signals) = (gains.states as usize, gains.signals());
    let m = signals.len();
    let name =
        |signal: &Signal| Signal::ALL.iter().find(|(_, known)| known == signal).map_or("", |(name, _)| name);
    let saturation = gains.saturation;
    let document = Document {
        inputs: signals.iter().map(|signal| name(signal).to_owned()).collect(),
        outputs: OUTPUTS.map(str::to_owned).to_vec(),
        sample_time: SAMPLE_TIME,
        a: gains.a[..n].iter().map(|row| row[..n].to_vec()).collect(),
        b: gains.b[..n].iter().map(|row| row[..m].to_vec()).collect(),
        c: [gains.c.main, gains.c.tail].map(|row| row[..n].to_vec()).to_vec(),
        d: [gains.d.main, gains.d.tail].map(|row| row[..m].to_vec()).to_vec(),
        saturation: (saturation != PerMotor::both(LARGEST)).then(|| vec![saturation.main, saturation.tail]),
        feed_forward: gains.feed_forward,
        anti_windup: if gains.corrected {
            AntiWindup::Matrix(gains.anti_windup[..n].iter().map(|row| vec![row.main, row.tail]).collect())
        } else {
            hold()
        },
    };
    let table = toml::Value::try_from(document).expect("it is made of lists and numbers");
    toml::Table::from_iter([(NAME.to_owned(), table)])
}

impl GainsFile {
    /// Refuses a law of matrices whose sampled loop on `rig`, called `name`, is unstable about the level
    /// pose: see [`margins`]. Other laws are taken as they are, as what is said of a law here may be tuned.
    ///
    /// # Errors
    ///
    /// Says how fast a small error grows.
    pub fn require_stable(&self, name: &str, rig: &Rig) -> Outcome<()> {
        if !matches!(self.controller.law, LawSettings::StateSpace(_)) {
            return Ok(());
        }
        let pole = margins::slowest_pole(rig, &self.settings(rig));
        if pole > 0.0 {
            return Ok(());
        }
        Err(Error::Unusable(format!(
            "the sampled loop of this state-space law on {name} is unstable: a small error grows at {:.3} \
             /s; allowed: a loop in which it dies (margins tells its slowest pole)",
            -pole
        )))
    }

    /// The same before a flight in one of the two worlds: in the paper's the rotors have no lag.
    ///
    /// # Errors
    ///
    /// See [`GainsFile::require_stable`].
    pub fn require_stable_in(&self, fidelity: Fidelity, name: &str, rig: &Rig) -> Outcome<()> {
        let mut rig = *rig;
        if fidelity == Fidelity::Ideal {
            rig.plant.rotor_time_constant = PerMotor::zero();
        }
        self.require_stable(name, &rig)
    }
}

impl Document {
    /// The law that it is.
    pub(crate) fn gains(&self) -> Outcome<StateSpaceGains<f64>> {
        let n = self.a.len();
        if n > MOST_STATES {
            let allowed = format_args!("at most {MOST_STATES} states, a row and a column each");
            return Err(invalid("A", format_args!("a matrix of {n} rows"), allowed));
        }
        let signals = self.signals()?;
        let order = self.order()?;
        if self.sample_time != SAMPLE_TIME {
            let allowed = "0.001 s, the board's tick: sample the law for it, such as by c2d(sys, 0.001), or \
                           d2d(sys, 0.001) if it is sampled already";
            return Err(invalid("sample_time", self.sample_time, allowed));
        }
        let (m, p) = (signals.len(), order.len());
        let of_motor = |rows: &[Vec<f64>], motor: usize| {
            let row = order.iter().position(|output| *output == motor);
            row.map_or_else(Vec::new, |row| rows[row].clone())
        };
        let (state, input, output) = ("one for each state", "one for each input", "one for each output");
        matrix("A", &self.a, (n, state), (n, state))?;
        matrix("B", &self.b, (n, state), (m, input))?;
        matrix("C", &self.c, (p, output), (n, state))?;
        matrix("D", &self.d, (p, output), (m, input))?;
        let mut gains = StateSpaceGains::none();
        (gains.states, gains.inputs) = (count(n), count(m));
        for (to, from) in gains.signals.iter_mut().zip(&signals) {
            *to = *from;
        }
        gains.feed_forward = self.feed_forward;
        gains.c = PerMotor::new(0, 1).map(|motor| padded(&of_motor(&self.c, motor)));
        gains.d = PerMotor::new(0, 1).map(|motor| padded(&of_motor(&self.d, motor)));
        for (to, from) in gains.a.iter_mut().zip(&self.a) {
            *to = padded(from);
        }
        for (to, from) in gains.b.iter_mut().zip(&self.b) {
            *to = padded(from);
        }
        if let Some(most) = &self.saturation {
            matrix("saturation", std::slice::from_ref(most), (1, ""), (p, output))?;
            if let Some(value) = most.iter().find(|value| **value <= 0.0) {
                return Err(invalid("saturation", value, "a finite number above 0, in V"));
            }
            let of = |motor| order.iter().position(|output| *output == motor).map_or(LARGEST, |k| most[k]);
            gains.saturation = PerMotor::new(of(0), of(1));
        }
        match &self.anti_windup {
            AntiWindup::Named(name) if name == HOLD => {}
            AntiWindup::Named(name) => {
                let allowed = "\"hold\", or a matrix with a row for each state and a column for each output";
                return Err(invalid("anti_windup", format_args!("\"{name}\""), allowed));
            }
            AntiWindup::Matrix(rows) => {
                matrix("anti_windup", rows, (n, state), (p, output))?;
                gains.corrected = true;
                for (to, row) in gains.anti_windup.iter_mut().zip(rows) {
                    let of = |motor| order.iter().position(|output| *output == motor).map_or(0.0, |k| row[k]);
                    *to = PerMotor::new(of(0), of(1));
                }
            }
        }
        Ok(gains)
    }

    fn signals(&self) -> Outcome<Vec<Signal>> {
        if !(1..=MOST_INPUTS).contains(&self.inputs.len()) {
            let given = format_args!("a list of {}", self.inputs.len());
            return Err(invalid("inputs", given, format_args!("1 to {MOST_INPUTS} names of signals")));
        }
        let known = || Signal::ALL.map(|(name, _)| name).join(", ");
        let mut signals = Vec::new();
        for (k, name) in self.inputs.iter().enumerate() {
            let Some((_, signal)) = Signal::ALL.iter().find(|(known, _)| known == name) else {
                return Err(invalid(format_args!("inputs[{k}]"), format_args!("\"{name}\""), known()));
            };
            if signals.contains(signal) {
                let value = format_args!("\"{name}\" again");
                return Err(invalid(format_args!("inputs[{k}]"), value, "each signal once"));
            }
            signals.push(*signal);
        }
        Ok(signals)
    }

    /// Which of [`OUTPUTS`] each row of C and D is.
    fn order(&self) -> Outcome<Vec<usize>> {
        let allowed = "\"volts.main\" and \"volts.tail\", each at most once";
        let mut order = Vec::new();
        for (k, name) in self.outputs.iter().enumerate() {
            match OUTPUTS.iter().position(|known| known == name) {
                Some(output) if !order.contains(&output) => order.push(output),
                _ => return Err(invalid(format_args!("outputs[{k}]"), format_args!("\"{name}\""), allowed)),
            }
        }
        if order.is_empty() { Err(invalid("outputs", "an empty list", allowed)) } else { Ok(order) }
    }
}

/// Requires so many rows and so many numbers in each, all of them usable.
fn matrix(
    field: &str,
    rows: &[Vec<f64>],
    (n, of_row): (usize, &str),
    (m, of_column): (usize, &str),
) -> Outcome<()> {
    if rows.len() != n {
        let given = format_args!("a matrix of {} rows", rows.len());
        return Err(invalid(field, given, format_args!("{n} rows, {of_row}")));
    }
    for (i, row) in rows.iter().enumerate() {
        let place = |j: &str| if of_row.is_empty() { field.to_owned() } else { format!("{field}[{i}]{j}") };
        if row.len() != m {
            let given = format_args!("a list of {}", row.len());
            return Err(invalid(place(""), given, format_args!("{m} numbers, {of_column}")));
        }
        for (j, value) in row.iter().enumerate() {
            if !(value.is_finite() && value.abs() <= LARGEST) {
                let allowed = "a finite number of at most 1e9 in size";
                return Err(invalid(place(&format!("[{j}]")), value, allowed));
            }
        }
    }
    Ok(())
}

fn padded<const N: usize>(row: &[f64]) -> [f64; N] {
    std::array::from_fn(|k| row.get(k).copied().unwrap_or_default())
}

#[expect(clippy::cast_possible_truncation, reason = "at most eight")]
fn count(of: usize) -> u32 {
    of as u32
}
