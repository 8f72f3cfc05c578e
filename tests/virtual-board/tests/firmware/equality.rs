//! What flies is what the host computes: the board's compare values and telemetry against the core's own
//! control loop on the host, with the same plant, tick for tick and bit for bit; both ways of driving
//! amplifiers.

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::board::FEATHER_F405;
use twinrotor::control_loop::{ControlLoop, Inputs, OperatorCommand, Outputs};
use twinrotor::drive::Drive as Amplifier;
use twinrotor::encoder::CounterWidth;
use twinrotor::first_power::Verdict;
use twinrotor::link::ToBoard;
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::{self, Rig};
use twinrotor::reference::Reference;
use twinrotor::sequence::{Numbered, Sequence};
use twinrotor::supervisor::{ArmState, Condition, Request};
use twinrotor::telemetry::Frame;
use twinrotor_station::again::bits;
use virtual_board::chip::timer::Drive;
use virtual_board::firmware::Firmware;
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::Setup;
use virtual_board::record::{self, ADDRESS, image};
use virtual_board::wiring::Amplifiers;

use super::{firmware, make_ready, paper_parameters, rest, start};

/// Ticks in the air: beyond every transient of the setpoints, after which each tick is like the last.
const TICKS: usize = 5_000;

/// What went into a tick of the board, and what telemetry told of it, where it was compared.
pub(super) struct Recorded {
    pub(super) counters: PerAxis<u32>,
    /// \[V\]
    pub(super) supply: f32,
    pub(super) command: Option<OperatorCommand>,
    pub(super) frame: Option<Frame>,
}

/// The board's loop on the host.
struct Host {
    helicopter: Helicopter,
    control: ControlLoop,
    /// The loop and the counters before the last tick.
    before_last: Option<(ControlLoop, PerAxis<u32>)>,
    drive: Amplifier<f32>,
    supply: f32,
    before: Option<Outputs>,
}

impl Host {
    fn new(rig: &Rig, parameters: &Parameters) -> Self {
        let supply = rig.volts_limit.main.max(rig.volts_limit.tail);
        let helicopter = Helicopter::new(rig, supply);
        let drive = Amplifier::new(rig.board.pwm_steps());
        let control = ControlLoop::new(parameters, CounterWidth::Bits16, helicopter.counters(), drive, None);
        let supply = helicopter.measured_supply();
        Self { helicopter, control, before_last: None, drive, supply, before: None }
    }

    fn compute(&self, command: Option<OperatorCommand>) -> (ControlLoop, Outputs) {
        self.tick(self.control, self.helicopter.counters(), command)
    }

    /// The last tick once more with `command`, of which its telemetry and its volts told nothing, since a
    /// command filter lets a jump through one tick later; then this tick.
    fn compute_late(&self, command: OperatorCommand) -> Option<(ControlLoop, Outputs)> {
        let (control, counters) = self.before_last?;
        let (corrected, _) = self.tick(control, counters, Some(command));
        (bits(&corrected.frame()) == bits(&self.control.frame()))
            .then(|| self.tick(corrected, self.helicopter.counters(), None))
    }

    fn tick(
        &self,
        mut control: ControlLoop,
        counters: PerAxis<u32>,
        command: Option<OperatorCommand>,
    ) -> (ControlLoop, Outputs) {
        let outputs = control.tick(&Inputs {
            command: command.map(|message| Numbered { sequence: Sequence::default(), message }).as_ref(),
            ..Inputs::sound(counters, self.supply)
        });
        (control, outputs)
    }

    /// Takes a tick that was computed. Answers the steps that are latched at it.
    fn take(&mut self, (control, outputs): (ControlLoop, Outputs)) -> [i64; 2] {
        self.before_last = Some((self.control, self.helicopter.counters()));
        self.control = control;
        let duty = self.before.map_or(PerMotor::default(), |before| before.duty);
        let volts = if outputs.enable { self.drive.volts(duty, self.supply) } else { PerMotor::zero() };
        self.helicopter.advance(volts, outputs.enable);
        self.before = Some(outputs);
        [duty.main.steps(), duty.tail.steps()].map(i64::from)
    }
}

