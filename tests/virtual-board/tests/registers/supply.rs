//! The supply's voltage detector: RM0090 5.2.4, datasheet DS8626 table 19.

use virtual_board::chip::{Settings, Tolerance};

use super::whole::Whole;

const PWR_CR: u64 = 0x4000_7000;
const PWR_CSR: u64 = PWR_CR + 4;
const PVDE: u64 = 1 << 4;
const PVDO: u64 = 1 << 2;
const ALL: [Tolerance; 3] = [Tolerance::Minimum, Tolerance::Typical, Tolerance::Maximum];

/// A part whose detector is on at `level`.
fn detecting(rail_millivolts: u32, detector: Tolerance, level: u64) -> Whole {
    let mut whole = Whole::new(Settings { rail_millivolts, detector, ..Settings::default() });
    whole.write(PWR_CR, level << 5 | PVDE);
    whole
}

fn low(whole: &mut Whole) -> bool {
    whole.read(PWR_CSR) & PVDO != 0
}

/// The highest rail \[mV\] that trips the detector from above, and the lowest that releases it from below.
fn thresholds(detector: Tolerance, level: u64) -> (u32, u32) {
    let mut whole = detecting(3600, detector, level);
    let mut at = 3600;
    let mut step = |whole: &mut Whole, by: i32| {
        at = u32::try_from(i32::try_from(at).unwrap() + by).unwrap();
        let now = whole.now();
        whole.part.set_rail(now, at);
        at
    };
    while !low(&mut whole) {
        step(&mut whole, -10);
    }
    let mut fell = step(&mut whole, 0);
    while low(&mut whole) {
        fell = fell.min(step(&mut whole, 10));
    }
    (fell, step(&mut whole, 0))
}

#[test]
fn level_7_trips_a_board_of_3_0_volts_unless_its_detector_is_at_the_lowest() {
    for rail in [3000, 3130, 3300] {
        let tripped = ALL.map(|detector| low(&mut detecting(rail, detector, 7)));
        assert_eq!(tripped, [false, rail < 3030, rail < 3090], "{rail} mV");
    }
}

#[test]
fn level_5_leaves_a_board_of_3_0_volts_alone_whatever_its_detector() {
    for rail in [3000, 3130, 3300] {
        assert_eq!(ALL.map(|detector| low(&mut detecting(rail, detector, 5))), [false; 3], "{rail} mV");
    }
}

#[test]
fn every_threshold_is_the_datasheets() {
    // Level: falling then rising, lowest, typical, highest.
    let table = [
        (0, [(1980, 2090), (2040, 2140), (2080, 2190)]),
        (5, [(2750, 2860), (2840, 2930), (2920, 2990)]),
        (7, [(2950, 3070), (3030, 3140), (3090, 3210)]),
    ];
    for (level, rows) in table {
        for (detector, (falls, rises)) in ALL.into_iter().zip(rows) {
            // In steps of 10 mV: below the falling threshold, at the rising one.
            assert_eq!(thresholds(detector, level), (falls - 10, rises), "level {level}, {detector:?}");
        }
    }
}

#[test]
fn a_detector_that_is_off_says_nothing() {
    let mut whole = detecting(2000, Tolerance::Typical, 7);
    assert!(low(&mut whole));
    whole.write(PWR_CR, 7 << 5);
    assert!(!low(&mut whole));
}
