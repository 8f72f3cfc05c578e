//! A crystal that is missing, wrong, or stops: RM0090 7.2.1, 7.2.7, 7.2.11 and 17.3.12.

use virtual_board::chip::Settings;

use super::whole::{MS, RCC, RCC_CFGR, US, Whole};

const PLLCFGR: u64 = RCC + 0x04;
const CIR: u64 = RCC + 0x0C;
const HSEON: u64 = 1 << 16;
const HSERDY: u64 = 1 << 17;
const CSSON: u64 = 1 << 19;
const PLLON: u64 = 1 << 24;
const PLLRDY: u64 = 1 << 25;
const CSSF: u64 = 1 << 7;
const HSI: u64 = 1 << 0;
const TIM1: u64 = 0x4001_0000;
const BDTR: u64 = TIM1 + 0x44;
const MOE: u64 = 1 << 15;
const TIM11: u64 = 0x4001_4800;

fn with_crystal(crystal_hz: u64) -> Whole {
    Whole::new(Settings { crystal_hz, ..Settings::default() })
}

/// On the PLL from the crystal, at 168 MHz with one of 8 MHz, TIM1 counting with its break enabled.
fn on_the_crystal(security: u64) -> Whole {
    let mut whole = with_crystal(8_000_000);
    whole.write(RCC, HSI | HSEON);
    whole.pass(2 * MS);
    whole.write(PLLCFGR, 4 | 168 << 6 | 1 << 22 | 7 << 24);
    whole.write(RCC, HSI | HSEON | PLLON | security);
    whole.pass(2 * MS);
    whole.write(RCC_CFGR, 2);
    assert_eq!(whole.read(RCC_CFGR) >> 2 & 3, 2, "the PLL is the system's clock");
    whole.write(TIM1 + 0x2C, 0xFFFF);
    whole.write(BDTR, MOE | 1 << 12 | 1 << 13);
    whole.write(TIM1, 1);
    whole.pass(100 * US);
    whole
}

#[test]
fn a_crystal_that_is_not_there_never_becomes_ready_and_neither_does_its_pll() {
    let mut whole = with_crystal(0);
    whole.write(RCC, HSI | HSEON);
    whole.pass(1_000 * MS);
    assert_eq!(whole.read(RCC) & (HSEON | HSERDY), HSEON);
    whole.write(PLLCFGR, 4 | 168 << 6 | 1 << 22 | 7 << 24);
    whole.write(RCC, HSI | HSEON | PLLON);
    whole.pass(MS);
    assert_eq!(whole.read(RCC) & (HSEON | HSERDY | PLLRDY), HSEON);
    // A switch to what is not ready waits, and the core runs on as before.
    whole.write(RCC_CFGR, 1);
    whole.pass(MS);
    assert_eq!(whole.read(RCC_CFGR) >> 2 & 3, 0);
    assert!(!whole.part.stalled());
    assert_eq!(with_crystal(8_000_000).read(RCC) & HSERDY, 0, "nor does one that nobody started");
}

/// \[ticks of 16 MHz\] What TIM11 captures over `periods` of 64 cycles of the crystal, if anything.
fn measured(crystal_hz: u64, periods: u64) -> Option<u64> {
    let mut whole = with_crystal(crystal_hz);
    whole.write(RCC, HSI | HSEON);
    whole.pass(MS);
    whole.write(RCC_CFGR, 8 << 16);
    whole.write(TIM11 + 0x50, 2);
    whole.write(TIM11 + 0x18, 1 | 3 << 2);
    whole.write(TIM11 + 0x20, 1);
    whole.write(TIM11, 1);
    let mut next = || {
        for _ in 0..1_000 {
            whole.pass(100);
            if whole.read(TIM11 + 0x10) & 2 != 0 {
                return Some(whole.read(TIM11 + 0x34));
            }
        }
        None
    };
    let first = next()?;
    let mut last = first;
    for _ in 0..periods {
        last = next()?;
    }
    Some((last + 0x1_0000 - first) % 0x1_0000)
}

#[test]
fn tim11_measures_the_crystal_against_the_internal_oscillator() {
    for crystal_hz in [8_000_000, 12_000_000, 25_000_000, 16_000_000] {
        let measured = measured(crystal_hz, 30).expect("captures");
        assert!(measured.abs_diff(30 * 16_000_000 * 64 / crystal_hz) <= 1, "{crystal_hz} Hz, {measured}");
    }
    assert_eq!(measured(0, 1), None, "without a crystal nothing is captured");
}

#[test]
fn with_clock_security_a_crystal_that_stops_breaks_the_pwm_and_gives_the_internal_oscillator() {
    let mut whole = on_the_crystal(CSSON);
    let at = whole.now();
    assert!(whole.part.stop_crystal(at), "the core is to be interrupted");
    whole.pass(US);
    assert_eq!(whole.read(BDTR) & MOE, 0, "TIM1 broke");
    assert_eq!(whole.read(CIR) & CSSF, CSSF);
    assert_eq!(whole.read(RCC_CFGR) >> 2 & 3, 0, "HSI");
    assert_eq!(whole.read(RCC) & (HSERDY | PLLRDY), 0);
    assert!(!whole.part.stalled());
    whole.write(CIR, 1 << 23);
    assert_eq!(whole.read(CIR) & CSSF, 0, "CSSC clears it");
    whole.write(RCC, HSI | HSEON);
    whole.pass(100 * MS);
    assert_eq!(whole.read(RCC) & HSERDY, 0, "and the crystal does not come back");
}

#[test]
fn without_clock_security_everything_it_clocked_stands_still_and_the_watchdog_does_not() {
    let mut whole = on_the_crystal(0);
    whole.write(0x4000_3000, 0xCCCC);
    whole.pass(MS);
    let at = whole.now();
    assert!(!whole.part.stop_crystal(at), "nobody hears of it");
    whole.pass(US);
    let count = whole.read(TIM1 + 0x24);
    whole.pass(MS);
    assert_eq!(whole.read(TIM1 + 0x24), count);
    assert_eq!(whole.read(BDTR) & MOE, MOE, "the bridge is as it was");
    assert!(whole.part.stalled(), "the core has no clock");
    assert!(whole.until_reset(1_000 * MS).is_some());
}

#[test]
fn a_crystal_that_clocks_nothing_may_stop_without_harm() {
    let mut whole = with_crystal(8_000_000);
    whole.write(RCC, HSI | HSEON);
    whole.pass(MS);
    let at = whole.now();
    assert!(!whole.part.stop_crystal(at));
    assert!(!whole.part.stalled());
}
