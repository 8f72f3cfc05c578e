//! The boards that this firmware is built for, a file each: clocks, pins, the supply's divider, the probe's
//! name for the chip. Nothing else in the firmware knows a number or a pin of a board.
//!
//! A board is a [`Board`] and a `wiring!` that says what is connected where. All of it is constant data,
//! which the tests on the host read too; on the target, `wiring!` also hands out the pins by their type, so
//! that a pin which cannot do what it is named for does not compile.

use twinrotor::drive::PWM_HZ;

/// What differs between boards.
pub(crate) struct Board {
    /// As its host knows it: its name is its feature's, and that of its file.
    pub(crate) known: &'static twinrotor::board::Board,
    /// The chip, as probe-rs knows it. `.cargo/config.toml` says it to probe-rs.
    #[cfg_attr(target_os = "none", expect(dead_code, reason = "a test compares it with .cargo/config.toml"))]
    pub(crate) probe_chip: &'static str,
    /// Where its clocks come from.
    pub(crate) clocks: Clocks,
    /// \[ns\] Between the two outputs of a half bridge, neither is on.
    #[cfg_attr(all(target_os = "none", feature = "simulated"), expect(dead_code, reason = "of a real rig"))]
    pub(crate) dead_time_ns: u32,
    /// ADC1's channel at [`Wiring::supply`], 0 to 15.
    #[cfg_attr(all(target_os = "none", feature = "simulated"), expect(dead_code, reason = "of a real rig"))]
    pub(crate) supply_channel: u8,
    /// \[V\] The amplifiers' supply at the converter's full scale.
    #[cfg_attr(all(target_os = "none", feature = "simulated"), expect(dead_code, reason = "of a real rig"))]
    pub(crate) supply_full_scale: f32,
    /// The user button, the emergency stop of a simulated rig.
    #[cfg_attr(
        all(target_os = "none", not(feature = "simulated")),
        expect(dead_code, reason = "of a simulated rig alone")
    )]
    pub(crate) button: Option<Button>,
    /// The level that lights the status LED.
    pub(crate) lit_high: bool,
    /// What is connected where.
    #[cfg_attr(
        all(target_os = "none", feature = "simulated", feature = "g4"),
        expect(dead_code, reason = "of a real rig")
    )]
    pub(crate) wiring: Wiring,
}

/// A user button.
#[derive(Clone, Copy)]
#[cfg_attr(
    all(target_os = "none", not(feature = "simulated")),
    expect(dead_code, reason = "of a simulated rig alone")
)]
pub(crate) struct Button {
    /// Its pin.
    pub(crate) pin: &'static str,
    /// The level that says that it is pressed.
    pub(crate) pressed_high: bool,
}

impl Board {
    /// \[counts\] Half a PWM period, centre-aligned.
    #[expect(clippy::cast_possible_truncation, reason = "asserted")]
    pub(crate) const fn pwm_top(&self) -> u16 {
        let top = self.clocks.pwm_timer_hz() / PWM_HZ / 2;
        assert!(
            top <= u16::MAX as u32 && top.is_multiple_of(2) && top * PWM_HZ * 2 == self.clocks.pwm_timer_hz()
        );
        top as u16
    }

    /// Compare steps from zero to the full supply.
    #[cfg(not(all(target_os = "none", feature = "simulated")))]
    pub(crate) const fn full_steps(&self) -> u32 {
        twinrotor::drive::full_steps(self.clocks.pwm_timer_hz())
    }

    /// \[counts\] The dead time, in periods of the PWM's timer (reference manual RM0090, 17.4.18: DTG up to
    /// 127 counts them).
    #[cfg(not(all(target_os = "none", feature = "simulated")))]
    #[expect(clippy::cast_possible_truncation, reason = "asserted")]
    pub(crate) const fn dead_time(&self) -> u8 {
        let counts = self.clocks.pwm_timer_hz() / 1_000_000 * self.dead_time_ns / 1_000;
        assert!(counts > 0 && counts < 128);
        counts as u8
    }
}

/// \[Hz\] Of the chip's internal oscillator, to a percent at room temperature, to 8 % anywhere.
pub(crate) const INTERNAL_HZ: u32 = 16_000_000;

/// From the source to the core and the buses: core = source / `divide` x `multiply` / `post_divide`.
pub(crate) struct Clocks {
    /// What swings.
    pub(crate) source: Source,
    /// \[Hz\] At which frequency.
    pub(crate) source_hz: u32,
    /// The PLL's input divider, 2 to 63.
    pub(crate) divide: u8,
    /// Its multiplier, 50 to 432.
    pub(crate) multiply: u16,
    /// Its output divider: 2, 4, 6 or 8.
    pub(crate) post_divide: u8,
    /// The divider to the slow peripherals' bus: 1, 2, 4, 8 or 16.
    pub(crate) apb1_divide: u8,
    /// The divider to the fast peripherals' bus, of the PWM's timer.
    pub(crate) apb2_divide: u8,
}

