//! What is to be flown: references, for how long, and what disturbs.

use crate::error::{Error, Outcome, at_least, known_name};
use crate::metrics::Step;
use crate::{Read, is_text, toml};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Deserialize;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::trajectory::{MAX_JUMPS, Profile, Trajectory, ticks};

pub use twinrotor::SAMPLE_TIME;

/// Longest flight \[s\]: a day would fill the memory with rows.
const LONGEST: f64 = 3_600.0;

/// What a scenario's references are.
#[derive(Debug, Clone, PartialEq)]
enum Source {
    Step,
    Sine,
    SquareYaw,
    SquarePitch,
    File(PerAxis<Course>),
}

/// Something to fly.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Its name, or the path of its file.
    pub name: String,
    source: Source,
    /// \[s\] How long.
    pub duration: f64,
    /// What is added to the volts in effect.
    pub disturbance: Option<Disturbance>,
}

/// Random volts added to what acts on each motor: uniform within ±volts, a new value every `hold`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// \[V\] Amplitude, at least 0.
    pub volts: f64,
    /// \[s\] How long a value holds, above 0.
    pub hold: f64,
    /// \[s\] From when to when; before and after there is none.
    pub window: [f64; 2],
}

/// The disturbance of scenario 3, eqs (38)-(39): for 20 s. The paper gives neither amplitude nor hold time.
const SCENARIO_3: Disturbance = Disturbance { volts: 2.0, hold: 0.1, window: [0.0, 20.0] };

impl Scenario {
    /// One of the paper's by name, or from the text of that name (anything that ends in `.toml`).
    ///
    /// # Errors
    ///
    /// If there is none, or the text is not one of a scenario that can be flown.
    pub fn load(name: &str, read: Read<'_>) -> Outcome<Self> {
        if is_text(name) {
            return Self::parse(name, &read(name)?);
        }
        Self::named(name)
    }

    /// One of the paper's: `step`, `1`, `2`, `3`, `3-square`.
    ///
    /// # Errors
    ///
    /// If there is none of that name.
    pub fn named(name: &str) -> Outcome<Self> {
        let of = |source, duration, disturbance| (source, duration, disturbance);
        let known = [
            ("step", of(Source::Step, 5.0, None)),
            ("1", of(Source::Sine, 40.0, None)),
            ("2", of(Source::SquareYaw, 40.0, None)),
            ("3", of(Source::Sine, 40.0, Some(SCENARIO_3))),
            ("3-square", of(Source::SquarePitch, 40.0, Some(SCENARIO_3))),
        ];
        let (source, duration, disturbance) = known_name("scenario", name, &known)?.clone();
        Ok(Self { name: name.to_owned(), source, duration, disturbance })
    }

    /// From the text of a scenario file, called `path` in what is said of it.
    ///
    /// # Errors
    ///
    /// If it is not one of a scenario that can be flown.
    pub fn parse(path: &str, text: &str) -> Outcome<Self> {
        let file: File = toml::parse(path, text)?;
        let in_file = |e: Error| e.within(path);
        file.pitch.validate("pitch").map_err(in_file)?;
        file.yaw.validate("yaw").map_err(in_file)?;
        let scenario = Self {
            name: path.to_owned(),
            source: Source::File(PerAxis::new(file.pitch, file.yaw)),
            duration: file.duration,
            disturbance: file.disturbance,
        };
        scenario.validate().map_err(in_file)?;
        Ok(scenario)
    }

    /// Duration and disturbance usable?
    ///
    /// # Errors
    ///
    /// If not: which number, and what is allowed.
    pub fn validate(&self) -> Outcome<()> {
        at_least("duration", self.duration, 0.0, true)?;
        if self.duration > LONGEST {
            return Err(Error::invalid("duration", self.duration, format_args!("at most {LONGEST} s")));
        }
        if self.duration < SAMPLE_TIME {
            let allowed = format_args!("at least one tick of {SAMPLE_TIME} s");
            return Err(Error::invalid("duration", self.duration, allowed));
        }
        let Some(d) = self.disturbance else { return Ok(()) };
        at_least("disturbance", d.volts, 0.0, false)?;
        at_least("hold", d.hold, 0.0, true)?;
        at_least("window's start", d.window[0], 0.0, false)?;
        at_least("window's end", d.window[1], d.window[0], false)?;
        Ok(())
    }

    /// The last tick; the flight has one more.
    pub fn last_tick(&self) -> u32 {
        ticks(self.duration, SAMPLE_TIME)
    }

