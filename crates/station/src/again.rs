//! A flight on a simulated rig, computed once more from what its frames say, and compared bit for bit.
//!
//! In which tick a message arrives is chance on a line. But a frame names the message that was taken last and
//! when, so a host that knows what it said can fly exactly those ticks itself: from the rig's rest pose,
//! where it was zeroed, through the same loop and the same bench.

use std::collections::BTreeMap;
use twinrotor::bench::SimulatedRig;
use twinrotor::control_loop::{ControlLoop, Inputs, OperatorCommand};
use twinrotor::drive::Drive;
use twinrotor::encoder::CounterWidth;
use twinrotor::first_power::REST_TICKS;
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::Rig;
use twinrotor::sequence::{Numbered, Sequence};
use twinrotor::supervisor::{ArmState, Condition, Conditions, Request};
use twinrotor::telemetry::Frame;
use twinrotor::trial::{Attempt, Candidate};
use twinrotor_sim::{Error, Outcome};

/// Flies the ticks of `frames` from zeroing to the last one armed once more, with what the operator `said`
/// and had `tried`, on `rig` and with `parameters`. Gives how many armed ticks were the same.
///
/// # Errors
///
/// The first tick that is not the same, or what the frames do not say.
pub fn again(
    rig: &Rig,
    parameters: &Parameters,
    frames: &[Frame],
    said: &[Numbered<OperatorCommand>],
    tried: Option<&(Sequence, Attempt)>,
) -> Outcome<usize> {
    let missing = |what: &str| Error::Failed(format!("the frames do not say when {what}"));
    let taken = taken(frames);
    let when = |wanted: OperatorCommand| {
        let numbers: Vec<Sequence> =
            said.iter().filter(|s| s.message == wanted).map(|s| s.sequence).collect();
        taken.iter().rev().find(|(_, sequence)| numbers.contains(sequence)).map(|(tick, _)| *tick)
    };
    let zeroed = when(OperatorCommand::Zero).ok_or_else(|| missing("it was zeroed"))?;
    let armed = when(OperatorCommand::Request(Request::Arm)).ok_or_else(|| missing("it was armed"))?;
    let first = frames.iter().find(|frame| frame.tick >= armed).ok_or_else(|| missing("it flew"))?;
    let candidate = tried.map(|(sequence, attempt)| Candidate::new(parameters, attempt, *sequence));
    let candidate = candidate.transpose().map_err(Error::from)?;
    let mut host = Host::at_rest(rig, parameters, first.supply, zeroed);
    host.candidate = candidate;
    let mut same = 0;
    let mut flown = frames.iter().filter(|frame| frame.tick >= armed).peekable();
    for tick in zeroed.. {
        if flown.peek().is_none_or(|frame| frame.state != ArmState::Armed) {
            break;
        }
        let command = taken.get(&tick).and_then(|number| said.iter().find(|s| s.sequence == *number));
        host.tick(command);
        let Some(there) = flown.next_if(|frame| frame.tick == tick) else { continue };
        let here = host.control.frame();
        if let Some(difference) = difference(&here, there) {
            return Err(Error::Failed(format!(
                "{} ticks after arming, in the board's tick {tick}, the flight is not the same: {difference}",
                tick - armed
            )));
        }
        same += 1;
    }
    Ok(same)
}

/// Which message was taken in which tick, as far as the frames tell.
fn taken(frames: &[Frame]) -> BTreeMap<u32, Sequence> {
    let told = frames.iter().filter(|frame| frame.taken.ago < u8::MAX);
    told.map(|frame| (frame.tick.wrapping_sub(frame.taken.ago.into()), frame.taken.sequence)).collect()
}

/// \[ticks\] A power of two, and a multiple of all periods in which something is done every so many ticks.
const PHASE: u32 = 1_024;

/// The board's loop with its rig.
struct Host {
    rig: SimulatedRig,
    control: ControlLoop,
    candidate: Option<Candidate>,
}

impl Host {
    /// Has lain at rest for long enough to be zeroed, in the board's tick `zeroed`: what is done every few
    /// ticks is then done in the same ones.
    fn at_rest(rig: &Rig, parameters: &Parameters, supply: f32, zeroed: u32) -> Self {
        let drive = Drive::new(rig.board.pwm_steps());
        let mut rig = SimulatedRig::new(rig);
        rig.bench.supply = supply;
        rig.bench.hold();
        let parameters = Parameters { checked: true, ..*parameters };
        let control = ControlLoop::new(&parameters, CounterWidth::Bits16, rig.counters(), drive, None);
        let mut host = Self { rig, control, candidate: None };
        let least = 2 * REST_TICKS;
        let ticks = least + zeroed.wrapping_sub(least) % PHASE;
        (0..ticks).for_each(|_| host.tick(None));
        host
    }

    fn tick(&mut self, command: Option<&Numbered<OperatorCommand>>) {
        let outputs = self.control.tick(&Inputs {
            trial: self.candidate.as_ref(),
            command,
            current_limit: self.rig.current_limit(),
            senses: Conditions::NONE.with(Condition::EmergencyStop, self.rig.emergency_stop()),
            ..Inputs::sound(self.rig.counters(), self.rig.supply())
        });
        if let Some(Numbered { message: OperatorCommand::Inject(injection), .. }) = command {
            self.rig.inject(injection);
        }
        self.rig.tick(outputs.duty, self.control.state());
    }
}

/// Every number of a frame that a loop computes, with its name.
fn numbers(frame: &Frame) -> [(&'static str, f32); 15] {
    let Frame { angle, rate, disturbance, reference, demand, unallocated_torque, volts, supply, .. } = *frame;
    [
        ("angle.pitch", angle.pitch),
        ("angle.yaw", angle.yaw),
        ("rate.pitch", rate.pitch),
        ("rate.yaw", rate.yaw),
        ("disturbance.pitch", disturbance.pitch),
        ("disturbance.yaw", disturbance.yaw),
        ("reference.pitch", reference.pitch),
        ("reference.yaw", reference.yaw),
        ("unallocated_torque.pitch", unallocated_torque.pitch),
        ("unallocated_torque.yaw", unallocated_torque.yaw),
        ("demand.main", demand.main),
        ("demand.tail", demand.tail),
        ("volts.main", volts.main),
        ("volts.tail", volts.tail),
        ("supply", supply),
    ]
}

/// The same as bits.
pub fn bits(frame: &Frame) -> Vec<u32> {
    numbers(frame).map(|(_, number)| number.to_bits()).to_vec()
}

/// The first number that is not the same, or the state.
fn difference(here: &Frame, there: &Frame) -> Option<String> {
    let pairs = numbers(here).into_iter().zip(numbers(there));
    let mut different = pairs.filter(|((_, here), (_, there))| here.to_bits() != there.to_bits());
    if let Some(((name, here), (_, there))) = different.next() {
        return Some(format!("{name} is {here:e} here, {there:e} on the board"));
    }
    let (here, there) = (here.state, there.state);
    (here != there).then(|| format!("the state is {here:?} here, {there:?} on the board"))
}
