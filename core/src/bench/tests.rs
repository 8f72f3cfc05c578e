use super::*;
use crate::plant::presets;

const SAMPLE_TIME: f64 = 1e-3;

#[test]
fn encoders_count_from_where_they_were_switched_on() {
    let mut bench = Bench::<f64>::at_rest(&presets::HELI, SAMPLE_TIME);
    let rest = presets::HELI.rest_angle.pitch * 4096.0 / core::f64::consts::TAU;
    assert!((f64::from(bench.position().pitch) - rest).abs() <= 0.5);
    assert_eq!(bench.counters(), PerAxis::both(0));
    let start = bench.position();
    for _ in 0..2_000 {
        bench.advance(PerMotor::new(20.0, 5.0), true);
    }
    assert_ne!(bench.counted(), PerAxis::both(0));
    assert_eq!(bench.counted(), bench.position().zip(start, |now, then| now - then));
}

#[test]
fn a_phase_moves_the_edges_between_counts() {
    let scale = core::f64::consts::TAU / 4096.0;
    let at = |phase: f64, counts: f64| {
        Encoders::<f64>::new(PerAxis::both(4096), PerAxis::both(phase))
            .counts(PerAxis::both(counts * scale))
            .pitch
    };
    assert_eq!(
        [at(0.5, 0.4), at(0.5, 0.6), at(0.9, 0.05), at(0.9, 0.2), at(0.1, -0.05)],
        [0.0, 1.0, 0.0, 1.0, 0.0]
    );
    assert_eq!([at(0.1, -0.2), at(0.1, 0.8)], [-1.0, 0.0]);
}

#[test]
fn a_heavy_nose_rests_on_its_stop_and_a_light_push_does_not_lift_it() {
    let mut bench = Bench::<f64>::at_rest(&presets::HELI, SAMPLE_TIME);
    (0..3_000).for_each(|_| _ = bench.advance(PerMotor::new(2.0, 0.0), true));
    let state = bench.state();
    assert_eq!(state.angle.pitch, presets::HELI.rest_angle.pitch);
    assert_eq!(state.rate.pitch, 0.0);
}

/// A rig whose nose rests level has nothing under it but a table.
#[test]
fn a_table_bears_a_heavy_nose_until_it_is_taken_away() {
    let rig = presets::PAPER;
    assert!(rig.plant.center_of_mass > 0.0 && rig.rest_angle.pitch >= 0.0);
    let mut bench = Bench::<f64>::at_rest(&rig, SAMPLE_TIME);
    bench.set_table(true);
    (0..500).for_each(|_| _ = bench.advance(PerMotor::zero(), false));
    assert_eq!(bench.state().angle.pitch, rig.rest_angle.pitch);
    bench.set_table(false);
    (0..500).for_each(|_| _ = bench.advance(PerMotor::zero(), false));
    assert!(bench.state().angle.pitch < rig.rest_angle.pitch - 0.1);
}

#[test]
fn who_holds_the_rig_lets_go_when_the_amplifiers_are_switched_on() {
    let mut bench = Bench::<f64>::at_rest(&presets::PAPER, SAMPLE_TIME);
    (0..300).for_each(|_| _ = bench.advance(PerMotor::new(20.0, 0.0), true));
    bench.hold();
    let caught = bench.state();
    assert_eq!(caught.rate, PerAxis::zero());
    (0..300).for_each(|_| _ = bench.advance(PerMotor::new(20.0, 0.0), false));
    assert_eq!(bench.state(), caught);
    bench.advance(PerMotor::new(20.0, 0.0), true);
    assert_ne!(bench.state(), caught);
}

#[test]
fn a_duty_acts_one_tick_late_and_only_through_enabled_amplifiers() {
    let mut bench = Bench::<f32>::at_rest(&presets::AERO, SAMPLE_TIME);
    let drive = Drive::new(presets::AERO.board.pwm_steps());
    let asked = PerMotor::new(12.0, -6.0);
    let duty = drive.duty(asked, bench.supply);
    assert_eq!(bench.tick(duty, true), PerMotor::zero());
    assert_eq!(bench.tick(PerMotor::default(), true), drive.volts(duty, bench.supply));
    bench.tick(duty, true);
    assert_eq!(bench.tick(duty, false), PerMotor::zero());
}

#[test]
fn faults_of_motors_change_what_the_motors_get() {
    let volts = PerMotor::new(3.0, 5.0);
    let with = |spoil: fn(&mut Faults)| {
        let mut faults = Faults::default();
        spoil(&mut faults);
        faults.motor_volts(volts)
    };
    assert_eq!(with(|_| {}), volts);
    assert_eq!(with(|f| f.motors_swapped = true), PerMotor::new(5.0, 3.0));
    assert_eq!(with(|f| f.motor_reversed.main = true), PerMotor::new(-3.0, 5.0));
    assert_eq!(with(|f| f.motor_open.tail = true), PerMotor::new(3.0, 0.0));
}

#[test]
fn faults_of_encoders_change_what_is_counted_from_then_on() {
    let with = |spoil: fn(&mut Faults)| {
        let mut faults = Faults::default();
        spoil(&mut faults);
        [faults.counted(PerAxis::new(2, -7)), faults.counted(PerAxis::new(1, 0))]
    };
    assert_eq!(with(|_| {}), [PerAxis::new(2, -7), PerAxis::new(1, 0)]);
    assert_eq!(with(|f| f.encoders_swapped = true), [PerAxis::new(-7, 2), PerAxis::new(0, 1)]);
    assert_eq!(with(|f| f.encoder_reversed.yaw = true), [PerAxis::new(2, 7), PerAxis::new(1, 0)]);
    assert_eq!(with(|f| f.encoder_stuck.pitch = true), [PerAxis::new(0, -7), PerAxis::new(0, 0)]);
    assert_eq!(with(|f| f.slip.pitch = 40), [PerAxis::new(42, -7), PerAxis::new(1, 0)], "a slip comes once");
    assert_eq!(with(|f| f.drift.yaw = 1), [PerAxis::new(2, -6), PerAxis::new(1, 1)]);
}
