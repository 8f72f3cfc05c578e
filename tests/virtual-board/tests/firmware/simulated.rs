//! The firmware for a Nucleo board without a rig: it computes one itself, which flies as the host's does to
//! the bit, takes what befalls it from its operator, and lets nothing out of the chip.

use std::time::Duration;

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Faults, Injection};
use twinrotor::board::{BLACK_PILL, Board, F405, FEATHER_F405, NUCLEO_F411, NUCLEO_F446};
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets;
use twinrotor::reference::Reference;
use twinrotor::rig_port::RigPort;
use twinrotor::supervisor::Condition;
use twinrotor::telemetry::Frame;
use twinrotor_sim::scenario::Scenario;
use twinrotor_station::again::again;
use twinrotor_station::session::{End, Ending, Event, Leg, Motors, Plan, Session, Write};
use twinrotor_station::words;
use virtual_board::board::Inputs;
use virtual_board::chip::Settings;
use virtual_board::chip::timer::Drive;
use virtual_board::firmware::Firmware;
use virtual_board::machine::{AtRest, Machine, Setup};
use virtual_board::record::{self, ADDRESS, image};

use super::board_with;

/// A preset's own controller, checked on a simulated rig.
fn parameters(preset: &str) -> Parameters {
    Parameters { port: RigPort::Simulated, ..record::tuned(preset).1 }
}

fn board(parameters: &Parameters) -> Machine {
    board_of(Firmware::simulated().unwrap_or_else(|why| panic!("{why}")), parameters)
}

fn board_of(firmware: Firmware, parameters: &Parameters) -> Machine {
    let setup = Setup::new(firmware).with_image(ADDRESS, image(&[*parameters]));
    let mut machine = Machine::switch_on(setup, AtRest(Inputs::default()));
    machine.run(200);
    machine
}

fn plan(parameters: &Parameters, legs: Vec<Leg>, injections: Vec<(u32, Injection)>) -> Plan {
    let (board, write, save) = (F405, Write::Never, false);
    Plan { board, parameters: *parameters, write, ask: false, frame_every: 1, injections, legs, save }
}

fn step(ticks: usize) -> Leg {
    Leg::Fly(vec![Reference::at_rest(PerAxis::new(0.15, 0.4)); ticks])
}

/// A session to its end. Its clock is the board's, so that a busy machine changes nothing.
fn fly(machine: &mut Machine, plan: Plan) -> (End, Vec<Frame>, Session) {
    fly_and(machine, plan, |_| {})
}

/// The same, and `then` as soon as the first leg has begun.
fn fly_and(machine: &mut Machine, plan: Plan, then: fn(&mut Machine)) -> (End, Vec<Frame>, Session) {
    const AT_ONCE: u64 = 2;
    let (mut session, mut frames, mut now) = (Session::new(plan, Duration::ZERO), Vec::new(), 0);
    loop {
        session.poll(Duration::from_millis(now));
        machine.say(&session.take_outgoing());
        machine.run(AT_ONCE);
        now += AT_ONCE;
        session.push(&machine.heard(), Duration::from_millis(now));
        while let Some(event) = session.event() {
            match event {
                Event::Frame(frame) => frames.push(frame),
                Event::Begins { .. } => then(machine),
                Event::Over(end) => return (end, frames, session),
                _ => {}
            }
        }
        assert!(now < 400_000, "no end");
    }
}

/// Flies the plan and computes it once more; answers how it ended and how many ticks were the same.
fn fly_twice(machine: &mut Machine, plan: Plan) -> (End, usize) {
    let parameters = plan.parameters;
    let (end, frames, session) = fly(machine, plan);
    let rig = parameters.rig(F405);
    let same = again(&rig, &parameters, &frames, session.said(), None);
    (end, same.unwrap_or_else(|why| panic!("{why}")))
}

/// No pin of the PWM's timer is connected, and the enable pin is low, all the time.
fn assert_nothing_left(machine: &mut Machine) {
    let (trace, _) = machine.trace();
    assert!(!trace.is_empty());
    for outputs in trace {
        assert!(!outputs.enabled && outputs.legs.iter().flatten().all(|leg| *leg == Drive::Released));
    }
}

/// All that there are to fly.
const SCENARIOS: [&str; 8] =
    ["step", "1", "2", "3", "3-square", "reversals.toml", "step-30-45.toml", "there-and-back.toml"];

fn text(name: &str) -> twinrotor_sim::Outcome<String> {
    let path = format!("{}/../../scenarios/{name}", env!("CARGO_MANIFEST_DIR"));
    Ok(std::fs::read_to_string(path).unwrap())
}

