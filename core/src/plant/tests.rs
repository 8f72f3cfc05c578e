use super::*;
use crate::DEGREE;
use presets::Rig;
use proptest::prelude::*;

/// The paper's helicopter with a centre of mass so far out that the m L² terms matter, and no friction.
fn free(rig: &Rig, length: f64) -> PlantParameters<f64> {
    PlantParameters { center_of_mass: length, damping: PerAxis::zero(), ..rig.plant.ideal(0.0) }
}

/// T + U of the Lagrangian that eqs (1)-(2) follow from:
/// ½(I_pp + mL²)θ̇² + ½(I_yy + mL² cos²θ)ψ̇² + m g L sin θ - K_sp cos θ.
fn energy(p: &PlantParameters<f64>, s: &State<f64>) -> f64 {
    let coupling = p.mass * p.center_of_mass * p.center_of_mass;
    let (sine, cosine) = s.angle.pitch.sin_cos();
    0.5 * (p.inertia.pitch + coupling) * s.rate.pitch.powi(2)
        + 0.5 * (p.inertia.yaw + coupling * cosine * cosine) * s.rate.yaw.powi(2)
        + p.mass * p.gravity * p.center_of_mass * sine
        - p.stiffness * cosine
}

fn yaw_momentum(p: &PlantParameters<f64>, s: &State<f64>) -> f64 {
    let lever = p.center_of_mass * s.angle.pitch.cos();
    (p.inertia.yaw + p.mass * lever * lever) * s.rate.yaw
}

/// Both Coriolis terms and both gravity terms have the right sign and size: without friction and thrust,
/// energy and the momentum about the vertical axis stay.
#[test]
fn a_free_body_keeps_its_energy_and_its_momentum() {
    for (_, rig) in presets::ALL {
        let p = free(&rig, 0.2);
        let start = State { angle: PerAxis::new(0.4, 0.1), rate: PerAxis::new(-0.7, 2.0) };
        let mut plant = IdealPlant::<f64>::new(&p, start, 1e-3);
        for _ in 0..20_000 {
            plant.advance(PerMotor::zero(), PerMotor::zero());
        }
        let end = plant.state();
        assert!((end.angle.yaw - start.angle.yaw).abs() > 1.0, "it moved");
        assert!((energy(&p, &end) - energy(&p, &start)).abs() < 1e-8);
        assert!((yaw_momentum(&p, &end) - yaw_momentum(&p, &start)).abs() < 1e-9);
    }
}

#[test]
fn signs_are_as_documented() {
    let p = presets::AERO.plant.ideal(0.0);
    let after = |volts, disturbance| {
        let mut plant = IdealPlant::<f64>::new(&p, State::default(), 1e-3);
        plant.advance(volts, disturbance);
        plant.state().rate
    };
    let main = after(PerMotor::new(10.0, 0.0), PerMotor::zero());
    assert!(main.pitch > 0.0 && main.yaw < 0.0);
    let tail = after(PerMotor::new(0.0, 10.0), PerMotor::zero());
    assert!(tail.pitch > 0.0 && tail.yaw > 0.0);
    assert_eq!(after(PerMotor::zero(), PerMotor::zero()), PerAxis::zero());
    // A disturbance in volts acts as volts do.
    assert_eq!(after(PerMotor::zero(), PerMotor::new(10.0, 0.0)), main);
}

/// The weight of the paper's helicopter drops the nose, with m g L cos θ; K_sp sin θ pulls it to the
/// horizontal.
#[test]
fn gravity_pulls_as_printed() {
    let paper = RigidBody::new(&presets::PAPER.plant);
    let level = paper.at(&State::default());
    assert!((level.opposing.pitch - 1.075 * 9.8 * 0.002).abs() < 1e-15);
    let aero = RigidBody::new(&presets::AERO.plant);
    let up = aero.at(&State::at_rest(PerAxis::new(15.0 * DEGREE, 0.0)));
    assert!((up.opposing.pitch - 0.037_463 * (15.0 * DEGREE).sin()).abs() < 1e-15);
    assert_eq!(aero.at(&State::default()).opposing.pitch, 0.0);
}