    /// The references in the arithmetic `R`.
    pub fn trajectory<R: Real<Scalar = R>>(&self) -> Trajectory<R> {
        match &self.source {
            Source::Step => Trajectory::paper_step(),
            Source::Sine => Trajectory::paper_sine(SAMPLE_TIME),
            Source::SquareYaw => Trajectory::paper_square_yaw(SAMPLE_TIME),
            Source::SquarePitch => Trajectory::paper_square_pitch(SAMPLE_TIME),
            Source::File(paths) => PerAxis { pitch: paths.pitch.profile(), yaw: paths.yaw.profile() },
        }
    }

    /// The reference of every tick.
    pub fn references<R: Real<Scalar = R>>(&self) -> Vec<Reference<R>> {
        let trajectory = self.trajectory::<R>();
        (0..=self.last_tick()).map(|tick| trajectory.at(tick)).collect()
    }

    /// The disturbance of every tick \[V\].
    pub fn disturbances<R: Real<Scalar = R>>(&self, seed: u64) -> Vec<PerMotor<R>> {
        let last = self.last_tick();
        let Some(d) = self.disturbance else {
            return vec![PerMotor::zero(); last as usize + 1];
        };
        let hold = ticks(d.hold, SAMPLE_TIME).max(1);
        let [from, to] = d.window.map(|t| ticks(t, SAMPLE_TIME));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || PerMotor::new(rng.random_range(-1.0..=1.0), rng.random_range(-1.0..=1.0));
        let mut value = PerMotor::both(0.0);
        let at = |tick: u32| {
            if tick < from || tick >= to {
                return PerMotor::zero();
            }
            if (tick - from).is_multiple_of(hold) {
                value = draw();
            }
            value.map(|x: f64| R::from_f64(d.volts * x))
        };
        (0..=last).map(at).collect()
    }

    /// The last step of each axis' reference, for a start at `initial` \[rad\].
    pub fn steps(&self, initial: PerAxis<f64>) -> PerAxis<Option<Step>> {
        let last = self.last_tick();
        let trajectory = self.trajectory::<f64>();
        let of = |profile: &Profile<f64>, initial: f64| {
            let Profile::Steps { .. } = profile else { return None };
            let angle = |tick: u32| profile.at(tick)[0];
            let change = |tick: u32| if tick == 0 { initial } else { angle(tick - 1) };
            (0..last)
                .rev()
                .map(|tick| Step { tick, from: change(tick), to: angle(tick) })
                .find(|step| (step.from - step.to).abs() > 0.0)
        };
        PerAxis { pitch: of(&trajectory.pitch, initial.pitch), yaw: of(&trajectory.yaw, initial.yaw) }
    }
}

/// A scenario file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    duration: f64,
    pitch: Course,
    yaw: Course,
    disturbance: Option<Disturbance>,
}

/// How one axis' reference runs, as files have it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Course {
    Steps {
        #[serde(default)]
        initial_deg: f64,
        /// \[s, deg\]
        jumps: Vec<[f64; 2]>,
        /// \[s\] 0 for never.
        #[serde(default)]
        period: f64,
    },
    Sine {
        #[serde(default)]
        offset_deg: f64,
        amplitude_deg: f64,
        /// \[rad/s\]
        frequency: f64,
        #[serde(default)]
        phase_deg: f64,
    },
}

impl Course {
    fn validate(&self, axis: &str) -> Outcome<()> {
        let finite = |field: &str, value: f64| at_least(&format!("{axis}.{field}"), value, f64::MIN, false);
        match self {
            Self::Steps { initial_deg, jumps, period } => {
                finite("initial_deg", *initial_deg)?;
                at_least(&format!("{axis}.period"), *period, 0.0, false)?;
                if jumps.len() > MAX_JUMPS {
                    return Err(Error::invalid(
                        format_args!("{axis}.jumps"),
                        format_args!("{} entries long", jumps.len()),
                        format_args!("at most {MAX_JUMPS}"),
                    ));
                }
                let mut before = 0.0;
                for [time, angle] in jumps {
                    at_least(&format!("{axis}.jumps: a time"), *time, before, false)?;
                    finite("jumps: an angle", *angle)?;
                    before = *time;
                }
                if *period > 0.0 && *period <= before {
                    let allowed = format_args!("0 for never, or above {before} s, or that jump never comes");
                    return Err(Error::invalid(format_args!("{axis}.period"), period, allowed));
                }
            }
            Self::Sine { offset_deg, amplitude_deg, frequency, phase_deg } => {
                finite("offset_deg", *offset_deg)?;
                finite("amplitude_deg", *amplitude_deg)?;
                finite("phase_deg", *phase_deg)?;
                at_least(&format!("{axis}.frequency"), *frequency, 0.0, false)?;
            }
        }
        Ok(())
    }

