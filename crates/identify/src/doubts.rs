//! Columns that a log has in another order, with another sign or in another unit than was said, by what
//! physics makes of them.
//!
//! The regression of [`first_guess`](crate::first_guess) is asked how much of the accelerations it explains
//! with signs as the rig must have them: thrust positive on the motor's own axis, of the preset's sign on the
//! other one, friction and stiffness not negative. It is asked again for every way in which signs may be
//! wrong or columns swapped. Where another way explains far more, the columns that it changes are named; ways
//! that differ by little are named together, since some of them (both motors, or both axes) no log can tell
//! apart.

use crate::first_guess::{LAGS, TERMS, Term, motion, rows};
use crate::windows::Run;
use nalgebra::{DMatrix, DVector};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::plant::PlantParameters;

/// Part of the accelerations that the columns as given must leave unexplained beyond the other way, and the
/// part of that which the other way may leave.
const FAR_MORE: [f64; 2] = [0.05, 0.8];
/// Ways within this part of the best are named beside it.
const ALIKE: f64 = 1.03;
/// Thrust that is so many times the preset's, or so small a part of it, is another unit or another rig.
const OTHER_SCALE: f64 = 5.0;

/// Rows of an axis, one every 20 ms in which it moves, of which fewer say nothing.
const FEWEST_ROWS: usize = 100;
/// Part of a regressor's square below which what is left of it says nothing.
const UNKNOWN: f64 = 1e-6;

/// A way in which columns may be wrong.
#[derive(Debug, Clone, Copy)]
struct Way {
    motors_swapped: bool,
    axes_swapped: bool,
    motors: PerMotor<f64>,
    axes: PerAxis<f64>,
}

/// What is doubtful about the columns of `runs`, if they are of a rig like `preset`: a line for each.
pub fn doubts(runs: &[Run], preset: &PlantParameters<f64>) -> Vec<String> {
    let mut found: Vec<(Way, Explained)> = Vec::new();
    for (motors_swapped, axes_swapped) in [(false, false), (true, false), (false, true), (true, true)] {
        let swapped: Vec<Run> = runs.iter().map(|run| swap(run, motors_swapped, axes_swapped)).collect();
        let pitch: Vec<_> = swapped.iter().filter(|r| r.moves.pitch).map(|r| (r, motion(r, true))).collect();
        let yaw: Vec<_> = swapped.iter().filter(|r| r.moves.yaw).map(|r| (r, motion(r, false))).collect();
        let volts = usual_volts(&swapped);
        let table = |lag: &f64| Tables {
            axes: PerAxis {
                pitch: Equations::new(pitch.iter().flat_map(|(r, m)| rows(r, m, preset, *lag, true))),
                yaw: Equations::new(yaw.iter().flat_map(|(r, m)| rows(r, m, preset, *lag, false))),
            },
            volts,
        };
        let tables: Vec<Tables> = LAGS.iter().map(table).collect();
        for signs in 0..16_u8 {
            let sign = |bit: u8| if signs & (1 << bit) == 0 { 1.0 } else { -1.0 };
            let way = Way {
                motors_swapped,
                axes_swapped,
                motors: PerMotor { main: sign(0), tail: sign(1) },
                axes: PerAxis { pitch: sign(2), yaw: sign(3) },
            };
            let explained = tables.iter().map(|table| table.explain(&way, preset));
            let best = explained.min_by(|a, b| a.missed.total_cmp(&b.missed));
            found.extend(best.map(|best| (way, best)));
        }
    }
    let Some((_, given)) = found.first().copied() else { return Vec::new() };
    let mut lines = Vec::new();
    let least = found.iter().map(|(_, explained)| explained.missed).fold(f64::INFINITY, f64::min);
    if given.missed - least > FAR_MORE[0] && least < FAR_MORE[1] * given.missed {
        let mut ways: Vec<&Way> =
            found.iter().filter(|(_, e)| e.missed <= ALIKE * least + 1e-3).map(|(way, _)| way).collect();
        ways.sort_by_key(|way| way.changes());
        let fewest = ways[0].changes();
        let named: Vec<String> = ways.iter().filter(|w| w.changes() == fewest).map(|w| w.columns()).collect();
        lines.push(format!(
            "the columns as given leave {:.0} % of the accelerations unexplained, with other signs or places \
             {:.0} %; say so: columns {}",
            50.0 * given.missed,
            50.0 * least,
            named.join(", or ")
        ));
    }
    lines.extend(given.other_scale());
    lines
}

