//! A rotor's lag from its tachometer, where a log has one.
//!
//! Angles show a rotor's lag only through what the thrust does to a heavy body, where a faster rotor looks
//! much like a stronger reaction torque. A tachometer shows it at once: the speed follows the volts in
//! effect, w = a + b x + c x|x|, and x lags behind the volts that were sent. For each lag that is tried a, b
//! and c are linear least squares; the lag with the smallest error is the rotor's.
//!
//! A speed that its volts do not explain is none: [`check`] refuses it, with what explains it better.

use super::interval::student_95;
use super::problem::stride;
use super::windows::Run;
use nalgebra::{Matrix3, Vector3};
use twinrotor::axes::PerMotor;
use twinrotor::plant::decay;
use twinrotor_sim::{Error, Outcome};
use twinrotor_tune::parallel;

/// A lag as a tachometer shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// \[s\]
    pub value: f64,
    /// \[s\] Half of its 95 % interval: the jackknife over parts of the logs in which the speed changes.
    pub half_width: f64,
}

/// \[s\] Least and most lag that is tried.
const RANGE: [f64; 2] = [0.01, 0.6];
/// How many are tried, evenly in their logarithm: parabolas between them are good to a thousandth.
const TRIED: usize = 160;
/// \[s\] Length of the parts that are left out in turn: some for each time that a rotor starts or stops.
const PART: f64 = 0.1;
/// Part of the highest speed by which the speed changes in a part that tells something of the lag.
const TELLING: f64 = 0.03;

/// Part of a speed's variation that lagged volts must explain.
const EXPLAINED: f64 = 0.9;
/// What another reading may leave of what is unexplained to be the right one.
const BETTER: f64 = 0.5;

/// Refuses tachometers that the volts do not explain, and says what would: another sign, the other motor's
/// volts, or volts without their sign.
///
/// # Errors
///
/// If a column of speeds is not one of its motor.
pub fn check(runs: &[Run]) -> Outcome<()> {
    let [main, tail]: [fn(&PerMotor<f64>) -> f64; 2] = [|v| v.main, |v| v.tail];
    for (name, volts_name, of, other) in [("w0", "v0", main, tail), ("w1", "v1", tail, main)] {
        let missed = |of_speed: fn(&PerMotor<f64>) -> f64, of_volts: fn(&PerMotor<f64>) -> f64, unsigned| {
            let at = |k: usize| {
                let sums =
                    runs.iter().flat_map(|run| sums(run, tried(k as f64), of_speed, of_volts, unsigned));
                let all = Sums::default().plus(&sums.collect::<Vec<_>>(), 1.0);
                (all.missed() / all.variation().max(f64::MIN_POSITIVE), all.slope())
            };
            let all = parallel::by_index(TRIED / COARSE, |k| at(COARSE * k));
            all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0.0))
        };
        let turns = runs.iter().flat_map(|r| r.log.rotor_speed.iter().flatten()).any(|w| of(w) != 0.0);
        let driven =
            |r: &Run| r.log.rotor_speed.is_some() && r.log.volts.iter().any(|v| of(v).abs() > DRIVEN);
        if !turns && runs.iter().any(driven) {
            let why = format!("{name} is 0 throughout, while {volts_name} drives that rotor");
            return Err(refused(&why, "a tachometer that turns with its rotor, or no such column"));
        }
        if !turns {
            continue;
        }
        let (own, slope) = missed(of, of, false);
        let better = |other: (f64, f64)| other.0 < BETTER * own && own > 1.0 - EXPLAINED.sqrt();
        let percent = 100.0 * (1.0 - own).max(0.0);
        let why = format!("{name} follows {volts_name} by {percent:.0} % of its variation alone");
        if better(missed(of, other, false)) {
            return Err(refused(&why, "speeds that their volts explain (w0 and w1 swapped?)"));
        }
        if better(missed(of, of, true)) {
            return Err(refused(&why, "speeds with the sign of the rotation (this column has none)"));
        }
        if own > 1.0 - EXPLAINED {
            return Err(refused(&why, "at least 90 %, of a speed that is one (leave the column out?)"));
        }
        if slope < 0.0 {
            let why = format!("{name} falls as {volts_name} rises");
            return Err(refused(&why, format!("the sign of the volts; say so: columns {name}=-NAME")));
        }
    }
    Ok(())
}

fn refused(why: &str, allowed: impl std::fmt::Display) -> Error {
    Error::Unusable(format!("{why}; allowed: {allowed}"))
}

/// The lag \[s\] at a place in the row of those that are tried.
fn tried(at: f64) -> f64 {
    RANGE[0] * ((RANGE[1] / RANGE[0]).ln() / (TRIED - 1) as f64 * at).exp()
}

