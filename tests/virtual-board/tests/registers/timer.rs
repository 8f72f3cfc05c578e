//! Counting, update events, preload, interrupts, encoder mode: RM0090 17.3.1 to 17.3.3 and 18.3.12.

use rigless::device::{Device, Level, RequestChange};
use rigless::soc::stm32f427::peripherals::rcc::CLOCK_FAILURE;
use virtual_board::chip::timer::{Kind, Register as R, Timer};

use super::Alone;

/// One tick is a microsecond.
const HZ: u64 = 1_000_000;
const US: u64 = 1_000;

fn timer(name: &'static str, kind: Kind) -> Alone<Timer> {
    Alone::new(name, Timer::new(kind, HZ))
}

fn general() -> Alone<Timer> {
    timer("TIM3", Kind::General)
}

#[test]
fn an_upcounter_goes_from_zero_to_the_reload_value_and_flags_its_update() {
    let mut timer = general();
    timer.write(R::Arr, 9);
    timer.write(R::Cr1, 1);
    timer.pass(9 * US);
    assert_eq!((timer.read(R::Cnt), timer.read(R::Sr) & 1), (9, 0));
    timer.pass(US);
    assert_eq!((timer.read(R::Cnt), timer.read(R::Sr) & 1), (0, 1));
}

#[test]
fn a_downcounter_goes_from_the_reload_value_to_zero() {
    let mut timer = general();
    timer.write(R::Arr, 9);
    timer.write(R::Cr1, 0x10);
    timer.write(R::Egr, 1);
    timer.write(R::Sr, 0);
    timer.write(R::Cr1, 0x11);
    assert_eq!(timer.read(R::Cnt), 9);
    timer.pass(9 * US);
    assert_eq!((timer.read(R::Cnt), timer.read(R::Sr) & 1), (0, 0));
    timer.pass(US);
    assert_eq!((timer.read(R::Cnt), timer.read(R::Sr) & 1), (9, 1));
}

#[test]
fn a_centre_aligned_counter_turns_at_the_top_and_at_zero_and_updates_at_both() {
    let mut timer = general();
    timer.write(R::Arr, 5);
    timer.write(R::Cr1, 0x21);
    let mut counts = Vec::new();
    let mut downwards = Vec::new();
    let mut updates = 0;
    for _ in 0..20 {
        counts.push(timer.read(R::Cnt));
        downwards.push(timer.read(R::Cr1) & 0x10 != 0);
        updates += timer.read(R::Sr) & 1;
        timer.write(R::Sr, 0);
        timer.pass(US);
    }
    assert_eq!(counts[..12], [0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0, 1]);
    assert_eq!(counts[..10], counts[10..]);
    assert!(!downwards[4] && downwards[5] && downwards[9] && !downwards[10]);
    assert_eq!(updates, 3, "at the ticks 5, 10 and 15");
}

#[test]
fn the_prescaler_waits_for_an_update_event() {
    let mut timer = general();
    timer.write(R::Arr, 9);
    timer.write(R::Psc, 99);
    timer.write(R::Cr1, 1);
    timer.pass(10 * US);
    assert_eq!(timer.read(R::Cnt), 0, "the first period passed unscaled");
    timer.pass(100 * US);
    assert_eq!(timer.read(R::Cnt), 1);
}

#[test]
fn the_repetition_counter_makes_one_update_of_forty_half_periods() {
    let mut timer = timer("TIM1", Kind::Advanced);
    timer.write(R::Cr1, 0x20);
    timer.write(R::Arr, 25);
    timer.write(R::Rcr, 39);
    timer.write(R::Egr, 1);
    timer.write(R::Sr, 0);
    timer.write(R::Dier, 1);
    timer.write(R::Cr1, 0x21);
    timer.pass(999 * US);
    assert_eq!(timer.raised(), []);
    timer.pass(US);
    assert_eq!(timer.raised(), [(25, true)], "TIM1_UP_TIM10, after 1000 us");
    timer.write(R::Sr, !1);
    assert_eq!(timer.raised(), [(25, false)]);
    for _ in 0..100 {
        timer.pass(1000 * US);
        timer.write(R::Sr, !1);
    }
    assert_eq!(timer.raised().len(), 200, "exactly one a millisecond");
}