impl Way {
    /// How many columns are not as given.
    fn changes(&self) -> usize {
        let signs = [self.motors.main, self.motors.tail, self.axes.pitch, self.axes.yaw];
        signs.iter().filter(|s| **s < 0.0).count()
            + 2 * usize::from(self.motors_swapped)
            + 2 * usize::from(self.axes_swapped)
    }

    /// As a list of columns, as it would have to be said.
    fn columns(&self) -> String {
        let mut said = Vec::new();
        let mut say = |ours: [&str; 2], signs: [f64; 2], swapped: bool| {
            for k in 0..2 {
                let minus = if signs[k] < 0.0 { "-" } else { "" };
                if swapped {
                    said.push(format!("{}={minus}NAME-OF-{}", ours[k], ours[1 - k]));
                } else if signs[k] < 0.0 {
                    said.push(format!("{}=-NAME", ours[k]));
                }
            }
        };
        say(["v0", "v1"], [self.motors.main, self.motors.tail], self.motors_swapped);
        say(["pitch", "yaw"], [self.axes.pitch, self.axes.yaw], self.axes_swapped);
        said.join(",")
    }
}

fn swap(run: &Run, motors: bool, axes: bool) -> Run {
    if !motors && !axes {
        return run.clone();
    }
    let mut log = run.log.clone();
    if motors {
        log.volts.iter_mut().for_each(|v| *v = PerMotor { main: v.tail, tail: v.main });
    }
    if axes {
        log.angle.iter_mut().for_each(|a| *a = PerAxis { pitch: a.yaw, yaw: a.pitch });
    }
    Run::new(log)
}

/// How much of the accelerations a way of reading leaves unexplained, summed over both axes, and how each
/// axis' thrust compares with the preset's.
#[derive(Debug, Clone, Copy)]
struct Explained {
    missed: f64,
    scale: PerAxis<Option<f64>>,
}

impl Explained {
    fn other_scale(&self) -> Vec<String> {
        let line = |(axis, scale): (&str, Option<f64>)| {
            let scale = scale.filter(|s| s.is_finite() && (*s > OTHER_SCALE || *s < 1.0 / OTHER_SCALE))?;
            let (times, units) = if scale > 1.0 {
                (scale, "degrees, milliradians or counts for rad, or a duty cycle for V")
            } else {
                (1.0 / scale, "turns for rad, or millivolts for V")
            };
            let way = if scale > 1.0 { "harder" } else { "less" };
            Some(format!(
                "{axis}: a volt turns it {times:.1} times {way} than the preset says: another unit \
                 ({units}), or \
                 a rig unlike the preset"
            ))
        };
        [("pitch", self.scale.pitch), ("yaw", self.scale.yaw)].into_iter().filter_map(line).collect()
    }
}

/// Normal equations of one axis: regressors, and their products with acceleration torque and weight.
struct Equations {
    squares: DMatrix<f64>,
    with_torque: DVector<f64>,
    with_weight: DVector<f64>,
    torque: f64,
    weight: f64,
    across: f64,
}

impl Equations {
    fn new(rows: impl Iterator<Item = Term>) -> Option<Self> {
        let mut all = Self {
            squares: DMatrix::zeros(TERMS, TERMS),
            with_torque: DVector::zeros(TERMS),
            with_weight: DVector::zeros(TERMS),
            torque: 0.0,
            weight: 0.0,
            across: 0.0,
        };
        let mut count = 0;
        for row in rows {
            let terms = DVector::from_row_slice(&row.terms);
            all.squares.ger(1.0, &terms, &terms, 1.0);
            all.with_torque.axpy(row.torque, &terms, 1.0);
            all.with_weight.axpy(row.weight, &terms, 1.0);
            all.torque += row.torque * row.torque;
            all.weight += row.weight * row.weight;
            all.across += row.torque * row.weight;
            count += 1;
        }
        (count > FEWEST_ROWS && all.torque > 0.0).then_some(all)
    }

