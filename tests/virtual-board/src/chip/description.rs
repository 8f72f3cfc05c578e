//! The STM32F405 described for the bus: which instances it has, what clocks, gates and resets them,
//! and its memory map. RM0090 table 1 and chapter 7, datasheet DS8626. The register tables are those
//! of the STM32F427 of the same manual, with what the F405 lacks left out.

use std::num::{NonZeroU32, NonZeroU64};

use rigless::cpu::armv7m;
use rigless::soc::stm32f427::generated::{self, gpioa};
use rigless::soc::stm32f427::peripherals::{adc, rcc};
use rigless::soc::{Builder, Bus, Clock, Cpu, Endian, EraseBlocks, Gate, Peripheral, Region, WriteModify};

use super::debug;
use super::exti;
use super::flash;
use super::more_clocks;
use super::parts::Part;
use super::timer;

/// The interrupt lines, table 61.
pub const INTERRUPT_LINES: u16 = 82;

const fn blocks(size: u64, count: u32) -> EraseBlocks {
    match (NonZeroU64::new(size), NonZeroU32::new(count)) {
        (Some(size), Some(count)) => EraseBlocks { size, count },
        _ => panic!("a sector has bytes"),
    }
}

static SECTORS: [EraseBlocks; 3] = [blocks(16 << 10, 4), blocks(64 << 10, 1), blocks(128 << 10, 7)];
/// Of half the flash.
static FEWER_SECTORS: [EraseBlocks; 3] = [blocks(16 << 10, 4), blocks(64 << 10, 1), blocks(128 << 10, 3)];

/// The RAM: where, and how much.
pub const SRAM: (u64, u64) = (0x2000_0000, 128 << 10);
/// The core-coupled RAM.
pub(super) const CCM: (u64, u64) = (0x1000_0000, 64 << 10);

const fn array(size: u64, sectors: &'static [EraseBlocks]) -> Region {
    Region::flash("flash", flash::BASE, size).erased_in(sectors).erased_to(0xFF).programmed_by("FLASH")
}

/// With the device's number and the calibration values behind it: 39.1, DS8626 table 72.
const SYSTEM: Region = Region::system("system", 0x1FFF_0000, 0x7A30);

static MEMORY: [Region; 4] = [
    array(flash::SIZE as u64, &SECTORS),
    Region::ram("ccm", CCM.0, CCM.1),
    SYSTEM,
    Region::ram("sram", SRAM.0, SRAM.1),
];
/// Without the CCM, with half the flash: RM0383 2.3, RM0390 2.2.2.
static LESS_MEMORY: [Region; 3] =
    [array(flash::SIZE as u64 / 2, &FEWER_SECTORS), SYSTEM, Region::ram("sram", SRAM.0, SRAM.1)];

/// Reserved space beside the RAMs, which answers with a bus error: where a stack runs into that has
/// outgrown its region.
const RESERVED: [(&str, u64, u64); 4] = [
    ("reserved below the CCM", 0x0810_0000, CCM.0 - 0x0810_0000),
    ("reserved above the CCM", CCM.0 + CCM.1, 0x10_0000),
    ("reserved below the SRAM", 0x1FFF_C010, SRAM.0 - 0x1FFF_C010),
    ("reserved above the SRAM", SRAM.0 + SRAM.1, 0x10_0000),
];
/// The same where there is less.
const RESERVED_WITH_LESS: [(&str, u64, u64); 3] = [
    ("reserved above the flash", 0x0808_0000, CCM.0 + CCM.1 + 0x10_0000 - 0x0808_0000),
    RESERVED[2],
    RESERVED[3],
];

/// A timer of the part: its kind, interrupts (table 61), and the bus that enables and clocks it.
pub struct TimerInstance {
    pub name: &'static str,
    pub kind: timer::Kind,
    pub interrupts: &'static [u16],
    on_apb2: bool,
    enable: &'static str,
    reset: &'static str,
}

macro_rules! timer {
    ($name:literal, $kind:ident, $interrupts:expr, $on_apb2:literal) => {
        TimerInstance {
            name: $name,
            kind: timer::Kind::$kind,
            interrupts: &$interrupts,
            on_apb2: $on_apb2,
            enable: concat!($name, "EN"),
            reset: concat!($name, "RST"),
        }
    };
}

