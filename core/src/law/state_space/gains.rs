//! The matrices of the law, and what its inputs can be.

use super::Seen;
use crate::axes::PerMotor;
use crate::real::Real;
use crate::settings::{Build, Field, LARGEST, Leaves, Rule, Table};
use crate::validate::Invalid;
use serde::{Deserialize, Serialize};

/// Most states that such a law may have. (A card's kernels and the page's module fly none.)
pub const MOST_STATES: usize = if cfg!(any(target_arch = "nvptx64", target_arch = "wasm32")) { 0 } else { 8 };
/// Most inputs.
pub const MOST_INPUTS: usize = if cfg!(any(target_arch = "nvptx64", target_arch = "wasm32")) { 0 } else { 4 };

/// Number of states or inputs, as an index.
type Few = u32;

/// What an input of the law can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Signal {
    /// \[rad\] Reference minus measured pitch.
    #[default]
    AngleErrorPitch,
    /// \[rad\] Reference minus measured yaw.
    AngleErrorYaw,
    /// \[rad/s\] Reference minus estimated rate of pitch.
    RateErrorPitch,
    /// \[rad/s\] Reference minus estimated rate of yaw.
    RateErrorYaw,
    /// \[rad\] Measured pitch.
    AnglePitch,
    /// \[rad\] Measured yaw.
    AngleYaw,
    /// \[rad/s\] Estimated rate of pitch.
    RatePitch,
    /// \[rad/s\] Estimated rate of yaw.
    RateYaw,
    /// \[rad\] Pitch of the reference.
    ReferencePitch,
    /// \[rad\] Yaw of the reference.
    ReferenceYaw,
    /// \[rad/s\] Rate of the reference's pitch.
    ReferenceRatePitch,
    /// \[rad/s\] Rate of the reference's yaw.
    ReferenceRateYaw,
}

impl Signal {
    /// Each with its name in a file, in the order of the stored record.
    pub const ALL: [(&'static str, Self); 12] = [
        ("angle_error.pitch", Self::AngleErrorPitch),
        ("angle_error.yaw", Self::AngleErrorYaw),
        ("rate_error.pitch", Self::RateErrorPitch),
        ("rate_error.yaw", Self::RateErrorYaw),
        ("angle.pitch", Self::AnglePitch),
        ("angle.yaw", Self::AngleYaw),
        ("rate.pitch", Self::RatePitch),
        ("rate.yaw", Self::RateYaw),
        ("reference.pitch", Self::ReferencePitch),
        ("reference.yaw", Self::ReferenceYaw),
        ("reference_rate.pitch", Self::ReferenceRatePitch),
        ("reference_rate.yaw", Self::ReferenceRateYaw),
    ];

    #[inline(always)]
    pub(super) fn of<R: Real>(self, seen: &Seen<'_, R>) -> R {
        let Seen { measured, rate, reference, .. } = seen;
        match self {
            Self::AngleErrorPitch => reference.angle.pitch - measured.pitch,
            Self::AngleErrorYaw => reference.angle.yaw - measured.yaw,
            Self::RateErrorPitch => reference.rate.pitch - rate.pitch,
            Self::RateErrorYaw => reference.rate.yaw - rate.yaw,
            Self::AnglePitch => measured.pitch,
            Self::AngleYaw => measured.yaw,
            Self::RatePitch => rate.pitch,
            Self::RateYaw => rate.yaw,
            Self::ReferencePitch => reference.angle.pitch,
            Self::ReferenceYaw => reference.angle.yaw,
            Self::ReferenceRatePitch => reference.rate.pitch,
            Self::ReferenceRateYaw => reference.rate.yaw,
        }
    }
}

/// The matrices. They have no row in the table of settings: no number of them means anything alone, so none
/// is offered to a slider or to a search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateSpaceGains<R> {
    /// How many states there are, at most [`MOST_STATES`]; rows and columns beyond are zero.
    pub states: Few,
    /// How many inputs there are, 1 to [`MOST_INPUTS`].
    pub inputs: Few,
    /// What they are; those beyond are the default.
    pub signals: [Signal; MOST_INPUTS],
    /// Is the torque that the model needs at the reference fed forward?
    pub feed_forward: bool,
    /// Is `anti_windup` a matrix? Otherwise the state is held.
    pub corrected: bool,
    /// \[V\] Most of each output, above 0.
    pub saturation: PerMotor<R>,
    /// C: a row for each motor.
    pub c: PerMotor<[R; MOST_STATES]>,
    /// D.
    pub d: PerMotor<[R; MOST_INPUTS]>,
    /// A: a row for each state.
    pub a: [[R; MOST_STATES]; MOST_STATES],
    /// B.
    pub b: [[R; MOST_INPUTS]; MOST_STATES],
    /// L: what of the volts that were given beyond those asked for goes to each state.
    pub anti_windup: [PerMotor<R>; MOST_STATES],
}

