//! The first-power check, in the loop.

use super::flight::*;
use super::*;

/// Ends the check and gives its verdict.
fn check(flight: &mut Flight) -> Verdict {
    flight.run(20, None);
    let mut command = Some(OperatorCommand::Request(Request::Check));
    for _ in 0..3 * SETTLE_TICKS {
        if let Some(verdict) = flight.tick(command.take()).verdict {
            flight.tick(None);
            assert_eq!(flight.control.state(), ArmState::Disarmed);
            return verdict;
        }
    }
    panic!("the check does not end");
}

#[test]
fn the_first_power_check_passes_every_rig_and_then_only_the_zero_is_missing() {
    for (name, rig) in presets::ALL {
        let mut flight = Flight::new(&rig, false);
        assert_eq!(check(&mut flight), Verdict::Passed, "{name}");
        let left: Vec<Condition> = flight.frame(None).conditions.iter().collect();
        assert_eq!(left, [Condition::NotZeroed], "{name}");
    }
}

#[test]
fn the_first_power_check_names_what_is_connected_wrongly() {
    let cases: [(Fault, Spoil); 7] = [
        (Fault::MotorsSwapped, |faults| faults.motors_swapped = true),
        (Fault::MainReversed, |faults| faults.motor_reversed.main = true),
        (Fault::TailReversed, |faults| faults.motor_reversed.tail = true),
        (Fault::BothReversed, |faults| faults.motor_reversed = PerMotor::both(true)),
        (Fault::PitchReversed, |faults| faults.encoder_reversed.pitch = true),
        (Fault::YawReversed, |faults| faults.encoder_reversed.yaw = true),
        (Fault::EncodersSwapped, |faults| faults.encoders_swapped = true),
    ];
    for (name, rig) in presets::ALL {
        for (fault, spoil) in cases {
            let mut flight = Flight::new(&rig, false);
            spoil(&mut flight.bench.faults);
            assert_eq!(check(&mut flight), Verdict::Wrong(fault), "{name}");
            assert!(flight.frame(None).conditions.contains(Condition::NotChecked));
        }
    }
}

/// Also where the other encoder alone shows the right directions.
#[test]
fn the_first_power_check_misses_an_encoder_that_is_not_connected() {
    for (name, rig) in presets::ALL {
        for stuck in [PerAxis::new(true, false), PerAxis::new(false, true)] {
            let mut flight = Flight::new(&rig, false);
            flight.bench.faults.encoder_stuck = stuck;
            let verdict = check(&mut flight);
            assert_ne!(verdict, Verdict::Passed, "{name} {stuck:?}");
        }
    }
}

#[test]
fn the_first_power_check_misses_a_motor_that_is_not_connected() {
    let mut flight = Flight::new(&presets::AERO, false);
    flight.bench.faults.motor_open.tail = true;
    assert_eq!(check(&mut flight), Verdict::NoMotion { motor: crate::first_power::Motor::Tail });
}
