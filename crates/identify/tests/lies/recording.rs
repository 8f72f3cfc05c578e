//! A rig that is known, flown open loop and written down as a laboratory's program would.

use rand::{Rng, RngExt};
use std::fmt::Write;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::encoder::angle_per_count;
use twinrotor::plant::presets::{AERO_LAB, Rig};
use twinrotor::plant::{PlantParameters, RealPlant, State, decay};

/// What everyone takes the rig for.
pub(crate) const RIG: Rig = AERO_LAB;
/// \[s\] Step of the simulation; rows are taken at whole ones.
const STEP: f64 = 0.001;
/// \[s\] How long a run lasts.
pub(crate) const DURATION: f64 = 24.0;
/// \[s\] From row to row of a good log.
pub(crate) const EVERY: f64 = 0.01;

/// A log before it is a file: times as text, since some have more digits than a float.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    /// The first line.
    pub(crate) header: String,
    /// Of every row, in the file's unit.
    pub(crate) time: Vec<String>,
    /// pitch, yaw, v0, v1.
    pub(crate) rows: Vec<[f64; 4]>,
    /// w0, w1.
    pub(crate) speeds: Option<Vec<[f64; 2]>>,
}

impl Table {
    /// The file.
    pub(crate) fn text(&self) -> String {
        let mut text = format!("{}\n", self.header);
        for (k, (time, [pitch, yaw, v0, v1])) in self.time.iter().zip(&self.rows).enumerate() {
            let _ = write!(text, "{time},{pitch},{yaw},{v0},{v1}");
            if let Some([w0, w1]) = self.speeds.as_ref().map(|speeds| speeds[k]) {
                let _ = write!(text, ",{w0},{w1}");
            }
            text.push('\n');
        }
        text
    }

    /// \[s\] Of every row, where times are in seconds.
    pub(crate) fn seconds(&self) -> Vec<f64> {
        self.time.iter().map(|t| t.parse().expect("seconds are numbers")).collect()
    }
}

/// The times \[s\] of a good log.
pub(crate) fn even() -> Vec<f64> {
    let rows = (DURATION / EVERY).round();
    (0..).map(f64::from).take_while(|k| *k < rows).map(|k| k * EVERY).collect()
}

/// Flies `plant` and takes a row at each of these times \[s\], rounded to the simulation's steps; volts are
/// held from row to row, as a board or a program does that sends them when it has read the angles.
pub(crate) fn record(plant: &PlantParameters<f64>, times: &[f64], rng: &mut impl Rng) -> Table {
    let mut body = RealPlant::<f64>::new(plant, State::default(), STEP);
    let per_count: PerAxis<f64> = RIG.encoder_counts.map(angle_per_count);
    let phase = PerAxis::new(rng.random::<f64>(), rng.random::<f64>());
    let keep = plant.rotor_time_constant.map(|lag| decay(STEP, lag));
    let mut table =
        Table { header: "t,pitch,yaw,v0,v1".to_owned(), time: Vec::new(), rows: Vec::new(), speeds: None };
    let mut speeds = Vec::new();
    let (mut volts, mut acting, mut tick) = (PerMotor::zero(), PerMotor::zero(), 0_u32);
    for time in times {
        while f64::from(tick) * STEP < time - 0.5 * STEP {
            body.advance(volts, PerMotor::zero());
            acting = volts.plus(acting.minus(volts).zip(keep, |m, k| m * k));
            tick += 1;
        }
        let now = f64::from(tick) * STEP;
        volts = levels(now);
        let counts = body.state().angle.zip(per_count, |a, c| a / c).zip(phase, |a, p| (a + p).floor());
        let angle = counts.zip(per_count, |n, c| n * c);
        table.time.push(format!("{:.3}", now));
        table.rows.push([angle.pitch, angle.yaw, volts.main, volts.tail]);
        let speed = acting.map(|x: f64| (21.0 * x - 0.26 * x * x.abs()).round());
        speeds.push([speed.main, speed.tail]);
    }
    table.speeds = Some(speeds);
    table
}

/// \[V\] Steps at several levels on both motors, either sign, one after the other and together: as high as
/// pitch bears it.
fn levels(t: f64) -> PerMotor<f64> {
    let pulse = |from: f64, to: f64, volts: f64| if (from..to).contains(&t) { volts } else { 0.0 };
    PerMotor {
        main: pulse(0.5, 4.0, 8.0) + pulse(8.0, 9.0, -10.0) + pulse(14.0, 18.0, 5.0) + pulse(20.0, 21.5, 9.0),
        tail: pulse(4.0, 7.0, 9.0)
            + pulse(11.0, 12.0, -11.0)
            + pulse(16.0, 19.0, 6.0)
            + pulse(21.0, 23.0, 7.0),
    }
}
