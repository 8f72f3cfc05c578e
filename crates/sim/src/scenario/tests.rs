use super::*;

#[test]
fn a_file_gives_its_references() {
    let text = "duration = 3.0\n[pitch.sine]\namplitude_deg = 10.0\nfrequency = 2.0\n\
                [yaw.steps]\njumps = [[1.0, 20.0], [2.0, -5.0]]\n";
    let scenario = Scenario::parse("mine.toml", text).unwrap();
    let references = scenario.references::<f64>();
    assert_eq!(references.len(), 3001);
    assert!((references[500].angle.pitch - 10.0_f64.to_radians() * 1.0_f64.sin()).abs() < 1e-12);
    assert!((references[2500].angle.yaw - (-5.0_f64).to_radians()).abs() < 1e-15);
    let steps = scenario.steps(PerAxis::zero());
    assert_eq!(steps.pitch, None);
    assert_eq!(steps.yaw.unwrap().tick, 2000);
}

#[test]
fn a_bad_file_is_told_in_one_line() {
    let cases = [
        ("duration = -1.0", "duration is -1"),
        ("duration = nan", "duration is NaN"),
        ("duration = 1.0\nlength = 2", "unknown field `length`"),
    ];
    let axes = "\n[pitch.steps]\njumps = [[0.0, 20.0]]\n[yaw.steps]\njumps = [[0.0, 20.0]]\n";
    for (head, expected) in cases {
        let error = Scenario::parse("mine.toml", &format!("{head}{axes}")).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
    let hidden = "duration = 10\n[pitch.steps]\njumps = [[1, 10], [8, 20]]\nperiod = 4\n\
                  [yaw.steps]\njumps = []\n";
    let error = Scenario::parse("mine.toml", hidden).unwrap_err().to_string();
    assert!(error.contains("pitch.period is 4; allowed: 0 for never, or above 8 s"), "{error}");
    let huge = "duration = 10\n[pitch.steps]\njumps = [[1, 1e300]]\n[yaw.steps]\njumps = []\n";
    let error = Scenario::parse("mine.toml", huge).unwrap_err().to_string();
    assert!(error.contains("pitch.jumps: an angle is 1e300; allowed: at most 1e9"), "{error}");
    let back = "duration = 1.0\n[pitch.steps]\njumps = [[2.0, 1.0], [1.0, 2.0]]\n[yaw.steps]\njumps = []\n";
    let error = Scenario::parse("mine.toml", back).unwrap_err().to_string();
    assert!(error.contains("pitch.jumps: a time is 1; allowed: a finite number of at least 2"), "{error}");
}

#[test]
fn a_disturbance_stays_in_its_window_and_within_its_volts() {
    let mut scenario = Scenario::named("3").unwrap();
    scenario.disturbance = Some(Disturbance { volts: 1.5, hold: 0.25, window: [2.0, 4.0] });
    let d = scenario.disturbances::<f64>(7);
    assert!(d[..2000].iter().chain(&d[4000..]).all(|v| *v == PerMotor::zero()));
    assert!(d[2000..4000].iter().all(|v| v.main.abs() <= 1.5 && v.main != 0.0 && v.tail != v.main));
    let changes = d[2000..4000].windows(2).filter(|w| w[0] != w[1]).count();
    assert_eq!(changes, 7);
    assert_eq!(d, scenario.disturbances::<f64>(7));
    assert_ne!(d, scenario.disturbances::<f64>(8));
}

/// A hover with more to it.
fn with(more: &str) -> Outcome<Scenario> {
    let axes = "duration = 10\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = []\n";
    Scenario::parse("mine.toml", &format!("{axes}{more}"))
}

#[test]
fn every_number_of_an_event_has_a_range_that_is_told() {
    let cases = [
        (
            "[[events.step]]\nvolts = [61, 0]\nwindow = [0, 1]",
            "events.step[0].volts[0] is 61; allowed: -60 to 60 V",
        ),
        ("[[events.step]]\nwindow = [0, 1]", "events.step[0] is without a push; allowed: volts or torque"),
        (
            "[[events.gust]]\ntorque = [0, 11]\nwindow = [0, 1]",
            "events.gust[0].torque[1] is 11; allowed: -10 to 10 N m",
        ),
        (
            "[[events.ramp]]\nvolts = [1, 0]\nwindow = [2, 2]",
            "events.ramp[0].window[1] is 2; allowed: above 2 s, where the window begins, to 3600 s",
        ),
        (
            "[[events.sine]]\nvolts = [1, 0]\nfrequency = 1e4\nwindow = [0, 1]",
            "events.sine[0].frequency is 10000; allowed: 0 to 1000 rad/s",
        ),
        ("[[events.sine]]\nvolts = [1, 0]\nwindow = [0, 1]", "missing field `frequency`"),
        (
            "[[events.weight]]\nmass = 20\narm = 0.1\nwindow = [0, 1]",
            "events.weight[0].mass is 20; allowed: 0 to 5 kg",
        ),
        (
            "[[events.weight]]\nmass = 0.02\narm = 17\nwindow = [0, 1]",
            "events.weight[0].arm is 17; allowed: -1 to 1 m",
        ),
        (
            "[[events.thrust]]\nleft = [50, 1]\nwindow = [0, 1]",
            "events.thrust[0].left[0] is 50; allowed: 0 to 2 of the thrust",
        ),
        (
            "[[events.supply]]\nvolts = 0\nwindow = [0, 1]",
            "events.supply[0].volts is 0; allowed: 0.1 to 75 V",
        ),
        (
            "[[events.supply]]\nvolts = 9\nfall = 2\nwindow = [0, 1]",
            "events.supply[0].fall is 2; allowed: 0 to 0.5 s",
        ),
        ("[[events.storm]]\nvolts = [1, 0]\nwindow = [0, 1]", "unknown field `storm`"),
        ("[start]\nangle_deg = [91, 0]", "start.angle_deg[0] is 91; allowed: -90 to 90 degrees"),
        ("[start]\nrate_deg = [0, nan]", "start.rate_deg[1] is NaN; allowed: -500 to 500"),
        ("[start]\nhot = true\nrotor_volts = [5, 0]", "start.hot is true; allowed: false beside"),
        ("[hardware]\ndelay = 0.5", "hardware.delay is 0.5; allowed: 0 to 0.031 s"),
        (
            "[hardware]\nnoise_counts = [2000, 0]",
            "hardware.noise_counts[0] is 2000; allowed: 0 to 1000 counts",
        ),
        ("[hardware]\nbacklash_deg = [-1, 0]", "hardware.backlash_deg[0] is -1; allowed: 0 to 10 degrees"),
        (
            "[hardware]\ndelay = 0.03\njitter = 0.002",
            "hardware.jitter is 0.002; allowed: 0 to 0.001 s, with hardware.delay to .031",
        ),
        ("[hardware]\ncable_stiffness = -1", "hardware.cable_stiffness is -1; allowed: 0 to 10 N m/rad"),
        ("[hardware]\ndead_zone = [0, 12]", "hardware.dead_zone[1] is 12; allowed: 0 to 10 V"),
    ];
    for (text, expected) in cases {
        let told = with(text).unwrap_err().to_string();
        assert!(told.starts_with("mine.toml") && told.contains(expected) && !told.contains('\n'), "{told}");
    }
}

#[test]
fn pushes_have_their_shapes_and_add_up() {
    let scenario = with(
        "[[events.step]]\nvolts = [2, 0]\nwindow = [1, 2]\n[[events.step]]\nvolts = [1, 0]\n\
         window = [1.5, 2]\n\
         [[events.ramp]]\ntorque = [0.4, 0]\nwindow = [2, 4]\n[[events.gust]]\nvolts = [0, 4]\n\
         window = [3, 5]\n\
         [[events.sine]]\ntorque = [0, 0.2]\nfrequency = 3.141592653589793\nwindow = [4, 8]\n",
    )
    .unwrap();
    let all: Vec<Now> = scenario.befalls(1).take(10_000).collect();
    let main = |tick: usize| all[tick].volts.main;
    assert_eq!(
        [main(999), main(1_000), main(1_499), main(1_500), main(1_999), main(2_000)],
        [0.0, 2.0, 2.0, 3.0, 3.0, 0.0]
    );
    let pitch = |tick: usize| all[tick].torque.pitch;
    assert_eq!(
        [pitch(2_000), pitch(3_000), pitch(4_000), pitch(9_999)],
        [0.0, 0.2, 0.4, 0.4],
        "a ramp stays"
    );
    let tail = |tick: usize| all[tick].volts.tail;
    assert!((tail(4_000) - 4.0).abs() < 1e-12 && (tail(3_500) - 2.0).abs() < 1e-12 && tail(5_000) == 0.0);
    // Half of what a step of its height and length would be.
    let area: f64 = all.iter().map(|now| now.volts.tail * SAMPLE_TIME).sum();
    assert!((area - 4.0).abs() < 1e-9, "{area}");
    let yaw = |tick: usize| all[tick].torque.yaw;
    assert!((yaw(4_500) - 0.2).abs() < 1e-12 && (yaw(5_500) + 0.2).abs() < 1e-12 && yaw(8_000) == 0.0);
    assert!(scenario.is_more_than_volts() && !Scenario::named("3").unwrap().is_more_than_volts());
}

#[test]
fn a_plant_changes_when_a_weight_comes_and_when_it_goes() {
    let scenario = with(
        "[[events.weight]]\nmass = 0.02\narm = 0.15\nwindow = [1, 3]\n[[events.thrust]]\nleft = [0.5, 1]\n\
         window = [2, 3]\n[[events.supply]]\nvolts = 10\nfall = 0.5\nwindow = [4, 6]\n",
    )
    .unwrap();
    let all: Vec<Now> = scenario.befalls(1).take(7_000).collect();
    let changes: Vec<usize> = (0..all.len()).filter(|tick| all[*tick].change.is_some()).collect();
    assert_eq!(changes, [1_000, 2_000, 3_000]);
    let plant = twinrotor::plant::presets::AERO2.plant;
    let at = |tick: usize| all[tick].change.as_ref().unwrap().of(&plant);
    assert_eq!(at(1_000), plant.with_weight(0.02, 0.15));
    assert_eq!(at(2_000), plant.with_weight(0.02, 0.15).with_thrust(PerMotor::new(0.5, 1.0)));
    assert_eq!(at(3_000), plant);
    let supply = |tick: usize| all[tick].supply(18.0_f64);
    assert_eq!(
        [supply(3_999), supply(4_000), supply(4_250), supply(5_000), supply(6_000)],
        [18.0, 18.0, 14.0, 10.0, 18.0]
    );
}

/// Volts are late by every whole number of ticks up to the most, each as often, and what else is random stays
/// what it was.
#[test]
fn jitter_is_uniform_and_draws_from_nothing_else() {
    let noise = "noise_counts = [3, 3]\n";
    let steady = with(&format!("[hardware]\n{noise}")).unwrap();
    let late = with(&format!("[hardware]\n{noise}delay = 0.002\njitter = 0.003\n")).unwrap();
    let mut often = [0_u32; 4];
    for (now, then) in late.befalls(7).zip(steady.befalls(7)).take(40_000) {
        often[now.jitter as usize] += 1;
        assert_eq!((now.noise, then.jitter), (then.noise, 0));
    }
    assert!(often.iter().all(|&count| count.abs_diff(10_000) < 400), "{often:?}");
    let alone = with("[hardware]\njitter = 0.003\n").unwrap();
    assert!(alone.is_more_than_volts(), "every tick is told it");
}
