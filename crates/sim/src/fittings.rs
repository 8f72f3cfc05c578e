//! What a closed loop has of a rig's hardware, in the numbers that it reckons with: of a [`Hardware`], or of
//! what a GPU's thread is told of one.

use twinrotor::axes::PerAxis;
use twinrotor::bench::{Hardware, Wear, counts_per_angle};
use twinrotor::encoder::angle_per_count;
use twinrotor::real::Real;

/// What a closed loop has of a rig's hardware.
pub trait Fittings<R> {
    /// \[counts/rad\] Of the encoders.
    fn counts_per_angle(&self) -> PerAxis<R>;
    /// \[rad\] As the controller has it.
    fn angle_per_count(&self) -> PerAxis<R>;
    /// Compare steps between zero and full voltage.
    fn pwm_steps(&self) -> u32;
    /// \[V\] Supply of the amplifiers.
    fn supply(&self) -> R;
    /// What is worn.
    fn wear(&self) -> Wear;
}

impl<R: Real> Fittings<R> for Hardware {
    #[inline(always)]
    fn counts_per_angle(&self) -> PerAxis<R> {
        self.encoder_counts.map(counts_per_angle)
    }

    #[inline(always)]
    fn angle_per_count(&self) -> PerAxis<R> {
        self.believed_counts.map(angle_per_count)
    }

    fn pwm_steps(&self) -> u32 {
        self.pwm_steps
    }

    fn supply(&self) -> R {
        R::from_f64(self.supply)
    }

    fn wear(&self) -> Wear {
        self.wear
    }
}