/// What a board's owner sends back, here: a preset's rig with its own controller, from checked to landed.
/// `TWINROTOR_SIMULATED=60` flies every scenario instead, each for at most so many seconds.
fn flies(preset: &str) {
    let seconds = std::env::var("TWINROTOR_SIMULATED").ok().map(|text| text.parse::<f64>().expect("seconds"));
    let parameters = parameters(preset);
    let mut machine = board(&parameters);
    let legs = match seconds {
        None => vec![step(1_500)],
        Some(seconds) => SCENARIOS
            .iter()
            .map(|name| {
                let mut scenario = Scenario::load(name, &text).unwrap();
                scenario.duration = scenario.duration.min(seconds);
                Leg::Fly(scenario.references())
            })
            .collect(),
    };
    let ticks: usize = legs.iter().map(|leg| if let Leg::Fly(r) = leg { r.len() } else { 0 }).sum();
    let (end, same) = fly_twice(&mut machine, plan(&parameters, legs, Vec::new()));
    assert_eq!(end, End { ending: Ending::Flown, motors: Motors::SeenOff }, "{preset}");
    assert!(same > ticks, "{preset}: {same} ticks");
    println!("{preset}: bit for bit equal over {same} ticks");
    assert_nothing_left(&mut machine);
}

mod every_simulated_rig_flies_on_the_board_as_on_the_host_bit_for_bit {
    use super::{flies, presets};

    /// A test for each preset, so that they fly at the same time.
    macro_rules! fly {
        ($($test:ident: $preset:literal),*) => {
            const FLOWN: &[&str] = &[$($preset),*];
            $(#[test]
            fn $test() {
                flies($preset);
            })*
        };
    }

    fly!(
        paper: "paper", paper_fixed: "paper-fixed", aero: "aero",
        aero2: "aero2", aero_lab: "aero-lab", heli: "heli"
    );

    #[test]
    fn and_there_is_no_other() {
        assert_eq!(presets::ALL.map(|(preset, _)| preset), FLOWN);
    }
}

/// The same rig on another board, by its own clock and its own PWM's steps, and its user button, if it has
/// one, which nothing else knows of.
fn flies_the_hosts_bits_and_its_button_is_the_emergency_stop(known: Board) {
    let firmware = Firmware::simulated_on(known).unwrap_or_else(|why| panic!("{why}"));
    let parameters = parameters(record::BUILT_IN);
    let mut machine = board_of(firmware, &parameters);
    let fly_step = |machine: &mut Machine, then| {
        let plan = Plan { board: known, ..plan(&parameters, vec![step(1_500)], Vec::new()) };
        let (end, frames, session) = fly_and(machine, plan, then);
        let identity = session.identity().expect("it said who it is");
        assert_eq!((identity.chip.as_str(), identity.port), (known.chip, RigPort::Simulated));
        let rig = parameters.rig(known);
        let same = again(&rig, &parameters, &frames, session.said(), None);
        (end, same.unwrap_or_else(|why| panic!("{why}")))
    };
    let flown = End { ending: Ending::Flown, motors: Motors::SeenOff };
    let (end, same) = fly_step(&mut machine, |_| {});
    println!("{}: bit for bit equal over {same} ticks", known.name);
    assert!(end == flown && same > 1_500, "{end:?}, {same} ticks");
    if Settings::of(known).button.is_some() {
        let (end, _) = fly_step(&mut machine, |machine| machine.rig(|rig: &mut AtRest| rig.0.button = true));
        let stop = words::condition(Condition::EmergencyStop);
        let stopped = Ending::Stopped(format!("a fault stopped the flight: {stop}"));
        assert_eq!(end, End { ending: stopped, motors: Motors::SeenOff });
        machine.rig(|rig: &mut AtRest| rig.0.button = false);
        let (end, _) = fly_step(&mut machine, |_| {});
        assert_eq!(end, flown);
    }
    assert_nothing_left(&mut machine);
}

#[test]
#[ignore = "long: another board's image, 15 s of a processor to build"]
fn a_nucleo_f446_flies_the_hosts_bits_and_its_button_is_the_emergency_stop() {
    flies_the_hosts_bits_and_its_button_is_the_emergency_stop(NUCLEO_F446);
}

#[test]
#[ignore = "long: another board's image, 15 s of a processor to build"]
fn a_nucleo_f411_flies_the_hosts_bits_and_its_button_is_the_emergency_stop() {
    flies_the_hosts_bits_and_its_button_is_the_emergency_stop(NUCLEO_F411);
}

#[test]
#[ignore = "long: another board's image, 15 s of a processor to build"]
fn a_black_pill_flies_the_hosts_bits_and_its_key_is_the_emergency_stop() {
    flies_the_hosts_bits_and_its_button_is_the_emergency_stop(BLACK_PILL);
}

#[test]
#[ignore = "long: another board's image, 15 s of a processor to build"]
fn a_feather_flies_the_hosts_bits() {
    flies_the_hosts_bits_and_its_button_is_the_emergency_stop(FEATHER_F405);
}