impl Clocks {
    /// \[Hz\] Of the core.
    pub(crate) const fn core_hz(&self) -> u32 {
        self.source_hz / self.divide as u32 * self.multiply as u32 / self.post_divide as u32
    }

    /// From the internal oscillator to the same frequency: the PLL's input divider in place of `divide`.
    #[expect(clippy::cast_possible_truncation, reason = "asserted")]
    pub(crate) const fn fallback_divide(&self) -> u8 {
        let divide = INTERNAL_HZ * self.divide as u32 / self.source_hz;
        assert!(divide <= 63 && divide * self.source_hz == INTERNAL_HZ * self.divide as u32);
        divide as u8
    }

    /// \[Hz\] Of the timers on the slow bus: twice the bus, unless it is as fast as the core.
    pub(crate) const fn slow_timer_hz(&self) -> u32 {
        let bus = self.core_hz() / self.apb1_divide as u32;
        if self.apb1_divide == 1 { bus } else { 2 * bus }
    }

    /// \[Hz\] Of TIM1 and TIM8: twice their bus, unless the bus is as fast as the core (RM0090, 7.2).
    pub(crate) const fn pwm_timer_hz(&self) -> u32 {
        let bus = self.core_hz() / self.apb2_divide as u32;
        if self.apb2_divide == 1 { bus } else { 2 * bus }
    }
}

/// A board's high-speed clock. A board's file names the one it has.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// A crystal at the chip's two pins.
    #[cfg_attr(
        all(target_os = "none", any(feature = "nucleo-f411", feature = "nucleo-f446")),
        expect(dead_code, reason = "the boards of these without")
    )]
    Crystal,
    /// A clock that another chip feeds in.
    External,
}

/// What is connected where, by the chip's names: `PA0` is pin 0 of port A.
#[cfg_attr(
    target_os = "none",
    expect(dead_code, reason = "most are used by their type; tests read the names")
)]
pub(crate) struct Wiring {
    /// A timer that counts both edges of both channels: pitch.
    pub(crate) pitch_timer: &'static str,
    /// The same: yaw.
    pub(crate) yaw_timer: &'static str,
    /// The timer of the PWM and of the tick: TIM1, or TIM8.
    pub(crate) pwm_timer: &'static str,
    /// Its output for the main motor: `CH1`, or `CH3N`, the complement of channel 3, on a board that has
    /// another use for channel 1's pin.
    pub(crate) main_output: &'static str,
    /// The serial link to the host.
    pub(crate) serial: &'static str,
    /// Its DMA stream to the host.
    pub(crate) serial_out_dma: &'static str,
    /// Its DMA stream from the host.
    pub(crate) serial_in_dma: &'static str,
    /// Serial output.
    pub(crate) serial_out: &'static str,
    /// Serial input.
    pub(crate) serial_in: &'static str,
    /// Pitch encoder, channel A.
    pub(crate) pitch_a: &'static str,
    /// Pitch encoder, channel B.
    pub(crate) pitch_b: &'static str,
    /// Yaw encoder, channel A.
    pub(crate) yaw_a: &'static str,
    /// Yaw encoder, channel B.
    pub(crate) yaw_b: &'static str,
    /// Main motor's PWM: [`Wiring::main_output`].
    pub(crate) main: &'static str,
    /// Its complement, for locked antiphase: that of channel 1.
    pub(crate) main_complement: &'static str,
    /// Tail motor's PWM: channel 2.
    pub(crate) tail: &'static str,
    /// Its complement, for locked antiphase.
    pub(crate) tail_complement: &'static str,
    /// The main and the tail motor's other direction, for sign and magnitude: channels 3 and 4, if the board
    /// leads them out.
    pub(crate) reverse: Option<[&'static str; 2]>,
    /// The amplifiers' enable input: high is on.
    pub(crate) enable: &'static str,
    /// The break input of the PWM's timer, and a line of EXTI: high, or cut, is stop.
    pub(crate) emergency_stop: &'static str,
    /// The amplifiers' fault or current limit: low.
    pub(crate) current_limit: &'static str,
    /// The amplifiers' supply, divided.
    pub(crate) supply: &'static str,
    /// The status LED.
    pub(crate) led: &'static str,
}

impl Wiring {
    /// Is the main motor's PWM that of [`Wiring::main_output`]'s second name?
    #[cfg(not(all(target_os = "none", feature = "simulated")))]
    pub(crate) const fn main_is_mirrored(&self) -> bool {
        match self.main_output.as_bytes() {
            b"CH1" => false,
            b"CH3N" => true,
            _ => panic!("CH1 or CH3N"),
        }
    }
}

/// A pin, by numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Pin {
    /// Its port: 0 is A.
    pub(crate) port: u8,
    /// 0 to 15.
    pub(crate) number: u8,
}

