//! ST Nucleo-F446RE: the ST-LINK feeds its 8 MHz in, and its serial port is at PA2 and PA3.

use super::{Board, Button, Clocks, Source};
use twinrotor::board;

/// This board.
pub(crate) const BOARD: Board = Board {
    known: &board::NUCLEO_F446,
    probe_chip: "STM32F446RETx",
    // 168 MHz core, 42 and 84 MHz buses, 84 and 168 MHz timers.
    clocks: Clocks {
        source: Source::External,
        source_hz: 8_000_000,
        divide: 4,
        multiply: 168,
        post_divide: 2,
        apb1_divide: 4,
        apb2_divide: 2,
    },
    dead_time_ns: 500,
    // 3.3 V behind 100 k and 10 k ohm.
    supply_channel: 10,
    supply_full_scale: 3.3 * 11.0,
    button: Some(Button { pin: "PC13", pressed_high: false }),
    lit_high: true,
    wiring: WIRING,
};

wiring! {
    pitch_timer: TIM2, yaw_timer: TIM3,
    pwm_timer: TIM1 (TIM1_UP_TIM10), main_output: CH1,
    serial: USART2,
    serial_out_dma: DMA1_CH6 (DMA1_STREAM6), serial_in_dma: DMA1_CH5,
    serial_out: PA2, serial_in: PA3,
    pitch_a: PA0, pitch_b: PA1,
    yaw_a: PC6, yaw_b: PC7,
    main: PA8, main_complement: PB13,
    tail: PA9, tail_complement: PB14,
    enable: PC8,
    current_limit: PC3,
    supply: PC0,
    led: PA5;
    emergency_stop: PB12 (EXTI15_10),
    main_reverse: PA10, tail_reverse: PA11,
}
