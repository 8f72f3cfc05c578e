//! ST Nucleo-G474RE: a 24 MHz crystal, and the ST-LINK's serial port at PA2 and PA3. It is wired as the other
//! Nucleo boards are. This board has been compiled, and has run nowhere.

use super::{Board, Button, Clocks, Source};
use twinrotor::board;

/// This board.
pub(crate) const BOARD: Board = Board {
    known: &board::NUCLEO_G474,
    probe_chip: "STM32G474RETx",
    // 170 MHz core, buses and timers.
    clocks: Clocks {
        source: Source::Crystal,
        source_hz: 24_000_000,
        divide: 6,
        multiply: 85,
        post_divide: 2,
        apb1_divide: 1,
        apb2_divide: 1,
    },
    dead_time_ns: 500,
    // 3.3 V behind 100 k and 10 k ohm.
    supply_channel: 6,
    supply_full_scale: 3.3 * 11.0,
    button: Some(Button { pin: "PC13", pressed_high: true }),
    lit_high: true,
    wiring: WIRING,
};

wiring! {
    pitch_timer: TIM2, yaw_timer: TIM3,
    pwm_timer: TIM1 (TIM1_UP_TIM16), main_output: CH1,
    serial: USART2,
    serial_out_dma: DMA1_CH6 (DMA1_CHANNEL6), serial_in_dma: DMA1_CH5,
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
