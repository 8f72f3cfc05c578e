//! A scenario's disturbances and events, tick by tick, the same for whoever flies it.

use super::ranges::are_zero;
use super::{SAMPLE_TIME, Scenario};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Bench;
use twinrotor::plant::PlantParameters;
use twinrotor::plant::presets::Rig;
use twinrotor::real::Real;
use twinrotor::trajectory::ticks;

/// What befalls a rig in a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct Now {
    /// \[V\] Added to the volts in effect.
    pub volts: PerMotor<f64>,
    /// \[N m\] On the body, from outside.
    pub torque: PerAxis<f64>,
    /// \[counts\] Whole counts that the encoders show beside those there are.
    pub noise: PerAxis<f64>,
    /// \[ticks\] By how many the volts come later than their delay.
    pub jitter: u32,
    /// The supply, where it is not as it should be.
    pub supply: Option<Lowered>,
    /// What the plant becomes, where it becomes another.
    pub change: Option<Change>,
}

/// A supply on its way to what it sags to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lowered {
    /// \[V\]
    pub to: f64,
    /// 0..1: how far on the way.
    pub part: f64,
}

impl Now {
    /// Nothing.
    pub fn nothing() -> Self {
        Self {
            volts: PerMotor::zero(),
            torque: PerAxis::zero(),
            noise: PerAxis::zero(),
            jitter: 0,
            supply: None,
            change: None,
        }
    }

    /// Pushes it and feeds its amplifiers as `other` does?
    pub fn is_as(&self, other: &Self) -> bool {
        (self.volts, self.torque, self.supply) == (other.volts, other.torque, other.supply)
    }

    /// \[V\] What a supply of `sound` has become.
    pub fn supply<R: Real>(&self, sound: R) -> R {
        self.supply
            .map_or(sound, |Lowered { to, part }| sound + R::from_f64(part) * (R::from_f64(to) - sound))
    }
}

/// What has become of a plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Weights that hang on it: kg, and m in front of the pivot.
    pub weights: Vec<(f64, f64)>,
    /// What is left of each motor's thrust.
    pub thrust: PerMotor<f64>,
}

impl Default for Change {
    fn default() -> Self {
        Self { weights: Vec::new(), thrust: PerMotor::both(1.0) }
    }
}

impl Change {
    /// The plant that `plant` has become.
    pub fn of(&self, plant: &PlantParameters<f64>) -> PlantParameters<f64> {
        let hung = |plant: PlantParameters<f64>, &(mass, arm): &(f64, f64)| {
            if mass > 0.0 { plant.with_weight(mass, arm) } else { plant }
        };
        self.weights.iter().fold(*plant, hung).with_thrust(self.thrust)
    }
}

/// Tick after tick of it.
#[derive(Debug, Clone)]
pub struct Befalls {
    scenario: Scenario,
    tick: u32,
    random: ChaCha8Rng,
    noise: ChaCha8Rng,
    late: ChaCha8Rng,
    value: PerMotor<f64>,
    before: Change,
}

impl Scenario {
    /// What befalls the rig from tick 0 on, without end; `seed` is of all that is random.
    pub fn befalls(&self, seed: u64) -> Befalls {
        // Other streams are the disturbance's, the encoders' phase, the drawn plants.
        let stream = |number: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(number);
            random
        };
        Befalls {
            scenario: self.clone(),
            tick: 0,
            random: ChaCha8Rng::seed_from_u64(seed),
            noise: stream(3),
            late: stream(4),
            value: PerMotor::both(0.0),
            before: Change::default(),
        }
    }

    /// Does anything befall the rig beside volts at its motors?
    pub fn is_more_than_volts(&self) -> bool {
        let events = &self.events;
        let turns = |torque: [f64; 2]| !are_zero(torque);
        let pushes = [&events.step, &events.ramp, &events.gust];
        let pushed = pushes.iter().any(|pushes| pushes.iter().any(|push| turns(push.torque)));
        pushed
            || events.sine.iter().any(|sine| turns(sine.torque))
            || !(events.weight.is_empty() && events.thrust.is_empty() && events.supply.is_empty())
            || self.hardware.noise_counts != [0; 2]
            || self.hardware.jitter > 0.0
    }
}