/// Fourth order: half the step, a sixteenth of the error.
#[test]
fn the_integrator_is_of_fourth_order() {
    let p = free(&presets::AERO, 0.2);
    let run = |steps: u32| {
        let mut plant = IdealPlant::<f64>::new(&p, State::default(), 1.0 / f64::from(steps));
        for _ in 0..steps {
            plant.advance(PerMotor::new(5.0, -5.0), PerMotor::zero());
        }
        plant.state().angle.pitch
    };
    let exact = run(6_400);
    let order = ((run(100) - exact) / (run(200) - exact)).log2();
    assert!((order - 4.0).abs() < 0.15, "order {order}");
}

/// Coulomb friction holds a body that is pushed with less, up to the creep that its width allows, and slows
/// one that moves at F/I.
#[test]
fn coulomb_friction_sticks_and_slows() {
    let p = presets::AERO_LAB.plant;
    let mut pushed = RealPlant::<f64>::new(&p, State::at_rest(PerAxis::new(0.02, 0.0)), 1e-3);
    for _ in 0..2_000 {
        pushed.advance(PerMotor::zero(), PerMotor::zero());
    }
    // K_sp x .02 rad is less than the friction: it creeps by a part of the width, a third of an encoder count
    // in 2 s.
    assert!((pushed.state().angle.pitch - 0.02).abs() < 2.0 * FRICTION_WIDTH);

    let spinning = State { angle: PerAxis::zero(), rate: PerAxis::new(0.0, 1.0) };
    let mut plant = RealPlant::<f64>::new(&p, spinning, 1e-3);
    for _ in 0..100 {
        plant.advance(PerMotor::zero(), PerMotor::zero());
    }
    let slowing = (p.coulomb_friction.yaw + p.damping.yaw * 0.99) / p.inertia.yaw;
    assert!((1.0 - plant.state().rate.yaw - 0.1 * slowing).abs() < 1e-3);
}

proptest! {
    /// f32 stays with f64 to within a few units in the last place of a step, whatever the state.
    #[test]
    fn one_step_in_f32_is_that_of_f64(
        pitch in -1.5..1.5, yaw in -3.0..3.0, dp in -5.0..5.0, dy in -5.0..5.0,
        main in -24.0..24.0, tail in -24.0..24.0,
    ) {
        for (_, rig) in presets::ALL {
            let state = State { angle: PerAxis::new(pitch, yaw), rate: PerAxis::new(dp, dy) };
            let single = State { angle: state.angle.cast(), rate: state.rate.cast() };
            let mut a = RealPlant::<f64>::new(&rig.plant, state, 1e-3);
            let mut b = RealPlant::<f32>::new(&rig.plant, single, 1e-3);
            let volts = PerMotor::new(main, tail);
            a.advance(volts, PerMotor::zero());
            b.advance(volts.cast(), PerMotor::zero());
            let (a, b) = (a.state(), b.state());
            prop_assert!((a.angle.pitch - f64::from(b.angle.pitch)).abs() < 4e-7);
            prop_assert!((a.angle.yaw - f64::from(b.angle.yaw)).abs() < 6e-7);
            prop_assert!((a.rate.pitch - f64::from(b.rate.pitch)).abs() < 1e-6);
            prop_assert!((a.rate.yaw - f64::from(b.rate.yaw)).abs() < 1e-6);
        }
    }
}

/// τ = I α about an axis without gravity, spring or friction.
#[test]
fn a_torque_from_outside_turns_the_body() {
    let p = free(&presets::PAPER, 0.0);
    let mut plant = IdealPlant::<f64>::new(&p, State::default(), 1e-3);
    plant.set_load(PerAxis::new(0.02, -0.03));
    (0..1_000).for_each(|_| plant.advance(PerMotor::zero(), PerMotor::zero()));
    let rate = plant.state().rate;
    assert!((rate.pitch - 0.02 / p.inertia.pitch).abs() < 1e-9, "{rate:?}");
    assert!((rate.yaw + 0.03 / p.inertia.yaw).abs() < 1e-9, "{rate:?}");
    plant.set_load(PerAxis::zero());
    plant.advance(PerMotor::zero(), PerMotor::zero());
    assert_eq!(plant.state().rate, rate, "and no longer");
}

