//! What the channels put on their pins: RM0090 17.3.9 to 17.3.13 and table 96.

use virtual_board::chip::timer::{Drive, Kind, Register as R, Side, Timer, dead_time_ticks};

use super::Alone;

const MOE: u64 = 1 << 15;

/// TIM1 at 20 kHz, centre-aligned, channel 1 in PWM mode 1 with both outputs.
fn bridge(compare: u64) -> Alone<Timer> {
    let mut timer = Alone::new("TIM1", Timer::new(Kind::Advanced, 168_000_000));
    timer.write(R::Cr1, 0x20);
    timer.write(R::Arr, 4200);
    timer.write(R::Ccmr1, 0x68);
    timer.write(R::Ccr1, compare);
    timer.write(R::Ccer, 0b0101);
    timer.write(R::Egr, 1);
    timer.write(R::Bdtr, MOE);
    timer.write(R::Cr1, 0x21);
    timer
}

fn drives(timer: &mut Alone<Timer>) -> [Drive; 2] {
    timer.drive(|timer, registers, _| {
        [Side::Main, Side::Complement].map(|side| timer.output(registers, 0, side))
    })
}

fn pulses(high: u64) -> Drive {
    Drive::Pulses { high, period: 8400 }
}

#[test]
fn centre_aligned_pulses_are_twice_the_compare_value_of_twice_the_reload_value() {
    assert_eq!(drives(&mut bridge(1000)), [pulses(2000), pulses(6400)]);
}

#[test]
fn nothing_and_everything_are_steady_levels() {
    assert_eq!(drives(&mut bridge(0)), [Drive::Low, Drive::High]);
    assert_eq!(drives(&mut bridge(4200)), [Drive::High, Drive::Low]);
    assert_eq!(drives(&mut bridge(5000)), [Drive::High, Drive::Low]);
}

#[test]
fn the_dead_time_comes_off_both_sides() {
    let mut timer = bridge(1000);
    timer.write(R::Bdtr, MOE | 100);
    assert_eq!(drives(&mut timer), [pulses(1900), pulses(6300)]);
}

#[test]
fn a_pulse_shorter_than_the_dead_time_does_not_come() {
    let mut timer = bridge(40);
    timer.write(R::Bdtr, MOE | 100);
    assert_eq!(drives(&mut timer), [Drive::Low, pulses(8220)]);
}

#[test]
fn the_dead_time_generator_has_four_ranges() {
    // 17.4.18: DTG, and the time in tDTS.
    for (generator, steps) in
        [(0, 0), (127, 127), (0x80, 128), (0xBF, 254), (0xC0, 256), (0xDF, 504), (0xE0, 512), (0xFF, 1008)]
    {
        let mut timer = bridge(1000);
        timer.write(R::Bdtr, MOE | generator);
        assert_eq!(timer.drive(|_, registers, _| dead_time_ticks(registers)), steps);
    }
}

#[test]
fn with_the_main_output_off_the_pins_are_released_or_idle_as_chosen() {
    let mut timer = bridge(1000);
    timer.write(R::Bdtr, 0);
    assert_eq!(drives(&mut timer), [Drive::Released; 2]);
    timer.write(R::Bdtr, 1 << 10); // OSSI
    assert_eq!(drives(&mut timer), [Drive::Low; 2]);
    timer.write(R::Cr2, 1 << 9); // OIS1N
    assert_eq!(drives(&mut timer), [Drive::Low, Drive::High]);
}

#[test]
fn an_output_alone_follows_the_reference_and_the_other_is_released_or_off() {
    let mut timer = bridge(1000);
    timer.write(R::Ccer, 0b0100);
    assert_eq!(drives(&mut timer), [Drive::Released, pulses(2000)]);
    timer.write(R::Bdtr, MOE | 1 << 11); // OSSR
    assert_eq!(drives(&mut timer), [Drive::Low, pulses(2000)]);
}

#[test]
fn polarity_and_the_second_mode_invert() {
    let mut timer = bridge(1000);
    timer.write(R::Ccer, 0b0111);
    assert_eq!(drives(&mut timer), [pulses(6400), pulses(6400)]);
    timer.write(R::Ccer, 0b0001);
    timer.write(R::Ccmr1, 0x78);
    assert_eq!(drives(&mut timer)[0], pulses(6400));
}

#[test]
fn forced_levels_hold() {
    let mut timer = bridge(1000);
    timer.write(R::Ccmr1, 0x58);
    assert_eq!(drives(&mut timer), [Drive::High, Drive::Low]);
    timer.write(R::Ccmr1, 0x48);
    assert_eq!(drives(&mut timer), [Drive::Low, Drive::High]);
}

#[test]
fn edge_aligned_pulses_are_the_compare_value_of_one_more_than_the_reload_value() {
    let mut timer = Alone::new("TIM3", Timer::new(Kind::General, 84_000_000));
    timer.write(R::Arr, 999);
    timer.write(R::Ccmr1, 0x60);
    timer.write(R::Ccr1, 250);
    timer.write(R::Ccer, 1);
    timer.write(R::Egr, 1);
    timer.write(R::Cr1, 1);
    let pulses = Drive::Pulses { high: 250, period: 1000 };
    assert_eq!(drives(&mut timer)[0], pulses);
    assert_eq!(pulses.share_high(), Some(0.25));
}

#[test]
fn a_match_mode_that_is_switched_on_is_told() {
    let mut timer = bridge(1000);
    timer.write(R::Ccmr1, 0x38);
    assert_eq!(timer.told(), ["the match and toggle output modes are not modelled"]);
}