#[test]
fn updates_that_nobody_looked_at_for_long_come_out_as_if_somebody_had() {
    let setup = || {
        let mut timer = timer("TIM1", Kind::Advanced);
        timer.write(R::Cr1, 0x20);
        timer.write(R::Arr, 7);
        timer.write(R::Rcr, 2);
        timer.write(R::Cr1, 0x21);
        timer
    };
    let (mut seldom, mut often) = (setup(), setup());
    seldom.pass(100_003 * US);
    for _ in 0..100_003 {
        often.pass(US);
        often.read(R::Sr);
    }
    assert_eq!(seldom.read(R::Cnt), often.read(R::Cnt));
    seldom.write(R::Sr, 0);
    often.write(R::Sr, 0);
    for _ in 0..100 {
        seldom.pass(US);
        often.pass(US);
        assert_eq!(seldom.read(R::Sr), often.read(R::Sr), "the next updates come together");
    }
}

#[test]
fn preloaded_values_take_effect_at_the_update_event_and_others_at_once() {
    let mut timer = general();
    timer.write(R::Arr, 99);
    timer.write(R::Ccmr1, 0x0068); // channel 1 preloaded, channel 2 not
    timer.write(R::Cr1, 0x81);
    timer.write(R::Ccr1, 11);
    timer.write(R::Ccr2, 22);
    timer.write(R::Arr, 49);
    let active = |timer: &mut Alone<Timer>| *timer.model().counter().active();
    assert_eq!(active(&mut timer).compare[..2], [0, 22]);
    timer.pass(99 * US);
    timer.read(R::Sr);
    assert_eq!((active(&mut timer).compare[0], active(&mut timer).reload), (0, 99));
    timer.pass(US);
    timer.read(R::Sr);
    assert_eq!((active(&mut timer).compare[0], active(&mut timer).reload), (11, 49));
}

#[test]
fn a_disabled_update_moves_nothing_and_flags_nothing() {
    let mut timer = general();
    timer.write(R::Arr, 9);
    timer.write(R::Ccmr1, 0x68);
    timer.write(R::Cr1, 0x03);
    timer.write(R::Ccr1, 5);
    timer.pass(50 * US);
    assert_eq!(timer.read(R::Sr) & 1, 0);
    assert_eq!(timer.model().counter().active().compare[0], 0);
}

#[test]
fn a_generated_update_flags_unless_only_counting_may() {
    let mut timer = general();
    timer.write(R::Egr, 1);
    assert_eq!(timer.read(R::Sr) & 1, 1);
    timer.write(R::Sr, 0);
    timer.write(R::Cr1, 4); // URS
    timer.write(R::Egr, 1);
    assert_eq!(timer.read(R::Sr) & 1, 0);
}

#[test]
fn one_pulse_mode_stops_at_the_update() {
    let mut timer = general();
    timer.write(R::Arr, 9);
    timer.write(R::Cr1, 0x09);
    timer.pass(100 * US);
    assert_eq!((timer.read(R::Cr1) & 1, timer.read(R::Sr) & 1), (0, 1));
}

#[test]
fn compare_matches_flag_and_interrupt_at_their_count() {
    let mut timer = general();
    timer.write(R::Arr, 99);
    timer.write(R::Ccr1, 30);
    timer.write(R::Ccr2, 60);
    timer.write(R::Dier, 0b100); // channel 2's
    timer.write(R::Cr1, 1);
    timer.pass(59 * US);
    assert_eq!(timer.read(R::Sr) & 0b111, 0b010);
    assert_eq!(timer.raised(), []);
    timer.pass(US);
    assert_eq!(timer.raised(), [(29, true)]);
    assert_eq!(timer.read(R::Sr) & 0b111, 0b110);
}