impl Pin {
    /// From its name: `PB12`.
    pub(crate) const fn named(name: &str) -> Self {
        let bytes = name.as_bytes();
        assert!(bytes[0] == b'P' && bytes.len() >= 3 && bytes.len() <= 4);
        let mut number = bytes[2] - b'0';
        if bytes.len() == 4 {
            number = 10 * number + (bytes[3] - b'0');
        }
        assert!(number < 16);
        Self { port: bytes[1] - b'A', number }
    }
}

/// A DMA stream, or channel, by numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Stream {
    /// 1 or 2.
    pub(crate) controller: u8,
    /// As it is named: 0 to 7.
    pub(crate) number: u8,
}

impl Stream {
    /// From its name: `DMA1_CH5`.
    pub(crate) const fn named(name: &str) -> Self {
        let bytes = name.as_bytes();
        assert!(bytes.len() == 8 && bytes[0] == b'D' && bytes[6] == b'H');
        let (controller, number) = (bytes[3] - b'0', bytes[7] - b'0');
        assert!((controller == 1 || controller == 2) && number < 8);
        Self { controller, number }
    }
}

/// What is connected where: a constant of names, and on the target the pins and peripherals themselves.
macro_rules! wiring {
    (
        pitch_timer: $pitch:ident, yaw_timer: $yaw:ident,
        pwm_timer: $pwm:ident ($tick:ident), main_output: $main_output:ident,
        serial: $serial:ident,
        serial_out_dma: $out:ident ($out_stream:ident), serial_in_dma: $in:ident,
        $($what:ident: $pin:ident),*;
        emergency_stop: $stop:ident ($edge:ident),
        $(main_reverse: $main_reverse:ident, tail_reverse: $tail_reverse:ident,)?
    ) => {
        const WIRING: super::Wiring = super::Wiring {
            pitch_timer: stringify!($pitch),
            yaw_timer: stringify!($yaw),
            pwm_timer: stringify!($pwm),
            main_output: stringify!($main_output),
            serial: stringify!($serial),
            serial_out_dma: stringify!($out),
            serial_in_dma: stringify!($in),
            $($what: stringify!($pin),)*
            emergency_stop: stringify!($stop),
            reverse: [$([stringify!($main_reverse), stringify!($tail_reverse)])?].first().copied(),
        };

        #[cfg(target_os = "none")]
        pub(crate) use on_chip::*;

        #[cfg(target_os = "none")]
        mod on_chip {
            use embassy_stm32::interrupt::Interrupt;
            use embassy_stm32::{Peri, Peripherals, bind_interrupts, dma, interrupt, pac, peripherals};

            pub(crate) type PitchTimer = peripherals::$pitch;
            pub(crate) type YawTimer = peripherals::$yaw;
            pub(crate) type PwmTimer = peripherals::$pwm;
            /// The timer of the PWM.
            pub(crate) const PWM_TIMER: pac::timer::TimAdv = pac::$pwm;
            /// The tick: its update.
            pub(crate) const TICK: Interrupt = Interrupt::$tick;

            #[interrupt]
            fn $tick() {
                crate::tick::tick();
            }

            /// The emergency stop's edge.
            #[cfg(not(feature = "simulated"))]
            pub(crate) const STOP_EDGE: Interrupt = Interrupt::$edge;

            #[cfg(not(feature = "simulated"))]
            #[interrupt]
            fn $edge() {
                crate::emergency_stop::edge();
            }

            bind_interrupts!(pub(crate) struct SerialInterrupts {
                $out_stream => dma::InterruptHandler<peripherals::$out>;
            });

            pub(crate) type Serial = peripherals::$serial;
            /// The port of the serial link.
            pub(crate) const SERIAL: pac::usart::Usart = pac::$serial;
            /// Its stream from the host.
            pub(crate) const SERIAL_IN: crate::boards::Stream =
                crate::boards::Stream::named(stringify!($in));

            /// Does each encoder's timer count?
            #[cfg(not(feature = "simulated"))]
            pub(crate) fn encoders_count() -> bool {
                pac::$pitch.cr1().read().cen() && pac::$yaw.cr1().read().cen()
            }

            /// Has all channels of the encoders filtered alike.
            #[cfg(not(feature = "simulated"))]
            pub(crate) fn filter_encoders(filter: pac::timer::vals::FilterValue) {
                pac::$pitch.ccmr_input(0).modify(|w| (0..2).for_each(|channel| w.set_icf(channel, filter)));
                pac::$yaw.ccmr_input(0).modify(|w| (0..2).for_each(|channel| w.set_icf(channel, filter)));
            }

            /// What the board's wiring needs of the chip.
            #[cfg_attr(
                any(feature = "simulated", feature = "sign-magnitude"),
                expect(dead_code, reason = "no rig is wired to it, or one without complements")
            )]
            pub(crate) struct Parts {
                pub(crate) pwm_timer: Peri<'static, PwmTimer>,
                pub(crate) stopwatch: Peri<'static, peripherals::TIM5>,
                pub(crate) adc: Peri<'static, peripherals::ADC1>,
                pub(crate) flash: Peri<'static, peripherals::FLASH>,
                pub(crate) pitch_timer: Peri<'static, PitchTimer>,
                pub(crate) yaw_timer: Peri<'static, YawTimer>,
                pub(crate) serial: Peri<'static, peripherals::$serial>,
                pub(crate) serial_out_dma: Peri<'static, peripherals::$out>,
                pub(crate) serial_in_dma: Peri<'static, peripherals::$in>,
                $(pub(crate) $what: Peri<'static, peripherals::$pin>,)*
                pub(crate) emergency_stop: Peri<'static, peripherals::$stop>,
                $(
                    #[cfg(feature = "sign-magnitude")]
                    pub(crate) main_reverse: Peri<'static, peripherals::$main_reverse>,
                    #[cfg(feature = "sign-magnitude")]
                    pub(crate) tail_reverse: Peri<'static, peripherals::$tail_reverse>,
                )?
            }

            impl Parts {
                pub(crate) fn of(chip: Peripherals) -> Self {
                    Self {
                        pwm_timer: chip.$pwm,
                        stopwatch: chip.TIM5,
                        adc: chip.ADC1,
                        flash: chip.FLASH,
                        pitch_timer: chip.$pitch,
                        yaw_timer: chip.$yaw,
                        serial: chip.$serial,
                        serial_out_dma: chip.$out,
                        serial_in_dma: chip.$in,
                        $($what: chip.$pin,)*
                        emergency_stop: chip.$stop,
                        $(
                            #[cfg(feature = "sign-magnitude")]
                            main_reverse: chip.$main_reverse,
                            #[cfg(feature = "sign-magnitude")]
                            tail_reverse: chip.$tail_reverse,
                        )?
                    }
                }
            }
        }
    };
}