/// What was made for a board with another PWM is not flown.
#[test]
fn another_board_than_is_expected_is_refused() {
    let parameters = parameters(record::BUILT_IN);
    let mut machine = board(&parameters);
    let plan = Plan { board: NUCLEO_F411, ..plan(&parameters, vec![step(500)], Vec::new()) };
    let (end, ..) = fly(&mut machine, plan);
    let why = "the board is a f405, and a nucleo-f411 is expected: 2100 and 1250 steps of the PWM";
    assert_eq!(end, End { ending: Ending::Trouble(why.to_owned()), motors: Motors::NeverTurned });
}

/// The plant is in the tick: 4,000 instructions are allowed for all of it.
#[test]
fn a_tick_with_its_plant_keeps_its_budget() {
    for preset in ["paper", "heli", record::BUILT_IN, "aero-lab"] {
        let parameters = parameters(preset);
        let mut machine = board(&parameters);
        let (end, _) = fly_twice(&mut machine, plan(&parameters, vec![step(500)], Vec::new()));
        assert_eq!(end.ending, Ending::Flown);
        let mut ticks: Vec<u64> = machine.trace().1.iter().map(|tick| tick.instructions).collect();
        ticks.sort_unstable();
        let (median, longest) = (ticks[ticks.len() / 2], ticks[ticks.len() - 1]);
        println!("{preset}: {median} instructions by the median, {longest} at most");
        assert!(longest < 4_000, "{preset}: {longest}");
    }
}

fn wiring(spoil: fn(&mut Faults)) -> Injection {
    let mut faults = Faults::default();
    spoil(&mut faults);
    Injection::Wiring(faults)
}

/// Everything that can befall the rig, and what the supervisor answers; what it stands is flown to the end.
/// The ticks until then are the host's, to the bit, with the same things befalling its rig.
#[test]
fn whatever_befalls_the_rig_the_supervisor_answers_and_the_host_computes() {
    let stuck = Faults { encoder_stuck: PerAxis::new(true, false), ..Faults::default() };
    let reversed = Faults { encoder_reversed: PerAxis::new(false, true), ..Faults::default() };
    let slip = Faults { slip: PerAxis::new(0, 1_000), ..Faults::default() };
    let push = PerMotor::new(2.0, -2.0);
    let cases = [
        (Injection::Wiring(stuck), Some(Condition::PitchMotion)),
        (Injection::Wiring(reversed), Some(Condition::YawMotion)),
        (Injection::Wiring(slip), Some(Condition::YawJump)),
        (Injection::Supply(9.0), Some(Condition::SupplyJump)),
        (Injection::CurrentLimit(true), Some(Condition::CurrentLimit)),
        (Injection::EmergencyStop(true), Some(Condition::EmergencyStop)),
        (Injection::Stall { ticks: 3 }, Some(Condition::TickOverrun)),
        (wiring(|faults| faults.drift.pitch = 4), Some(Condition::AngleEnvelope)),
        (wiring(|faults| faults.drift.yaw = -8), Some(Condition::RateEnvelope)),
        (wiring(|faults| faults.motor_open.main = true), Some(Condition::PitchMotion)),
        (wiring(|faults| faults.motor_reversed.tail = true), Some(Condition::YawMotion)),
        (Injection::Disturbance(push), None),
        (Injection::Weight { mass: 0.004, arm: 0.1 }, None),
    ];
    let parameters = parameters(record::BUILT_IN);
    // One board for all: each session lays the rig down, sound, and clears what the last has left.
    let mut machine = board(&parameters);
    for (injection, answer) in cases {
        // There and back, so that both axes are to move after it.
        let there = vec![Reference::at_rest(PerAxis::new(0.15, 0.4)); 700];
        let back = vec![Reference::at_rest(PerAxis::new(-0.1, -0.4)); 2_500];
        let leg = Leg::Fly([there, back].concat());
        let (end, same) = fly_twice(&mut machine, plan(&parameters, vec![leg], vec![(600, injection)]));
        let expected = answer.map_or(Ending::Flown, |cause| {
            Ending::Stopped(format!("a fault stopped the flight: {}", words::condition(cause)))
        });
        assert_eq!(end, End { ending: expected, motors: Motors::SeenOff }, "{injection:?}");
        assert!(same > 600, "{injection:?}: {same}");
    }
    assert_nothing_left(&mut machine);
}

/// A rig that was checked on the board's own simulation is not checked for a real one, and a real one has
/// nothing befall it.
#[test]
fn what_was_checked_on_a_simulated_rig_does_not_arm_a_real_one() {
    let mut station = board_with(&presets::AERO2, &parameters(record::BUILT_IN));
    station.run(300);
    assert!(station.heard.conditions().contains(&Condition::NotChecked), "{}", station.heard.summary());
    let nonce = twinrotor::link::Nonce::default();
    station.send(&twinrotor::link::ToBoard::Inject(nonce, Injection::Rest));
    station.run(50);
    assert_eq!(station.heard.refusals, [twinrotor::link::Refusal::NotSimulated]);
    assert_eq!(station.heard.identities.last().map(|who| who.port), Some(RigPort::Pwm));
}
