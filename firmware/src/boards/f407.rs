//! ST STM32F4-Discovery: an STM32F407VG with an 8 MHz crystal, at 3.0 V. Its codec, microphone, USB
//! connector, accelerometer and button have pins of their own (UM1472, table 7); these are free, but for PB3,
//! whose trace output to the ST-LINK is given up. The LED is its green one.

use super::{Board, Button, Clocks, Source};
use twinrotor::board;

/// This board.
pub(crate) const BOARD: Board = Board {
    known: &board::F407,
    probe_chip: "STM32F407VGTx",
    // 168 MHz core, 42 and 84 MHz buses, 84 and 168 MHz timers.
    clocks: Clocks {
        source: Source::Crystal,
        source_hz: 8_000_000,
        divide: 4,
        multiply: 168,
        post_divide: 2,
        apb1_divide: 4,
        apb2_divide: 2,
    },
    dead_time_ns: 500,
    // 100 k and 10 k ohm, seen from 3.3 V; the chip at 3.0 V measures up to 33 V of it.
    supply_channel: 11,
    supply_full_scale: 3.3 * 11.0,
    button: Some(Button { pin: "PA0", pressed_high: true }),
    lit_high: true,
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
    main: PE9, main_complement: PE8,
    tail: PE11, tail_complement: PE10,
    enable: PD10,
    current_limit: PD11,
    supply: PC1,
    led: PD12;
    emergency_stop: PB12 (EXTI15_10),
    main_reverse: PE13, tail_reverse: PE14,
}
