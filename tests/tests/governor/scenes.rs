//! What is asked for.

use std::f64::consts::TAU;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::PerAxis;
use twinrotor::trajectory::{Profile, Trajectory};

/// How a reference runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wave {
    Square,
    Sine,
}

/// One reference.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene {
    pub(crate) wave: Wave,
    pub(crate) amplitude_deg: PerAxis<f64>,
    pub(crate) hertz: f64,
    /// Yaw runs against pitch.
    pub(crate) against: bool,
    /// After a minute of squares of 25 and 60 degrees at .4 Hz.
    pub(crate) hot: bool,
    pub(crate) seconds: f64,
}

/// What makes the motors hot.
pub(crate) const HEATING: Scene = Scene {
    wave: Wave::Square,
    amplitude_deg: PerAxis::new(25.0, 60.0),
    hertz: 0.4,
    against: false,
    hot: false,
    seconds: 60.0,
};

impl Scene {
    /// Its reference.
    pub(crate) fn trajectory(&self) -> Trajectory<f32> {
        self.amplitude().map(|amplitude| match self.wave {
            Wave::Sine => Profile::sine(0.0, amplitude, TAU * self.hertz, 0.0, SAMPLE_TIME),
            Wave::Square => {
                let half = 0.5 / self.hertz;
                Profile::steps(0.0, &[(0.0, amplitude), (half, -amplitude)], 2.0 * half, SAMPLE_TIME)
            }
        })
    }

    /// \[rad\]
    pub(crate) fn amplitude(&self) -> PerAxis<f64> {
        let PerAxis { pitch, yaw } = self.amplitude_deg.map(f64::to_radians);
        PerAxis::new(pitch, if self.against { -yaw } else { yaw })
    }
}

/// All: two waves, three amplitudes, six frequencies, in and against phase, cold and hot.
pub(crate) fn grid(seconds: f64) -> Vec<Scene> {
    let mut scenes = Vec::new();
    for wave in [Wave::Square, Wave::Sine] {
        for (pitch, yaw) in [(5.0, 10.0), (15.0, 40.0), (25.0, 60.0)] {
            for hertz in [0.05, 0.1, 0.2, 0.3, 0.5, 1.0] {
                for (against, hot) in [(false, false), (false, true), (true, false), (true, true)] {
                    let amplitude_deg = PerAxis::new(pitch, yaw);
                    scenes.push(Scene { wave, amplitude_deg, hertz, against, hot, seconds });
                }
            }
        }
    }
    scenes
}

/// Some, of those that tumbled rigs before there was a governor.
pub(crate) fn some() -> Vec<Scene> {
    let of = |wave, pitch, yaw, hertz, against| Scene {
        wave,
        amplitude_deg: PerAxis::new(pitch, yaw),
        hertz,
        against,
        hot: false,
        seconds: 30.0,
    };
    vec![
        of(Wave::Square, 15.0, 40.0, 0.2, false),
        of(Wave::Square, 25.0, 45.0, 0.25, true),
        of(Wave::Sine, 15.0, 40.0, 0.3, false),
        of(Wave::Sine, 5.0, 10.0, 0.3, true),
    ]
}

/// The quickest of those that `paper` could follow, for as long as an error is looked at.
pub(crate) fn quick(against: bool) -> Scene {
    Scene {
        wave: Wave::Sine,
        amplitude_deg: PerAxis::new(5.0, 10.0),
        hertz: 1.0,
        against,
        hot: false,
        seconds: 40.0,
    }
}
