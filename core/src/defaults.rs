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
            position: 5.335300539775662,
            rate: 71.39013020251392,
            weight: 0.948678428778969,
            integral: 6.566179828146438,
        },
        IntegralGains {
            position: 4.522745799880962,
            rate: 30.994331561865316,
            weight: 0.6704532383002693,
            integral: 17.93610834023257,
        },
    )),
    estimator: EstimatorSettings::Luenberger {
        bandwidth: PerAxis::new(378.1249431175186, 161.01262242165143),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(11.371811018368529, 9.280927515501558),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 1.3142934015571395 },
    lead: None,
    cancellation: None,
};

/// For [`presets::PAPER_FIXED`](crate::plant::presets::PAPER_FIXED): `gains/paper-fixed.toml`.
pub const PAPER_FIXED: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 7.96679643464321,
            rate: 6.9872698229528,
            weight: 0.3793128886655423,
            integral: 14.253518683793473,
        },
        IntegralGains {
            position: 9.610276718405654,
            rate: 6.5655389958364445,
            weight: 0.3772532912465324,
            integral: 19.957974287082063,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(29.330905625414125, 25.975198539001116),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(5.078836969786465, 5.644157909228391),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 2.282859738781614 },
    lead: Some(Lead { factor: 2.9762976711255194 }),
    cancellation: Some(PerAxis::new(0.20145307627936818, 0.2408698764172363)),
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
            position: 4.185798219597297,
            rate: 1.3260360185271525,
            weight: 0.7292766122530333,
            integral: 3.2010102598243995,
        },
        IntegralGains {
            position: 2.031178645571389,
            rate: 2.7678604897160946,
            weight: 0.24243875975780188,
            integral: 1.9857489699721904,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(9.338262060516266, 18.79236726729599),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(3.2059291137442876, 2.1367269806177998),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 2.4417642069053276 },
    lead: Some(Lead { factor: 4.281960557118461 }),
    cancellation: Some(PerAxis::new(0.18456237188781843, 0.2895568690710204)),
};

/// For [`presets::AERO_LAB`](crate::plant::presets::AERO_LAB): `gains/aero-lab.toml`.
pub const AERO_LAB: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 10.936591210128768,
            rate: 16.85028651142968,
            weight: 2.4098438005029044,
            integral: 21.323632796242922,
        },
        IntegralGains {
            position: 0.45422238698778894,
            rate: 8.81470545772939,
            weight: 0.2125606476987629,
            integral: 18.651775528553927,
        },
    )),
    estimator: EstimatorSettings::Luenberger {
        bandwidth: PerAxis::new(19.74674879823922, 24.21323725590469),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(8.121774023518011, 3.8864362268509622),
        reach: Some(PerAxis::new(0.2617993877991494, 0.6981317007977318)),
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.12915033843629098 },
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
