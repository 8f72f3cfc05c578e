//! Step 4 of the tick where there is a command filter: from a setpoint to what the law is to follow.

use crate::adaptive_feed_forward::AdaptiveFeedForward;
use crate::allocation::{Allocation, CurrentLimit};
use crate::axes::PerAxis;
use crate::command_filter::{CommandFilter, FilterSettings};
use crate::governor::Governor;
use crate::pipeline::settings::Settings;
use crate::plant::State;
use crate::real::{Mask, Real};
use crate::reference::Reference;

/// Governor, command filter and adaptive feed-forward, in this order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shaper<R> {
    governor: Governor<R>,
    filter: CommandFilter<R>,
    feed_forward: AdaptiveFeedForward<R>,
}

impl<R: Real> Shaper<R> {
    /// At rest at `angle` \[rad\].
    pub(crate) fn new(settings: &Settings<R>, filter: &FilterSettings<R>, angle: PerAxis<R>) -> Self {
        Self {
            governor: Governor::new(settings, filter),
            filter: CommandFilter::new(filter, angle, settings.sample_time),
            feed_forward: AdaptiveFeedForward::new(filter, settings.sample_time),
        }
    }

    /// Starts afresh at `angle` \[rad\], at rest.
    pub(crate) fn restart(&mut self, angle: PerAxis<R>) {
        self.governor.restart();
        self.filter.restart(angle);
        self.feed_forward.restart();
    }

    /// Goes on from where `other` is.
    pub(crate) fn continue_from(&mut self, other: &Self) {
        self.governor.continue_from(&other.governor);
        self.filter.continue_from(&other.filter);
        self.feed_forward.continue_from(&other.feed_forward);
    }

    /// What of `setpoint` to follow in this tick, from `state`, with a `limit` where the motors are known.
    ///
    /// (Once for each kind of number in WebAssembly, whose size counts.)
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    pub(crate) fn step(
        &mut self,
        setpoint: &Reference<R>,
        limit: Option<&CurrentLimit<R>>,
        state: &State<R>,
    ) -> Reference<R> {
        let leave = self.governor.leave(limit);
        let wanted = self.governor.govern(setpoint, &leave);
        let asked = self.filter.step(&wanted, self.governor.reach(&leave));
        let within = self.governor.within(asked, state.angle, &leave);
        let moving = self.governor.moving();
        if !(moving.pitch | moving.yaw).any() {
            return within;
        }
        let in_full = self.governor.in_full();
        let more = self.feed_forward.learn(&within, &wanted, state, in_full);
        // Where nothing moves there is nothing to add, not even a zero: -0 would become 0.
        let accel = within.accel.zip(more, |accel, more| accel + more);
        let accel = PerAxis {
            pitch: R::select(moving.pitch, accel.pitch, within.accel.pitch),
            yaw: R::select(moving.yaw, accel.yaw, within.accel.yaw),
        };
        Reference { accel, ..within }
    }

    /// Ends the tick: what the motors were made to do about it.
    #[inline(always)]
    pub(crate) fn settle(&mut self, allocation: &Allocation<R>) {
        self.feed_forward.settle(allocation.clipped());
    }
}
