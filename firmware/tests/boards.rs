//! The boards' files, read as data: clocks, pins and names that fit each other, the host and the documents.

#[path = "../src/boards/mod.rs"]
mod boards;

use boards::{Board, INTERNAL_HZ, Pin, Source, Stream};
use boards::{black_pill, f405, f407, feather_f405, nucleo_f411, nucleo_f446, nucleo_g474};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use twinrotor::plant::presets;

const ALL: [Board; 7] = [
    f405::BOARD,
    feather_f405::BOARD,
    f407::BOARD,
    black_pill::BOARD,
    nucleo_f411::BOARD,
    nucleo_f446::BOARD,
    nucleo_g474::BOARD,
];

/// Its chip is an STM32G4.
fn is_g4(board: &Board) -> bool {
    board.known.chip.starts_with("stm32g4")
}

/// \[Hz\] Into the PLL, and within it: RM0090, 7.3.2 (192 MHz at least on early chips); RM0440, 7.4.4 and
/// datasheet DS12288, table 42.
fn pll_limits(board: &Board) -> [std::ops::RangeInclusive<u32>; 2] {
    if is_g4(board) {
        [2_660_000..=16_000_000, 96_000_000..=344_000_000]
    } else {
        [1_000_000..=2_000_000, 192_000_000..=432_000_000]
    }
}

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path))
        .expect("a file of the tree")
}

/// Signal and pin, for every pin.
fn pins(board: &Board) -> Vec<(&'static str, &'static str)> {
    let w = &board.wiring;
    let reverse = w.reverse.map(|[main, tail]| [("main reverse", main), ("tail reverse", tail)]);
    let always = [
        ("serial out", w.serial_out),
        ("serial in", w.serial_in),
        ("pitch A", w.pitch_a),
        ("pitch B", w.pitch_b),
        ("yaw A", w.yaw_a),
        ("yaw B", w.yaw_b),
        ("main", w.main),
        ("main's complement", w.main_complement),
        ("tail", w.tail),
        ("tail's complement", w.tail_complement),
        ("enable", w.enable),
        ("emergency stop", w.emergency_stop),
        ("current limit", w.current_limit),
        ("supply", w.supply),
        ("LED", w.led),
    ];
    always.into_iter().chain(reverse.into_iter().flatten()).collect()
}

/// STM32F405 and F446 datasheets: 168 (180) MHz core, 42 (45) and 84 (90) MHz buses; F411: 100, 50 and 100
/// MHz; G474: 170 MHz, all.
#[test]
fn clocks_are_whole_and_within_the_chips_limits() {
    for board in ALL {
        let (name, c) = (board.known.name, &board.clocks);
        let input = c.source_hz / u32::from(c.divide);
        let inside = input * u32::from(c.multiply);
        let [into, within] = pll_limits(&board);
        assert!(into.contains(&input), "{name}: {input} Hz into the PLL");
        assert!(within.contains(&inside), "{name}: {inside} Hz in the PLL");
        assert_eq!(input * u32::from(c.divide), c.source_hz, "{name}");
        assert!(
            [2, 4, 6, 8].contains(&c.post_divide) && inside.is_multiple_of(c.post_divide.into()),
            "{name}"
        );
        let [core, slow, fast] = match &board.known.chip[..9] {
            "stm32f411" => [100_000_000, 50_000_000, 100_000_000],
            "stm32g474" => [170_000_000; 3],
            _ => [168_000_000, 42_000_000, 84_000_000],
        };
        assert!(c.core_hz() <= core && c.core_hz().is_multiple_of(1_000_000), "{name}");
        assert!(c.core_hz() / u32::from(c.apb1_divide) <= slow, "{name}");
        assert!(c.core_hz() / u32::from(c.apb2_divide) <= fast, "{name}");
    }
}

