//! How one axis' reference runs, as files have it.

use super::SAMPLE_TIME;
use crate::error::{Error, Outcome, at_least};
use serde::Deserialize;
use twinrotor::real::Real;
use twinrotor::trajectory::{MAX_JUMPS, Profile};

/// How one axis' reference runs, as files have it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Course {
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
    /// Refuses what no axis could be asked for.
    pub(super) fn validate(&self, axis: &str) -> Outcome<()> {
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

    pub(super) fn profile<R: Real<Scalar = R>>(&self) -> Profile<R> {
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
