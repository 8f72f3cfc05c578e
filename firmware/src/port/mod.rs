//! The way to the plant. The tick is written over [`PlantPort`]; a rig with another interface is another file
//! here, and its name in [`Port`].

#[cfg(not(feature = "simulated"))]
pub(crate) mod amplifier;
#[cfg(not(feature = "simulated"))]
pub(crate) mod encoder_pwm;
#[cfg(not(feature = "simulated"))]
pub(crate) mod senses;
#[cfg(feature = "simulated")]
pub(crate) mod simulated;

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::Injection;
use twinrotor::drive::{Drive, Duty};
use twinrotor::encoder::CounterWidth;
use twinrotor::parameters::Parameters;
use twinrotor::rig_port::RigPort;
use twinrotor::supervisor::ArmState;

/// The port that this firmware is built for.
#[cfg(not(feature = "simulated"))]
pub(crate) type Port = encoder_pwm::EncoderPwmPort;
/// The port that this firmware is built for.
#[cfg(feature = "simulated")]
pub(crate) type Port = simulated::SimulatedPort;

/// What the tick needs of a rig.
pub(crate) trait PlantPort {
    /// What a host is told of it.
    const KIND: RigPort;
    /// At how many bits the encoders' counters wrap.
    const COUNTER_WIDTH: CounterWidth;
    /// What the board itself has of the rig: nothing of a real one.
    type Rig;
    /// The rig of which these parameters speak.
    fn rig(parameters: &Parameters) -> Self::Rig;
    /// The motors' amplifiers, as the core's [`Drive`] sees them.
    fn drive(&self) -> Drive<f32>;
    /// What the encoders' counters show.
    fn counters(&mut self, rig: &Self::Rig) -> PerAxis<u32>;
    /// What else there is to see; call it once a tick.
    fn sense(&mut self) -> Sensed;
    /// The same, with what the rig adds to it.
    fn seen(sensed: Sensed, rig: &Self::Rig) -> Sensed;
    /// Something befalls a rig that is not real.
    fn inject(rig: &mut Self::Rig, injection: &Injection);
    /// The tick's decision, to be latched at the next one. Where the motors may not turn in `state` they are
    /// off at once and `duty` counts for nothing.
    fn write(&mut self, rig: &mut Self::Rig, duty: PerMotor<Duty<f32>>, state: ArmState);
    /// The motors off, while the tick stands aside.
    fn rest(&mut self);
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