#[test]
fn without_its_crystal_a_board_is_as_fast_and_the_stopwatch_counts_whole_cycles() {
    for board in ALL {
        let (name, c) = (board.known.name, &board.clocks);
        let input = INTERNAL_HZ / u32::from(c.fallback_divide());
        assert!(pll_limits(&board)[0].contains(&input), "{name}: {input} Hz into the PLL");
        assert_eq!(input * u32::from(c.multiply) / u32::from(c.post_divide), c.core_hz(), "{name}");
        assert!(c.slow_timer_hz().is_multiple_of(1_000), "{name}");
        assert!(c.core_hz().is_multiple_of(c.slow_timer_hz()), "{name}");
    }
}

/// RM0090, table 42: USART2's receiver is DMA1's stream 5, USART3's stream 1. A G474 has no such table, and
/// channels from 1 on.
#[test]
fn the_serial_ports_stream_is_its_own() {
    for board in ALL {
        let feather = board.known.name == "feather-f405";
        let (serial, number) = if feather { ("USART3", 1) } else { ("USART2", 5) };
        assert_eq!(board.wiring.serial, serial, "{}", board.known.name);
        assert_eq!(Stream::named(board.wiring.serial_in_dma), Stream { controller: 1, number });
    }
}

#[test]
fn a_nucleo_f4_is_fed_and_the_others_have_a_crystal() {
    for board in ALL {
        // UM1724, 6.7.1; UM2505, 7.9: the G474's has a crystal.
        let fed = board.known.name.starts_with("nucleo-f4");
        assert_eq!(board.clocks.source == Source::External, fed, "{}", board.known.name);
    }
}

#[test]
fn the_pwm_is_what_the_host_simulates() {
    for board in ALL {
        assert_eq!(u32::from(board.pwm_top()), 2 * board.full_steps(), "{}", board.known.name);
        assert_eq!(board.clocks.pwm_timer_hz(), board.known.pwm_timer_hz, "{}", board.known.name);
        assert_eq!(board.full_steps(), board.known.pwm_steps(), "{}", board.known.name);
        let timer_hz = f64::from(board.clocks.pwm_timer_hz());
        let dead_time = f64::from(board.dead_time()) / timer_hz * 1e9;
        assert!(
            (dead_time - f64::from(board.dead_time_ns)).abs() < 1e9 / timer_hz,
            "{}: {dead_time} ns",
            board.known.name
        );
    }
}

#[test]
fn every_pin_has_one_signal_and_no_probe_on_it() {
    for board in ALL {
        let pins = pins(&board);
        let places: BTreeSet<_> =
            pins.iter().map(|&(_, pin)| (Pin::named(pin).port, Pin::named(pin).number)).collect();
        assert_eq!(places.len(), pins.len(), "{}: two signals on one pin", board.known.name);
        for taken in ["PA13", "PA14"] {
            let probe = Pin::named(taken);
            assert!(
                !places.contains(&(probe.port, probe.number)),
                "{}: {taken} is the probe's",
                board.known.name
            );
        }
        // STM32F4 datasheets: ADC1's channels 0 to 7 are PA0 to PA7, 8 and 9 PB0 and PB1, 10 to 15 PC0 to
        // PC5; G474: 6 to 9 are PC0 to PC3.
        let supply = Pin::named(board.wiring.supply);
        let first = if is_g4(&board) { [1, 20, 6] } else { [0, 8, 10] };
        let channel = supply.number + first[usize::from(supply.port)];
        assert_eq!(channel, board.supply_channel, "{}", board.known.name);
    }
}

/// STM32F411xC/E datasheet DS10314, table 8, the package of 48 pins: all of port A, B without 2 (BOOT1) and
/// 11, C from 13 on. PA12 is USB's. A compiler for the F411RE would take more.
#[test]
fn the_black_pill_has_the_pins_that_it_uses() {
    for (signal, pin) in pins(&black_pill::BOARD) {
        let Pin { port, number } = Pin::named(pin);
        let has = match port {
            0 => number != 12,
            1 => number != 2 && number != 11,
            2 => number >= 13,
            _ => false,
        };
        assert!(has, "{signal}: {pin}");
    }
}