/// \[V\] With more than this a rotor turns.
const DRIVEN: f64 = 2.0;

/// Every so many of the lags are enough to see whether any explains a speed.
const COARSE: usize = 8;

/// The lags of both rotors, from all runs that have speeds; none where hardly anything happens.
pub fn lags(runs: &[Run]) -> PerMotor<Option<Lag>> {
    PerMotor { main: lag(runs, |v| v.main), tail: lag(runs, |v| v.tail) }
}

fn lag(runs: &[Run], of: fn(&PerMotor<f64>) -> f64) -> Option<Lag> {
    let of_lag =
        |k: usize| runs.iter().flat_map(|run| sums(run, tried(k as f64), of, of, false)).collect::<Vec<_>>();
    let parts: Vec<Vec<Sums>> = parallel::by_index(TRIED, of_lag);
    let whole: Vec<Sums> = parts.iter().map(|of_one| Sums::default().plus(of_one, 1.0)).collect();
    let highest = parts[0].iter().fold(0.0_f64, |most, part| most.max(part.highest));
    let telling: Vec<usize> =
        (0..parts[0].len()).filter(|p| parts[0][*p].change > TELLING * highest).collect();
    if telling.len() < 2 {
        return None;
    }
    let value = tried(lowest(whole.iter().map(Sums::missed).collect())?);
    let without = |left_out: &usize| {
        let missed =
            whole.iter().zip(&parts).map(|(all, of_one)| all.plus(&[of_one[*left_out]], -1.0).missed());
        lowest(missed.collect()).map(tried)
    };
    let others: Vec<f64> = parallel::map(&telling, without).into_iter().collect::<Option<_>>()?;
    let count = telling.len() as f64;
    let spread: f64 = others.iter().map(|other| (other - value).powi(2)).sum();
    let half_width = student_95(telling.len() - 1) * ((count - 1.0) / count * spread).sqrt();
    Some(Lag { value, half_width })
}

/// Where, in steps, a row of errors is lowest, by the parabola through the lowest and its neighbours; none at
/// an end.
fn lowest(errors: Vec<f64>) -> Option<f64> {
    let k = (0..errors.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b]))?;
    if k == 0 || k + 1 == errors.len() {
        return None;
    }
    let (before, at, after) = (errors[k - 1], errors[k], errors[k + 1]);
    let bend = before - 2.0 * at + after;
    Some(k as f64 + if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 })
}

/// Of speeds w and regressors (1, x, x|x|) over the rows of a part.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    regressors: Matrix3<f64>,
    with_speed: Vector3<f64>,
    speed_squared: f64,
    /// Between the first and the last row.
    change: f64,
    highest: f64,
    first: Option<f64>,
}

impl Sums {
    /// With `weight` times the sums of others.
    fn plus(mut self, others: &[Self], weight: f64) -> Self {
        for other in others {
            self.regressors += other.regressors * weight;
            self.with_speed += other.with_speed * weight;
            self.speed_squared += other.speed_squared * weight;
        }
        self
    }

    /// The a, b and c that explain most.
    fn curve(&self) -> Vector3<f64> {
        // Volts of one level leave a curve undetermined: then the smallest coefficients are as good as any.
        let svd = self.regressors.svd(true, true);
        svd.solve(&self.with_speed, 1e-9 * svd.singular_values.max()).unwrap_or_else(|_| Vector3::zeros())
    }

    /// Squares that no a, b, c explain.
    fn missed(&self) -> f64 {
        self.speed_squared - self.curve().dot(&self.with_speed)
    }

    /// Squares about the mean.
    fn variation(&self) -> f64 {
        self.speed_squared - self.with_speed[0] * self.with_speed[0] / self.regressors[(0, 0)].max(1.0)
    }

    /// How the speed grows with the volts, up to 10 V.
    fn slope(&self) -> f64 {
        let curve = self.curve();
        curve[1] + curve[2]
    }
}

