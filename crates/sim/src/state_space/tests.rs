//! Files of matrices: those that are read, those that are refused, and what flies.

use super::*;
use crate::closed_loop::{BoardLoop, ClosedLoop, Hardware, RigLoop};
use crate::lanes::{Kernel, LANES, gather, in_lanes};
use twinrotor::axes::PerAxis;
use twinrotor::defaults;
use twinrotor::law::{MotorGains, StateFeedbackGains};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::AERO2;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;

/// Two states, three inputs, both outputs in the other order.
const GOOD: &str = "controller = \"state-space\"

[state-space]
inputs = [\"angle_error.pitch\", \"angle_error.yaw\", \"rate.pitch\"]
outputs = [\"volts.tail\", \"volts.main\"]
sample_time = 0.001
A = [[1, 0], [0.5, 0.25]]
B = [[1, 2, 3], [4, 5, 6]]
C = [[7, 8], [9, 10]]
D = [[11, 12, 13], [14, 15, 16]]
saturation = [17, 18]
feed_forward = false
anti_windup = [[19, 20], [21, 22]]
";

fn parsed(text: &str) -> StateSpaceGains<f64> {
    match GainsFile::parse("x", text).unwrap().controller.law {
        LawSettings::StateSpace(gains) => gains,
        law => panic!("{law:?}"),
    }
}

#[test]
fn a_file_is_what_it_says_and_survives_being_written() {
    let gains = parsed(GOOD);
    let mut expected = StateSpaceGains::none();
    (expected.states, expected.inputs) = (2, 3);
    expected.signals[..3].copy_from_slice(&[
        Signal::AngleErrorPitch,
        Signal::AngleErrorYaw,
        Signal::RatePitch,
    ]);
    expected.a[0][0] = 1.0;
    (expected.a[1][0], expected.a[1][1]) = (0.5, 0.25);
    expected.b[0] = [1.0, 2.0, 3.0, 0.0];
    expected.b[1] = [4.0, 5.0, 6.0, 0.0];
    (expected.c.tail[0], expected.c.tail[1]) = (7.0, 8.0);
    (expected.c.main[0], expected.c.main[1]) = (9.0, 10.0);
    expected.d = PerMotor::new([14.0, 15.0, 16.0, 0.0], [11.0, 12.0, 13.0, 0.0]);
    expected.saturation = PerMotor::new(18.0, 17.0);
    expected.feed_forward = false;
    expected.corrected = true;
    expected.anti_windup[0] = PerMotor::new(20.0, 19.0);
    expected.anti_windup[1] = PerMotor::new(22.0, 21.0);
    assert_eq!(gains, expected);
    let file = GainsFile::parse("x", GOOD).unwrap();
    let again = GainsFile::parse("x", &file.to_toml()).unwrap();
    assert_eq!(again, file);
    assert_eq!(again.to_toml(), file.to_toml());
}

#[test]
fn what_may_be_left_out_has_its_meaning() {
    let text: String = GOOD.lines().take(10).map(|line| format!("{line}\n")).collect();
    let gains =
        parsed(&text.replace("\"volts.tail\", ", "").replace("[7, 8], ", "").replace("[11, 12, 13], ", ""));
    assert!(gains.feed_forward && !gains.corrected);
    assert_eq!(gains.saturation, PerMotor::both(LARGEST));
    assert_eq!((gains.c.tail, gains.d.tail), ([0.0; 8], [0.0; 4]), "a motor that no output is");
    let none = parsed(
        "controller = \"state-space\"\n[state-space]\ninputs = [\"rate.yaw\"]\noutputs = [\"volts.tail\"]
         sample_time = 0.001\nA = []\nB = []\nC = [[]]\nD = [[-3]]\nanti_windup = \"hold\"",
    );
    assert_eq!((none.states, none.d.tail[0]), (0, -3.0));
}

#[test]
fn every_malformed_file_is_refused_in_one_sentence() {
    let nine = |row: &str| format!("[{}]", [row; 9].join(", "));
    let cases = [
        (
            GOOD.replace("[[1, 0], [0.5, 0.25]]", &nine("[1]")),
            "state-space.A is a matrix of 9 rows; allowed: at most 8",
        ),
        (
            GOOD.replace("[0.5, 0.25]]", "[0.5]]"),
            "state-space.A[1] is a list of 1; allowed: 2 numbers, one for each state",
        ),
        (
            GOOD.replace("0.25", "nan"),
            "state-space.A[1][1] is NaN; allowed: a finite number of at most 1e9 in size",
        ),
        (GOOD.replace("0.25", "-inf"), "state-space.A[1][1] is -inf"),
        (
            GOOD.replace("[4, 5, 6]", "[4, 5, 6e9]"),
            "state-space.B[1][2] is 6000000000; allowed: a finite number",
        ),
        (
            GOOD.replace("[4, 5, 6]", "[4, 5]"),
            "state-space.B[1] is a list of 2; allowed: 3 numbers, one for each input",
        ),
        (
            GOOD.replace(", [4, 5, 6]", ""),
            "state-space.B is a matrix of 1 rows; allowed: 2 rows, one for each state",
        ),
        (
            GOOD.replace(", [9, 10]", ""),
            "state-space.C is a matrix of 1 rows; allowed: 2 rows, one for each output",
        ),
        (
            GOOD.replace("[9, 10]", "[9]"),
            "state-space.C[1] is a list of 1; allowed: 2 numbers, one for each state",
        ),
        (GOOD.replace("[14, 15, 16]", "[14]"), "state-space.D[1] is a list of 1; allowed: 3 numbers"),
        (
            GOOD.replace("rate.pitch", "speed"),
            "state-space.inputs[2] is \"speed\"; allowed: angle_error.pitch, angle_er",
        ),
        (
            GOOD.replace("rate.pitch", "angle_error.yaw"),
            "inputs[2] is \"angle_error.yaw\" again; allowed: each signal once",
        ),
        (
            GOOD.replace("\"rate.pitch\"]", "\"rate.pitch\", \"rate.yaw\", \"angle.yaw\"]"),
            "inputs is a list of 5; allowed: 1 to 4",
        ),
        (
            GOOD.replace("volts.main", "volts.tail"),
            "outputs[1] is \"volts.tail\"; allowed: \"volts.main\" and \"volts.tail\"",
        ),
        (GOOD.replace("volts.main", "torque"), "state-space.outputs[1] is \"torque\""),
        (GOOD.replace("[\"volts.tail\", \"volts.main\"]", "[]"), "state-space.outputs is an empty list"),
        (GOOD.replace("0.001", "0.002"), "state-space.sample_time is 0.002; allowed: 0.001 s"),
        (GOOD.replace("0.001", "0"), "such as by c2d(sys, 0.001)"),
        (
            GOOD.replace("[17, 18]", "[17, 0]"),
            "state-space.saturation is 0; allowed: a finite number above 0, in V",
        ),
        (
            GOOD.replace("[17, 18]", "[17]"),
            "state-space.saturation is a list of 1; allowed: 2 numbers, one for each output",
        ),
        (
            GOOD.replace("[[19, 20], [21, 22]]", "\"clamp\""),
            "anti_windup is \"clamp\"; allowed: \"hold\", or a matrix",
        ),
        (GOOD.replace("[21, 22]]", "[21]]"), "state-space.anti_windup[1] is a list of 1; allowed: 2 numbers"),
        (GOOD.replace("[[19, 20], [21, 22]]", "3"), "\"hold\", or a matrix with a row for each state"),
        (GOOD.replace("A = [[1, 0], [0.5, 0.25]]\n", ""), "missing field `A`"),
        (GOOD.replace("sample_time = 0.001\n", ""), "missing field `sample_time`"),
        (GOOD.replace("feed_forward", "E"), "unknown field `E`"),
        (GOOD.replace("[state-space]", "[pitch]"), "missing field `state-space`"),
        (format!("{GOOD}[pitch]\nposition = 1.0\n"), "unknown field `pitch`"),
    ];
    for (text, expected) in cases {
        assert_ne!(text, GOOD, "{expected}");
        let told = GainsFile::parse("my.toml", &text).unwrap_err().to_string();
        assert!(told.contains(expected), "{told}\nfor {expected}");
        assert!(!told.contains('\n') && told.starts_with("my.toml"), "{told}");
    }
}

/// State feedback with integrals: what a gains file of that law has, and the same as matrices.
fn twins() -> [GainsFile; 2] {
    let rows = |main: [f64; 2], tail: [f64; 2]| -> MotorGains<f64> {
        PerMotor { main: PerAxis::new(main[0], main[1]), tail: PerAxis::new(tail[0], tail[1]) }
    };
    let gains = StateFeedbackGains {
        angle: rows([80.0, -20.0], [40.0, 45.0]),
        rate: rows([55.0, -10.0], [25.0, 35.0]),
        integral: rows([12.0, -3.0], [5.0, 7.0]),
        integral_limit: 1e6,
        feed_forward: true,
    };
    let text = "controller = \"state-space\"
[state-space]
inputs = [\"angle_error.pitch\", \"angle_error.yaw\", \"rate_error.pitch\", \"rate_error.yaw\"]
outputs = [\"volts.main\", \"volts.tail\"]
sample_time = 0.001
A = [[1, 0], [0, 1]]
B = [[0.012, -0.003, 0, 0], [0.005, 0.007, 0, 0]]
C = [[1, 0], [0, 1]]
D = [[80, -20, 55, -10], [40, 45, 25, 35]]";
    let matrices = GainsFile::parse("x", text).unwrap();
    let mut feedback = matrices.clone();
    feedback.controller.law = LawSettings::StateFeedback(gains);
    [feedback, matrices]
}

fn settings(file: &GainsFile) -> Settings<f32> {
    file.settings(&AERO2).map(f32::from_f64)
}

fn plant<R: Real>() -> RealPlant<R> {
    RealPlant::new(&AERO2.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME)
}

fn hardware() -> Hardware {
    Hardware::of(&AERO2, PerAxis::new(0.3, 0.8))
}

/// A known law and its matrices fly the same flight, but for rounding: a step that saturates neither motor.
#[test]
fn a_known_law_and_its_matrices_fly_alike() {
    let [mut one, mut other] =
        twins().map(|file| RigLoop::<f64>::new(plant(), &hardware(), &file.settings(&AERO2)));
    let goal = Reference::at_rest(PerAxis::new(0.03, -0.04));
    let mut moved = 0.0_f64;
    for tick in 0..6_000 {
        let [a, b] = [&mut one, &mut other].map(|flown| flown.tick(&goal, PerMotor::new(0.5, -0.3)));
        let apart = a.state.angle.minus(b.state.angle).map(f64::abs);
        assert!(apart.pitch < 1e-9 && apart.yaw < 1e-9, "tick {tick}: {apart:?}");
        moved = moved.max(a.state.angle.yaw.abs());
    }
    assert!(moved > 0.03, "it flew: {moved}");
}

/// Eight states that take part, so that nothing of a matrix is left out.
fn wide() -> GainsFile {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../gains/choices/aero2-state-space.toml"
    ));
    GainsFile::parse("aero2-state-space.toml", &text.unwrap()).unwrap()
}

struct Together<'a>(&'a Settings<f32>);

impl Kernel for Together<'_> {
    type Output = Vec<[u32; 4]>;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> Self::Output {
        let settings = gather::<R>(&[*self.0; LANES]);
        let mut flown = RigLoop::<R>::new(plant(), &hardware(), &settings);
        let goal = Reference::at_rest(PerAxis::<f32>::new(0.26, -0.7));
        let tick = |_| {
            let now = flown.tick(&Reference::splat(&goal), PerMotor::zero());
            let decision = now.decision.allocation;
            [now.state.angle.pitch, now.state.angle.yaw, decision.demand.main, decision.volts.tail]
                .map(|x| x.lane(LANES - 1).to_bits())
        };
        (0..3_000).map(tick).collect()
    }
}

