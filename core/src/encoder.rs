//! Step 1 of the tick: from what a hardware counter shows to an angle.

use crate::real::Real;

/// Width of a hardware counter that wraps around; each stands for what it leaves of 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum CounterWidth {
    /// A timer in encoder mode.
    Bits16 = 16,
    /// The counters of the Aero and the Aero 2.
    Bits24 = 8,
}

impl CounterWidth {
    /// The signed step from one reading to the next, right while the shaft turns less than half the counter's
    /// range between the two.
    #[inline]
    const fn step(self, from: u32, to: u32) -> i32 {
        let spare = self as u32;
        to.wrapping_sub(from).wrapping_shl(spare).cast_signed().wrapping_shr(spare)
    }
}

/// \[rad\] An angle for each count of an encoder with `counts` a revolution.
#[inline(always)]
pub fn angle_per_count<R: Real>(counts: u32) -> R {
    R::from_f64(core::f64::consts::TAU / f64::from(counts))
}

/// One incremental encoder: unwraps its counter and knows its scale and zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoder {
    width: CounterWidth,
    angle_per_count: f32,
    last: u32,
    position: i32,
}

impl Encoder {
    /// An encoder whose counter now shows `reading`, where its position is `position` counts from its zero.
    pub fn new(width: CounterWidth, angle_per_count: f32, reading: u32, position: i32) -> Self {
        Self { width, angle_per_count, last: reading, position }
    }

    /// Takes a reading of the counter and gives the angle \[rad\] from zero. Higher bits than the counter has
    /// are ignored.
    #[inline]
    pub fn read(&mut self, reading: u32) -> f32 {
        self.position = self.position.wrapping_add(self.width.step(self.last, reading));
        self.last = reading;
        self.angle()
    }

    /// \[rad\] The angle at the last reading.
    #[inline]
    pub fn angle(&self) -> f32 {
        f32::from_i32(self.position) * self.angle_per_count
    }

    /// At how many bits its counter wraps.
    #[inline]
    pub fn width(&self) -> CounterWidth {
        self.width
    }

    /// The last reading.
    #[inline]
    pub fn reading(&self) -> u32 {
        self.last
    }

    /// Counts from zero at the last reading.
    #[inline]
    pub fn position(&self) -> i32 {
        self.position
    }

    /// Declares where it is now to be `position` counts from zero.
    pub fn set_position(&mut self, position: i32) {
        self.position = position;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_walk_is_followed_through_every_wrap(
            start in any::<u32>(),
            steps in prop::collection::vec(-32_767_i32..=32_767, 1..200),
        ) {
            for (width, mask) in [(CounterWidth::Bits16, 0xFFFF), (CounterWidth::Bits24, 0xFF_FFFF)] {
                let mut counter = start & mask;
                let mut encoder = Encoder::new(width, 1.0, counter, 0);
                let mut position = 0;
                for step in &steps {
                    position += step;
                    counter = counter.wrapping_add(step.cast_unsigned()) & mask;
                    encoder.read(counter);
                    prop_assert_eq!(encoder.position(), position);
                }
            }
        }

        #[test]
        fn counts_to_angle_and_back(position in -4_000_000_i32..4_000_000, counts in 1_000_u32..10_000) {
            let encoder = Encoder::new(CounterWidth::Bits16, angle_per_count(counts), 0, position);
            let back = f64::from(encoder.angle()) * f64::from(counts) / core::f64::consts::TAU;
            prop_assert!((back - f64::from(position)).abs() < 0.5);
        }
    }

    #[test]
    fn one_revolution_is_two_pi() {
        let encoder = Encoder::new(CounterWidth::Bits24, angle_per_count(4096), 0, 4096);
        assert_eq!(encoder.angle(), core::f32::consts::TAU);
    }

    #[test]
    fn both_wraps_of_16_bits() {
        let mut up = Encoder::new(CounterWidth::Bits16, 1.0, 0xFFFE, 0);
        assert_eq!(up.read(0x0003), 5.0);
        assert_eq!(up.read(0xFFFE), 0.0);
    }
}
