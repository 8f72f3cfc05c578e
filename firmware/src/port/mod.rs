//! The way to the plant. The tick is written over [`PlantPort`]; a rig with another interface is another file
//! here, and its name in [`Port`].

pub(crate) mod amplifier;
pub(crate) mod encoder_pwm;
pub(crate) mod senses;

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::drive::{Drive, Duty};
use twinrotor::encoder::CounterWidth;

/// The port that this firmware is built for.
pub(crate) type Port = encoder_pwm::EncoderPwmPort;

/// What the tick needs of a rig.
pub(crate) trait PlantPort {
    /// At how many bits the encoders' counters wrap.
    const COUNTER_WIDTH: CounterWidth;
    /// The motors' amplifiers, as the core's [`Drive`] sees them.
    fn drive(&self) -> Drive<f32>;
    /// What the encoders' counters show.
    fn counters(&mut self) -> PerAxis<u32>;
    /// What else there is to see; call it once a tick.
    fn sense(&mut self) -> Sensed;
    /// To be latched at the next tick. Without `enable` the motors are off at once and these count for
    /// nothing.
    fn write(&mut self, duty: PerMotor<Duty<f32>>, enable: bool);
    /// Switches the motors off, whatever state the program is in: a panic, a fault and the emergency stop
    /// call it from anywhere, in the middle of any other of these.
    fn off();
}

/// One tick's view.
#[derive(Clone, Copy)]
pub(crate) struct Sensed {
    /// \[V\] Supply of the amplifiers, measured since the last tick.
    pub(crate) supply: f32,
    /// All that is sensed is new, and the encoders are being counted.
    pub(crate) fresh: bool,
    /// Pressed now, or its cable broken.
    pub(crate) emergency_stop: bool,
    /// The amplifiers limit the current or are at fault.
    pub(crate) current_limit: bool,
}
