use super::*;
use crate::scenario::Scenario;
use twinrotor::defaults;
use twinrotor::plant::presets::{AERO2, PAPER};

/// A hover for `seconds` with more to it.
fn hover(seconds: u32, more: &str) -> Scenario {
    let text = format!(
        "duration = {seconds}.0\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.5, 40.0]]\n{more}"
    );
    Scenario::parse("hover.toml", &text).unwrap()
}

fn plan<'a>(settings: &'a Settings<f64>, scenario: &'a Scenario, truth: &'a Rig) -> Plan<'a> {
    let initial = scenario.start.angle();
    Plan { rig: &AERO2, truth, settings, scenario, initial, fidelity: Fidelity::Rig, seed: 5 }
}

fn settings() -> Settings<f64> {
    Settings::new(&AERO2, defaults::AERO2, SAMPLE_TIME)
}

fn last(flight: &Flight) -> State<f64> {
    flight.rows.last().unwrap().state
}

/// All that can befall a rig at once, mildly.
const MISERY: &str = "[hardware]\nnoise_counts = [1, 1]\nbacklash_deg = [0.3, 0.2]\ndead_zone = [0.2, 0.1]\n\
                      delay = 0.004\njitter = 0.003\ncable_stiffness = 0.001\ncable_free_deg = 20\n[start]\nangle_deg = [2, -3]\nrate_deg = [5, -8]\nrotor_volts = [3, 1]\n\
                      [[events.gust]]\nvolts = [1.5, -1]\nwindow = [1, 3]\n[[events.sine]]\n\
                      torque = [0.001, 0.0005]\nfrequency = 4\nwindow = [2, 5]\n[[events.weight]]\n\
                      mass = 0.001\narm = 0.15\nwindow = [3, 6]\n[[events.thrust]]\nleft = [0.95, 0.9]\n\
                      window = [4, 7]\n[[events.supply]]\nvolts = 12\nfall = 0.5\nwindow = [1, 8]\n";

/// Whatever befalls it: lanes fly, to the bit, what the board flies.
#[test]
fn in_all_circumstances_the_loop_of_the_lanes_is_the_boards() {
    let (settings, scenario) = (settings(), hover(8, MISERY));
    let plan = plan(&settings, &scenario, &AERO2);
    let board = record(&plan, board_loop(&plan)).unwrap();
    assert_eq!(board.board, Some(BoardState::ARMED), "{:?}", board.board);
    let lanes = record(&plan, rig_loop::<f32>(&plan)).unwrap();
    let differ = board.rows.iter().zip(&lanes.rows).position(|(a, b)| a != b);
    assert_eq!(differ.map(|tick| (board.rows[tick], lanes.rows[tick])), None);
}

#[test]
fn every_circumstance_changes_the_flight_from_its_time_on() {
    let settings = settings();
    let calm = hover(4, "");
    let undisturbed = fly(&plan(&settings, &calm, &AERO2), Scalar::F32).unwrap();
    for more in [
        "[[events.step]]\nvolts = [0, 1]\nwindow = [2, 3]\n",
        "[[events.ramp]]\ntorque = [0.01, 0]\nwindow = [2, 3]\n",
        "[[events.gust]]\ntorque = [0.01, 0]\nwindow = [2, 3]\n",
        "[[events.sine]]\nvolts = [1, 0]\nfrequency = 3\nwindow = [2, 3]\n",
        "[[events.weight]]\nmass = 0.02\narm = 0.1\nwindow = [2, 3]\n",
        "[[events.thrust]]\nleft = [0.5, 1]\nwindow = [2, 3]\n",
    ] {
        let scenario = hover(4, more);
        let flown = fly(&plan(&settings, &scenario, &AERO2), Scalar::F32).unwrap();
        let differ = |a: &Row, b: &Row| a.state != b.state;
        let first = flown.rows.iter().zip(&undisturbed.rows).position(|(a, b)| differ(a, b)).unwrap();
        // A gust and a swing begin with nothing, and f32 sees the least of them later.
        assert!((2_001..2_030).contains(&first), "{more}: {first}");
    }
}