#[test]
fn a_written_zero_clears_a_flag_and_a_written_one_does_not() {
    let mut timer = general();
    timer.write(R::Arr, 9);
    timer.write(R::Ccr1, 5);
    timer.write(R::Cr1, 1);
    timer.pass(20 * US);
    let flags = timer.read(R::Sr);
    assert_eq!(flags & 0b11, 0b11);
    timer.write(R::Sr, !1);
    assert_eq!(timer.read(R::Sr) & 0b11, 0b10);
}

#[test]
fn a_stopped_counter_keeps_its_count_and_goes_on_from_there() {
    let mut timer = general();
    timer.write(R::Arr, 99);
    timer.write(R::Cr1, 1);
    timer.pass(40 * US);
    timer.write(R::Cr1, 0);
    timer.pass(500 * US);
    assert_eq!(timer.read(R::Cnt), 40);
    timer.write(R::Cr1, 1);
    timer.pass(5 * US);
    assert_eq!(timer.read(R::Cnt), 45);
}

/// Encoder mode 3 on both channels, with the input filter that counts for nothing here.
fn encoder(ccer: u64, slave: u64) -> Alone<Timer> {
    let mut timer = general();
    timer.write(R::Ccmr1, 0xF1F1);
    timer.write(R::Ccer, ccer);
    timer.write(R::Smcr, slave);
    timer.write(R::Arr, 0xFFFF);
    timer.write(R::Cr1, 1);
    timer
}

fn turn(timer: &mut Alone<Timer>, edges: i64) {
    timer.drive(|timer, registers, context| timer.turn(edges, registers, context));
}

#[test]
fn an_encoder_counts_every_edge_both_ways_and_shows_the_direction() {
    let mut timer = encoder(0, 3);
    turn(&mut timer, 5);
    assert_eq!((timer.read(R::Cnt), timer.read(R::Cr1) & 0x10), (5, 0));
    turn(&mut timer, -8);
    assert_eq!((timer.read(R::Cnt), timer.read(R::Cr1) & 0x10), (0xFFFD, 0x10));
    assert_eq!(timer.read(R::Sr) & 1, 1, "past zero is an update");
}

#[test]
fn an_inverted_channel_reverses_the_encoder_and_two_do_not() {
    let mut one = encoder(0x02, 3);
    turn(&mut one, 4);
    assert_eq!(one.read(R::Cnt), 0xFFFC);
    let mut both = encoder(0x22, 3);
    turn(&mut both, 4);
    assert_eq!(both.read(R::Cnt), 4);
}

#[test]
fn an_encoder_on_one_channel_alone_counts_half_the_edges() {
    let mut timer = encoder(0, 1);
    turn(&mut timer, 40);
    assert_eq!(timer.read(R::Cnt), 20);
}

#[test]
fn a_shaft_turns_nothing_while_the_counter_is_off_or_counts_time() {
    let mut timer = encoder(0, 3);
    timer.write(R::Cr1, 0);
    turn(&mut timer, 9);
    assert_eq!(timer.read(R::Cnt), 0);
    timer.write(R::Smcr, 0);
    timer.write(R::Cr1, 1);
    turn(&mut timer, 9);
    assert_eq!(timer.read(R::Cnt), 0);
}

#[test]
fn a_register_the_timer_has_not_is_told() {
    let mut basic = timer("TIM6", Kind::Basic);
    basic.write(R::Ccr1, 1);
    assert_eq!(basic.told(), ["this timer has no such register"]);
    let mut narrow = timer("TIM12", Kind::TwoChannels);
    narrow.read(R::Bdtr);
    assert_eq!(narrow.told().len(), 1);
}

