//! What a debugger does to a part: DDI 0403E.b C1.6.5 and C1.8.8, RM0090 38.16.

use rigless::device::ResetCause;
use virtual_board::chip::Settings;
use virtual_board::chip::timer::{Drive, Side};

use super::whole::{MS, US, Whole};

const DHCSR: u64 = 0xE000_EDF0;
const DEMCR: u64 = 0xE000_EDFC;
const TRCENA: u64 = 1 << 24;
const DWT_CTRL: u64 = 0xE000_1000;
const CYCCNT: u64 = 0xE000_1004;
const APB1_FZ: u64 = 0xE004_2008;
const APB2_FZ: u64 = 0xE004_200C;
const TIM1: u64 = 0x4001_0000;
const TIM1_CNT: u64 = TIM1 + 0x24;
const IWDG_KR: u64 = 0x4000_3000;

#[test]
fn the_cycle_counter_counts_only_while_trcena_is_set() {
    let mut whole = Whole::new(Settings::default());
    whole.write(DWT_CTRL, 1);
    whole.pass(US);
    assert_eq!(whole.read(CYCCNT), 0);
    whole.write(DEMCR, TRCENA);
    whole.pass(US);
    assert_eq!(whole.read(CYCCNT), 16);
    whole.write(DEMCR, 0);
    whole.pass(MS);
    assert_eq!(whole.read(CYCCNT), 16, "what it had counted stands");
    whole.write(DEMCR, TRCENA);
    whole.pass(US);
    assert_eq!(whole.read(CYCCNT), 32);
}

#[test]
fn trcena_outlasts_a_reset_of_the_core_but_not_of_the_supply() {
    for (cause, kept) in [(ResetCause::Core, TRCENA), (ResetCause::Pin, TRCENA), (ResetCause::PowerOn, 0)] {
        let mut whole = Whole::new(Settings::default());
        whole.write(DEMCR, TRCENA);
        whole.restart(cause);
        assert_eq!(whole.read(DEMCR), kept, "{cause:?}");
        whole.write(DWT_CTRL, 1);
        whole.pass(US);
        assert_eq!(whole.read(CYCCNT) > 0, kept != 0, "{cause:?}");
    }
}

#[test]
fn a_firmware_can_read_that_a_debugger_is_attached_but_not_write_it() {
    let mut whole = Whole::new(Settings::default());
    whole.write(DHCSR, 0xA05F_0001);
    assert_eq!(whole.read(DHCSR), 0);
    let at = whole.now();
    whole.part.freeze(at);
    assert_eq!(whole.read(DHCSR) & (1 | 1 << 17), 1 | 1 << 17);
    whole.part.thaw(at);
    assert_eq!(whole.read(DHCSR) & (1 | 1 << 17), 1);
}

#[test]
fn a_halt_stops_the_timer_that_is_to_stop_and_a_leg_as_it_was() {
    for stops in [false, true] {
        let mut whole = Whole::new(Settings::default());
        whole.write(APB2_FZ, u64::from(stops));
        whole.write(TIM1 + 0x2C, 999);
        whole.write(TIM1 + 0x18, 0x60);
        whole.write(TIM1 + 0x34, 500);
        whole.write(TIM1 + 0x20, 1);
        whole.write(TIM1 + 0x44, 1 << 15);
        whole.write(TIM1 + 0x14, 1);
        whole.write(TIM1, 1);
        // Of 1,000 counts the leg is high for the first 500.
        for (count, leg) in [(160, Drive::High), (800, Drive::Low)] {
            let passed = if count == 160 { 10 * US } else { 40 * US };
            whole.pass(passed);
            let at = whole.now();
            assert_eq!(whole.read(TIM1_CNT), count);
            whole.part.freeze(at);
            let driven = whole.part.timer_output(at, 0, 0, Side::Main);
            let pulses = Drive::Pulses { high: 500, period: 1000 };
            assert_eq!(driven, if stops { leg } else { pulses });
            // A whole number of periods, so that a timer that goes on comes round to the same count.
            whole.pass(1_000 * 125 * US / 2 + if stops { 7 * US } else { 0 });
            assert_eq!(whole.read(TIM1_CNT), count, "stops: {stops}");
            let at = whole.now();
            whole.part.thaw(at);
        }
    }
}

#[test]
fn a_halt_stops_the_watchdog_only_where_asked() {
    for (freeze, resets) in [(0, true), (1 << 12, false)] {
        let mut whole = Whole::new(Settings::default());
        whole.write(APB1_FZ, freeze);
        whole.write(IWDG_KR, 0xCCCC);
        whole.pass(MS);
        let at = whole.now();
        whole.part.freeze(at);
        assert_eq!(whole.until_reset(2_000 * MS).is_some(), resets);
        if !resets {
            let at = whole.now();
            whole.part.thaw(at);
            assert!(whole.until_reset(600 * MS).is_some(), "it goes on where it stood");
        }
    }
}