    fn profile<R: Real<Scalar = R>>(&self) -> Profile<R> {
        match self {
            Self::Steps { initial_deg, jumps, period } => {
                let jumps: Vec<(f64, f64)> = jumps.iter().map(|[t, a]| (*t, a.to_radians())).collect();
                Profile::steps(initial_deg.to_radians(), &jumps, *period, SAMPLE_TIME)
            }
            Self::Sine { offset_deg, amplitude_deg, frequency, phase_deg } => Profile::sine(
                offset_deg.to_radians(),
                amplitude_deg.to_radians(),
                *frequency,
                phase_deg.to_radians(),
                SAMPLE_TIME,
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_gives_its_references() {
        let text = "duration = 3.0\n[pitch.sine]\namplitude_deg = 10.0\nfrequency = 2.0\n\
                    [yaw.steps]\njumps = [[1.0, 20.0], [2.0, -5.0]]\n";
        let scenario = Scenario::parse("mine.toml", text).unwrap();
        let references = scenario.references::<f64>();
        assert_eq!(references.len(), 3001);
        assert!((references[500].angle.pitch - 10.0_f64.to_radians() * 1.0_f64.sin()).abs() < 1e-12);
        assert!((references[2500].angle.yaw - (-5.0_f64).to_radians()).abs() < 1e-15);
        let steps = scenario.steps(PerAxis::zero());
        assert_eq!(steps.pitch, None);
        assert_eq!(steps.yaw.unwrap().tick, 2000);
    }

    #[test]
    fn a_bad_file_is_told_in_one_line() {
        let cases = [
            ("duration = -1.0", "duration is -1"),
            ("duration = nan", "duration is NaN"),
            ("duration = 1.0\nlength = 2", "unknown field `length`"),
        ];
        let axes = "\n[pitch.steps]\njumps = [[0.0, 20.0]]\n[yaw.steps]\njumps = [[0.0, 20.0]]\n";
        for (head, expected) in cases {
            let error = Scenario::parse("mine.toml", &format!("{head}{axes}")).unwrap_err().to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
        let hidden = "duration = 10\n[pitch.steps]\njumps = [[1, 10], [8, 20]]\nperiod = 4\n\
                      [yaw.steps]\njumps = []\n";
        let error = Scenario::parse("mine.toml", hidden).unwrap_err().to_string();
        assert!(error.contains("pitch.period is 4; allowed: 0 for never, or above 8 s"), "{error}");
        let huge = "duration = 10\n[pitch.steps]\njumps = [[1, 1e300]]\n[yaw.steps]\njumps = []\n";
        let error = Scenario::parse("mine.toml", huge).unwrap_err().to_string();
        assert!(error.contains("pitch.jumps: an angle is 1e300; allowed: at most 1e9"), "{error}");
        let back =
            "duration = 1.0\n[pitch.steps]\njumps = [[2.0, 1.0], [1.0, 2.0]]\n[yaw.steps]\njumps = []\n";
        let error = Scenario::parse("mine.toml", back).unwrap_err().to_string();
        assert!(
            error.contains("pitch.jumps: a time is 1; allowed: a finite number of at least 2"),
            "{error}"
        );
    }

    #[test]
    fn a_disturbance_stays_in_its_window_and_within_its_volts() {
        let mut scenario = Scenario::named("3").unwrap();
        scenario.disturbance = Some(Disturbance { volts: 1.5, hold: 0.25, window: [2.0, 4.0] });
        let d = scenario.disturbances::<f64>(7);
        assert!(d[..2000].iter().chain(&d[4000..]).all(|v| *v == PerMotor::zero()));
        assert!(d[2000..4000].iter().all(|v| v.main.abs() <= 1.5 && v.main != 0.0 && v.tail != v.main));
        let changes = d[2000..4000].windows(2).filter(|w| w[0] != w[1]).count();
        assert_eq!(changes, 7);
        assert_eq!(d, scenario.disturbances::<f64>(7));
        assert_ne!(d, scenario.disturbances::<f64>(8));
    }
}
