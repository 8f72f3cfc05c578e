//! The parts that are modelled, as far as the firmware can tell them apart: what each lacks of the F405's
//! peripherals and memory, or has beside them.

use super::more_clocks;
use twinrotor::board::Board;

/// Which part it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Part {
    /// STM32F405, reference manual RM0090.
    #[default]
    F405,
    /// STM32F411, RM0383: 100 MHz, fewer timers, ports and converters, half the flash, no core-coupled RAM.
    F411,
    /// STM32F446, RM0390: half the flash, no core-coupled RAM, two clock registers more (6.3.27, 6.3.28).
    F446,
}

/// What the F411 has not, datasheet DS10314 table 2, of what an F405 has.
const NOT_IN_F411: [&str; 28] = [
    "TIM6",
    "TIM7",
    "TIM8",
    "TIM12",
    "TIM13",
    "TIM14",
    "USART3",
    "UART4",
    "UART5",
    "ADC2",
    "ADC3",
    "GPIOF",
    "GPIOG",
    "GPIOI",
    "DAC",
    "CAN1",
    "CAN2",
    "DCMI",
    "HASH",
    "RNG",
    "Ethernet_MAC",
    "Ethernet_MMC",
    "Ethernet_PTP",
    "Ethernet_DMA",
    "OTG_HS_GLOBAL",
    "OTG_HS_HOST",
    "OTG_HS_DEVICE",
    more_clocks::NAME,
];
const NOT_IN_F446: [&str; 7] =
    ["GPIOI", "HASH", "RNG", "Ethernet_MAC", "Ethernet_MMC", "Ethernet_PTP", "Ethernet_DMA"];

impl Part {
    /// The one on that board. An F407 is an F405 with more that nothing here uses.
    ///
    /// # Panics
    ///
    /// If its chip is not modelled.
    pub fn of(known: Board) -> Self {
        match &known.chip[..9] {
            "stm32f405" | "stm32f407" => Self::F405,
            "stm32f411" => Self::F411,
            "stm32f446" => Self::F446,
            chip => panic!("an {chip} is not modelled"),
        }
    }

    /// What the emulator calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F405 => "STM32F405",
            Self::F411 => "STM32F411",
            Self::F446 => "STM32F446",
        }
    }

    /// `DBGMCU_IDCODE`: RM0090, 38.6.1, device 0x413, revision Y; RM0383, 23.6.1, device 0x431, revision A;
    /// RM0390, 33.6.1, device 0x421, revision A.
    pub const fn identity(self) -> u64 {
        match self {
            Self::F405 => 0x100F_6413,
            Self::F411 => 0x1000_6431,
            Self::F446 => 0x1000_6421,
        }
    }

    /// \[Hz\] Its core's clock, and the rate at which it retires instructions: one a cycle, which is what a
    /// "virtual" second is made of.
    pub const fn core_hz(self) -> u64 {
        match self {
            Self::F405 | Self::F446 => 168_000_000,
            Self::F411 => 100_000_000,
        }
    }

    /// Has it the core-coupled RAM, and the second half of the flash?
    pub const fn is_large(self) -> bool {
        matches!(self, Self::F405)
    }

    /// Whether it has that instance.
    pub fn has(self, instance: &str) -> bool {
        match self {
            Self::F405 => instance != more_clocks::NAME,
            Self::F411 => !NOT_IN_F411.contains(&instance),
            Self::F446 => !NOT_IN_F446.contains(&instance),
        }
    }
}
