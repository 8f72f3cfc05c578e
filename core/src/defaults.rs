//! The controllers that boards boot with, one for each preset: the numbers of the committed gains files, which say how they were
//! tuned. A test of the host holds the two equal.

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
        IntegralGains {
            position: 6.288678750672421,
            rate: 66.91818721044362,
            weight: 1.2486056367714573,
            integral: 6.144122756957767,
        },
        IntegralGains {
            position: 5.325424397542709,
            rate: 23.089496041787186,
            weight: 0.6208081611937222,
            integral: 15.44097982638692,
        },
    )),
    estimator: EstimatorSettings::Luenberger {
        bandwidth: PerAxis::new(378.2068884894583, 181.61632933313746),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(12.089219078195471, 9.110580616013065),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 1.4424956709810333 },
    lead: None,
    cancellation: None,
};

/// For [`presets::PAPER_FIXED`](crate::plant::presets::PAPER_FIXED): `gains/paper-fixed.toml`.
pub const PAPER_FIXED: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 9.599438780238726,
            rate: 7.066354579477341,
            weight: 0.5886189825678743,
            integral: 17.84384355269644,
        },
        IntegralGains {
            position: 8.504758054699863,
            rate: 8.905605790536125,
            weight: 0.2477057680648389,
            integral: 16.674775485588352,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(30.250063061396148, 31.854965466582886),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(5.28482345565251, 5.392675939074023),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 2.518744531625228 },
    lead: Some(Lead { factor: 2.8115190567479726 }),
    cancellation: Some(PerAxis::new(0.18774897340861785, 0.25302085306538935)),
};

/// For [`presets::AERO`](crate::plant::presets::AERO): `gains/aero.toml`.
pub const AERO: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 4.621914209427116,
            rate: 5.532388463675461,
            weight: 0.32898206539421543,
            integral: 1.8022781020011969,
        },
        IntegralGains {
            position: 2.4727567697135933,
            rate: 5.055183664937737,
            weight: 1.8707446170419841,
            integral: 3.7828824158292242,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(14.076070114219657, 28.11745473759024),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(4.53633177123163, 4.151320652290522),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 2.3350288849078935 },
    lead: Some(Lead { factor: 4.538692717140932 }),
    cancellation: Some(PerAxis::new(0.2597324788003398, 0.42617181281482985)),
};

/// For [`presets::AERO2`](crate::plant::presets::AERO2): `gains/aero2.toml`.
pub const AERO2: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 2.663604838975188,
            rate: 2.4359476732920498,
            weight: 0.6619257561597307,
            integral: 2.3077095760090973,
        },
        IntegralGains {
            position: 1.9702244641647575,
            rate: 2.1374475186423805,
            weight: 0.25457597775602614,
            integral: 1.963640931294575,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(9.969937309570224, 15.923004087512094),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(3.251220694243697, 2.116057310838569),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 2.413573823754779 },
    lead: Some(Lead { factor: 5.008181959864647 }),
    cancellation: Some(PerAxis::new(0.3545549091176871, 0.5354161398566992)),
};

/// For [`presets::AERO_LAB`](crate::plant::presets::AERO_LAB): `gains/aero-lab.toml`.
pub const AERO_LAB: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 10.493914527412343,
            rate: 16.894347428188528,
            weight: 2.4009798961392743,
            integral: 19.896426923202025,
        },
        IntegralGains {
            position: 0.42032488690281045,
            rate: 9.647105679600578,
            weight: 0.20524449930116512,
            integral: 18.81924098877145,
        },
    )),
    estimator: EstimatorSettings::Luenberger {
        bandwidth: PerAxis::new(19.53480378684673, 22.636393262352243),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(7.906722992353425, 4.013902619229888),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.13858441240487426 },
    lead: None,
    cancellation: None,
};

/// For [`presets::HELI`](crate::plant::presets::HELI): `gains/heli.toml`.
pub const HELI: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 9.35892162108853,
            rate: 12.006198124869808,
            weight: 0.44725290365866444,
            integral: 23.24499609734522,
        },
        IntegralGains {
            position: 4.3011625447193405,
            rate: 17.500059405150388,
            weight: 2.1625283231057124,
            integral: 9.971091117477263,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(49.3594580799479, 40.42273637737018),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(7.199383431013751, 7.8235773571055125),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.3261878622012514 },
    lead: Some(Lead { factor: 9.109926530972674 }),
    cancellation: Some(PerAxis::new(0.4932282435260368, 0.3924066399405477)),
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