/// A weight behind the pivot takes what one in front of it gives, also where both balance to nothing.
#[test]
fn weights_in_front_of_and_behind_the_pivot_balance() {
    let p = presets::PAPER.plant;
    let moment = p.mass * p.center_of_mass;
    let level = |plant: &PlantParameters<f64>| RigidBody::new(plant).at(&State::default());
    let (bare, heavy) = (level(&p), level(&p.with_weight(0.02, 0.2)));
    let more = 0.02 * 0.2 * p.gravity;
    assert!((heavy.opposing.pitch - bare.opposing.pitch - more).abs() < 1e-12);
    assert!((heavy.inertia.pitch - bare.inertia.pitch - 0.02 * 0.04).abs() < 1e-12);
    let balanced = level(&p.with_weight(moment / 0.2, -0.2));
    assert!(balanced.opposing.pitch.abs() < 1e-7, "{balanced:?}");
    let square = p.mass * p.center_of_mass.powi(2) + moment / 0.2 * 0.04;
    assert!((balanced.inertia.pitch - p.inertia.pitch - square).abs() < 1e-9, "{balanced:?}");
    let at_the_pivot = presets::AERO.plant.with_weight(0.5, 0.0);
    assert!((level(&at_the_pivot).opposing.pitch).abs() < 1e-7);
}

#[test]
fn a_motor_that_lost_half_its_thrust_gives_half_on_both_axes() {
    let p = presets::AERO_LAB.plant;
    let torque = |plant: &PlantParameters<f64>, volts: PerMotor<f64>| {
        let mut rotors = LaggedRotors::new(plant, 1e-3);
        rotors.volts = volts;
        rotors.over_step(volts, PerMotor::zero())[2].torque
    };
    let half = p.with_thrust(PerMotor::new(0.5, 1.0));
    let (main, tail) = (PerMotor::new(9.0, 0.0), PerMotor::new(0.0, 9.0));
    assert_eq!(torque(&half, main), torque(&p, main).scaled(0.5));
    assert_eq!(torque(&half, tail), torque(&p, tail));
}

/// One that goes on where another is flies on as that one does, to the bit; else it stays what it was.
#[test]
fn a_plant_goes_on_where_another_is() {
    let parameters = presets::AERO_LAB.plant;
    let begun = || RealPlant::<f32>::new(&parameters, State::default(), 1e-3);
    let fly = |plant: &mut RealPlant<f32>| {
        for k in 0..300_u16 {
            plant.advance(PerMotor::new(f32::from(k % 70) * 0.2, -5.0), PerMotor::zero());
        }
    };
    let mut flown = begun();
    fly(&mut flown);
    let [mut same, mut fresh] = [begun(), begun()];
    same.go_on(true, &flown);
    fresh.go_on(false, &flown);
    assert_eq!((same, fresh), (flown, begun()));
    fly(&mut same);
    fly(&mut flown);
    assert_eq!(same, flown);
    assert!(flown.state().rate.pitch.abs() > 0.01);
}

/// A cable turns yaw back with its stiffness once it is taut, either way, and a body on it swings without
/// loss: ½ J ψ̇² + ½ k (|ψ| - free)² stays.
#[test]
fn a_cable_holds_yaw_back_once_it_is_taut() {
    let p = free(&presets::AERO2, 0.0);
    let cable = Cable { stiffness: 0.004, free: 0.5 };
    for way in [1.0, -1.0] {
        let start = State { angle: PerAxis::zero(), rate: PerAxis::new(0.0, way * 0.3) };
        let mut plant = IdealPlant::<f64>::new(&p, start, 1e-3);
        plant.set_cable(&cable);
        let energy = |s: &State<f64>| {
            let taut = (s.angle.yaw.abs() - cable.free).max(0.0);
            0.5 * p.inertia.yaw * s.rate.yaw.powi(2) + 0.5 * cable.stiffness * taut * taut
        };
        let mut furthest = 0.0_f64;
        for tick in 0..20_000 {
            plant.advance(PerMotor::zero(), PerMotor::zero());
            let now = plant.state();
            furthest = furthest.max(way * now.angle.yaw);
            assert!(tick > 1_000 || (now.rate.yaw - start.rate.yaw).abs() < 1e-12, "it is slack as yet");
            assert!((energy(&now) / energy(&start) - 1.0).abs() < 1e-5);
        }
        let taut = 0.3 * (p.inertia.yaw / cable.stiffness).sqrt();
        assert!((furthest - cable.free - taut).abs() < 1e-4, "{furthest}");
    }
    let mut none = IdealPlant::<f64>::new(&p, State::at_rest(PerAxis::new(0.0, 3.0)), 1e-3);
    none.set_cable(&Cable::default());
    none.advance(PerMotor::zero(), PerMotor::zero());
    assert_eq!(none.state().rate, PerAxis::zero());
}