/// The pins at the two headers of Adafruit's Feather STM32F405 Express, its pinout, and its LED.
#[test]
fn the_feather_leads_out_the_pins_that_it_uses() {
    const LED_OUT: [&str; 22] = [
        "PA4", "PA5", "PA6", "PA7", "PC4", "PC5", "PB13", "PB15", "PB14", "PB11", "PB10", "PB7", "PB6",
        "PC7", "PC6", "PB8", "PB9", "PC3", "PC2", "PC1", "PA13", "PA14",
    ];
    let used = pins(&feather_f405::BOARD);
    assert_eq!(used.len(), 15, "all but those of sign and magnitude");
    for (signal, pin) in used {
        assert!(LED_OUT.contains(&pin), "{signal}: {pin}");
    }
}

/// STM32F40x datasheet DS8626, table 9: where the PWM's timer comes out, and its break input. The compiler
/// knows a pin's functions by its type; what is looked at here is that one timer has them all.
#[test]
fn the_pwm_and_its_break_input_are_one_timers() {
    for Board { known: twinrotor::board::Board { name, .. }, wiring: w, .. } in &ALL {
        let (timer, output) = if *name == "feather-f405" { ("TIM8", "CH3N") } else { ("TIM1", "CH1") };
        assert_eq!((w.pwm_timer, w.main_output), (timer, output), "{name}");
        assert_eq!(w.main_is_mirrored(), output == "CH3N", "{name}");
        assert_eq!(w.reverse.is_some(), output == "CH1", "{name}: channels 3 and 4");
        let stop = if timer == "TIM8" { "PA6" } else { "PB12" };
        assert_eq!(w.emergency_stop, stop, "{name}");
    }
}

/// What ends the words of a command: an image lies in a folder of its own; lints, which leave no image, share
/// what they are compiled from.
fn folder(alias: &str, image: &str) -> String {
    if alias == "fw-clippy" { String::new() } else { format!(" --target-dir target/{image}") }
}

#[test]
fn cargo_has_a_command_to_build_lint_and_program_each() {
    let config = read(".cargo/config.toml");
    let words: Vec<&str> = config.split_whitespace().collect();
    let config = words.join(" ");
    assert!(
        config.contains(&format!("PROBE_RS_CHIP = \"{}\"", f405::BOARD.probe_chip)),
        "cargo fw-run's chip"
    );
    for board in ALL.iter().skip(1) {
        let Board { known: twinrotor::board::Board { name, .. }, probe_chip, .. } = board;
        for alias in ["fw", "fw-run", "fw-clippy"] {
            let (_, line) = config.split_once(&format!("{alias}-{name} = ")).expect("an alias for the board");
            let line = line.split("\"\"\"").nth(1).expect("its words");
            assert!(
                line.contains(&format!("--no-default-features --features {name}{}", folder(alias, name))),
                "{alias}-{name}: {line}"
            );
            let programs = line.contains(&format!("--config env.PROBE_RS_CHIP='{probe_chip}'"));
            assert_eq!(programs, alias == "fw-run", "{alias}-{name}: {line}");
        }
    }
}

#[test]
fn the_wiring_table_has_every_pin() {
    let document = read("docs/wiring.md");
    for board in ALL {
        for (signal, pin) in pins(&board) {
            assert!(document.contains(pin), "{}: docs/wiring.md lacks {pin}, {signal}", board.known.name);
        }
    }
}

/// RM0090, 18.3.12: TIM2 to TIM5 count encoders. TIM1 or TIM8 has the PWM, TIM12 the program's time.
#[test]
fn every_peripheral_has_one_use() {
    for Board { known: twinrotor::board::Board { name, .. }, wiring: w, .. } in &ALL {
        let encoders = ["TIM2", "TIM3", "TIM4", "TIM5"];
        assert!(encoders.contains(&w.pitch_timer) && encoders.contains(&w.yaw_timer), "{name}");
        assert_ne!(w.pitch_timer, w.yaw_timer, "{name}");
        assert!(w.serial.starts_with("USART"), "{name}: {}", w.serial);
        assert_ne!(w.serial_out_dma, w.serial_in_dma, "{name}");
    }
}

