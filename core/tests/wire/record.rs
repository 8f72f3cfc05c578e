//! The parameter record: each choice in it, all of it as a payload, and its place on flash.

use crate::{compare, counting};
use serde::Serialize;
use twinrotor::allocation::{AllocationSettings, CurrentLimitSettings};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::command_filter::FilterSettings;
use twinrotor::controller::ControllerSettings;
use twinrotor::estimator::{EstimatorSettings, ObserverGains};
use twinrotor::first_power::Push;
use twinrotor::gains::AxisGains;
use twinrotor::law::{
    IntegralGains, LawSettings, MotorGains, PidGains, Signal, StateFeedbackGains, StateSpaceGains,
    SuperTwistingGains,
};
use twinrotor::lead::Lead;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{MAX_PAYLOAD, SLOT_SIZE, Store};
use twinrotor::parameters::{EncoderScale, Limits, LostLink, Parameters};
use twinrotor::pipeline::Settings;
use twinrotor::plant::{Effectiveness, PlantParameters};
use twinrotor::rig_port::RigPort;

type Next<'a> = &'a mut dyn FnMut() -> f32;

fn each_axis<T>(n: Next<'_>, mut of: impl FnMut(Next<'_>) -> T) -> PerAxis<T> {
    PerAxis { pitch: of(n), yaw: of(n) }
}

fn axes(n: Next<'_>) -> PerAxis<f32> {
    each_axis(n, |n| n())
}

fn motors(n: Next<'_>) -> PerMotor<f32> {
    PerMotor { main: n(), tail: n() }
}

fn effectiveness(n: Next<'_>) -> Effectiveness<f32> {
    Effectiveness { main_on_pitch: n(), tail_on_pitch: n(), main_on_yaw: n(), tail_on_yaw: n() }
}

fn push(n: Next<'_>) -> Push {
    Push { volts: n(), motion: axes(n), swapped: axes(n), reversed: axes(n) }
}

fn motor_gains(n: Next<'_>) -> MotorGains<f32> {
    PerMotor { main: axes(n), tail: axes(n) }
}

/// Everything that may be there is, and every number is the next one.
pub(crate) fn controller(n: Next<'_>) -> ControllerSettings<f32> {
    ControllerSettings {
        law: LawSettings::Backstepping(each_axis(n, |n| AxisGains { position: n(), rate: n() })),
        estimator: EstimatorSettings::FilteredDerivative { bandwidth: axes(n) },
        filter: Some(FilterSettings {
            bandwidth: axes(n),
            damping: Some(axes(n)),
            advance: Some(axes(n)),
            reach: Some(axes(n)),
        }),
        allocation: AllocationSettings::Weighted { pitch_weight: n() },
        lead: Some(Lead { factor: n() }),
        cancellation: Some(axes(n)),
    }
}

/// The same of all parameters.
pub(crate) fn numbered() -> Parameters {
    let n: Next<'_> = &mut counting(1);
    let model = |n: Next<'_>| PlantParameters {
        mass: n(),
        center_of_mass: n(),
        gravity: n(),
        inertia: axes(n),
        damping: axes(n),
        stiffness: n(),
        effectiveness: effectiveness(n),
        quadratic_effectiveness: effectiveness(n),
        rotor_time_constant: motors(n),
        rotor_reaction: motors(n),
        coulomb_friction: axes(n),
        tilting_inertia: n(),
        rotor_momentum: n(),
        tilting_thrust: n(),
    };
    let limits = |n: Next<'_>| Limits {
        pitch: n(),
        rate: axes(n),
        supply_low: n(),
        supply_high: n(),
        command_timeout: 500,
        lost_link: LostLink::Hold { ticks: 2_000 },
        approach_rate: n(),
        check: PerMotor { main: push(n), tail: push(n) },
    };
    Parameters {
        settings: Settings {
            sample_time: n(),
            model: model(n),
            effectiveness: effectiveness(n),
            volts_limit: motors(n),
            current_limit: Some(CurrentLimitSettings {
                resistance: n(),
                back_emf: n(),
                peak: n(),
                continuous: n(),
            }),
            controller: controller(n),
        },
        encoders: PerAxis {
            pitch: EncoderScale { angle_per_count: n(), rest_counts: -1 },
            yaw: EncoderScale { angle_per_count: n(), rest_counts: 300 },
        },
        limits: limits(n),
        checked: true,
        port: RigPort::Simulated,
    }
}