/// The sums of each part of a run, if it has speeds: those of one motor, with the volts of one, by size alone
/// if they are `unsigned`.
fn sums(
    run: &Run,
    lag: f64,
    of: fn(&PerMotor<f64>) -> f64,
    of_volts: fn(&PerMotor<f64>) -> f64,
    unsigned: bool,
) -> Vec<Sums> {
    let log = &run.log;
    let Some(speeds) = &log.rotor_speed else { return Vec::new() };
    let keep = decay(log.sample_time, lag);
    let stride = (stride(run) / 4).max(1);
    let mut all = Vec::new();
    for stretch in &log.stretches {
        let mut acting = of_volts(&log.volts[stretch.start]);
        let mut begun = f64::NEG_INFINITY;
        for row in stretch.clone() {
            if log.time[row] - begun >= PART - 0.5 * log.sample_time {
                begun = log.time[row];
                all.push(Sums::default());
            }
            let Some(part) = all.last_mut() else { continue };
            let (sent, speed) = (of_volts(&log.volts[row]), of(&speeds[row]));
            part.change = (speed - *part.first.get_or_insert(speed)).abs();
            part.highest = part.highest.max(speed.abs());
            if (row - stretch.start) % stride == 0 {
                // Tenfold volts, so that the columns are of one size.
                let x = 0.1 * if unsigned { acting.abs() } else { acting };
                let terms = Vector3::new(1.0, x, x * x.abs());
                part.regressors += terms * terms.transpose();
                part.with_speed += terms * speed;
                part.speed_squared += speed * speed;
            }
            acting = sent + keep * (acting - sent);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use twinrotor::axes::PerAxis;

    /// A main rotor with this lag that starts, stops and starts again; the tail stands still.
    fn turned(lag: f64) -> Run {
        let (step, mut acting) = (0.002, 0.0_f64);
        let mut speeds = Vec::new();
        let rows: Vec<_> = (0..4000)
            .map(|k| {
                let volts = if (500..2000).contains(&k) || k > 3000 { 10.0 } else { 0.0 };
                // A tachometer counts: so fine, and no finer.
                speeds.push(PerMotor { main: (21.0 * acting - 0.26 * acting * acting).round(), tail: 0.0 });
                acting = volts + decay(step, lag) * (acting - volts);
                (PerAxis::new(0.001 * k as f64, 0.0), PerMotor { main: volts, tail: 0.0 })
            })
            .collect();
        let mut log = Log::from_rows("turned", step, &rows);
        log.rotor_speed = Some(speeds);
        Run::new(log)
    }

    #[test]
    fn the_lag_comes_back_and_a_rotor_at_rest_has_none() {
        for lag in [0.05, 0.154, 0.3] {
            let found = lags(&[turned(lag)]);
            let main = found.main.unwrap();
            assert!((main.value - lag).abs() < 0.003 + main.half_width, "{main:?}");
            assert!(main.half_width < 0.1 * lag, "{main:?}");
            assert_eq!(found.tail, None);
        }
        let mut silent = turned(0.1);
        silent.log.rotor_speed = None;
        assert_eq!(lags(&[silent]).main, None);
    }

    /// Both rotors, either way, with lags of .15 s; then what is wrong with the speeds.
    fn spoilt(change: impl Fn(usize, PerMotor<f64>) -> PerMotor<f64>) -> String {
        let (step, mut acting) = (0.002, PerMotor::<f64>::zero());
        let mut speeds = Vec::new();
        let rows: Vec<_> = (0..8000)
            .map(|k| {
                let level = |every: usize, sizes: [f64; 4]| sizes[k / every % 4];
                let volts = PerMotor {
                    main: level(700, [0.0, 10.0, -8.0, 4.0]),
                    tail: level(1100, [6.0, -12.0, 0.0, 9.0]),
                };
                speeds.push(change(k, acting.map(|x| 21.0 * x - 0.26 * x * x.abs())));
                acting = volts.plus(acting.minus(volts).scaled(decay(step, 0.15)));
                (PerAxis::new(0.001 * k as f64, 0.0), volts)
            })
            .collect();
        let mut log = Log::from_rows("turned", step, &rows);
        log.rotor_speed = Some(speeds);
        check(&[Run::new(log)]).err().map_or_else(String::new, |e| e.to_string())
    }

    #[test]
    fn speeds_that_the_volts_do_not_explain_are_refused() {
        assert_eq!(spoilt(|_, w| w), "");
        let noise = |k: usize| ((k * 7919 + 13) % 1009) as f64 - 504.0;
        let cases = [
            (spoilt(|_, w| w.map(f64::abs)), "w0 follows v0", "this column has none"),
            (spoilt(|_, w| PerMotor { main: w.tail, tail: w.main }), "w0 follows v0", "swapped"),
            (spoilt(|k, w| PerMotor { main: noise(k), ..w }), "w0 follows v0", "at least 90 %"),
            (spoilt(|_, w| PerMotor { tail: -w.tail, ..w }), "w1 falls as v1 rises", "w1=-NAME"),
            (spoilt(|_, w| PerMotor { tail: 0.0, ..w }), "w1 is 0 throughout", "turns with its rotor"),
        ];
        for (told, what, why) in cases {
            assert!(told.contains(what) && told.contains(why), "{told}");
        }
    }
}