#[test]
fn the_chip_told_is_the_chip_programmed() {
    for Board { known: twinrotor::board::Board { name, chip, .. }, probe_chip, .. } in &ALL {
        assert!(probe_chip.to_lowercase().starts_with(chip), "{name}: {chip}, {probe_chip}");
    }
}

/// A supply beyond the converter's range would read as one within.
#[test]
fn the_converter_sees_more_than_any_rig_may_have() {
    for board in ALL {
        for (preset, rig) in presets::ALL {
            let most = rig.volts_limit.main.max(rig.volts_limit.tail);
            assert!(
                f64::from(board.supply_full_scale) > 1.25 * most,
                "{}, {preset}: {most} V",
                board.known.name
            );
        }
    }
}

/// A board that computes its rig is built, linted and programmed by the same three words, with `-sim`.
#[test]
fn cargo_has_the_same_commands_for_a_simulated_rig() {
    let config = read(".cargo/config.toml");
    let words: Vec<&str> = config.split_whitespace().collect();
    let config = words.join(" ");
    for (board, features) in [
        (f405::BOARD, "simulated"),
        (feather_f405::BOARD, "feather-f405,simulated"),
        (black_pill::BOARD, "black-pill,simulated"),
        (nucleo_f411::BOARD, "nucleo-f411,simulated"),
        (nucleo_f446::BOARD, "nucleo-f446,simulated"),
        (nucleo_g474::BOARD, "nucleo-g474,simulated"),
    ] {
        let Board { known: twinrotor::board::Board { name, .. }, probe_chip, .. } = board;
        for alias in ["fw", "fw-run", "fw-clippy"] {
            let (_, line) = config.split_once(&format!("{alias}-{name}-sim = ")).expect("an alias");
            let line = line.split("\"\"\"").nth(1).expect("its words");
            assert!(
                line.contains(&format!("--features {features}{}", folder(alias, &format!("{name}-sim")))),
                "{alias}-{name}-sim: {line}"
            );
            // The f405's chip is the one that is programmed without a word.
            let programs = line.contains(&format!("--config env.PROBE_RS_CHIP='{probe_chip}'"));
            assert_eq!(
                programs,
                alias == "fw-run" && *name != f405::BOARD.known.name,
                "{alias}-{name}-sim: {line}"
            );
        }
    }
}

/// UM1724, 6.4; UM1472, 6.3; the Black Pill's schematic, on which the LED's other end is at 3.3 V.
#[test]
fn an_led_is_lit_as_its_board_has_it() {
    for board in ALL {
        assert_eq!(board.lit_high, board.known.name != "black-pill", "{}", board.known.name);
    }
}

/// UM1724 (Nucleo-64), 6.6: B1 pulls PC13 to ground. MB1367 (Nucleo-G474RE): it puts VDD on it. UM1472
/// (F4-Discovery), 6.4: B1 puts VDD on PA0. The Black Pill's schematic: KEY pulls PA0 to ground.
#[test]
fn a_button_is_on_a_pin_of_a_port_that_all_chips_have() {
    for board in ALL {
        let Some(button) = board.button else { continue };
        let pin = Pin::named(button.pin);
        assert!(pin.port < 4, "{}: {}", board.known.name, button.pin);
        let high = ["f407", "nucleo-g474"].contains(&board.known.name);
        assert_eq!(button.pressed_high, high, "{}", board.known.name);
        let w = &board.wiring;
        assert!(![w.serial_out, w.serial_in, w.led, w.enable].contains(&button.pin), "{}", board.known.name);
    }
}
