//! A law that only tests have: that a file and a line in the list are all that a law takes.

#![allow(dead_code, unreachable_pub, reason = "a test needs a part of what the macros make")]

use super::registry::laws;
use super::{Backstepping, ControlLaw, Situation};
use crate::allocation::Allocation;
use crate::axes::PerAxis;
use crate::estimator::{Belief, Estimate};
use crate::gains::{self, Gains};
use crate::plant::{Effectiveness, RigidBody, State, presets};
use crate::real::{Mask, Real};
use crate::reference::Reference;

// What a law's own file holds.

settings! {
    /// The gain of one axis.
    pub struct SpringGains<R> at "pitch.", "yaw." {
        /// k, of the angle error.
        stiffness: (R) "N m/rad", (0 to 2), typical 0.1 to 1.0, default 0.5;
    }
}

/// Torque in proportion to the error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring<R> {
    gains: PerAxis<SpringGains<R>>,
}

impl<R: Real> ControlLaw<R> for Spring<R> {
    type Gains = PerAxis<SpringGains<R>>;

    fn start(gains: Self::Gains, _effectiveness: Effectiveness<R>, _sample_time: R) -> Self {
        Self { gains }
    }

    fn integrates(_gains: &Self::Gains) -> R::Mask {
        R::Mask::splat(false)
    }

    fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
        self.gains.zip(now.angle_error(), |g, e| g.stiffness * e)
    }
}

// The list, with one line more.

laws! {
    /// The paper's.
    "backstepping" Backstepping(Gains<R>);
    /// A spring to the reference.
    "spring" Spring(PerAxis<SpringGains<R>>);
}

#[test]
fn a_law_is_a_file_and_a_line() {
    let names: std::vec::Vec<_> = LawSettings::<f64>::KINDS.iter().map(|kind| kind.name).collect();
    assert_eq!(names, ["backstepping", "spring"]);

    let settings = LawSettings::<f64>::named("spring").unwrap();
    assert_eq!((settings.kind(), settings.validate()), ("spring", Ok(())));
    let fields: std::vec::Vec<_> = settings.fields().iter().map(|f| (f.name, f.unit, f.default)).collect();
    assert_eq!(fields, [("pitch.stiffness", "N m/rad", 0.5), ("yaw.stiffness", "N m/rad", 0.5)]);
    let error = settings.map(|k| 10.0 * k).validate().unwrap_err();
    assert_eq!((error.field, error.value, error.allowed), ("pitch.stiffness", 5.0, "0 to 2"));

    // Stored, it is its place in the list and its numbers; a law that was there before is what it was.
    let mut buffer = [0; 64];
    let stored = postcard::to_slice(&settings.map(f32::from_f64), &mut buffer).unwrap();
    assert_eq!(stored, [1, 0, 0, 0, 63, 0, 0, 0, 63]);
    let paper = postcard::to_slice(&LawSettings::Backstepping(gains::PAPER), &mut buffer).unwrap();
    assert_eq!(paper[0], 0);

    let rig = presets::AERO;
    let body = RigidBody::new(&rig.plant);
    let mut law = Law::new(&settings, rig.plant.effectiveness, 1e-3);
    let belief = Belief::new(&body, Estimate::exact(State::default()));
    let now = Situation::new(&body, belief, Reference::at_rest(PerAxis::new(0.2, -0.4)));
    assert_eq!(law.torque(&now), PerAxis::new(0.1, -0.2));
    law.settle(&now, &Allocation::none());
    law.restart();
    assert!(!Law::integrates(&settings));
}
