//! Two quadrature encoders on timers, two PWM amplifiers with a common enable pin.

use super::amplifier::{self, Outputs};
use super::senses::Senses;
use super::{PlantPort, Sensed};
use crate::boards::{PitchTimer, YawTimer};
use embassy_stm32::gpio::Output;
use embassy_stm32::timer::qei::Qei;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Injection;
use twinrotor::drive::{Drive, Duty};
use twinrotor::encoder::CounterWidth;
use twinrotor::parameters::Parameters;
use twinrotor::rig_port::RigPort;
use twinrotor::supervisor::ArmState;

/// A real rig: the board has nothing of it.
pub(crate) struct Wired;

/// A rig whose motors and encoders are wired to the board.
pub(crate) struct EncoderPwmPort {
    pitch: Qei<'static, PitchTimer>,
    yaw: Qei<'static, YawTimer>,
    senses: Senses,
    _outputs: Outputs,
    _enable: Output<'static>,
}

impl EncoderPwmPort {
    /// Everything set up, motors off. The timer of the outputs is the clock's, which comes first.
    pub(crate) fn start(
        outputs: Outputs,
        enable: Output<'static>,
        pitch: Qei<'static, PitchTimer>,
        yaw: Qei<'static, YawTimer>,
        senses: Senses,
    ) -> Self {
        amplifier::configure();
        Self { pitch, yaw, senses, _outputs: outputs, _enable: enable }
    }
}

impl PlantPort for EncoderPwmPort {
    const KIND: RigPort = RigPort::Pwm;
    const COUNTER_WIDTH: CounterWidth = CounterWidth::Bits16;
    type Rig = Wired;

    fn rig(_: &Parameters) -> Wired {
        Wired
    }

    fn drive(&self) -> Drive<f32> {
        Drive::limited(amplifier::FULL_STEPS, amplifier::MOST_STEPS)
    }

    #[inline(always)]
    fn counters(&mut self, _: &Wired) -> PerAxis<u32> {
        PerAxis::new(self.pitch.count().into(), self.yaw.count().into())
    }

    fn sense(&mut self) -> Sensed {
        self.senses.read()
    }

    #[inline(always)]
    fn seen(sensed: Sensed, _: &Wired) -> Sensed {
        sensed
    }

    /// The conversation refuses it.
    fn inject(_: &mut Wired, _: &Injection) {}

    fn write(&mut self, _: &mut Wired, duty: PerMotor<Duty<f32>>, state: ArmState) {
        if state.motors_may_turn() {
            amplifier::set(duty.map(Duty::steps));
            amplifier::on();
        } else {
            self.rest();
        }
    }

    fn rest(&mut self) {
        amplifier::off();
        amplifier::set(PerMotor::both(0));
    }

    fn off() {
        amplifier::off();
    }
}
