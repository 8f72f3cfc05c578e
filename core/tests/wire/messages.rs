//! Every message, each variant in it, framed.

use crate::record::{controller, numbered};
use crate::{compare, counting};
use serde::Serialize;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Faults, Injection};
use twinrotor::first_power::{Fault, Motor, Verdict};
use twinrotor::link::{
    ChipSerial, Health, Identity, MAX_FRAME, Nonce, Refusal, ResetReport, ToBoard, ToHost, encode, text,
};
use twinrotor::parameters::{self, Provenance};
use twinrotor::reference::Reference;
use twinrotor::replay::{Replayed, Sample};
use twinrotor::rig_port::RigPort;
use twinrotor::sequence::Sequence;
use twinrotor::supervisor::{ArmState, Condition, Conditions};
use twinrotor::telemetry::{Frame, InForce, Kept, Taken, TrialPhase};
use twinrotor::trial::Attempt;

/// Of the boot that messages are meant for.
const SERIAL: ChipSerial = ChipSerial([1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
const NONCE: Nonce = Nonce(0x89AB_CDEF);

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
    let nonce = NONCE;
    let replay = |wanted| {
        let (counts, volts) = (PerAxis { pitch: -3, yaw: 1_000_000 }, PerMotor { main: 1.0, tail: 2.0 });
        ToBoard::Replay(Sample { number: 70_000, counts, volts, wanted })
    };
    let faults = Faults {
        motors_swapped: true,
        motor_reversed: PerMotor { main: false, tail: true },
        motor_open: PerMotor { main: true, tail: false },
        encoders_swapped: false,
        encoder_reversed: PerAxis { pitch: true, yaw: false },
        encoder_stuck: PerAxis { pitch: false, yaw: true },
        slip: PerAxis { pitch: 40, yaw: -40 },
        drift: PerAxis { pitch: 0, yaw: 1 },
    };
    let inject = |injection| ToBoard::Inject(nonce, injection);
    let messages = [
        ("alive", ToBoard::Alive),
        ("identify", ToBoard::Identify),
        ("disarm", ToBoard::Disarm),
        ("setpoint", ToBoard::Setpoint(reference(1))),
        ("zero", ToBoard::Zero),
        ("arm", ToBoard::Arm(nonce)),
        ("clear-fault", ToBoard::ClearFault(nonce)),
        ("check", ToBoard::Check(nonce)),
        ("telemetry", ToBoard::Telemetry { every: 1000 }),
        ("read-parameters", ToBoard::ReadParameters),
        ("write-parameters", ToBoard::WriteParameters(nonce, numbered())),
        ("replay", replay(None)),
        ("replay-wanted", replay(Some(reference(3)))),
        ("trial", ToBoard::Trial(nonce, Attempt::new(controller(&mut counting(1))))),
        ("accept", ToBoard::Accept(nonce)),
        ("revert", ToBoard::Revert),
        ("save", ToBoard::Save(nonce)),
        ("inject-rest", inject(Injection::Rest)),
        ("inject-wiring", inject(Injection::Wiring(faults))),
        ("inject-supply", inject(Injection::Supply(1.0))),
        ("inject-disturbance", inject(Injection::Disturbance(PerMotor { main: 1.0, tail: 2.0 }))),
        ("inject-current-limit", inject(Injection::CurrentLimit(true))),
        ("inject-emergency-stop", inject(Injection::EmergencyStop(true))),
        ("inject-weight", inject(Injection::Weight { mass: 1.0, arm: 2.0 })),
        ("inject-stall", inject(Injection::Stall { ticks: 3 })),
    ];
    let sequence = (40_000..).map(Sequence);
    let framed = messages.into_iter().zip(sequence).map(|((name, message), sequence)| {
        let alone = message.clone().meant_for(NONCE);
        assert_eq!(alone, message, "{name} is meant for that boot");
        (name, framed(&message.numbered(sequence)))
    });
    compare("to-board/", framed);
}

fn frame(tick: u32, state: ArmState, conditions: &[Condition]) -> ToHost {
    let n = &mut counting(1);
    ToHost::Frame(Frame {
        tick,
        state,
        conditions: Conditions::of(conditions),
        angle: axes(n),
        rate: axes(n),
        disturbance: axes(n),
        reference: axes(n),
        demand: motors(n),
        unallocated_torque: axes(n),
        volts: motors(n),
        supply: n(),
        taken: Taken { sequence: Sequence(40_000), ago: 7 },
        controller: InForce { accepted: Kept::Unsaved, trial: TrialPhase::FadingIn, blend: 50 },
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
        Condition::SupplyJump,
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
        Condition::ResetByClock,
        Condition::ClockFallback,
        Condition::DebugBuild,
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
    let identity = |provenance, reset| {
        ToHost::Identity(Identity {
            firmware: text("0.1.0"),
            chip: text("stm32f405rg"),
            serial: SERIAL,
            port: RigPort::Simulated,
            parameters: parameters::VERSION,
            provenance,
            nonce: NONCE,
            expected: Sequence(300),
            reset,
        })
    };
    let reset = ResetReport { cause: Condition::ResetByPanic, program_counter: 0x0801_2345, ticks: 7 };
    let health = Health {
        frames_dropped: 1,
        messages_rejected: 2,
        messages_stale: 3,
        tick_cycles_max: 150_000,
        stack_used: 4,
        stack_size: 16_384,
    };
    let replayed = |volts| {
        let n = &mut counting(1);
        let (angle, rate, disturbance) = (axes(n), axes(n), axes(n));
        ToHost::Replayed(Replayed { number: 9, angle, rate, disturbance, volts })
    };
    let setpoint = Refusal::Setpoint { field: text("setpoint.angle.pitch"), low: 1.0, high: 2.0 };
    let range = Refusal::Range { field: text("limits.pitch"), allowed: text("above 0") };
    [
        ("health", ToHost::Health(health)),
        ("identity", identity(Provenance::Stored, None)),
        ("identity-reset", identity(Provenance::Missing, Some(reset))),
        ("identity-other-version", identity(Provenance::OtherVersion { found: 4 }, None)),
        ("identity-damaged", identity(Provenance::Damaged, None)),
        ("parameters", ToHost::Parameters(numbered())),
        ("saved", ToHost::Saved),
        ("replayed", replayed(None)),
        ("replayed-wanted", replayed(Some(PerMotor { main: 7.0, tail: 8.0 }))),
        ("refused-motors-may-turn", ToHost::Refused(Refusal::MotorsMayTurn)),
        ("refused-no-replay", ToHost::Refused(Refusal::NoReplay)),
        ("refused-busy", ToHost::Refused(Refusal::Busy)),
        ("refused-nonce", ToHost::Refused(Refusal::Nonce)),
        ("refused-no-parameters", ToHost::Refused(Refusal::NoParameters)),
        ("refused-setpoint", ToHost::Refused(setpoint)),
        ("refused-flash", ToHost::Refused(Refusal::Flash)),
        ("refused-range", ToHost::Refused(range)),
        ("refused-not-armed", ToHost::Refused(Refusal::NotArmed)),
        ("refused-trial-under-way", ToHost::Refused(Refusal::TrialUnderWay)),
        ("refused-nothing-to-accept", ToHost::Refused(Refusal::NothingToAccept)),
        ("refused-too-often", ToHost::Refused(Refusal::TooOften { least: 300 })),
        ("refused-not-simulated", ToHost::Refused(Refusal::NotSimulated)),
    ]
    .map(|(name, message)| (name.to_owned(), message))
    .into()
}

#[test]
fn every_message_to_the_host_is_its_literal() {
    let messages: Vec<_> = [frames(), verdicts(), answers()].concat();
    compare("to-host/", messages.iter().map(|(name, message)| (name.as_str(), framed(message))));
}