/// Flies on the board, setpoint after setpoint; answers every frame, and what the latched compare values ask
/// for after each tick.
fn fly(
    setup: Setup,
    rig: &Rig,
    parameters: &Parameters,
    setpoints: &[PerAxis<f32>],
    ticks: usize,
) -> (Vec<Frame>, Vec<[i64; 2]>) {
    let mut station = start(setup.with_image(ADDRESS, image(&[*parameters])), rig);
    // What is said before the board listens is lost.
    station.run(10);
    station.send(&ToBoard::Telemetry { every: 1 });
    make_ready(&mut station);
    station.aim(setpoints[0]);
    station.run(50);
    station.request(Request::Arm);
    station.run(ticks as u64 / setpoints.len() as u64 + 50);
    for &setpoint in &setpoints[1..] {
        station.aim(setpoint);
        station.run(ticks as u64 / setpoints.len() as u64 + 50);
    }
    let (trace, ticks) = station.machine.trace();
    // The outputs that were looked at next after each tick.
    let mut after = trace.iter().peekable();
    let asked = ticks.iter().filter_map(|tick| {
        while after.next_if(|outputs| outputs.at < tick.at).is_some() {}
        let outputs = after.peek()?;
        Some([0, 1].map(|motor| outputs.asked(motor)))
    });
    assert_eq!(station.heard.damaged, 0);
    (station.heard.frames.clone(), asked.collect())
}

fn assert_equal(rig: &Rig, parameters: &Parameters, setpoints: &[PerAxis<f32>]) {
    assert_equal_on(Setup::new(firmware()), rig, parameters, setpoints);
}

fn assert_equal_on(setup: Setup, rig: &Rig, parameters: &Parameters, setpoints: &[PerAxis<f32>]) {
    compared(setup, rig, parameters, setpoints, TICKS);
}

/// Flies so many ticks on the board and compares every one; gives them all, from switched on.
pub(super) fn compared(
    setup: Setup,
    rig: &Rig,
    parameters: &Parameters,
    setpoints: &[PerAxis<f32>],
    ticks: usize,
) -> Vec<Recorded> {
    let (frames, asked) = fly(setup, rig, parameters, setpoints, ticks);
    let zeroed = frames.iter().position(|frame| !frame.conditions.contains(Condition::NotZeroed));
    let zeroed = frames[zeroed.expect("it was zeroed")].tick;
    let armed = frames.iter().find(|frame| frame.state == ArmState::Armed).expect("it was armed").tick;
    let mut host = Host::new(rig, parameters);
    let mut waiting = setpoints.iter();
    let mut compared = 0;
    let mut recorded: Vec<Recorded> = Vec::with_capacity(asked.len());
    let mut frames = frames.iter().peekable();
    for (tick, &steps) in (0_u32..).zip(&asked) {
        let mut command = match tick {
            tick if tick + 1 == zeroed => Some(OperatorCommand::Zero),
            tick if tick == armed => Some(OperatorCommand::Request(Request::Arm)),
            _ => None,
        };
        let mut computed = host.compute(command);
        let frame = frames.next_if(|frame| frame.tick == tick);
        if let Some(frame) = frame
            && tick >= zeroed
            && bits(frame) != bits(&computed.0.frame())
            && let Some(&setpoint) = waiting.next()
        {
            // A setpoint that came over the link came into this tick, or into the last one.
            let aim = OperatorCommand::Setpoint(Reference::at_rest(setpoint));
            computed = host.compute(Some(aim));
            command = Some(aim);
            if bits(frame) != bits(&computed.0.frame())
                && let Some(late) = host.compute_late(aim)
                && let Some(last) = recorded.last_mut()
            {
                computed = late;
                (last.command, command) = (command, None);
            }
        }
        if let Some(frame) = frame
            && tick >= zeroed
        {
            assert_eq!(
                bits(frame),
                bits(&computed.0.frame()),
                "tick {tick}: {frame:?} {:?}",
                computed.0.frame()
            );
            assert_eq!(frame.state, computed.0.frame().state, "tick {tick}");
        }
        let frame = frame.filter(|frame| frame.tick >= zeroed);
        recorded.push(Recorded {
            counters: host.helicopter.counters(),
            supply: host.supply,
            command,
            frame: frame.copied(),
        });
        let expected = host.take(computed);
        assert_eq!(steps, expected, "compare values latched at tick {tick}");
        compared += usize::from(tick > armed && frame.is_some());
    }
    assert!(compared >= ticks, "only {compared} ticks in the air were compared");
    assert!(waiting.next().is_none(), "every setpoint came to bear");
    let moved = asked.iter().filter(|&&steps| steps != [0, 0]).count();
    assert!(moved > ticks / 2, "the motors turned");
    recorded
}

