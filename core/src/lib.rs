//! Twinrotor's control core: the plant model, the backstepping law, the saturation logic and the tick that a
//! board runs.
//!
//! No I/O, no clock, no allocation, no `unsafe`; nothing panics in a tick. The same source computes in `f32`
//! on an STM32, in `f64` when it is verified, and in lanes of `f32` when the tuner flies thousands of
//! candidates: what was tuned is, bit for bit, what flies.
//!
//! # Signs and axes
//!
//! Pitch θ is positive nose up, zero at the horizontal. Yaw ψ is positive as positive volts on the tail motor
//! turn it. Positive volts on the main motor raise the nose. Errors are reference minus actual, as in the
//! paper.
//!
//! # Units
//!
//! SI without suffix: rad, rad/s, rad/s², V, N m, s, kg, m, A. Anything else carries its unit in its name.
//! Public fields say unit and range first. Time is an integer tick; seconds are `tick * sample_time`, never a
//! sum.
//!
//! # The tick
//!
//! 1. [`encoder`]: counter readings to angles.
//! 2. [`estimator`]: angles to angles, rates and disturbances, with the rotors as [`rotor_model`] has them.
//! 4. [`mod@reference`]: what is wanted to a reference with derivatives, kept by [`governor`] within what the
//!    motors can follow and hold ([`static_reach`]) and shaped by [`command_filter`].
//! 5. [`law`]: both to the torque on each axis, eqs (26)-(27).
//! 6. [`allocation`]: torque to motor volts, eqs (28)-(29), within limits, after [`lead`] against rotor lag.
//! 7. [`drive`]: volts to the duty of the PWM amplifiers.
//!
//! [`pipeline`] is steps 2, 4, 5 and 6 over any [`Real`](real::Real), [`control_loop`] all of it. "Eq. (26)"
//! and "Table 3" mean those of "Backstepping control of Quanser's 2-DOF Helicopter under disturbance and
//! actuator saturation based on Flower Pollination Algorithm".

#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]
#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "tests compare bits and make samples"
    )
)]

#[cfg(test)]
extern crate std;

pub mod real;
pub mod trig;

pub mod axes;
pub mod compensated;
pub mod validate;

pub mod plant;

pub mod gains;

pub mod allocation;
pub mod command_filter;
pub mod controller;
pub mod drive;

pub mod encoder;
pub mod estimator;
pub mod law;
pub mod lead;
pub mod reference;
pub mod rotor_model;

pub mod approach;
pub mod first_power;
pub mod monitor;
pub mod supervisor;
pub mod telemetry;

pub mod control_loop;
pub mod governor;
pub mod pipeline;
pub mod replay;
pub mod static_reach;

pub mod defaults;
pub mod link;
pub mod parameters;

/// \[rad\] One degree. Inside the core angles are in rad; this is for constants that a source gives in
/// degrees.
pub const DEGREE: f64 = core::f64::consts::PI / 180.0;