impl<R> Table for StateSpaceGains<R> {
    const FIELDS: &'static [Field] = &[];
    const RULES: &'static [Rule] = &[];
}

impl<R: Real> Leaves<R> for StateSpaceGains<R> {
    type Of<U> = StateSpaceGains<U>;

    fn map_each<U, F: FnMut(R) -> U>(self, f: &mut F) -> StateSpaceGains<U> {
        let Self { states, inputs, signals, feed_forward, corrected, saturation, c, d, a, b, anti_windup } =
            self;
        StateSpaceGains {
            states,
            inputs,
            signals,
            feed_forward,
            corrected,
            saturation: saturation.map(&mut *f),
            c: c.map(|row| row.map(&mut *f)),
            d: d.map(|row| row.map(&mut *f)),
            a: a.map(|row| row.map(&mut *f)),
            b: b.map(|row| row.map(&mut *f)),
            anti_windup: anti_windup.map(|row| row.map(&mut *f)),
        }
    }

    /// None of its numbers has a place in the table.
    fn change<F: FnMut(usize, R) -> R>(&mut self, first: usize, _f: &mut F) -> usize {
        first
    }
}

impl<R: Real> Build<R> for StateSpaceGains<R> {
    /// One that asks for nothing.
    fn build<F: FnMut(usize) -> R>(first: usize, _f: &mut F) -> (Self, usize) {
        (Self::none(), first)
    }
}

impl<R: Real> StateSpaceGains<R> {
    /// Without states, and with a D of zeros: the feed-forward alone.
    #[must_use]
    pub fn none() -> Self {
        Self {
            states: 0,
            inputs: 1,
            signals: [Signal::default(); MOST_INPUTS],
            feed_forward: true,
            corrected: false,
            saturation: PerMotor::both(R::from_f64(LARGEST)),
            c: PerMotor::both([R::zero(); MOST_STATES]),
            d: PerMotor::both([R::zero(); MOST_INPUTS]),
            a: [[R::zero(); MOST_STATES]; MOST_STATES],
            b: [[R::zero(); MOST_INPUTS]; MOST_STATES],
            anti_windup: [PerMotor::zero(); MOST_STATES],
        }
    }

    /// The states that there are.
    #[inline(always)]
    pub(super) fn order(&self) -> usize {
        (self.states as usize).min(MOST_STATES)
    }

    /// The signals that there are.
    #[must_use]
    #[inline(always)]
    pub fn signals(&self) -> &[Signal] {
        self.signals.get(..self.inputs as usize).unwrap_or(&self.signals)
    }
}

impl<R: Real<Mask = bool>> StateSpaceGains<R> {
    /// Every number and every count allowed.
    ///
    /// # Errors
    /// Names the matrix or the count.
    pub fn validate(&self) -> Result<(), Invalid<R>> {
        let count = |field, count: Few, least: usize, most: usize, allowed| {
            let fits = (least..=most).contains(&(count as usize));
            #[expect(
                clippy::cast_possible_wrap,
                reason = "what is so large is refused, whatever it is told as"
            )]
            let value = R::from_i32(count as i32);
            if fits { Ok(()) } else { Err(Invalid { field, value, allowed }) }
        };
        count("states", self.states, 0, MOST_STATES, "0 to 8")?;
        count("inputs", self.inputs, 1, MOST_INPUTS, "1 to 4")?;
        if MOST_STATES == 0 {
            return Ok(());
        }
        let small = |field, value: R| {
            let allowed = "a finite number of at most 1e9 in size";
            let fits = value.is_finite() && value.abs().le(R::from_f64(LARGEST));
            if fits { Ok(()) } else { Err(Invalid { field, value, allowed }) }
        };
        let all = |field, values: &[R]| values.iter().try_for_each(|value| small(field, *value));
        for value in [self.saturation.main, self.saturation.tail] {
            small("saturation", value)?;
            if !R::zero().lt(value) {
                return Err(Invalid { field: "saturation", value, allowed: "a finite number above 0" });
            }
        }
        self.a.iter().try_for_each(|row| all("A", row))?;
        self.b.iter().try_for_each(|row| all("B", row))?;
        [&self.c.main, &self.c.tail].into_iter().try_for_each(|row| all("C", row))?;
        [&self.d.main, &self.d.tail].into_iter().try_for_each(|row| all("D", row))?;
        self.anti_windup.iter().try_for_each(|row| all("anti_windup", &[row.main, row.tail]))
    }
}