/// 15 and 40 degrees, the paper's step.
pub(super) const STEP: PerAxis<f32> = PerAxis { pitch: 0.261_799_4, yaw: 0.698_131_7 };
pub(super) const BACK: PerAxis<f32> = PerAxis { pitch: -0.05, yaw: 0.1 };

#[test]
fn the_papers_rig_flies_on_the_board_as_on_the_host() {
    assert_equal(&presets::PAPER, &paper_parameters(&presets::PAPER), &[STEP, BACK]);
}

#[test]
fn an_aero_flies_on_the_board_as_on_the_host() {
    assert_equal(&presets::AERO, &paper_parameters(&presets::AERO), &[STEP, BACK, STEP]);
}

#[test]
fn an_aero_2_flies_on_the_board_as_on_the_host() {
    assert_equal(&presets::AERO2, &paper_parameters(&presets::AERO2), &[STEP]);
}

#[test]
fn an_aero_with_real_friction_flies_on_the_board_as_on_the_host() {
    assert_equal(&presets::AERO_LAB, &paper_parameters(&presets::AERO_LAB), &[BACK, STEP]);
}

/// The firmware with the feature `sign-magnitude`, its amplifiers connected for it: only the pins differ.
fn sign_magnitude() -> Setup {
    let firmware = Firmware::sign_magnitude().unwrap_or_else(|why| panic!("{why}"));
    Setup { amplifiers: Amplifiers::SignMagnitude, ..Setup::new(firmware) }
}

#[test]
fn sign_magnitude_flies_on_the_board_as_on_the_host() {
    assert_equal_on(sign_magnitude(), &presets::PAPER, &paper_parameters(&presets::PAPER), &[STEP, BACK]);
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    assert_equal_on(sign_magnitude(), &rig, &parameters, &[STEP, BACK]);
}

/// A Feather with a rig: its PWM is another timer's, one motor's inputs are the complements of two of its
/// channels, and its encoders and its serial line have other ports than everybody's.
fn feather() -> Setup {
    Setup::new(Firmware::released_for(FEATHER_F405).unwrap_or_else(|why| panic!("{why}")))
}

#[test]
#[ignore = "long: another board's image, 15 s of a processor to build"]
fn a_feather_flies_on_its_own_pins_as_on_the_host() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    assert_equal_on(feather(), &rig, &parameters, &[STEP, BACK]);
}

#[test]
#[ignore = "long: another board's image, 15 s of a processor to build"]
fn a_feather_checks_its_wires_and_obeys_the_emergency_stop() {
    checks_and_stops(feather(), |_| true);
}

#[test]
fn sign_magnitude_never_drives_both_inputs_of_a_bridge_and_obeys_the_emergency_stop() {
    let high = |leg: Drive| leg.share_high().is_some_and(|share| share > 0.0);
    checks_and_stops(sign_magnitude(), |bridge| !bridge.into_iter().all(high));
}

/// The first-power check passes, a step is flown in which both directions are driven and all bridges are as
/// they `may` be, and the emergency stop ends it.
fn checks_and_stops(setup: Setup, may: impl Fn([Drive; 2]) -> bool) {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let unchecked = Parameters { checked: false, ..parameters };
    let mut station = start(setup.with_image(ADDRESS, image(&[unchecked])), &rig);
    rest(&mut station);
    station.send(&ToBoard::Zero);
    station.run(50);
    station.request(Request::Check);
    assert!(station.run_until(400_000, |heard| !heard.verdicts.is_empty()));
    assert_eq!(station.heard.verdicts, [Verdict::Passed]);
    station.await_state(1_000, ArmState::Ready);
    station.aim(STEP);
    station.request(Request::Arm);
    station.run(1_000);
    assert!(station.machine.outputs().live());
    let (trace, _) = station.machine.trace();
    assert!(trace.iter().flat_map(|outputs| outputs.legs).all(may));
    let turned =
        |sign: f64| trace.iter().any(|outputs| outputs.duty().into_iter().any(|duty| duty * sign > 0.0));
    assert!(turned(1.0) && turned(-1.0), "both directions were driven");
    station.machine.rig(|rig: &mut Helicopter| rig.press(true, false));
    station.run(2);
    assert!(!station.machine.outputs().live());
    station.await_state(20, ArmState::Fault(Condition::EmergencyStop));
}

/// The controllers tuned for each preset: every law, estimator and allocation that a board boots with.
#[test]
fn every_tuned_controller_flies_on_the_board_as_on_the_host() {
    for (name, _) in presets::ALL {
        let (rig, parameters) = record::tuned(name);
        assert_equal(&rig, &parameters, &[STEP, BACK]);
    }
}
