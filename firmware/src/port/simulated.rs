//! A rig that the board computes itself, in the tick. Nothing leaves the chip: no pin is given to the PWM's
//! timer, its outputs are never enabled, and the amplifiers' enable pin is held low.

use super::{PlantPort, Sensed};
use crate::boards::BOARD;
use crate::{clock, pins};
use embassy_stm32::gpio::Output;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Injection, SimulatedRig};
use twinrotor::drive::{Drive, Duty};
use twinrotor::encoder::CounterWidth;
use twinrotor::parameters::Parameters;
use twinrotor::rig_port::RigPort;
use twinrotor::supervisor::ArmState;

/// No rig at all.
pub(crate) struct SimulatedPort {
    /// Low, for good: nothing in this firmware writes it.
    _enable: Output<'static>,
}

impl SimulatedPort {
    /// With the amplifiers' enable pin, low.
    pub(crate) const fn start(enable: Output<'static>) -> Self {
        Self { _enable: enable }
    }
}

impl PlantPort for SimulatedPort {
    const KIND: RigPort = RigPort::Simulated;
    const COUNTER_WIDTH: CounterWidth = CounterWidth::Bits16;
    type Rig = SimulatedRig;

    fn rig(parameters: &Parameters) -> SimulatedRig {
        SimulatedRig::of(parameters, *BOARD.known)
    }

    fn drive(&self) -> Drive<f32> {
        Drive::new(BOARD.known.pwm_steps())
    }

    fn counters(&mut self, rig: &SimulatedRig) -> PerAxis<u32> {
        rig.counters()
    }

    /// The board's button is the emergency stop; all else is the rig's.
    fn sense(&mut self) -> Sensed {
        Sensed { supply: 0.0, fresh: true, emergency_stop: pins::button(), current_limit: false }
    }

    fn seen(sensed: Sensed, rig: &SimulatedRig) -> Sensed {
        Sensed {
            supply: rig.supply(),
            emergency_stop: sensed.emergency_stop | rig.emergency_stop(),
            current_limit: rig.current_limit(),
            ..sensed
        }
    }

    fn inject(rig: &mut SimulatedRig, injection: &Injection) {
        rig.inject(injection);
    }

    fn write(&mut self, rig: &mut SimulatedRig, duty: PerMotor<Duty<f32>>, state: ArmState) {
        rig.tick(duty, state);
        let stall = rig.take_stall();
        if stall > 0 {
            clock::idle(stall.into());
        }
    }

    fn rest(&mut self) {}

    fn off() {}
}
