//! The controllers that boards boot with, one for each preset: the numbers of the committed gains
//! files, which say how they were tuned. Written by `scripts/generate-defaults.py`; a test of the host
//! holds the two equal.

use crate::allocation::AllocationSettings;
use crate::axes::PerAxis;
use crate::command_filter::FilterSettings;
use crate::controller::ControllerSettings;
use crate::estimator::EstimatorSettings;
use crate::law::{IntegralGains, LawSettings};
use crate::lead::Lead;

/// For [`presets::PAPER`](crate::plant::presets::PAPER): `gains/paper.toml`.
pub const PAPER: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains { position: 5.22138, rate: 68.2763, weight: 1.46726, integral: 13.2509 },
        IntegralGains { position: 5.19239, rate: 28.4428, weight: 1.51098, integral: 20.3253 },
    )),
    estimator: EstimatorSettings::Luenberger { bandwidth: PerAxis::new(370.144, 188.479) },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(14.6519, 9.27037),
        damping: Some(PerAxis::new(1.68462, 1.14456)),
        advance: Some(PerAxis::new(0.169967, 0.115189)),
        reach: Some(PerAxis::new(0.261799, 0.698132)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.96848 },
    lead: None,
    cancellation: None,
};

/// For [`presets::PAPER_FIXED`](crate::plant::presets::PAPER_FIXED): `gains/paper-fixed.toml`.
pub const PAPER_FIXED: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 11.911010888559105,
            rate: 3.43850211885494,
            weight: 0.8359206554590607,
            integral: 28.87797997956994,
        },
        IntegralGains {
            position: 6.502798455173586,
            rate: 7.929395544874434,
            weight: 0.15010007052533436,
            integral: 12.158988899216371,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(32.95802861307172, 37.355016713855186),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(9.350292359836233, 13.901998365490329),
        damping: Some(PerAxis::new(2.0321996922966066, 2.8109004126080794)),
        advance: Some(PerAxis::new(0.038338992196015394, 0.044474005555528134)),
        reach: Some(PerAxis::new(0.2618, 0.69813)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 2.096298051756671 },
    lead: Some(Lead { factor: 2.8491019903355843 }),
    cancellation: Some(PerAxis::new(0.10701994325577034, 0.35974027920401663)),
};

/// For [`presets::AERO`](crate::plant::presets::AERO): `gains/aero.toml`.
pub const AERO: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 5.723452436581236,
            rate: 4.738648480099153,
            weight: 1.0490780486510118,
            integral: 2.997035690185546,
        },
        IntegralGains {
            position: 3.4692095179823417,
            rate: 6.219582065565533,
            weight: 0.3418800492015123,
            integral: 3.967113583507116,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(20.36895104385217, 28.897600250116746),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(3.585785771716216, 3.2873237234052723),
        damping: Some(PerAxis::new(0.80655089510031, 0.768542727238165)),
        advance: Some(PerAxis::new(0.020935139121016695, 0.0630942298442402)),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 2.4209373432597197 },
    lead: Some(Lead { factor: 2.566480061455506 }),
    cancellation: Some(PerAxis::new(0.23036049260032748, 0.23690884171894247)),
};

/// For [`presets::AERO2`](crate::plant::presets::AERO2): `gains/aero2.toml`.
pub const AERO2: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 3.49480998142749,
            rate: 3.2555657897101513,
            weight: 1.9624931026896217,
            integral: 2.7369192267069384,
        },
        IntegralGains {
            position: 2.6036978910779323,
            rate: 0.7119209426531611,
            weight: 0.40372044412924996,
            integral: 3.2230982375729145,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(14.376125584087669, 22.985706923827845),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(2.482447213223025, 2.3798624193136217),
        damping: Some(PerAxis::new(0.9114947417489543, 1.1348313042524403)),
        advance: Some(PerAxis::new(0.506849149929818, 0.37417395832861844)),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 1.4988688654109872 },
    lead: Some(Lead { factor: 1.8024648241490548 }),
    cancellation: Some(PerAxis::new(0.13632432984551957, 0.8252273218081545)),
};

/// For [`presets::AERO_LAB`](crate::plant::presets::AERO_LAB): `gains/aero-lab.toml`.
pub const AERO_LAB: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 8.198833261073418,
            rate: 6.916590856585199,
            weight: 2.050579161429943,
            integral: 40.48534928725755,
        },
        IntegralGains {
            position: 0.6116378942499915,
            rate: 8.210480031412427,
            weight: 0.2549527024867946,
            integral: 16.13682254655964,
        },
    )),
    estimator: EstimatorSettings::Luenberger {
        bandwidth: PerAxis::new(19.74674879823922, 24.21323725590469),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(5.905926218486964, 3.4741636626167147),
        damping: Some(PerAxis::new(0.8929919846670171, 0.9399699763220435)),
        advance: Some(PerAxis::new(0.019774319123395955, 0.020756671831023327)),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.20779602348581697 },
    lead: None,
    cancellation: None,
};

/// For [`presets::HELI`](crate::plant::presets::HELI): `gains/heli.toml`.
pub const HELI: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 9.190406420266104,
            rate: 40.49797192370051,
            weight: 2.424102216015123,
            integral: 24.621003614082152,
        },
        IntegralGains {
            position: 34.794027282565985,
            rate: 6.043894482109863,
            weight: 1.0829997427189817,
            integral: 47.96702955798019,
        },
    )),
    estimator: EstimatorSettings::Luenberger {
        bandwidth: PerAxis::new(119.9999363735044, 116.0700900850898),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(11.178997724490888, 6.315700788933962),
        damping: Some(PerAxis::new(1.4491988158534665, 0.8171699039222939)),
        advance: Some(PerAxis::new(0.0368960320319162, 0.15582006971899115)),
        reach: Some(PerAxis::new(0.2618, 0.69813)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.38719964014701286 },
    lead: Some(Lead { factor: 1.9349997070140406 }),
    cancellation: None,
};

/// Every default by its preset's name.
pub const ALL: [(&str, ControllerSettings<f64>); 6] = [
    ("paper", PAPER),
    ("paper-fixed", PAPER_FIXED),
    ("aero", AERO),
    ("aero2", AERO2),
    ("aero-lab", AERO_LAB),
    ("heli", HELI),
];

/// The default of the preset of this name.
pub fn named(preset: &str) -> Option<ControllerSettings<f64>> {
    ALL.into_iter().find(|(name, _)| *name == preset).map(|(_, controller)| controller)
}
