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

/// \[V\] More than any of these rigs takes.
pub(super) const MOST_VOLTS: f64 = 60.0;

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
            (Self::Time, "ns") => Some(1e-9),
            (Self::Angle, "deg") | (Self::Speed, "deg/s") => Some(turn / 360.0),
            (Self::Angle, "mrad") => Some(1e-3),
            (Self::Angle, "turn") => Some(turn),
            (Self::Speed, "rpm") => Some(turn / 60.0),
            (Self::Angle, _) => {
                let counts: u32 = unit.strip_prefix("counts")?.parse().ok()?;
                (counts > 0).then(|| turn / f64::from(counts))
            }
            (Self::Volts, _) => {
                let full: f64 = unit.strip_prefix("duty")?.parse().ok()?;
                (full > 0.0 && full <= MOST_VOLTS).then_some(full)
            }
            _ => None,
        }
    }

    fn units(self) -> &'static str {
        match self {
            Self::Time => "s, ms, us, ns",
            Self::Angle => "rad, deg, countsN (N a turn), mrad, turn",
            Self::Volts => "V, mV, dutyN (N volts at a duty cycle of 1)",
            Self::Speed => "rad/s, deg/s, rpm",
        }
    }
}

/// A column as it is called and scaled in a file.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    name: String,
    factor: f64,
    unit: Option<String>,
}

/// How to read a log's columns: by their own names in SI units, but for what is said otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns([Source; COLUMNS.len()]);

impl Default for Columns {
    fn default() -> Self {
        Self(COLUMNS.map(|(name, ..)| Source { name: name.to_owned(), factor: 1.0, unit: None }))
    }
}

impl Columns {
    /// From text such as `t=time:ms,pitch=-theta:deg,v0=u_main`: our name, `=`, minus for the other sign, the
    /// file's name, `:` and a unit. What is not mentioned is called and scaled as we do.
    ///
    /// # Errors
    ///
    /// If there is no such column or unit, or one is named twice.
    pub fn parse(text: &str) -> Outcome<Self> {
        let mut columns = Self::default();
        let mut named = [false; COLUMNS.len()];
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
            if std::mem::replace(&mut named[index], true) {
                return Err(bad(format!("names {} a second time; allowed: once", COLUMNS[index].0)));
            }
            let unit = unit.map(str::to_owned);
            columns.0[index] = Source { name: name.to_owned(), factor: sign * scale, unit };
        }
        Ok(columns)
    }

    /// Where each column stands in a file with this header.
    pub(super) fn locate(&self, header: &csv::StringRecord) -> Result<Layout, String> {
        let found: Vec<&str> = header.iter().collect();
        if found.iter().all(|name| name.is_empty()) {
            return Err("is empty; allowed: a CSV file whose first row names its columns".to_owned());
        }
        // Some programs write a byte order mark before the first name.
        let places = |name: &str| -> Vec<usize> {
            let same = |k: &usize| found[*k].trim_start_matches('\u{feff}') == name;
            (0..found.len()).filter(same).collect()
        };
        let mut at = [None; COLUMNS.len()];
        for (k, (source, (ours, _, needed))) in self.0.iter().zip(COLUMNS).enumerate() {
            let places = places(&source.name);
            if places.len() > 1 {
                return Err(format!(
                    "has {} columns called '{}'; allowed: one, so that it is clear which is meant",
                    places.len(),
                    source.name
                ));
            }
            at[k] = places.first().copied();
            if at[k].is_none() && (needed || source.name != ours) {
                return Err(format!(
                    "has no column '{}'; it has: {} (name it: columns {ours}=NAME:UNIT)",
                    source.name,
                    found.join(", ")
                ));
            }
            if let Some(other) = (0..k).find(|j| at[*j].is_some() && at[*j] == at[k]) {
                return Err(format!(
                    "'{}' would be both {} and {ours}; allowed: a column of its own for each",
                    source.name, COLUMNS[other].0
                ));
            }
        }
        Ok(Layout { columns: self.clone(), at })
    }
}

/// A time as it is written, in whole units and the rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    whole: i128,
    part: f64,
}

impl Moment {
    fn parse(text: &str) -> Option<Self> {
        let value: f64 = text.parse().ok().filter(|value: &f64| value.is_finite() && value.abs() < 1e24)?;
        let (whole, part) = text.split_once('.').unwrap_or((text, ""));
        let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
        if !whole.is_empty() && digits(whole) && digits(part) {
            let part = if part.is_empty() { 0.0 } else { format!("0.{part}").parse().ok()? };
            return Some(Self { whole: whole.parse().ok()?, part });
        }
        #[expect(clippy::cast_possible_truncation, reason = "it was found to be small enough")]
        let whole = value.floor() as i128;
        Some(Self { whole, part: value - value.floor() })
    }
}

/// Columns found in a file.
#[derive(Debug)]
pub(super) struct Layout {
    columns: Columns,
    at: [Option<usize>; COLUMNS.len()],
}

impl Layout {
    /// How much of the SI unit one of the file's unit is, without the sign, and the unit if one was said.
    pub(super) fn unit(&self, ours: &str) -> (f64, Option<&str>) {
        let found = COLUMNS.iter().zip(&self.columns.0).find(|((name, ..), _)| *name == ours);
        found.map_or((1.0, None), |(_, source)| (source.factor.abs(), source.unit.as_deref()))
    }

    /// Counts a turn, where that is the unit that was said.
    pub(super) fn counts(&self, ours: &str) -> Option<f64> {
        self.unit(ours).1?.strip_prefix("counts")?.parse().ok()
    }

    /// What is there but of no use without its partner: a line for each.
    pub(super) fn alone(&self) -> Vec<String> {
        let name = |k: usize| COLUMNS[k].0;
        [(5, 6), (6, 5), (7, 8), (8, 7)]
            .into_iter()
            .filter(|(here, there)| self.at[*here].is_some() && self.at[*there].is_none())
            .map(|(here, there)| {
                let (here, there) = (name(here), name(there));
                format!("{here} is there without {there}: it is not read; name both or none")
            })
            .collect()
    }

    fn text<'r>(&self, record: &'r csv::StringRecord, index: usize) -> Option<&'r str> {
        self.at[index].map(|at| record.get(at).unwrap_or_default())
    }

    fn number(&self, record: &csv::StringRecord, index: usize) -> Result<Option<f64>, String> {
        let Some(text) = self.text(record, index) else { return Ok(None) };
        let source = &self.columns.0[index];
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

    /// \[s\] Since the log's `origin`, which the first row sets: taken off before anything is scaled, since
    /// seconds since 1970 leave no digits for microseconds.
    pub(super) fn time(
        &self,
        record: &csv::StringRecord,
        origin: &mut Option<Moment>,
    ) -> Result<f64, String> {
        let (source, text) = (&self.columns.0[0], self.text(record, 0).unwrap_or_default());
        let moment = Moment::parse(text)
            .ok_or_else(|| format!("{} is '{text}'; allowed: a finite number", source.name))?;
        let origin = origin.get_or_insert(moment);
        Ok(source.factor * ((moment.whole - origin.whole) as f64 + (moment.part - origin.part)))
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
