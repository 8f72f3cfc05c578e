//! What befalls a rig at chosen times: pushes of five shapes, a weight hung on, a motor that gets weaker, a
//! supply that sags. Each a list of its own in a scenario file, such as `[[events.step]]`.

use super::befalls::{Change, Lowered};
use super::ranges::{are_zero, pair, window, within};
use super::{LONGEST, SAMPLE_TIME};
use crate::error::{Error, Outcome};
use serde::Deserialize;
use std::f64::consts::TAU;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::real::Real;
use twinrotor::trajectory::ticks;

/// All events of a scenario.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Events {
    /// At once, and at once over: a short window makes it a pulse.
    pub step: Vec<Push>,
    /// Grows straight from nothing over its window, and stays.
    pub ramp: Vec<Push>,
    /// (1 - cos)/2: grows, is at its height in the middle of its window, and dies away.
    pub gust: Vec<Push>,
    /// Swings.
    pub sine: Vec<Sine>,
    /// Weights that hang on the rig.
    pub weight: Vec<Weight>,
    /// Motors that give only a part of their thrust.
    pub thrust: Vec<Thrust>,
    /// A supply that is lower than it should be.
    pub supply: Vec<Sag>,
}

/// What pushes: volts added to those in effect, a torque on the body, or both.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// \[V\] At the main and the tail motor, up to 60 either way.
    #[serde(default)]
    pub volts: [f64; 2],
    /// \[N m\] On pitch and yaw, up to 10 either way.
    #[serde(default)]
    pub torque: [f64; 2],
    /// \[s\] From when to when.
    pub window: [f64; 2],
}

/// A push that swings.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// \[V\] Amplitude at the main and the tail motor, up to 60 either way.
    #[serde(default)]
    pub volts: [f64; 2],
    /// \[N m\] Amplitude on pitch and yaw, up to 10 either way.
    #[serde(default)]
    pub torque: [f64; 2],
    /// \[s\] From when to when.
    pub window: [f64; 2],
    /// \[rad/s\] 0 to 1000.
    pub frequency: f64,
    /// \[deg\] At the beginning of the window.
    #[serde(default)]
    pub phase_deg: f64,
}

/// A weight that hangs on the rig for a while.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weight {
    /// \[kg\] 0 to 5.
    pub mass: f64,
    /// \[m\] In front of the pivot, up to 1; negative behind it.
    pub arm: f64,
    /// \[s\] From when to when.
    pub window: [f64; 2],
}

/// Motors that give only a part of their thrust.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thrust {
    /// What is left of the main and the tail motor's thrust, 0 to 2; 1 for all of it.
    pub left: [f64; 2],
    /// \[s\] From when to when.
    pub window: [f64; 2],
}

/// A supply that is not as it should be.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sag {
    /// \[V\] .1 to 75.
    pub volts: f64,
    /// \[s\] That it takes to fall, and again to come back, within its window; 0 for at once, which a board
    /// takes for a broken wire if it is more than a fifth.
    #[serde(default)]
    pub fall: f64,
    /// \[s\] From when to when.
    pub window: [f64; 2],
}

/// How far into its window a tick is, 0 to below 1; `None` outside of it.
fn into(window: [f64; 2], tick: u32) -> Option<f64> {
    let [from, to] = window.map(|time| ticks(time, SAMPLE_TIME));
    (from <= tick && tick < to).then(|| f64::from(tick - from) / f64::from(to - from))
}

