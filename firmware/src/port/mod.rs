//! The way to the plant. Encoders and PWM amplifiers here; a rig with another interface is another
//! [`PlantPort`].

pub(crate) mod amplifier;
pub(crate) mod senses;

use crate::board;
use amplifier::Outputs;
use embassy_stm32::gpio::Output;
use embassy_stm32::peripherals::{TIM1, TIM2, TIM3};
use embassy_stm32::timer::low_level::Timer;
use embassy_stm32::timer::qei::Qei;
use senses::{Sensed, Senses};
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::drive::{Drive, Duty, FULL_STEPS};

/// What the tick needs of a rig.
pub(crate) trait PlantPort {
    /// The motors' amplifiers, as the core's [`Drive`] sees them.
    fn drive(&self) -> Drive<f32>;
    /// What the encoders' counters show.
    fn counters(&mut self) -> PerAxis<u32>;
    /// What else there is to see; call it once a tick.
    fn sense(&mut self) -> Sensed;
    /// To be latched at the next tick. Without `enable` the motors are off at once and these count for
    /// nothing.
    fn write(&mut self, duty: PerMotor<Duty<f32>>, enable: bool);
}

/// Two quadrature encoders on timers, two PWM amplifiers with a common enable pin.
pub(crate) struct EncoderPwmPort {
    _timer: Timer<'static, TIM1>,
    _outputs: Outputs,
    _enable: Output<'static>,
    pitch: Qei<'static, TIM2>,
    yaw: Qei<'static, TIM3>,
    senses: Senses,
}

impl EncoderPwmPort {
    /// Everything set up, motors off, the PWM's timer not yet running.
    pub(crate) fn start(
        timer: Timer<'static, TIM1>,
        outputs: Outputs,
        enable: Output<'static>,
        pitch: Qei<'static, TIM2>,
        yaw: Qei<'static, TIM3>,
        senses: Senses,
    ) -> Self {
        amplifier::configure();
        Self { _timer: timer, _outputs: outputs, _enable: enable, pitch, yaw, senses }
    }
}

impl PlantPort for EncoderPwmPort {
    fn drive(&self) -> Drive<f32> {
        Drive::new(FULL_STEPS)
    }

    fn counters(&mut self) -> PerAxis<u32> {
        PerAxis::new(self.pitch.count().into(), self.yaw.count().into())
    }

    fn sense(&mut self) -> Sensed {
        self.senses.read()
    }

    fn write(&mut self, duty: PerMotor<Duty<f32>>, enable: bool) {
        if enable {
            amplifier::set(duty.map(Duty::steps));
            amplifier::outputs_on();
            board::enable_pin(true);
        } else {
            board::amplifiers_off();
            amplifier::set(PerMotor::both(0));
        }
    }
}
