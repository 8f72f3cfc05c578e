//! What the first-power check's pushes should do to a rig, by its whole model: worked out on the host, kept
//! in the parameter record.

use super::{FAR_ENOUGH, PUSH_TICKS, Push, farthest};
use crate::SAMPLE_TIME;
use crate::axes::{PerAxis, PerMotor};
use crate::bench::{Bench, Faults};
use crate::plant::PlantParameters;
use crate::plant::presets::Rig;
use crate::real::Real;

impl Push {
    /// What `volts` on one motor at a time do to a rig, by its whole model: friction may hold one axis, the
    /// reaction of a rotor that starts to turn may outweigh its thrust, and a nose that its weight pulls down
    /// lies on something.
    pub fn predicted(rig: &Rig, volts: PerMotor<f64>) -> PerMotor<Self> {
        let right = Faults::default();
        let swapped = Faults { motors_swapped: true, ..right };
        let reversed = Faults { motor_reversed: PerMotor::both(true), ..right };
        let push = |volts: PerMotor<f64>| Self {
            volts: f32::from_f64(volts.main + volts.tail),
            motion: motion(rig, volts, right),
            swapped: motion(rig, volts, swapped),
            reversed: motion(rig, volts, reversed),
        };
        PerMotor::new(push(PerMotor::new(volts.main, 0.0)), push(PerMotor::new(0.0, volts.tail)))
    }
}

/// \[rad\] How far `volts` turn the rig from its rest pose until a push ends.
fn motion(rig: &Rig, volts: PerMotor<f64>, faults: Faults) -> PerAxis<f32> {
    let nose_heavy = rig.plant.center_of_mass > 0.0;
    // A nose that is too light is held; only one that is too heavy lies by itself.
    let gravity = if nose_heavy { rig.plant.gravity } else { 0.0 };
    let rig = Rig { plant: PlantParameters { gravity, ..rig.plant }, ..*rig };
    let mut bench = Bench::<f64>::at_rest(&rig, SAMPLE_TIME);
    bench.set_table(true);
    bench.faults = faults;
    let mut moved = PerAxis::zero();
    for _ in 0..PUSH_TICKS {
        bench.advance(volts, true);
        moved = bench.state().angle.minus(rig.rest_angle).cast();
        if farthest(moved) > FAR_ENOUGH {
            break;
        }
    }
    moved
}
