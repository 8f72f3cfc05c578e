//! Adafruit Feather STM32F405 Express, with a 12 MHz crystal. It leads out TIM1 not at all, and TIM8 in part:
//! channel 1's pin, D6, is an encoder's, and channel 3's complement at MOSI takes its place; channels 3 and 4
//! lie at the card's socket, so that there is no sign and magnitude. The LED is the red one, D13. This board
//! has been flown on the virtual board only.

use super::{Board, Clocks, Source};
use twinrotor::board;

/// This board.
pub(crate) const BOARD: Board = Board {
    known: &board::FEATHER_F405,
    probe_chip: "STM32F405RGTx",
    // 168 MHz core, 42 and 84 MHz buses, 84 and 168 MHz timers.
    clocks: Clocks {
        source: Source::Crystal,
        source_hz: 12_000_000,
        divide: 6,
        multiply: 168,
        post_divide: 2,
        apb1_divide: 4,
        apb2_divide: 2,
    },
    dead_time_ns: 500,
    // 3.3 V behind 100 k and 10 k ohm.
    supply_channel: 4,
    supply_full_scale: 3.3 * 11.0,
    button: None,
    lit_high: true,
    wiring: WIRING,
};

wiring! {
    pitch_timer: TIM4, yaw_timer: TIM3,
    pwm_timer: TIM8 (TIM8_UP_TIM13), main_output: CH3N,
    serial: USART3,
    serial_out_dma: DMA1_CH3 (DMA1_STREAM3), serial_in_dma: DMA1_CH1,
    serial_out: PB10, serial_in: PB11,
    pitch_a: PB6, pitch_b: PB7,
    yaw_a: PC6, yaw_b: PA7,
    main: PB15, main_complement: PA5,
    tail: PC7, tail_complement: PB14,
    enable: PB8,
    current_limit: PB9,
    supply: PA4,
    led: PC1;
    emergency_stop: PA6 (EXTI9_5),
}
