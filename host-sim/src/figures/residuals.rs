//! Residual plots: what windows of the identified plant make of the logs.

use twinrotor::plant::PlantParameters;
use twinrotor_identify::problem::{Guess, Problem};
use twinrotor_identify::windows::Run;
use twinrotor_plot::{Figure, Line, Panel, Stroke};

/// Two panels for each log: angles measured and simulated over windows, and their differences.
pub fn residuals(title: &str, runs: &[(&Run, f64)], plant: &PlantParameters<f64>, window: f64) -> Figure {
    let panels = runs.iter().flat_map(|(run, offset)| panels(run, plant, *offset, window)).collect();
    Figure { title: title.to_owned(), panels, ..Figure::default() }
}

fn panels(run: &Run, plant: &PlantParameters<f64>, offset: f64, window: f64) -> [Panel; 2] {
    let windows = run.windows(0, window);
    let problem = Problem::new(std::slice::from_ref(run), windows.clone(), plant, &[], f64::INFINITY);
    let guess = Guess { values: Vec::new(), offsets: vec![offset] };
    let rotors = run.rotor_volts(&windows, plant.rotor_time_constant);
    let mut simulated = [Vec::new(), Vec::new()];
    let mut missed = [Vec::new(), Vec::new()];
    for (block, rotor_volts) in problem.blocks(&guess, false).iter().zip(rotors) {
        run.simulate(&block.window, plant, block.start, rotor_volts, 1, |row, angle| {
            let (time, measured) = (run.log.time[row], run.log.angle[row]);
            for (k, (angle, measured)) in
                [(angle.pitch - offset, measured.pitch), (angle.yaw, measured.yaw)].into_iter().enumerate()
            {
                simulated[k].push((time, angle.to_degrees()));
                missed[k].push((time, (angle - measured).to_degrees()));
            }
        });
    }
    let measured = |of: fn(&twinrotor::axes::PerAxis<f64>) -> f64| {
        run.log.time.iter().zip(&run.log.angle).map(|(t, a)| (*t, of(a).to_degrees())).collect::<Vec<_>>()
    };
    let line = |name: &str, colour: usize, dashed: bool, points: Vec<(f64, f64)>| Line {
        name: name.to_owned(),
        points,
        colour,
        stroke: if dashed { Stroke::Dashed } else { Stroke::Solid },
    };
    let short = std::path::Path::new(&run.log.name)
        .file_stem()
        .map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let [simulated_pitch, simulated_yaw] = simulated;
    let [missed_pitch, missed_yaw] = missed;
    let mut lines = Vec::new();
    let mut differences = Vec::new();
    if run.moves.pitch {
        lines.push(line("pitch, measured", 0, false, measured(|a| a.pitch)));
        lines.push(line("pitch, simulated", 4, true, simulated_pitch));
        differences.push(line("pitch", 0, false, missed_pitch));
    }
    if run.moves.yaw {
        lines.push(line("yaw, measured", 1, false, measured(|a| a.yaw)));
        lines.push(line("yaw, simulated", 5, true, simulated_yaw));
        differences.push(line("yaw", 1, false, missed_yaw));
    }
    [
        Panel { y_label: format!("{short} [°]"), lines, ..Panel::default() },
        Panel { y_label: "simulated - measured [°]".to_owned(), lines: differences, ..Panel::default() },
    ]
}