/// A step that saturates, in the lanes and on the board's own loop: the same bits.
#[test]
fn lanes_and_the_boards_loop_fly_the_same_bits() {
    for file in [wide(), twins()[1].clone()] {
        let settings = settings(&file);
        let lanes = in_lanes(Together(&settings));
        let mut board = BoardLoop::new(plant(), &hardware(), &settings);
        let goal = Reference::at_rest(PerAxis::<f32>::new(0.26, -0.7));
        let mut clipped = 0;
        for (tick, lane) in lanes.iter().enumerate() {
            let now = board.tick(&goal, PerMotor::zero());
            let decision = now.decision.allocation;
            let angle = now.state.angle;
            let alone = [angle.pitch, angle.yaw, decision.demand.main, decision.volts.tail].map(f32::to_bits);
            assert_eq!(*lane, alone, "tick {tick}");
            clipped += u32::from(decision.clipped());
        }
        assert!(clipped > 10 && board.is_armed(), "{clipped} ticks at the limit");
    }
}

/// A large step with an integral: held while the volts clip, it overshoots less than one that winds up.
#[test]
fn holding_the_state_lessens_what_winds_up() {
    let [_, held] = twins();
    let LawSettings::StateSpace(mut gains) = held.controller.law else { panic!("matrices") };
    gains.corrected = true;
    let mut wound = held.clone();
    wound.controller.law = LawSettings::StateSpace(gains);
    let overshoot = |file: &GainsFile| {
        let mut flown = RigLoop::<f64>::new(plant(), &hardware(), &file.settings(&AERO2));
        let goal = Reference::at_rest(PerAxis::new(0.0, 2.5));
        let far = (0..12_000).map(|_| flown.tick(&goal, PerMotor::zero()).state.angle.yaw);
        far.fold(0.0_f64, f64::max) - 2.5
    };
    let (held, wound) = (overshoot(&held), overshoot(&wound));
    assert!(wound > 1.2 * held && wound > 0.05, "held {held} rad, wound up {wound} rad");
}

