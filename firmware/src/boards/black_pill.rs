//! WeAct Black Pill: an STM32F411CE in its package of 48 pins, with a 25 MHz crystal. Its key, which no
//! resistor holds, is at PA0, its LED at PC13 is lit by a low level, and PA11 and PA12 are its USB
//! connector's. The chip is the Nucleo's as far as a program goes, and is compiled as that one.

use super::{Board, Button, Clocks, Source};
use twinrotor::board;

/// This board.
pub(crate) const BOARD: Board = Board {
    known: &board::BLACK_PILL,
    probe_chip: "STM32F411CEUx",
    // 100 MHz core, 50 and 100 MHz buses, 100 MHz timers.
    clocks: Clocks {
        source: Source::Crystal,
        source_hz: 25_000_000,
        divide: 25,
        multiply: 200,
        post_divide: 2,
        apb1_divide: 2,
        apb2_divide: 1,
    },
    dead_time_ns: 500,
    // 3.3 V behind 100 k and 10 k ohm.
    supply_channel: 4,
    supply_full_scale: 3.3 * 11.0,
    button: Some(Button { pin: "PA0", pressed_high: false }),
    lit_high: false,
    wiring: WIRING,
};

wiring! {
    pitch_timer: TIM2, yaw_timer: TIM3,
    pwm_timer: TIM1 (TIM1_UP_TIM10), main_output: CH1,
    serial: USART2,
    serial_out_dma: DMA1_CH6 (DMA1_STREAM6), serial_in_dma: DMA1_CH5,
    serial_out: PA2, serial_in: PA3,
    pitch_a: PA15, pitch_b: PB3,
    yaw_a: PB4, yaw_b: PB5,
    main: PA8, main_complement: PB13,
    tail: PA9, tail_complement: PB14,
    enable: PB1,
    current_limit: PB10,
    supply: PA4,
    led: PC13;
    emergency_stop: PB12 (EXTI15_10),
    main_reverse: PA10, tail_reverse: PA11,
}