    /// The part of the torque's square that is missed with `kept` regressors, and their coefficients. The
    /// angle's sign turns the torque about, not the weight.
    fn solve(&self, kept: &[usize], sign: f64) -> (f64, DVector<f64>) {
        let scale = |k: usize| Some(self.squares[(k, k)].sqrt()).filter(|s| *s > 0.0).unwrap_or(1.0);
        let matrix = DMatrix::from_fn(kept.len(), kept.len(), |i, j| {
            self.squares[(kept[i], kept[j])] / (scale(kept[i]) * scale(kept[j]))
        });
        let wanted = DVector::from_fn(kept.len(), |i, _| {
            (self.with_torque[kept[i]] + sign * self.with_weight[kept[i]]) / scale(kept[i])
        });
        let all = self.torque + self.weight + 2.0 * sign * self.across;
        // Regressors that say the same thing share what they say.
        let held = matrix + DMatrix::identity(kept.len(), kept.len()) * UNKNOWN;
        let x = held.cholesky().map_or_else(|| DVector::zeros(kept.len()), |c| c.solve(&wanted));
        let mut found = DVector::zeros(TERMS);
        kept.iter().enumerate().for_each(|(i, k)| found[*k] = x[i] / scale(*k));
        ((all - x.dot(&wanted)).max(0.0) / all.max(f64::MIN_POSITIVE), found)
    }
}

/// The equations of both axes at one lag, and how high the volts are.
struct Tables {
    axes: PerAxis<Option<Equations>>,
    volts: PerMotor<f64>,
}

/// \[V\] The root mean square of each motor's.
fn usual_volts(runs: &[Run]) -> PerMotor<f64> {
    let volts = runs.iter().flat_map(|r| &r.log.volts);
    let sum = volts.clone().fold(PerMotor::zero(), |sum: PerMotor<f64>, v| sum.plus(v.map(|v| v * v)));
    let count = volts.count().max(1) as f64;
    sum.map(|s| (s / count).sqrt())
}

impl Tables {
    fn explain(&self, way: &Way, preset: &PlantParameters<f64>) -> Explained {
        let at = |volts: f64| preset.effectiveness_at(volts);
        let (main, tail) = (at(self.volts.main), at(self.volts.tail));
        let pitch = self.axes.pitch.as_ref().map(|equations| {
            self.admit(equations, [main.main_on_pitch, tail.tail_on_pitch], 0, way.motors, way.axes.pitch)
        });
        let yaw = self.axes.yaw.as_ref().map(|equations| {
            self.admit(equations, [main.main_on_yaw, tail.tail_on_yaw], 1, way.motors, way.axes.yaw)
        });
        let missed = |axis: Option<(f64, f64)>| axis.map_or(0.0, |(missed, _)| missed);
        Explained {
            missed: missed(pitch) + missed(yaw),
            scale: PerAxis { pitch: pitch.map(|p| p.1), yaw: yaw.map(|y| y.1) },
        }
    }

    /// What is missed with the signs that a rig has, and the thrust as a part of the preset's. Terms of
    /// another sign are left out, one after the other.
    fn admit(
        &self,
        equations: &Equations,
        meant: [f64; 2],
        own: usize,
        motors: PerMotor<f64>,
        axis: f64,
    ) -> (f64, f64) {
        let volts = [self.volts.main, self.volts.tail];
        let signs = [motors.main * axis, motors.tail * axis];
        let mut kept: Vec<usize> = (0..TERMS).collect();
        let (_, free) = equations.solve(&kept, axis);
        let thrust_of = |x: &DVector<f64>| [0, 1].map(|m| x[m] + x[m + 2] * volts[m]);
        let size = |k: [f64; 2]| (k[0] * volts[0]).hypot(k[1] * volts[1]);
        let scale = size(thrust_of(&free)) / size(meant);
        loop {
            let (missed, x) = equations.solve(&kept, axis);
            let thrust = thrust_of(&x);
            let wrong_thrust = |m: usize| {
                let expected = if m == own { 1.0 } else { meant[m].signum() * f64::from(meant[m] != 0.0) };
                thrust[m] * signs[m] * expected < 0.0
            };
            // What each group of terms that has a sign brings where that sign is wrong.
            let brought = |terms: &[usize]| -> f64 {
                terms.iter().map(|k| x[*k].abs() * equations.squares[(*k, *k)].sqrt()).sum()
            };
            let groups: [(&[usize], bool); 5] = [
                (&[0, 2], wrong_thrust(0)),
                (&[1, 3], wrong_thrust(1)),
                (&[4], x[4] < 0.0),
                (&[5], x[5] < 0.0),
                (&[7], x[7] < 0.0),
            ];
            let wrong = groups.iter().filter(|(_, is_wrong)| *is_wrong);
            let Some((worst, _)) = wrong.max_by(|a, b| brought(a.0).total_cmp(&brought(b.0))) else {
                return (missed, scale);
            };
            kept.retain(|k| !worst.contains(k));
        }
    }
}