#[test]
fn what_is_not_modelled_is_told() {
    let mut slave = general();
    slave.write(R::Smcr, 4);
    assert_eq!(slave.told().len(), 1);
    let mut capture = general();
    capture.write(R::Ccmr1, 1);
    capture.read(R::Ccr1);
    assert_eq!(capture.told(), ["input capture is not modelled"]);
    let mut requests = general();
    requests.write(R::Dier, 1 << 8);
    assert_eq!(requests.told().len(), 1);
}

#[test]
fn a_change_of_clock_keeps_the_count() {
    let mut timer = general();
    timer.write(R::Arr, 0xFFFF);
    timer.write(R::Cr1, 1);
    timer.pass(100 * US);
    timer.drive(|timer, registers, context| {
        rigless::device::Device::on_clock(timer, 2 * HZ, registers, context);
    });
    assert_eq!(timer.read(R::Cnt), 100);
    timer.pass(50 * US);
    assert_eq!(timer.read(R::Cnt), 200);
}

#[test]
fn the_break_input_waits_for_its_enable_and_its_polarity() {
    let mut timer = timer("TIM1", Kind::Advanced);
    let set = |timer: &mut Alone<Timer>, high: bool| {
        let level = Some(Level::from(high));
        timer.drive(|timer, registers, context| timer.set_break_input(level, registers, context));
    };
    timer.write(R::Bdtr, 1 << 15);
    set(&mut timer, true);
    assert_ne!(timer.held(R::Bdtr) & 1 << 15, 0, "not enabled");
    set(&mut timer, false);
    timer.write(R::Dier, 1 << 7);
    timer.write(R::Bdtr, 0b1011 << 12); // MOE, BKP high, BKE
    set(&mut timer, true);
    assert_eq!(timer.held(R::Bdtr) & 1 << 15, 0, "MOE off at once");
    assert_eq!(timer.read(R::Sr) & 1 << 7, 1 << 7);
    assert_eq!(timer.raised(), [(24, true)], "TIM1_BRK_TIM9");
    timer.write(R::Bdtr, 0b1011 << 12);
    assert_eq!(timer.held(R::Bdtr) & 1 << 15, 0, "MOE cannot be set while the break stands");
    set(&mut timer, false);
    assert_eq!(timer.held(R::Bdtr) & 1 << 15, 0, "and does not come back by itself");
    timer.write(R::Bdtr, 0b1011 << 12);
    assert_ne!(timer.held(R::Bdtr) & 1 << 15, 0, "but by being set again");
}

#[test]
fn a_failing_crystal_breaks_too() {
    let mut timer = timer("TIM1", Kind::Advanced);
    timer.write(R::Bdtr, 1 << 15 | 1 << 12);
    let request = CLOCK_FAILURE;
    timer.drive(|timer, registers, context| {
        timer.on_request(RequestChange { instance: "RCC", request, level: Level::High }, registers, context);
    });
    assert_eq!(timer.held(R::Bdtr) & 1 << 15, 0);
    assert_eq!(timer.read(R::Sr) & 1 << 7, 1 << 7);
}

#[test]
fn with_automatic_output_the_next_update_brings_the_output_back() {
    let mut timer = timer("TIM1", Kind::Advanced);
    timer.write(R::Arr, 9);
    timer.write(R::Bdtr, 0b1111 << 12);
    timer.write(R::Cr1, 1);
    for (high, expected) in [(true, 0), (false, 1 << 15)] {
        let level = Some(Level::from(high));
        timer.drive(|timer, registers, context| timer.set_break_input(level, registers, context));
        timer.pass(10 * US);
        timer.read(R::Sr);
        assert_eq!(timer.held(R::Bdtr) & 1 << 15, expected);
    }
}

#[test]
fn a_lock_keeps_the_break_configuration_until_reset() {
    let mut timer = timer("TIM1", Kind::Advanced);
    timer.write(R::Bdtr, 0b11 << 12 | 1 << 8 | 42);
    timer.write(R::Bdtr, 1 << 15);
    assert_eq!(timer.held(R::Bdtr), 0b1011 << 12 | 1 << 8 | 42);
}