#[test]
fn an_unstable_loop_is_refused_with_its_pole() {
    let [feedback, good] = twins();
    assert_eq!(good.require_stable("aero2", &AERO2), Ok(()));
    assert_eq!(wide().require_stable("aero2", &AERO2), Ok(()));
    let LawSettings::StateSpace(gains) = good.controller.law else { panic!("matrices") };
    let told = |change: fn(&mut StateSpaceGains<f64>)| {
        let mut gains = gains;
        change(&mut gains);
        let mut file = good.clone();
        file.controller.law = LawSettings::StateSpace(gains);
        file.require_stable("aero2", &AERO2).unwrap_err().to_string()
    };
    // The wrong sign; too much gain for the rotors' lag, also behind a saturation that would hide it; a state
    // that grows and that no output shows.
    let all = [
        told(|g| g.d = g.d.map(|row| row.map(|x| -x))),
        told(|g| g.d = g.d.map(|row| row.map(|x| 40.0 * x))),
        told(|g| {
            g.d = g.d.map(|row| row.map(|x| 40.0 * x));
            g.saturation = PerMotor::both(1e-3);
        }),
        told(|g| {
            g.states = 3;
            (g.a[2][2], g.b[2][0]) = (1.001, 1.0);
        }),
    ];
    for told in all {
        assert!(
            told.contains("of this state-space law on aero2 is unstable: a small error grows at"),
            "{told}"
        );
        assert!(told.ends_with("(margins tells its slowest pole)") && !told.contains('\n'), "{told}");
        let grows = told.split("grows at ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
        assert!(grows.parse::<f64>().unwrap() > 0.0, "{told}");
    }
    // What no file of matrices holds is nobody's business here.
    let mut wild = feedback;
    wild.controller = defaults::AERO2;
    assert_eq!(wild.require_stable("heli", &twinrotor::plant::presets::HELI), Ok(()));
}
