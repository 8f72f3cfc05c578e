//! A controller's flights in lanes without the supervisor of its board and with it: what that costs.

use crate::closed_loop::{ClosedLoop, Hardware, RigLoop, Tick};
use crate::guard::Guard;
use crate::lanes::{Kernel, LANES, in_lanes};
use crate::scenario::SAMPLE_TIME;
use std::hint::black_box;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;

/// Flies these references on `rig` in every lane, and how many steps that were.
///
/// # Panics
///
/// If a watched flight is cut: a controller is measured on its own rig.
pub fn fly(rig: &Rig, settings: &Settings<f32>, references: &[Reference<f32>], watched: bool) -> usize {
    in_lanes(Own { rig, settings, references, watched })
}

/// That controller's flights in lanes, as the robust objective flies them.
#[derive(Clone, Copy)]
struct Own<'a> {
    rig: &'a Rig,
    settings: &'a Settings<f32>,
    references: &'a [Reference<f32>],
    watched: bool,
}

impl Kernel for Own<'_> {
    /// Steps flown.
    type Output = usize;
    #[inline(always)]
    fn run<R: Real<Scalar = f32>>(self) -> usize {
        let settings = self.settings.map(R::splat);
        let hardware = Hardware::of(self.rig, PerAxis::both(0.5));
        let mut guard = Guard::new(&settings, &hardware);
        if self.watched {
            self.fly(
                &settings,
                &hardware,
                #[inline(always)]
                |tick, happened| guard.see(tick, happened),
            );
            assert_eq!(guard.ended(0), None, "a preset's controller on its own rig");
        } else {
            self.fly(
                &settings,
                &hardware,
                #[inline(always)]
                |_, _| {},
            );
        }
        self.references.len() * LANES
    }
}

impl Own<'_> {
    #[inline(always)]
    fn fly<R: Real<Scalar = f32>>(
        &self,
        settings: &Settings<R>,
        hardware: &Hardware,
        mut see: impl FnMut(u32, &Tick<R>),
    ) {
        let plant = RealPlant::new(&self.rig.plant, State::at_rest(PerAxis::zero()), SAMPLE_TIME);
        let mut closed_loop = RigLoop::new(plant, hardware, settings);
        let mut squares = PerAxis::zero();
        for (tick, reference) in (0..).zip(self.references) {
            let happened = black_box(&mut closed_loop).tick(&Reference::splat(reference), PerMotor::zero());
            see(tick, &happened);
            let error = happened.error();
            squares = squares.plus(error.zip(error, |a, b| a * b));
        }
        black_box(squares);
    }
}
