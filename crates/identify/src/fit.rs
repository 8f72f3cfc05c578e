//! How well a plant explains a log: windows simulated from their best initial states.

use super::problem::{Guess, Problem};
use super::windows::Run;
use serde::Serialize;
use twinrotor::axes::PerAxis;
use twinrotor::plant::PlantParameters;

/// Fit in percent, 100 (1 - root mean square error / standard deviation over the log), with windows of one
/// length; none for an axis that does not move.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fit {
    /// \[s\]
    pub window_s: f64,
    /// Of pitch.
    pub pitch: Option<f64>,
    /// Of yaw.
    pub yaw: Option<f64>,
}

/// \[s\] The window lengths that are reported.
pub const LENGTHS: [f64; 3] = [2.0, 5.0, 10.0];

/// The fit of `plant` to a run whose pitch zero is off by `offset` \[rad\].
pub fn fit(run: &Run, plant: &PlantParameters<f64>, offset: f64, window: f64) -> Fit {
    let windows = run.windows(0, window);
    let runs = std::slice::from_ref(run);
    let problem = Problem::new(runs, windows.clone(), plant, &[], f64::INFINITY);
    let guess = Guess { values: Vec::new(), offsets: vec![offset] };
    let rotors = run.rotor_volts(&windows, plant.rotor_time_constant);
    let mut square: PerAxis<f64> = PerAxis::zero();
    let mut rows = 0.0;
    for (block, rotor_volts) in problem.blocks(&guess, false).iter().zip(rotors) {
        run.simulate(&block.window, plant, block.start, rotor_volts, 1, |row, angle| {
            let mut error = angle.minus(run.log.angle[row]);
            error.pitch -= offset;
            square = square.plus(error.map(|e| e * e));
            rows += 1.0;
        });
    }
    let percent = |square: f64, spread: f64| 100.0 * (1.0 - (square / rows).sqrt() / spread);
    let spread = run.log.spread();
    Fit {
        window_s: window,
        pitch: run.moves.pitch.then(|| percent(square.pitch, spread.pitch)),
        yaw: run.moves.yaw.then(|| percent(square.yaw, spread.yaw)),
    }
}