impl Events {
    /// Refuses what could not befall a rig.
    ///
    /// # Errors
    ///
    /// Which number, and what is allowed.
    pub fn validate(&self) -> Outcome<()> {
        for (shape, pushes) in [("step", &self.step), ("ramp", &self.ramp), ("gust", &self.gust)] {
            for (k, push) in pushes.iter().enumerate() {
                let Push { volts, torque, window } = *push;
                check_push(&format!("events.{shape}[{k}]"), volts, torque, window)?;
            }
        }
        for (k, sine) in self.sine.iter().enumerate() {
            let place = format!("events.sine[{k}]");
            check_push(&place, sine.volts, sine.torque, sine.window)?;
            within(&format!("{place}.frequency"), sine.frequency, [0.0, 1e3], "rad/s")?;
            within(&format!("{place}.phase_deg"), sine.phase_deg, [-360.0, 360.0], "degrees")?;
        }
        for (k, weight) in self.weight.iter().enumerate() {
            let place = format!("events.weight[{k}]");
            within(&format!("{place}.mass"), weight.mass, [0.0, 5.0], "kg")?;
            within(&format!("{place}.arm"), weight.arm, [-1.0, 1.0], "m")?;
            window(&place, weight.window, LONGEST)?;
        }
        for (k, thrust) in self.thrust.iter().enumerate() {
            let place = format!("events.thrust[{k}]");
            pair(&format!("{place}.left"), thrust.left, [0.0, 2.0], "of the thrust, 1 for all")?;
            window(&place, thrust.window, LONGEST)?;
        }
        for (k, sag) in self.supply.iter().enumerate() {
            let place = format!("events.supply[{k}]");
            within(&format!("{place}.volts"), sag.volts, [0.1, 75.0], "V")?;
            window(&place, sag.window, LONGEST)?;
            let half = 0.5 * (sag.window[1] - sag.window[0]);
            within(&format!("{place}.fall"), sag.fall, [0.0, half], "s, half of its window")?;
        }
        Ok(())
    }

    /// What pushes in a tick: volts at the motors, and a torque \[N m\] on the body.
    pub(super) fn push(&self, tick: u32) -> (PerMotor<f64>, PerAxis<f64>) {
        let (mut volts, mut torque) = (PerMotor::zero(), PerAxis::zero());
        let mut add = |v: [f64; 2], t: [f64; 2], share: f64| {
            volts = volts.plus(PerMotor::new(v[0], v[1]).map(|x| share * x));
            torque = torque.plus(PerAxis::new(t[0], t[1]).map(|x| share * x));
        };
        for push in &self.step {
            if into(push.window, tick).is_some() {
                add(push.volts, push.torque, 1.0);
            }
        }
        for push in &self.ramp {
            let over = tick >= ticks(push.window[1], SAMPLE_TIME);
            add(push.volts, push.torque, if over { 1.0 } else { into(push.window, tick).unwrap_or(0.0) });
        }
        for push in &self.gust {
            if let Some(part) = into(push.window, tick) {
                add(push.volts, push.torque, 0.5 * (1.0 - Real::sin_cos(TAU * part).1));
            }
        }
        for sine in &self.sine {
            if into(sine.window, tick).is_some() {
                let since = f64::from(tick) * SAMPLE_TIME - sine.window[0];
                let phase = sine.frequency * since + sine.phase_deg.to_radians();
                add(sine.volts, sine.torque, Real::sin_cos(phase).0);
            }
        }
        (volts, torque)
    }

    /// What the plant has become in a tick.
    pub(super) fn change(&self, tick: u32) -> Change {
        let mut change = Change::default();
        for weight in &self.weight {
            if into(weight.window, tick).is_some() {
                change.weights.push((weight.mass, weight.arm));
            }
        }
        for thrust in &self.thrust {
            if into(thrust.window, tick).is_some() {
                let [main, tail] = thrust.left;
                change.thrust = change.thrust.zip(PerMotor::new(main, tail), |a, b| a * b);
            }
        }
        change
    }

    /// The supply in a tick where it is not as it should be; the lowest of what is told.
    pub(super) fn supply(&self, tick: u32) -> Option<Lowered> {
        let lowered = |sag: &Sag| {
            let [since, left] = {
                let part = into(sag.window, tick)?;
                let length = sag.window[1] - sag.window[0];
                [part * length, (1.0 - part) * length]
            };
            let part = if sag.fall > 0.0 { (since.min(left) / sag.fall).min(1.0) } else { 1.0 };
            Some(Lowered { to: sag.volts, part })
        };
        self.supply.iter().filter_map(lowered).reduce(|a, b| if b.to < a.to { b } else { a })
    }
}

fn check_push(place: &str, volts: [f64; 2], torque: [f64; 2], times: [f64; 2]) -> Outcome<()> {
    pair(&format!("{place}.volts"), volts, [-60.0, 60.0], "V")?;
    pair(&format!("{place}.torque"), torque, [-10.0, 10.0], "N m")?;
    if are_zero(volts) && are_zero(torque) {
        let allowed = "volts or torque other than 0, such as volts = [2, 0]";
        return Err(Error::invalid(place, "without a push", allowed));
    }
    window(place, times, LONGEST)
}
