//! Every message, each variant in it, framed.

use crate::record::numbered;
use crate::{compare, counting};
use serde::Serialize;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::control_loop::OperatorCommand;
use twinrotor::first_power::{Fault, Motor, Verdict};
use twinrotor::link::{Health, Identity, MAX_FRAME, Refusal, ResetReport, ToBoard, ToHost, encode, text};
use twinrotor::parameters;
use twinrotor::reference::Reference;
use twinrotor::replay::{Replayed, Sample};
use twinrotor::supervisor::{ArmState, Condition, Conditions, Request};
use twinrotor::telemetry::Frame;

fn framed(message: &impl Serialize) -> Vec<u8> {
    encode(message, &mut [0; MAX_FRAME]).unwrap().to_vec()
}

fn axes(n: &mut impl FnMut() -> f32) -> PerAxis<f32> {
    PerAxis { pitch: n(), yaw: n() }
}

fn motors(n: &mut impl FnMut() -> f32) -> PerMotor<f32> {
    PerMotor { main: n(), tail: n() }
}

fn reference(first: u8) -> Reference<f32> {
    let n = &mut counting(first);
    Reference { angle: axes(n), rate: axes(n), accel: axes(n) }
}

#[test]
fn every_message_to_the_board_is_its_literal() {
    let request = |request| ToBoard::Control(OperatorCommand::Request(request));
    let replay = |wanted| {
        let (counts, volts) = (PerAxis { pitch: -3, yaw: 1_000_000 }, PerMotor { main: 1.0, tail: 2.0 });
        ToBoard::Replay(Sample { number: 70_000, counts, volts, wanted })
    };
    let messages = [
        ("alive", ToBoard::Alive),
        ("identify", ToBoard::Identify),
        ("control-arm", request(Request::Arm)),
        ("control-disarm", request(Request::Disarm)),
        ("control-clear-fault", request(Request::ClearFault)),
        ("control-check", request(Request::Check)),
        ("control-setpoint", ToBoard::Control(OperatorCommand::Setpoint(reference(1)))),
        ("control-zero", ToBoard::Control(OperatorCommand::Zero)),
        ("telemetry", ToBoard::Telemetry { every: 1000 }),
        ("read-parameters", ToBoard::ReadParameters),
        ("write-parameters", ToBoard::WriteParameters(numbered())),
        ("replay", replay(None)),
        ("replay-wanted", replay(Some(reference(3)))),
    ];
    compare("to-board/", messages.iter().map(|(name, message)| (*name, framed(message))));
}

fn frame(tick: u32, state: ArmState, conditions: &[Condition]) -> ToHost {
    let n = &mut counting(1);
    ToHost::Frame(Frame {
        tick,
        state,
        conditions: Conditions::of(conditions),
        angle: axes(n),
        rate: axes(n),
        reference: axes(n),
        demand: motors(n),
        volts: motors(n),
        supply: n(),
    })
}

fn frames() -> Vec<(String, ToHost)> {
    let conditions = [Condition::ResetByBrownOut, Condition::SensorStale, Condition::EmergencyStop];
    let states = [
        ("disarmed", ArmState::Disarmed),
        ("ready", ArmState::Ready),
        ("checking", ArmState::Checking),
        ("armed", ArmState::Armed),
    ];
    let states = states.map(|(name, state)| (format!("frame-{name}"), frame(86_400_000, state, &conditions)));
    let faults = [
        Condition::EmergencyStop,
        Condition::CurrentLimit,
        Condition::SupplyRange,
        Condition::SensorStale,
        Condition::PitchJump,
        Condition::YawJump,
        Condition::PitchMotion,
        Condition::YawMotion,
        Condition::AngleEnvelope,
        Condition::RateEnvelope,
        Condition::NonFinite,
        Condition::TickOverrun,
        Condition::CommandTimeout,
        Condition::StackGuard,
        Condition::ParametersInvalid,
        Condition::ParametersMissing,
        Condition::NotZeroed,
        Condition::NotChecked,
        Condition::ResetByWatchdog,
        Condition::ResetByPanic,
        Condition::ResetByFault,
        Condition::ResetByStackOverflow,
        Condition::ResetByBrownOut,
    ];
    let latched = faults.iter().enumerate();
    let latched =
        latched.map(|(k, cause)| (format!("frame-fault-{k}"), frame(1, ArmState::Fault(*cause), &[])));
    states.into_iter().chain(latched).collect()
}

fn verdicts() -> Vec<(String, ToHost)> {
    let verdict = |name: &str, verdict| (format!("verdict-{name}"), ToHost::Verdict(verdict));
    let faults = [
        Fault::MotorsSwapped,
        Fault::MainReversed,
        Fault::TailReversed,
        Fault::BothReversed,
        Fault::PitchReversed,
        Fault::YawReversed,
        Fault::EncodersSwapped,
    ];
    let wrong = faults.into_iter().enumerate();
    let wrong = wrong.map(|(k, fault)| verdict(&format!("wrong-{k}"), Verdict::Wrong(fault)));
    let others = [
        verdict("passed", Verdict::Passed),
        verdict("no-motion-main", Verdict::NoMotion { motor: Motor::Main }),
        verdict("no-motion-tail", Verdict::NoMotion { motor: Motor::Tail }),
        verdict("restless", Verdict::Restless),
    ];
    wrong.chain(others).collect()
}

fn answers() -> Vec<(String, ToHost)> {
    let identity = |reset| {
        let (firmware, chip) = (text("0.1.0"), text("stm32f405rg"));
        ToHost::Identity(Identity { firmware, chip, parameters: parameters::VERSION, reset })
    };
    let reset = ResetReport { cause: Condition::ResetByPanic, program_counter: 0x0801_2345, ticks: 7 };
    let health = Health {
        frames_dropped: 1,
        messages_rejected: 2,
        tick_cycles_max: 150_000,
        stack_used: 4,
        stack_size: 16_384,
    };
    let replayed = |volts| {
        let n = &mut counting(1);
        let (angle, rate, disturbance) = (axes(n), axes(n), axes(n));
        ToHost::Replayed(Replayed { number: 9, angle, rate, disturbance, volts })
    };
    let range = Refusal::Range { field: text("limits.pitch"), allowed: text("above 0") };
    [
        ("health", ToHost::Health(health)),
        ("identity", identity(None)),
        ("identity-reset", identity(Some(reset))),
        ("parameters", ToHost::Parameters(numbered())),
        ("saved", ToHost::Saved),
        ("replayed", replayed(None)),
        ("replayed-wanted", replayed(Some(PerMotor { main: 7.0, tail: 8.0 }))),
        ("refused-motors-may-turn", ToHost::Refused(Refusal::MotorsMayTurn)),
        ("refused-no-replay", ToHost::Refused(Refusal::NoReplay)),
        ("refused-busy", ToHost::Refused(Refusal::Busy)),
        ("refused-flash", ToHost::Refused(Refusal::Flash)),
        ("refused-range", ToHost::Refused(range)),
    ]
    .map(|(name, message)| (name.to_owned(), message))
    .into()
}

#[test]
fn every_message_to_the_host_is_its_literal() {
    let messages: Vec<_> = [frames(), verdicts(), answers()].concat();
    compare("to-host/", messages.iter().map(|(name, message)| (name.as_str(), framed(message))));
}
