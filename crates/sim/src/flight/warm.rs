//! Motors are warmed before a flight.

use super::{DIVERGED, Plan};
use crate::closed_loop::ClosedLoop;
use crate::error::{Error, Outcome};
use crate::scenario::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::supervisor::ArmState;
use twinrotor::trajectory::{Profile, ticks};

/// \[s\] How long motors are warmed, and then rest.
const WARMING: [f64; 2] = [60.0, 4.0];

/// Flies what [`Start::hot`](crate::scenario::Start::hot) says, of which nothing is kept but what the
/// controller, the motors and the rig have become.
pub(super) fn warm_up<R, L>(plan: &Plan<'_>, closed_loop: &mut L) -> Outcome<()>
where
    R: Real<Scalar = R> + Into<f64>,
    L: ClosedLoop<R>,
{
    let [warming, rest] = WARMING.map(|time| ticks(time, SAMPLE_TIME));
    let swing = |angle: f64| {
        let angle = angle.to_radians();
        Profile::steps(0.0, &[(0.0, angle), (1.25, -angle)], 2.5, SAMPLE_TIME)
    };
    let squares = PerAxis::new(swing(25.0), swing(60.0));
    let begin = Reference::at_rest(plan.initial.cast());
    for tick in 0..warming + rest {
        let reference = if tick < warming { squares.at(tick) } else { begin };
        let happened = closed_loop.tick(&reference, PerMotor::zero());
        let angle = happened.state.angle.map(Into::into);
        let cut = match closed_loop.arm_state() {
            Some(ArmState::Fault(cause)) => Some(format!("the board cut the motors: {cause:?}")),
            _ => (!(angle.pitch.abs() < DIVERGED && angle.yaw.abs() < DIVERGED))
                .then(|| "the loop diverged".to_owned()),
        };
        if let Some(why) = cut {
            let time = f64::from(tick) * SAMPLE_TIME;
            return Err(Error::Failed(format!("while the motors were warmed, after {time:.3} s, {why}")));
        }
    }
    Ok(())
}