/// The timers, TIM1 first. An interrupt line that two of them share goes to whichever moves it last:
/// nothing here has both in use.
pub static TIMERS: [TimerInstance; 14] = [
    timer!("TIM1", Advanced, [24, 25, 26, 27], true),
    timer!("TIM2", Wide, [28], false),
    timer!("TIM3", General, [29], false),
    timer!("TIM4", General, [30], false),
    timer!("TIM5", Wide, [50], false),
    timer!("TIM6", Basic, [54], false),
    timer!("TIM7", Basic, [55], false),
    timer!("TIM8", Advanced, [43, 44, 45, 46], true),
    timer!("TIM9", TwoChannels, [24], true),
    timer!("TIM10", OneChannel, [25], true),
    timer!("TIM11", Remapped, [26], true),
    timer!("TIM12", TwoChannels, [43], false),
    timer!("TIM13", OneChannel, [44], false),
    timer!("TIM14", OneChannel, [45], false),
];

/// The ports of the 64-pin to 176-pin packages, A to I.
pub const PORTS: [&str; 9] =
    ["GPIOA", "GPIOB", "GPIOC", "GPIOD", "GPIOE", "GPIOF", "GPIOG", "GPIOH", "GPIOI"];
/// Reset values of MODER, OSPEEDR and PUPDR where they are not zero, 8.4.1, 8.4.3, 8.4.4.
const PORT_RESETS: [(&str, [u64; 3]); 2] =
    [("GPIOA", [0xA800_0000, 0x0C00_0000, 0x6400_0000]), ("GPIOB", [0x0000_0280, 0x0000_00C0, 0x0000_0100])];

/// A serial port: its name, whether it is on APB2, its enable and reset bits as the tables spell them.
const SERIAL: [(&str, bool, &str, &str); 6] = [
    ("USART1", true, "USART1EN", "USART1RST"),
    ("USART2", false, "USART2EN", "UART2RST"),
    ("USART3", false, "USART3EN", "UART3RST"),
    ("USART6", true, "USART6EN", "USART6RST"),
    ("UART4", false, "UART4EN", "UART4RST"),
    ("UART5", false, "UART5EN", "UART5RST"),
];

/// What the F405 has not, and what no model here answers for: an access to either fails a run.
const LEFT_OUT: [&str; 12] =
    ["UART7", "UART8", "SPI4", "SPI5", "SPI6", "SAI1", "LTDC", "DMA2D", "GPIOJ", "GPIOK", "FMC", "CRYP"];

/// The RCC register of bus `apb2` with the suffix `ENR` or `RSTR`.
const fn apb(apb2: bool, enable: bool) -> &'static str {
    match (apb2, enable) {
        (true, true) => "APB2ENR",
        (true, false) => "APB2RSTR",
        (false, true) => "APB1ENR",
        (false, false) => "APB1RSTR",
    }
}

fn instances(part: Part) -> Vec<Peripheral> {
    generated::PERIPHERALS
        .iter()
        .chain([&armv7m::PERIPHERAL, &debug::PERIPHERAL, &more_clocks::PERIPHERAL])
        .filter(|each| !LEFT_OUT.contains(&each.name) && part.has(each.name))
        .map(|&each| {
            if let Some(timer) = TIMERS.iter().find(|timer| timer.name == each.name) {
                return Peripheral {
                    interrupts: timer.interrupts,
                    registers: &timer::REGISTERS,
                    size: 0x400,
                    ..each
                };
            }
            match each.name {
                // As far as its registers go: behind them the F446 has more.
                "RCC" => Peripheral { size: 0x90, ..each },
                "EXTI" => Peripheral { interrupts: exti::INTERRUPTS, ..each },
                "ADC1" | "ADC2" | "ADC3" => Peripheral { interrupts: &[18], size: 0x100, ..each },
                name if PORTS.contains(&name) => Peripheral { registers: &gpioa::REGISTERS, ..each },
                // A line past the part's own belongs to an instance that the F405 shares with others only.
                _ if each.interrupts.iter().any(|&line| line >= INTERRUPT_LINES) => {
                    Peripheral { interrupts: &[], ..each }
                }
                _ => each,
            }
        })
        .collect()
}

