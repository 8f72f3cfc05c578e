//! What all environments of a batch share, and one episode of one of them.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor_tune::robust::{Draw, draw};

/// Ticks of 1 ms between two actions.
pub(super) const TICKS: u16 = 20;
/// \[rad\] Goals are drawn from within.
const GOALS_DEG: PerAxis<f64> = PerAxis::new(15.0, 40.0);
/// \[deg\] What an action of one asks of the board's controller.
const REACH_DEG: PerAxis<f32> = PerAxis::new(25.0, 90.0);
/// Numbers that are seen of an environment: angles, rates, errors, volts.
pub(super) const SEEN: usize = 8;
/// What an end of its own costs an episode.
const END: f64 = 10.0;

/// What an action means.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "there is one for each thread")]
pub(super) enum Kind {
    /// Parts of the motors' limits.
    Volts,
    /// Where the controller is to fly, behind the board's supervisor or without it.
    Setpoint { believed: Rig, settings: Settings<f32>, supervised: bool },
}

/// When an environment whose episode is over begins the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Autoreset {
    NextStep,
    SameStep,
    Disabled,
}

/// The rules.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task {
    /// What flies, or around which it is drawn.
    pub(super) rig: Rig,
    pub(super) kind: Kind,
    /// Does each episode fly another plant?
    pub(super) spread: bool,
    /// Actions until an episode is cut.
    pub(super) steps: u32,
    pub(super) autoreset: Autoreset,
}

impl Task {
    /// What is asked of the motors \[V\] or the controller \[rad\] by an action, which is within ±1.
    pub(super) fn asked(&self, action: [f32; 2]) -> [f32; 2] {
        let [first, second] = action.map(|part| part.clamp(-1.0, 1.0));
        #[expect(clippy::cast_possible_truncation, reason = "a limit of volts")]
        let [most, other] = match self.kind {
            Kind::Volts => self.rig.volts_limit.map(|limit| limit as f32).to_array(),
            Kind::Setpoint { .. } => REACH_DEG.map(f32::to_radians).to_array(),
        };
        [first * most, second * other]
    }
}

/// What a world tells of a plant after an action.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seen {
    pub(super) angle: PerAxis<f32>,
    pub(super) rate: PerAxis<f32>,
    /// \[V\] At the motors, in the last tick.
    pub(super) volts: PerMotor<f32>,
    /// \[rad²\] What was missing to the goal: both axes, the ticks' mean.
    pub(super) square: f32,
    /// It has left the envelope, or the supervisor has switched the motors off.
    pub(super) ended: bool,
}

/// An environment's place in its episode. What is drawn depends on seed and number alone.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Episode {
    seed: u64,
    number: u64,
    pub(super) goal: PerAxis<f32>,
    left: u32,
    pub(super) over: bool,
}

/// What an action came to.
pub(super) struct Outcome {
    pub(super) reward: f64,
    pub(super) terminated: bool,
    pub(super) truncated: bool,
}

impl Episode {
    /// The first of those of `seed` comes next.
    pub(super) fn seed(&mut self, seed: u64) {
        *self = Self { seed, ..Self::default() };
    }

    /// The next one: its plant, and what is seen at its beginning, at rest.
    pub(super) fn begin(&mut self, task: &Task) -> (Draw, [f32; SEEN]) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.number);
        let plant = rng.next_u64();
        #[expect(clippy::cast_possible_truncation, reason = "a goal in f32")]
        let goal = GOALS_DEG.map(|most| rng.random_range(-most..most).to_radians() as f32);
        *self = Self { number: self.number + 1, goal, left: task.steps, over: false, ..*self };
        let drawn = if task.spread {
            draw(&task.rig, 1, plant).pop().expect("one was asked for")
        } else {
            Draw { plant: task.rig.plant, disturbance: PerMotor::zero(), encoder_phase: PerAxis::both(0.5) }
        };
        (drawn, self.shows(&Seen::default()))
    }

    /// Has there been one?
    pub(super) fn has_begun(&self) -> bool {
        self.number > 0
    }

    /// Angles, rates, what is missing to the goal, volts.
    pub(super) fn shows(&self, seen: &Seen) -> [f32; SEEN] {
        let missing = self.goal.minus(seen.angle);
        let [angle, rate, missing] = [seen.angle, seen.rate, missing].map(PerAxis::to_array);
        let [main, tail] = seen.volts.to_array();
        [angle[0], angle[1], rate[0], rate[1], missing[0], missing[1], main, tail]
    }

    /// An action has been flown.
    pub(super) fn flown(&mut self, seen: &Seen) -> Outcome {
        self.left = self.left.saturating_sub(1);
        let (terminated, truncated) = (seen.ended, self.left == 0);
        self.over = terminated || truncated;
        let reward = -f64::from(seen.square) - if terminated { END } else { 0.0 };
        Outcome { reward, terminated, truncated }
    }
}
