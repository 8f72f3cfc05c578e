//! Which column of a file is what, in which unit and with which sign.

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor_sim::{Error, Outcome};

/// What may stand in a log: its name, its kind, and whether a log needs it.
pub const COLUMNS: [(&str, Kind, bool); 9] = [
    ("t", Kind::Time, true),
    ("pitch", Kind::Angle, true),
    ("yaw", Kind::Angle, true),
    ("v0", Kind::Volts, true),
    ("v1", Kind::Volts, true),
    ("w0", Kind::Speed, false),
    ("w1", Kind::Speed, false),
    ("ref_pitch", Kind::Angle, false),
    ("ref_yaw", Kind::Angle, false),
];

/// What a column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// \[s\]
    Time,
    /// \[rad\]
    Angle,
    /// \[V\]
    Volts,
    /// \[rad/s\]
    Speed,
}

impl Kind {
    /// How much of the SI unit one of `unit` is.
    fn scale(self, unit: &str) -> Option<f64> {
        let turn = std::f64::consts::TAU;
        match (self, unit) {
            (Self::Time, "s") | (Self::Angle, "rad") | (Self::Volts, "V") | (Self::Speed, "rad/s") => {
                Some(1.0)
            }
            (Self::Time, "ms") | (Self::Volts, "mV") => Some(1e-3),
            (Self::Time, "us") => Some(1e-6),
            (Self::Angle, "deg") | (Self::Speed, "deg/s") => Some(turn / 360.0),
            (Self::Speed, "rpm") => Some(turn / 60.0),
            (Self::Angle, _) => {
                let counts: u32 = unit.strip_prefix("counts")?.parse().ok()?;
                (counts > 0).then(|| turn / f64::from(counts))
            }
            _ => None,
        }
    }

    fn units(self) -> &'static str {
        match self {
            Self::Time => "s, ms, us",
            Self::Angle => "rad, deg, countsN (N a turn)",
            Self::Volts => "V, mV",
            Self::Speed => "rad/s, deg/s, rpm",
        }
    }
}

/// A column as it is called and scaled in a file.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    name: String,
    factor: f64,
}

/// How to read a log's columns: by their own names in SI units, but for what is said otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns([Source; COLUMNS.len()]);

impl Default for Columns {
    fn default() -> Self {
        Self(COLUMNS.map(|(name, ..)| Source { name: name.to_owned(), factor: 1.0 }))
    }
}

impl Columns {
    /// From text such as `t=time:ms,pitch=-theta:deg,v0=u_main`: our name, `=`, minus for the other sign, the
    /// file's name, `:` and a unit. What is not mentioned is called and scaled as we do.
    ///
    /// # Errors
    ///
    /// If there is no such column or unit.
    pub fn parse(text: &str) -> Outcome<Self> {
        let mut columns = Self::default();
        for part in text.split(',').filter(|part| !part.trim().is_empty()) {
            let bad = |why: String| Error::Unusable(format!("'{}' {why}", part.trim())).within("columns");
            let (ours, theirs) = part
                .split_once('=')
                .ok_or_else(|| bad("has no '='; allowed: pitch=theta, pitch=-theta:deg".to_owned()))?;
            let known = COLUMNS.iter().position(|(name, ..)| *name == ours.trim());
            let index = known.ok_or_else(|| {
                let names: Vec<&str> = COLUMNS.iter().map(|(name, ..)| *name).collect();
                bad(format!("names no column of ours; allowed: {}", names.join(", ")))
            })?;
            let (name, unit) =
                theirs.rsplit_once(':').map_or((theirs, None), |(name, unit)| (name, Some(unit.trim())));
            let kind = COLUMNS[index].1;
            let scale = unit.map_or(Some(1.0), |unit| kind.scale(unit));
            let scale =
                scale.ok_or_else(|| bad(format!("has an unknown unit; allowed: {}", kind.units())))?;
            let (name, sign) = name.trim().strip_prefix('-').map_or((name.trim(), 1.0), |name| (name, -1.0));
            if name.is_empty() {
                return Err(bad("names no column of the file".to_owned()));
            }
            columns.0[index] = Source { name: name.to_owned(), factor: sign * scale };
        }
        Ok(columns)
    }

    /// Where each column stands in a file with this header.
    pub(super) fn locate(&self, header: &csv::StringRecord) -> Result<Layout, String> {
        let found: Vec<&str> = header.iter().collect();
        if found.iter().all(|name| name.is_empty()) {
            return Err("is empty; allowed: a CSV file whose first row names its columns".to_owned());
        }
        let mut at = [None; COLUMNS.len()];
        for ((source, (ours, _, needed)), at) in self.0.iter().zip(COLUMNS).zip(&mut at) {
            // Some programs write a byte order mark before the first name.
            *at = found.iter().position(|name| name.trim_start_matches('\u{feff}') == source.name);
            if at.is_none() && (needed || source.name != ours) {
                return Err(format!(
                    "has no column '{}'; it has: {} (name it: columns {ours}=NAME:UNIT)",
                    source.name,
                    found.join(", ")
                ));
            }
        }
        Ok(Layout { columns: self.clone(), at })
    }
}

/// Columns found in a file.
#[derive(Debug)]
pub(super) struct Layout {
    columns: Columns,
    at: [Option<usize>; COLUMNS.len()],
}

impl Layout {
    /// Is this column taken for radians because nothing else was said?
    pub(super) fn is_plain_rad(&self, ours: &str) -> bool {
        COLUMNS
            .iter()
            .zip(&self.columns.0)
            .any(|((name, ..), source)| *name == ours && (source.factor.abs() - 1.0).abs() < 1e-12)
    }

    fn number(&self, record: &csv::StringRecord, index: usize) -> Result<Option<f64>, String> {
        let Some(at) = self.at[index] else { return Ok(None) };
        let (source, text) = (&self.columns.0[index], record.get(at).unwrap_or_default());
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value * source.factor)),
            _ => Err(format!("{} is '{text}'; allowed: a finite number", source.name)),
        }
    }

    fn needed(&self, record: &csv::StringRecord, index: usize) -> Result<f64, String> {
        self.number(record, index).map(|value| value.unwrap_or(f64::NAN))
    }

    fn both(&self, record: &csv::StringRecord, indices: [usize; 2]) -> Result<Option<[f64; 2]>, String> {
        let [first, second] = indices;
        Ok(self.number(record, first)?.zip(self.number(record, second)?).map(|(a, b)| [a, b]))
    }

    pub(super) fn time(&self, record: &csv::StringRecord) -> Result<f64, String> {
        self.needed(record, 0)
    }

    pub(super) fn angle(&self, record: &csv::StringRecord) -> Result<PerAxis<f64>, String> {
        Ok(PerAxis { pitch: self.needed(record, 1)?, yaw: self.needed(record, 2)? })
    }

    pub(super) fn volts(&self, record: &csv::StringRecord) -> Result<PerMotor<f64>, String> {
        Ok(PerMotor { main: self.needed(record, 3)?, tail: self.needed(record, 4)? })
    }

    pub(super) fn rotor_speed(&self, record: &csv::StringRecord) -> Result<Option<PerMotor<f64>>, String> {
        Ok(self.both(record, [5, 6])?.map(|[main, tail]| PerMotor { main, tail }))
    }

    pub(super) fn reference(&self, record: &csv::StringRecord) -> Result<Option<PerAxis<f64>>, String> {
        Ok(self.both(record, [7, 8])?.map(|[pitch, yaw]| PerAxis { pitch, yaw }))
    }
}