#[cfg(all(feature = "feather-f405", feature = "sign-magnitude"))]
compile_error!("the Feather leads out neither channel 3 nor channel 4 of its PWM's timer: no sign-magnitude");

#[cfg(any(feature = "black-pill", not(target_os = "none")))]
pub(crate) mod black_pill;
#[cfg(any(feature = "f405", not(target_os = "none")))]
pub(crate) mod f405;
#[cfg(any(feature = "f407", not(target_os = "none")))]
pub(crate) mod f407;
#[cfg(any(feature = "feather-f405", not(target_os = "none")))]
pub(crate) mod feather_f405;
#[cfg(any(feature = "nucleo-f411", not(target_os = "none")))]
pub(crate) mod nucleo_f411;
#[cfg(any(feature = "nucleo-f446", not(target_os = "none")))]
pub(crate) mod nucleo_f446;
#[cfg(any(feature = "nucleo-g474", not(target_os = "none")))]
pub(crate) mod nucleo_g474;

#[cfg(all(target_os = "none", feature = "black-pill"))]
pub(crate) use black_pill::*;
#[cfg(all(target_os = "none", feature = "f405"))]
pub(crate) use f405::*;
#[cfg(all(target_os = "none", feature = "f407"))]
pub(crate) use f407::*;
#[cfg(all(target_os = "none", feature = "feather-f405"))]
pub(crate) use feather_f405::*;
#[cfg(all(target_os = "none", feature = "nucleo-f411"))]
pub(crate) use nucleo_f411::*;
#[cfg(all(target_os = "none", feature = "nucleo-f446"))]
pub(crate) use nucleo_f446::*;
#[cfg(all(target_os = "none", feature = "nucleo-g474"))]
pub(crate) use nucleo_g474::*;