fn plain(value: &impl Serialize) -> Vec<u8> {
    postcard::to_slice(value, &mut [0; MAX_PAYLOAD]).unwrap().to_vec()
}

#[test]
fn every_choice_is_its_literal() {
    let n = || counting(1);
    let law = |law: LawSettings<f32>| plain(&law);
    let estimator = |estimator: EstimatorSettings<f32>| plain(&estimator);
    let allocation = |allocation: AllocationSettings<f32>| plain(&allocation);
    let backstepping = each_axis(&mut n(), |n| AxisGains { position: n(), rate: n() });
    let integral =
        each_axis(&mut n(), |n| IntegralGains { position: n(), rate: n(), weight: n(), integral: n() });
    let pid = each_axis(&mut n(), |n| PidGains { proportional: n(), integral: n(), derivative: n() });
    let feedback = |n: Next<'_>| StateFeedbackGains {
        angle: motor_gains(n),
        rate: motor_gains(n),
        integral: motor_gains(n),
        integral_limit: n(),
        feed_forward: true,
    };
    let twisting = each_axis(&mut n(), |n| SuperTwistingGains {
        surface: n(),
        proportional: n(),
        integral: n(),
        width: n(),
    });
    let each = |n: Next<'_>| std::array::from_fn(|_| n());
    let matrices = |n: Next<'_>| StateSpaceGains {
        states: 8,
        inputs: 4,
        signals: [Signal::AnglePitch, Signal::AngleYaw, Signal::ReferenceRatePitch, Signal::ReferenceRateYaw],
        feed_forward: true,
        corrected: true,
        saturation: motors(n),
        c: PerMotor { main: std::array::from_fn(|_| n()), tail: std::array::from_fn(|_| n()) },
        d: PerMotor { main: each(n), tail: each(n) },
        a: std::array::from_fn(|_| std::array::from_fn(|_| n())),
        b: std::array::from_fn(|_| each(n)),
        anti_windup: std::array::from_fn(|_| motors(n)),
    };
    let observer = each_axis(&mut n(), |n| ObserverGains { angle: n(), rate: n(), disturbance: n() });
    let bandwidth = axes(&mut n());
    compare(
        "choice/",
        [
            ("law-backstepping", law(LawSettings::Backstepping(backstepping))),
            ("law-integral-backstepping", law(LawSettings::IntegralBackstepping(integral))),
            ("law-pid", law(LawSettings::Pid(pid))),
            ("law-state-feedback", law(LawSettings::StateFeedback(feedback(&mut n())))),
            ("law-super-twisting", law(LawSettings::SuperTwisting(twisting))),
            ("law-state-space", law(LawSettings::StateSpace(matrices(&mut n())))),
            ("estimator-filtered-derivative", estimator(EstimatorSettings::FilteredDerivative { bandwidth })),
            ("estimator-luenberger", estimator(EstimatorSettings::Luenberger { bandwidth })),
            ("estimator-extended-state", estimator(EstimatorSettings::ExtendedState { bandwidth })),
            ("estimator-observer", estimator(EstimatorSettings::Observer { gains: observer })),
            ("allocation-clamp", allocation(AllocationSettings::Clamp)),
            ("allocation-scale", allocation(AllocationSettings::Scale)),
            ("allocation-weighted", allocation(AllocationSettings::Weighted { pitch_weight: 1.0 })),
        ],
    );
}

#[test]
fn the_record_is_its_literal_as_a_payload_and_on_flash() {
    let payload = numbered().encode(&mut [0; MAX_PAYLOAD]).unwrap().to_vec();
    let mut store = Store::new(RamFlash::default(), 0);
    store.save(&payload, &mut [0; SLOT_SIZE]).unwrap();
    let flash = store.into_flash().bytes().to_vec();
    // Header and CRC around a payload that is padded to words; the rest of the area stays erased.
    let (slot, erased) = flash.split_at(8 + payload.len().next_multiple_of(4) + 4);
    assert!(erased.iter().all(|&byte| byte == 0xFF));
    compare("record/", [("payload", payload), ("slot", slot.to_vec())]);
}
