//! The board around the part: what its pins are wired to, and how a rig meets them.

use std::num::{NonZeroU32, NonZeroU64};
use std::sync::Arc;

use rigless::cpu::armv7m as cpu;
use rigless::device::Level;
use rigless::machine::{Board as Described, Target, armv7m};
use rigless::mcu::Mcu;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

use crate::chip::timer::{Drive, Side, Timer};
use crate::chip::{INTERRUPT_LINES, Settings, Stm32f405};
use crate::serial::Line;
use crate::warm_core::WarmCore;
use crate::wiring::{Amplifiers, Bridge, Encoder, Leg, SUPPLY_DIVIDER, Wire};

/// What the rig puts on the board's connectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// \[counts\] edges of the pitch and the yaw encoder since it was at rest, four to a line.
    pub counts: [i64; 2],
    /// \[V\] of the amplifiers' supply.
    pub supply: f64,
    /// The emergency stop is pressed: its contact is open.
    pub emergency_stop: bool,
    /// The amplifiers report a fault or their current limit.
    pub amplifier_fault: bool,
    /// The user button of a Nucleo board is pressed.
    pub button: bool,
}

impl Default for Inputs {
    fn default() -> Self {
        Self { counts: [0; 2], supply: 24.0, emergency_stop: false, amplifier_fault: false, button: false }
    }
}

/// What the board puts on its connectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// When.
    pub at: VirtualNanos,
    /// \[counts\] the PWM timer's compare values as latched, and its reload value.
    pub compare: [u64; 4],
    pub reload: u64,
    /// What the timer's outputs are connected to: the main and the tail motor's bridge.
    pub bridges: [Bridge; 2],
    /// What the legs of the main and the tail motor's bridge do.
    pub legs: [[Drive; 2]; 2],
    /// The amplifiers are switched on.
    pub enabled: bool,
    /// The status LED is lit.
    pub lit: bool,
}

impl Outputs {
    /// The mean voltage across each motor, main and tail, as a share of the supply, -1 to 1: what lies
    /// between its bridge's two legs. A leg that nothing drives is pulled to ground.
    pub fn duty(&self) -> [f64; 2] {
        self.legs.map(|[forward, back]| {
            let share = |leg: Drive| leg.share_high().unwrap_or(0.0);
            if self.enabled { share(forward) - share(back) } else { 0.0 }
        })
    }

    /// What the compare values ask of each motor, in steps from zero: the duty, but for the dead time that
    /// takes a pulse off the bridge near either end. Zero where the duty is, with the amplifiers or the PWM
    /// off.
    pub fn steps(&self) -> [i64; 2] {
        [0, 1].map(|motor| {
            let driven = self.enabled && !self.legs[motor].contains(&Drive::Released);
            if driven { self.asked(motor) } else { 0 }
        })
    }

    /// What the compare values ask of a motor, in steps from zero, whether or not anything comes of it.
    pub fn asked(&self, motor: usize) -> i64 {
        let counts = |value: u64| i64::try_from(value).expect("16 bits");
        let [forward, back] = self.bridges[motor].map(|leg| {
            let compare = counts(self.compare[leg.channel]);
            if (leg.side == Side::Main) == leg.above { counts(self.reload) - compare } else { compare }
        });
        (forward - back) / 2
    }

    /// Whether a motor could turn.
    pub fn live(&self) -> bool {
        self.duty().into_iter().any(|share| share.abs() > 0.0)
    }
}

/// The board.
#[derive(Debug)]
pub struct Board {
    chip: Stm32f405,
    inputs: Inputs,
    /// The counts already turned into the timers.
    turned: [i64; 2],
    amplifiers: Amplifiers,
    /// The serial port's pins are in the right function.
    speaks: bool,
    protects_memory: bool,
}

impl Store for Board {}

impl Board {
    /// A board out of power-on; `seed` decides what chance decides, `settings` the rest. Without
    /// `protects_memory` the core's memory protection unit takes no effect, which a firmware that never
    /// violates it cannot tell, and the emulator runs twice as fast.
    ///
    /// # Errors
    ///
    /// If the part's description contradicts itself.
    pub fn new(
        seed: u64,
        settings: Settings,
        amplifiers: Amplifiers,
        protects_memory: bool,
    ) -> Result<Self, rigless::soc::Error> {
        let mut chip = Stm32f405::new(seed, settings)?;
        let (port, _) = settings.wiring.serial;
        chip.serial(port).attach(Line::default());
        Ok(Self {
            chip,
            inputs: Inputs::default(),
            turned: [0; 2],
            amplifiers,
            speaks: false,
            protects_memory,
        })
    }

    /// The microcontroller.
    pub fn chip(&mut self) -> &mut Stm32f405 {
        &mut self.chip
    }

    /// The host's end of the serial line.
    pub fn line(&mut self) -> &mut Line {
        let (port, _) = self.chip.settings().wiring.serial;
        self.chip.serial(port).line().expect("attached when the board was made")
    }

    /// What the rig puts on the connectors from `at` on.
    pub fn apply(&mut self, at: VirtualNanos, inputs: Inputs) {
        self.inputs = inputs;
        self.connect(at);
    }