/// N m on an axis move it until the controller's own torque balances them: the volts say how much that was.
#[test]
fn a_torque_is_balanced_by_volts() {
    let settings = settings();
    let held = |more: &str| {
        let scenario = hover(20, more);
        let flown = fly(&plan(&settings, &scenario, &AERO2), Scalar::F32).unwrap();
        let rows = &flown.rows[18_000..];
        let mean = |of: fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
        PerMotor::new(mean(|row| row.volts.main), mean(|row| row.volts.tail))
    };
    let pushed = held("[[events.step]]\ntorque = [0.003, -0.002]\nwindow = [3, 30]\n");
    let change = pushed.minus(held(""));
    // At level the spring of AERO2 is at rest, so all of it is the rotors'.
    let given = AERO2.plant.effectiveness.torque(change);
    assert!((given.pitch + 0.003).abs() < 3e-4 && (given.yaw - 0.002).abs() < 3e-4, "{given:?}");
    // A cable that is taut from 10° on pulls 40° back with 30° of its stiffness.
    let wound = held("[hardware]\ncable_stiffness = 0.004\ncable_free_deg = 10\n").minus(held(""));
    let given = AERO2.plant.effectiveness.torque(wound);
    let pulled = 0.004 * 30.0_f64.to_radians();
    assert!(given.pitch.abs() < 3e-4 && (given.yaw - pulled).abs() < 3e-4, "{given:?}");
}

/// A board that reckons with half the encoder's counts takes every angle for twice what it is.
#[test]
fn a_board_that_believes_in_other_encoders_flies_to_other_angles() {
    let (settings, scenario) = (settings(), hover(15, ""));
    let truth = Rig { encoder_counts: AERO2.encoder_counts.map(|counts| 2 * counts), ..AERO2 };
    let flown = fly(&plan(&settings, &scenario, &truth), Scalar::F32).unwrap();
    assert!((last(&flown).angle.yaw.to_degrees() - 20.0).abs() < 0.2);
    let known = fly(&plan(&settings, &scenario, &AERO2), Scalar::F32).unwrap();
    assert!((last(&known).angle.yaw.to_degrees() - 40.0).abs() < 0.2);
}

#[test]
fn amplifiers_give_no_more_than_the_true_limit() {
    let (settings, scenario) = (settings(), hover(6, ""));
    let peak =
        |truth: &Rig| fly(&plan(&settings, &scenario, truth), Scalar::F32).unwrap().report.tail.peak_volts;
    let weak = Rig { volts_limit: PerMotor::new(18.0, 3.0), ..AERO2 };
    assert!(peak(&AERO2) > 3.0 && peak(&weak) == 3.0);
}

#[test]
fn warm_motors_fly_slower() {
    let settings = settings();
    let hot = hover(14, "[start]\nhot = true\n");
    let hot = fly(&plan(&settings, &hot, &AERO2), Scalar::F32).unwrap();
    let cold = fly(&plan(&settings, &hover(14, ""), &AERO2), Scalar::F32).unwrap();
    let settled = |flight: &Flight| flight.report.yaw.settling_time_2.unwrap();
    assert!(settled(&hot) > 1.1 * settled(&cold), "{} {}", settled(&hot), settled(&cold));
    assert_eq!(hot.rows.len(), cold.rows.len());
}

#[test]
fn a_flight_says_how_far_it_went_and_how_much_it_chattered() {
    let (settings, scenario) = (settings(), hover(4, ""));
    let flown = fly(&plan(&settings, &scenario, &AERO2), Scalar::F32).unwrap();
    let turned: f64 = flown.rows.windows(2).map(|w| (w[1].volts.tail - w[0].volts.tail).abs()).sum();
    assert!((flown.report.tail.voltage_variation - turned / 4.0).abs() < 1e-4 * turned);
    let extent = flown.extent(&AERO2.envelope);
    assert!(extent.text(flown.left_envelope).starts_with("envelope: kept; pitch up to "));
    assert!(extent.rate_deg.yaw > 20.0 && extent.rate_deg.yaw < extent.allowed_rate_deg.yaw);
    let gains = crate::gains_file::GainsFile::paper();
    let ideal = Plan {
        rig: &PAPER,
        truth: &PAPER,
        settings: &gains.settings(&PAPER),
        ..plan(&settings, &scenario, &PAPER)
    };
    let ideal = Plan { fidelity: Fidelity::Ideal, ..ideal };
    assert_eq!(fly(&ideal, Scalar::F32).unwrap().board, None, "no board flies the paper's world");
}
