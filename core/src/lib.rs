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
//! 3. [`monitor`] finds what is wrong; [`supervisor`] decides from it and from the operator's request whether
//!    the motors may turn.
//! 4. [`mod@reference`]: where to be. [`approach`] leads from the rest pose to the operator's setpoint after
//!    arming; [`governor`] keeps it within what the motors can follow and hold ([`static_reach`]);
//!    [`command_filter`] shapes what is left of jumps into derivatives that belong together;
//!    [`adaptive_feed_forward`] adds what following a goal that moves has been found to take.
//! 5. [`law`]: both to the torque on each axis, eqs (26)-(27).
//! 6. [`allocation`]: torque, after [`lead`] against rotor lag, to motor volts within limits, eqs (28)-(29).
//! 7. [`drive`]: volts to the duty of the PWM amplifiers, as fine as the [`board`] makes it.
//! 8. [`telemetry`]: the frame of the tick.
//!
//! [`pipeline`] is steps 2, 4 (from the governor on), 5 and 6 over any [`Real`](real::Real);
//! [`control_loop`] is the whole tick in `f32`. While the supervisor says so, [`first_power`] takes the
//! place of steps 4 to 6: it turns one motor at a time to check the wiring. [`replay`] takes a recorded tick
//! through the pipeline, [`trial`] another controller through a flight.
//!
//! # Beside the tick
//!
//! - Numbers: [`real`] (the arithmetic), [`compensated`] (sums), [`axes`] (axis and motor apart by type),
//!   [`validate`] (what is wrong with a value).
//! - The helicopter: [`plant`] integrates it, [`mod@bench`] shows it as its cables do, [`trajectory`] has the
//!   references that a simulation follows.
//! - The controller's settings: [`settings`], the table of all that a person may choose, declared where it is
//!   used; [`gains`], [`controller`], and [`defaults`], what each preset starts from.
//! - The board's data: [`parameters`], the record it flies with, [`rig_port`], what its rig is, and [`link`],
//!   its messages, numbered by [`sequence`]. [`conversation`] is what it answers to each.
//!
//! # A step
//!
//! The pipeline and a plant are enough to close the loop. What is measured are angles, as encoders give them;
//! the volts of a tick are in effect from the next one on, as on a board.
//!
//! ```
//! use twinrotor::axes::{PerAxis, PerMotor};
//! use twinrotor::pipeline::{Pipeline, Settings};
//! use twinrotor::plant::{RealPlant, State, presets};
//! use twinrotor::reference::Reference;
//! use twinrotor::{DEGREE, SAMPLE_TIME, defaults};
//!
//! let settings = Settings::new(&presets::AERO2, defaults::AERO2, SAMPLE_TIME).map(|number| number as f32);
//! let (start, goal) = (PerAxis::zero(), PerAxis::new(5.0 * DEGREE as f32, 20.0 * DEGREE as f32));
//! let mut controller = Pipeline::new(&settings, start);
//! let mut plant = RealPlant::<f32>::new(&presets::AERO2.plant, State::at_rest(start), SAMPLE_TIME);
//! let mut volts = PerMotor::zero();
//! for _ in 0..4_000 {
//!     let belief = controller.believe_once(plant.state().angle, volts);
//!     let decision = controller.decide_once(belief, &Reference::at_rest(goal));
//!     plant.advance(volts, PerMotor::zero());
//!     volts = decision.allocation.volts;
//! }
//! let error = goal.minus(plant.state().angle);
//! assert!(error.pitch.abs() < 0.02 * goal.pitch && error.yaw.abs() < 0.02 * goal.yaw, "{error:?}");
//! ```
//!
//! "Eq. (26)" and "Table 3" mean those of "Backstepping control of Quanser's 2-DOF Helicopter under
//! disturbance and actuator saturation based on Flower Pollination Algorithm".

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

// Settings as data, declared once; the macro stands before what it declares.
#[macro_use]
pub mod settings;

// Numbers.
pub mod axes;
pub mod compensated;
pub mod real;
pub mod validate;

// The helicopter, simulated.
pub mod bench;
pub mod plant;
pub mod trajectory;

// The tick, step by step.
pub mod encoder;

pub mod estimator;
pub mod rotor_model;

pub mod monitor;
pub mod supervisor;

pub mod approach;
pub mod command_filter;
pub mod governor;
pub mod reference;
pub mod static_reach;

pub mod law;

pub mod adaptive_feed_forward;
pub mod allocation;
pub mod lead;

pub mod board;
pub mod drive;

pub mod telemetry;

// The tick as a whole, and what may take its place.
pub mod control_loop;
pub mod first_power;
pub mod pipeline;
pub mod replay;
pub mod trial;

// The controller's settings.
pub mod controller;
pub mod defaults;
pub mod gains;

// The board's data, and what it says.
pub mod conversation;
pub mod link;
pub mod parameters;
pub mod rig_port;
pub mod sequence;

/// \[s\] From tick to tick, on a board and wherever one is simulated: 1 kHz.
pub const SAMPLE_TIME: f64 = 1e-3;

/// \[rad\] One degree. Inside the core angles are in rad; this is for constants that a source gives in
/// degrees.
pub const DEGREE: f64 = core::f64::consts::PI / 180.0;