    /// What is on the connectors now.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    fn connected(&self, wire: Wire) -> bool {
        self.chip.pin_function(wire.port, wire.pin) == wire.function
    }

    /// Takes the inputs to the pins, and from pins in the right function to what they reach. A pin in
    /// another function is a wire to nowhere.
    fn connect(&mut self, at: VirtualNanos) {
        let Inputs { counts, supply, emergency_stop, amplifier_fault, button } = self.inputs;
        let wiring = self.chip.settings().wiring;
        let stop = wiring.emergency_stop;
        let stop_level = Level::from(emergency_stop);
        self.chip.drive_pin(at, stop.port, stop.pin, Some(stop_level));
        let fault = wiring.amplifier_fault;
        let fault_level = Level::from(!amplifier_fault);
        self.chip.drive_pin(at, fault.port, fault.pin, Some(fault_level));
        if let Some((port, pin)) = self.chip.settings().button {
            self.chip.drive_pin(at, port, pin, Some(Level::from(!button)));
        }
        let break_level = self.connected(stop).then_some(stop_level);
        self.chip.timer(at, wiring.pwm_timer, |timer, registers, context| {
            timer.set_break_input(break_level, registers, context);
        });
        let encoders = [wiring.pitch_encoder, wiring.yaw_encoder];
        for (nth, Encoder { timer, pins }) in encoders.into_iter().enumerate() {
            let edges = counts[nth] - self.turned[nth];
            self.turned[nth] = counts[nth];
            if pins.into_iter().all(|pin| self.connected(pin)) {
                self.chip.timer(at, timer, |timer, registers, context| {
                    Timer::turn(timer, edges, registers, context);
                });
            }
        }
        self.connect_line();
        let (converter, channel) = wiring.supply;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few volts")]
        let millivolts = (supply / SUPPLY_DIVIDER * 1000.0).round().max(0.0) as u32;
        self.chip.set_analog(converter, channel, millivolts);
        self.chip.watch_rail(at);
    }

    fn connect_line(&mut self) {
        let (port, pins) = self.chip.settings().wiring.serial;
        self.speaks = pins.into_iter().all(|pin| self.connected(pin));
        self.chip.serial(port).silence(!self.speaks);
    }

    /// What the board puts on its connectors at `at`.
    pub fn outputs(&mut self, at: VirtualNanos) -> Outputs {
        let wiring = self.chip.settings().wiring;
        let bridges = wiring.bridges(self.amplifiers);
        let legs = bridges.map(|bridge| {
            bridge.map(|Leg { channel, side, pin, .. }| {
                if self.connected(pin) {
                    self.chip.timer_output(at, wiring.pwm_timer, channel, side)
                } else {
                    Drive::Released
                }
            })
        });
        let active = self.chip.timer(at, wiring.pwm_timer, |timer, _, _| *timer.counter().active());
        Outputs {
            at,
            compare: active.compare,
            reload: active.reload,
            bridges,
            legs,
            enabled: self.driven_high(wiring.amplifier_enable),
            lit: self.driven_high(wiring.status_led),
        }
    }

    /// An output of the part that is high; everything it drives is pulled low outside.
    fn driven_high(&self, wire: Wire) -> bool {
        self.chip.pin_is_output(wire.port, wire.pin)
            && self.chip.pin_level(wire.port, wire.pin) == Level::High
    }
}

impl Described for Board {
    fn name(&self) -> &'static str {
        "virtual-board"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec!["stm32f405"]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(self)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        const fn some(value: u64) -> NonZeroU64 {
            NonZeroU64::new(value).expect("not zero")
        }
        let hz = some(self.chip.part().core_hz());
        let core = armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: hz,
            interrupt_lines: NonZeroU32::from(std::num::NonZeroU16::new(INTERRUPT_LINES).expect("not zero")),
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).expect("not zero"),
            instructions_per_second: hz,
            boot: "flash",
        };
        let windows = cpu::windows(self.chip.bus());
        let regions = if self.protects_memory { armv7m::MpuRegions::Eight } else { armv7m::MpuRegions::None };
        let mut spec = core.spec_with_parts(&windows, armv7m::Fpu::FpV4Sp, regions);
        let cold = spec.processor;
        spec.processor = Arc::new(move |endian| Ok(Box::new(WarmCore::new(cold(endian)?))));
        vec![Target::new("stm32f405", self, spec)]
    }
}

/// The part as the emulator sees it. What firmware does to a pin's function connects or disconnects it at the
/// end of the millisecond, when the inputs are applied again; looking at every stop would cost more than all
/// the rest. But the serial line is connected in the middle of a millisecond: what is said before would be
/// lost.
impl Mcu for Board {
    fn bus(&self) -> &rigless::soc::Bus {
        self.chip.bus()
    }

    fn bus_mut(&mut self) -> &mut rigless::soc::Bus {
        self.chip.bus_mut()
    }

    fn reset(&mut self, at: VirtualNanos, cause: rigless::device::ResetCause) {
        self.chip.reset(at, cause);
        self.connect(at);
    }

    fn poll(&mut self, now: VirtualNanos) {
        if !self.speaks {
            self.connect_line();
        }
        self.chip.poll(now);
    }

    fn split(
        &mut self,
        slot: usize,
    ) -> (&mut rigless::soc::Bus, Option<&mut dyn rigless::device::ErasedDevice>) {
        self.chip.split(slot)
    }
}
