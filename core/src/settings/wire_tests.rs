//! A controller's bytes, as boards have stored them since version 4 of the record: captured from the code
//! that spelled every structure out by hand. Whatever declares the settings, these must not change.

use crate::allocation::AllocationSettings;
use crate::axes::{PerAxis, PerMotor};
use crate::command_filter::FilterSettings;
use crate::controller::ControllerSettings;
use crate::defaults;
use crate::estimator::{EstimatorSettings, ObserverGains};
use crate::gains;
use crate::law::{IntegralGains, LawSettings, PidGains, StateFeedbackGains, SuperTwistingGains};
use crate::parameters::store::MAX_PAYLOAD;
use crate::parameters::{Parameters, SAMPLE_TIME};
use crate::pipeline::Settings;
use crate::plant::presets;
use crate::real::Real;
use std::format;
use std::string::String;

/// Numbers that say where they are: 1, 2, 3, ...
fn counting() -> impl FnMut() -> f64 {
    let mut next = 0.0;
    move || {
        next += 1.0;
        next
    }
}

/// Every law, estimator and allocation at least once, with and without what may be left out.
fn controllers() -> [ControllerSettings<f64>; 6] {
    let paper = ControllerSettings::paper(gains::PAPER);
    let mut n = counting();
    let mut pair = || PerAxis::new(n(), n());
    let filter =
        FilterSettings { bandwidth: pair(), damping: Some(pair()), advance: None, reach: Some(pair()) };
    let integral = IntegralGains { position: 1.0, rate: 2.0, weight: 3.0, integral: 4.0 };
    let pid = PidGains { proportional: 1.0, integral: 2.0, derivative: 3.0 };
    let twisting = SuperTwistingGains { surface: 1.0, proportional: 2.0, integral: 3.0, width: 4.0 };
    let mut n = counting();
    let mut matrix = || PerMotor::new(PerAxis::new(n(), n()), PerAxis::new(n(), n()));
    let feedback = StateFeedbackGains {
        angle: matrix(),
        rate: matrix(),
        integral: matrix(),
        integral_limit: 20.0,
        feed_forward: true,
    };
    let observer = ObserverGains { angle: 1.0, rate: 2.0, disturbance: 3.0 };
    let bandwidth = PerAxis::new(5.0, 6.0);
    [
        paper,
        ControllerSettings {
            law: LawSettings::IntegralBackstepping(PerAxis::both(integral)),
            estimator: EstimatorSettings::Luenberger { bandwidth },
            filter: Some(filter),
            allocation: AllocationSettings::Weighted { pitch_weight: 1.5 },
            ..paper
        },
        ControllerSettings {
            law: LawSettings::Pid(PerAxis::both(pid)),
            estimator: EstimatorSettings::ExtendedState { bandwidth },
            allocation: AllocationSettings::Scale,
            cancellation: Some(PerAxis::new(0.25, 0.5)),
            ..paper
        },
        ControllerSettings {
            law: LawSettings::StateFeedback(feedback),
            estimator: EstimatorSettings::Observer { gains: PerAxis::both(observer) },
            ..paper
        },
        ControllerSettings {
            law: LawSettings::SuperTwisting(PerAxis::both(twisting)),
            lead: Some(crate::lead::Lead { factor: 2.0 }),
            ..paper
        },
        defaults::AERO2,
    ]
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn a_controllers_bytes_are_what_they_were() {
    let mut buffer = [0; 512];
    for (settings, expected) in controllers().into_iter().zip(CONTROLLERS) {
        let bytes = postcard::to_slice(&settings.map(f32::from_f64), &mut buffer).unwrap();
        assert_eq!(hex(bytes), expected, "{settings:?}");
        let back: ControllerSettings<f32> = postcard::from_bytes(bytes).unwrap();
        assert_eq!(back, settings.map(f32::from_f64));
    }
}

#[test]
fn a_records_bytes_are_what_they_were() {
    let rig = presets::AERO2;
    let record = Parameters::new(&rig, &Settings::new(&rig, defaults::AERO2, SAMPLE_TIME));
    assert_eq!(hex(record.encode(&mut [0; MAX_PAYLOAD]).unwrap()), RECORD);
}

const CONTROLLERS: [&str; 6] = [
    "0066668640cdccc44185eb1140cdcc2c41000000c8420000c84200000000",
    "010000803f0000004000004040000080400000803f000000400000404000008040010000a0400000\
        c040010000803f0000004001000040400000804000010000a0400000c040020000c03f0000",
    "020000803f00000040000040400000803f0000004000004040020000a0400000c040000100010000\
        803e0000003f",
    "030000803f0000004000004040000080400000a0400000c0400000e0400000004100001041000020\
        4100003041000040410000a04101030000803f00000040000040400000803f000000400000404000\
        000000",
    "040000803f0000004000004040000080400000803f000000400000404000008040000000c8420000\
        c8420000010000004000",
    "01f7aa5f40315b5040f932fb3faf292f40fca226407340363f72b4ce3e3e474e40029c046641bae2\
        b741016ae01e40aa4f184001b857693f2742913f01dec0013fbb93bf3e01920a863ec2b8323f02ef\
        dabf3f012bb7e63f019b980b3e1942533f",
];

const RECORD: &str = "046f12833ac3f5883f00000000c3f51c41cff5bd3c070ec33ca96a023b82a8fb3a3ecbf33b76c50c\
        3ab81f703922fc0bba85b1853a000000000000000000000000000000000ad7233e0ad7233e000000\
        0000000000000000000000000076c50c3ab81f703922fc0bba85b1853a0000904100009041016666\
        06411a61393f000000400000003f01f7aa5f40315b5040f932fb3faf292f40fca226407340363f72\
        b4ce3e3e474e40029c046641bae2b741016ae01e40aa4f184001b857693f2742913f01dec0013fbb\
        93bf3e01920a863ec2b8323f02efdabf3f012bb7e63f019b980b3e1942533f35fa0e3b00db0fc93a\
        00c2b8323f0000204100002041000010410000b441f4030000003f00001041aab9173edfb819be10\
        490a3d2bb6193eaab917bedfb8193e0000104110490a3d2bb6193eaab9173edfb819be10490abd2b\
        b619be00";