/// The part's bus, with every gate, reset line and clock.
pub fn builder(part: Part) -> Builder {
    let cpu = Cpu::new(part.name(), true, INTERRUPT_LINES, Endian::Little);
    let (memory, reserved): (&[Region], &[_]) =
        if part.is_large() { (&MEMORY, &RESERVED) } else { (&LESS_MEMORY, &RESERVED_WITH_LESS) };
    let mut builder = Bus::builder(cpu, memory, instances(part))
        .reset("DBG", "DBGMCU_IDCODE", part.identity())
        .clocked_by(armv7m::DWT, Clock::output("RCC", rcc::HCLK))
        .clocked_by("IWDG", Clock::output("RCC", rcc::IWDG_CLK))
        .reads_requests("RCC")
        .reads_requests(armv7m::DWT)
        .reads_requests("EXTI")
        .write_modify("FLASH", "SR", WriteModify::OneToClear)
        .write_modify("EXTI", "PR", WriteModify::OneToClear)
        .gate("PWR", Gate::by("RCC", "APB1ENR", "PWREN"))
        .gate("SYSCFG", Gate::by("RCC", "APB2ENR", "SYSCFGEN"))
        .reset_by("PWR", Gate::by("RCC", "APB1RSTR", "PWRRST"))
        .reset_by("SYSCFG", Gate::by("RCC", "APB2RSTR", "SYSCFGRST"))
        .gate_writes("RCC", &["BDCR"], Gate::by("PWR", "CR", "DBP"));
    for &(name, base, size) in reserved {
        builder = builder.aborts_in(name, base, size);
    }
    for timer in TIMERS.iter().filter(|timer| part.has(timer.name)) {
        let source = if timer.on_apb2 { rcc::APB2_TIMERS } else { rcc::APB1_TIMERS };
        builder = builder
            .clocked_by(timer.name, Clock::output("RCC", source))
            .gate(timer.name, Gate::by("RCC", apb(timer.on_apb2, true), timer.enable))
            .reset_by(timer.name, Gate::by("RCC", apb(timer.on_apb2, false), timer.reset))
            .reset(timer.name, "ARR", timer.kind.top());
        if timer.kind == timer::Kind::Advanced {
            builder = builder.reads_requests(timer.name);
        }
    }
    for (name, on_apb2, enable, reset) in SERIAL.into_iter().filter(|port| part.has(port.0)) {
        let source = if on_apb2 { rcc::PCLK2 } else { rcc::PCLK1 };
        builder = builder
            .reset(name, "SR", 0xC0)
            .clocked_by(name, Clock::output("RCC", source))
            .gate(name, Gate::by("RCC", apb(on_apb2, true), enable))
            .reset_by(name, Gate::by("RCC", apb(on_apb2, false), reset));
    }
    for (port, (enable, reset)) in PORTS.into_iter().zip(PORT_BITS).filter(|(port, _)| part.has(port)) {
        for register in ["MODER", "OSPEEDR", "PUPDR"] {
            builder = builder.reset(port, register, 0);
        }
        builder = builder
            .gate(port, Gate::by("RCC", "AHB1ENR", enable))
            .reset_by(port, Gate::by("RCC", "AHB1RSTR", reset));
    }
    for (port, values) in PORT_RESETS {
        for (register, value) in ["MODER", "OSPEEDR", "PUPDR"].into_iter().zip(values) {
            builder = builder.reset(port, register, value);
        }
    }
    for (controller, enable, reset) in [("DMA1", "DMA1EN", "DMA1RST"), ("DMA2", "DMA2EN", "DMA2RST")] {
        builder = builder
            .reads_requests(controller)
            .gate(controller, Gate::by("RCC", "AHB1ENR", enable))
            .reset_by(controller, Gate::by("RCC", "AHB1RSTR", reset));
    }
    let converters = [("ADC1", "ADC1EN"), ("ADC2", "ADC2EN"), ("ADC3", "ADC3EN")];
    for (converter, enable) in converters.into_iter().filter(|(name, _)| part.has(name)) {
        builder = builder
            .gate(converter, Gate::by("RCC", "APB2ENR", enable))
            .clocked_by(converter, Clock::output("C_ADC", adc::ADCCLK))
            .reset_by(converter, Gate::by("RCC", "APB2RSTR", "ADCRST"));
    }
    for field in [&rcc::GPIOJEN, &rcc::GPIOKEN] {
        builder = builder.declare("RCC", "AHB1ENR", field);
    }
    for field in [&rcc::GPIOJRST, &rcc::GPIOKRST] {
        builder = builder.declare("RCC", "AHB1RSTR", field);
    }
    builder
        .reads_requests("ADC1")
        .reads_requests("C_ADC")
        .clocked_by("C_ADC", Clock::output("RCC", rcc::PCLK2))
        .gate("C_ADC", Gate::by("RCC", "APB2ENR", "ADC1EN"))
        .reset_by("C_ADC", Gate::by("RCC", "APB2RSTR", "ADCRST"))
}

const PORT_BITS: [(&str, &str); 9] = [
    ("GPIOAEN", "GPIOARST"),
    ("GPIOBEN", "GPIOBRST"),
    ("GPIOCEN", "GPIOCRST"),
    ("GPIODEN", "GPIODRST"),
    ("GPIOEEN", "GPIOERST"),
    ("GPIOFEN", "GPIOFRST"),
    ("GPIOGEN", "GPIOGRST"),
    ("GPIOHEN", "GPIOHRST"),
    ("GPIOIEN", "GPIOIRST"),
];