impl Befalls {
    /// \[V\] Uniform within the disturbance's volts, a new value every hold time.
    fn random(&mut self) -> PerMotor<f64> {
        let Some(d) = self.scenario.disturbance else { return PerMotor::zero() };
        let [from, to] = d.window.map(|t| ticks(t, SAMPLE_TIME));
        if self.tick < from || self.tick >= to {
            return PerMotor::zero();
        }
        if (self.tick - from).is_multiple_of(ticks(d.hold, SAMPLE_TIME).max(1)) {
            let mut draw = || self.random.random_range(-1.0..=1.0);
            self.value = PerMotor::new(draw(), draw());
        }
        self.value.map(|x| d.volts * x)
    }

    /// \[counts\] None in the first tick, in which the encoders are set to zero.
    fn noise(&mut self) -> PerAxis<f64> {
        if self.tick == 0 {
            return PerAxis::zero();
        }
        let [pitch, yaw] = self.scenario.hardware.noise_counts.map(|most| {
            let most = i64::from(most);
            if most > 0 { self.noise.random_range(-most..=most) as f64 } else { 0.0 }
        });
        PerAxis::new(pitch, yaw)
    }

    /// \[ticks\]
    fn jitter(&mut self) -> u32 {
        let most = ticks(self.scenario.hardware.jitter, SAMPLE_TIME);
        if most > 0 { self.late.random_range(0..=most) } else { 0 }
    }
}

impl Iterator for Befalls {
    type Item = Now;

    fn next(&mut self) -> Option<Now> {
        let events = &self.scenario.events;
        let (volts, torque) = events.push(self.tick);
        let change = events.change(self.tick);
        let supply = events.supply(self.tick);
        let now = Now {
            volts: self.random().plus(volts),
            torque,
            noise: self.noise(),
            jitter: self.jitter(),
            supply,
            change: (change != self.before).then(|| change.clone()),
        };
        self.before = change;
        self.tick += 1;
        Some(now)
    }
}

/// A scenario that befalls a simulated rig whose board is flown by somebody else. Where nothing of it changes
/// it leaves the rig as it is: what is injected beside it stays.
#[derive(Debug, Clone)]
pub struct Befallen {
    befalls: Befalls,
    plant: PlantParameters<f64>,
    /// \[V\] As it should be.
    supply: f32,
    /// What has befallen it last.
    before: Now,
    /// The plant is another than it was.
    changed: bool,
    /// Ticks that have befallen it.
    done: u32,
    end: u32,
}

impl Befallen {
    /// From its first tick on; `bench` is `rig`'s, on a sound supply.
    pub fn new(scenario: &Scenario, seed: u64, rig: &Rig, bench: &Bench<f32>) -> Self {
        Self {
            befalls: scenario.befalls(seed),
            plant: rig.plant,
            supply: bench.supply,
            before: Now::nothing(),
            changed: false,
            done: 0,
            end: scenario.last_tick() + 1,
        }
    }

    /// The bench's hardware becomes what the scenario says it is.
    pub fn wear(scenario: &Scenario, bench: &mut Bench<f32>) {
        bench.set_wear(&scenario.hardware.wear());
    }

    /// What befalls the rig in `tick` of the scenario, with all that was missed; nothing once it is over.
    pub fn befall(&mut self, bench: &mut Bench<f32>, tick: u32) {
        let mut last = None;
        while self.done <= tick && self.done < self.end {
            let now = self.befalls.next().expect("there is no end to it");
            if let Some(change) = &now.change {
                bench.become_plant(&change.of(&self.plant).map(f32::from_f64));
                self.changed = true;
            }
            last = Some(now);
            self.done += 1;
        }
        if tick >= self.end {
            self.become_now(bench, Now::nothing());
            if std::mem::take(&mut self.changed) {
                bench.become_plant(&self.plant.map(f32::from_f64));
            }
        } else if let Some(now) = last {
            self.become_now(bench, now);
        }
    }

    fn become_now(&mut self, bench: &mut Bench<f32>, now: Now) {
        if now.volts != self.before.volts {
            bench.disturbance = now.volts.cast();
        }
        if now.torque != self.before.torque {
            bench.set_load(now.torque.cast());
        }
        if now.noise != self.before.noise {
            bench.worn.set_noise(now.noise.cast());
        }
        if now.jitter != self.before.jitter {
            bench.worn.set_jitter(now.jitter);
        }
        if now.supply != self.before.supply {
            bench.supply = now.supply(self.supply);
        }
        self.before = now;
    }
}
