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
            position: 6.368196216550404,
            rate: 55.014299238043485,
            weight: 3.1032212620047455,
            integral: 8.567458419107323,
        },
        IntegralGains {
            position: 5.096490303790917,
            rate: 19.46622202024535,
            weight: 1.054049120625751,
            integral: 16.458049492970805,
        },
    )),
    estimator: EstimatorSettings::Luenberger {
        bandwidth: PerAxis::new(323.58319776270133, 143.90020753813138),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(12.742938774332734, 8.32645781862359),
        reach: None,
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 1.821978848304778 },
    lead: None,
    cancellation: None,
};

/// For [`presets::PAPER_FIXED`](crate::plant::presets::PAPER_FIXED): `gains/paper-fixed.toml`.
pub const PAPER_FIXED: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 20.448938463683493,
            rate: 2.946059003806862,
            weight: 1.4184192840571137,
            integral: 56.691983694108075,
        },
        IntegralGains {
            position: 15.3124479538989,
            rate: 9.860561285094434,
            weight: 0.38546689805811035,
            integral: 29.27022284561698,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(17.111520928077134, 11.006875806891307),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(5.108641404007155, 5.009550709383793),
        reach: None,
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 1.9094115852706186 },
    lead: Some(Lead { factor: 5.3119168429101045 }),
    cancellation: Some(PerAxis::new(0.6364763774121573, 0.49980880578936765)),
};

/// For [`presets::AERO`](crate::plant::presets::AERO): `gains/aero.toml`.
pub const AERO: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 4.636182360907709,
            rate: 4.72506673280518,
            weight: 0.05408367697682731,
            integral: 1.680164787437803,
        },
        IntegralGains {
            position: 5.296544652374515,
            rate: 2.408658854118997,
            weight: 0.28872879687289155,
            integral: 8.342336143188163,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(12.699270825028801, 28.116065468745298),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(4.004010469998066, 4.395486533024905),
        reach: None,
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 2.4967860760931857 },
    lead: Some(Lead { factor: 6.9051784576758655 }),
    cancellation: Some(PerAxis::new(0.47310768169881, 0.21203709692889358)),
};

/// For [`presets::AERO2`](crate::plant::presets::AERO2): `gains/aero2.toml`.
pub const AERO2: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 1.378318914692204,
            rate: 9.19779817192941,
            weight: 1.9906974934217687,
            integral: 1.3468080999792131,
        },
        IntegralGains {
            position: 0.7023095344959887,
            rate: 15.447285968010828,
            weight: 1.7219590701001874,
            integral: 5.562345798899488,
        },
    )),
    estimator: EstimatorSettings::Luenberger {
        bandwidth: PerAxis::new(36.725461028472054, 78.54077405345978),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(2.5868638992349418, 1.7355504302968905),
        reach: None,
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.7341562484373592 },
    lead: None,
    cancellation: None,
};

/// For [`presets::AERO_LAB`](crate::plant::presets::AERO_LAB): `gains/aero-lab.toml`.
pub const AERO_LAB: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 16.79097858208428,
            rate: 7.966437828010677,
            weight: 2.2728310498751494,
            integral: 1.9886029256815612,
        },
        IntegralGains {
            position: 2.7938326467242276,
            rate: 16.335955165256436,
            weight: 5.883693127547536,
            integral: 9.739500974818288,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(11.987255420315607, 19.02710664611405),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(8.299788459474938, 4.57852143860774),
        reach: None,
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.7055610132095085 },
    lead: Some(Lead { factor: 0.7712720994505502 }),
    cancellation: Some(PerAxis::new(0.5239729750681004, 0.10743712615458303)),
};

/// For [`presets::HELI`](crate::plant::presets::HELI): `gains/heli.toml`.
pub const HELI: ControllerSettings<f64> = ControllerSettings {
    law: LawSettings::IntegralBackstepping(PerAxis::new(
        IntegralGains {
            position: 5.190089845314556,
            rate: 21.21062667453244,
            weight: 0.10726586968463787,
            integral: 7.8697134877071235,
        },
        IntegralGains {
            position: 4.5836806239796,
            rate: 10.530038665081662,
            weight: 0.33927570934870577,
            integral: 15.932354290901083,
        },
    )),
    estimator: EstimatorSettings::ExtendedState {
        bandwidth: PerAxis::new(30.789175174255725, 65.96838770549942),
    },
    filter: Some(FilterSettings {
        bandwidth: PerAxis::new(5.207461794871686, 7.920425031105237),
        reach: None,
    }),
    allocation: AllocationSettings::Weighted { pitch_weight: 0.587128186497554 },
    lead: Some(Lead { factor: 5.919212287264231 }),
    cancellation: Some(PerAxis::new(0.5058818127516516, 0.6043933345853039)),
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
