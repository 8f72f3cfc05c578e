//! The time base of a timer: prescaler, counter, repetition counter and preload, RM0090 sections
//! 17.3.1 to 17.3.3, worked out in closed form from the virtual clock. Nothing ticks: the counter is
//! asked where it stands, and says which update and compare events passed since it was last asked.

use super::registers::Kind;

const NANOS: u128 = 1_000_000_000;

/// Which way the counter sweeps, `CR1.CMS` and `CR1.DIR`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shape {
    /// From 0 to the reload value, then 0 again.
    #[default]
    Up,
    /// From the reload value to 0, then the reload value again.
    Down,
    /// Up to the reload value and down again. Compare flags rise on the way up, down, or both.
    Centre { flag_up: bool, flag_down: bool },
}

/// The bits of `CR1` and `CCMRx` that say how the counter counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Control {
    /// `CEN`, with the counter on the internal clock.
    pub enabled: bool,
    /// `UDIS`: no update events, so nothing preloaded takes effect.
    pub updates_disabled: bool,
    /// `OPM`: the counter stops at the next update event.
    pub one_pulse: bool,
    /// `ARPE`: the reload value waits for an update event.
    pub reload_preloaded: bool,
    /// `OCxPE`: the compare value waits for an update event.
    pub compare_preloaded: [bool; 4],
    /// The sweep.
    pub shape: Shape,
}

/// The values that an update event moves from what was written to what is in effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Values {
    pub prescaler: u64,
    pub reload: u64,
    pub repetition: u64,
    pub compare: [u64; 4],
}

/// What passed between two looks at the counter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Passed {
    /// Update events.
    pub updates: u64,
    /// Compare matches, by channel.
    pub matched: [bool; 4],
    /// One-pulse mode stopped the counter.
    pub stopped: bool,
}

/// A counter on its clock.
#[derive(Debug, Clone)]
pub struct Counter {
    kind: Kind,
    /// \[Hz\], and the instant that input tick 0 fell on \[ns\].
    clock_hz: u64,
    clock_since: u64,
    control: Control,
    /// As written.
    written: Values,
    /// In effect.
    active: Values,
    /// The position at input tick `origin`. Positions count prescaled ticks and never wrap: every
    /// multiple of a sweep is an overflow or underflow.
    origin: u64,
    origin_position: u64,
    /// The position up to which events were reported.
    seen: u64,
    repetitions_left: u64,
}

impl Counter {
    /// A counter out of reset, on a clock of `clock_hz` \[Hz\].
    pub fn new(kind: Kind, clock_hz: u64) -> Self {
        let values = Values { prescaler: 0, reload: kind.top(), repetition: 0, compare: [0; 4] };
        Self {
            kind,
            clock_hz,
            clock_since: 0,
            control: Control::default(),
            written: values,
            active: values,
            origin: 0,
            origin_position: 0,
            seen: 0,
            repetitions_left: 0,
        }
    }

    /// The values in effect.
    pub fn active(&self) -> &Values {
        &self.active
    }

    /// How it counts.
    pub fn control(&self) -> &Control {
        &self.control
    }

    /// The input clock \[Hz\].
    pub fn clock_hz(&self) -> u64 {
        self.clock_hz
    }

    fn runs(&self) -> bool {
        // 17.3.1: a reload value of zero blocks the counter.
        self.control.enabled && self.clock_hz > 0 && self.active.reload > 0
    }

    fn tick(&self, now: u64) -> u64 {
        let elapsed = u128::from(now - self.clock_since);
        u64::try_from(elapsed * u128::from(self.clock_hz) / NANOS).expect("centuries of ticks")
    }

    fn instant(&self, tick: u64) -> u64 {
        let elapsed = (u128::from(tick) * NANOS).div_ceil(u128::from(self.clock_hz));
        self.clock_since + u64::try_from(elapsed).expect("centuries of nanoseconds")
    }

    /// The ticks from one overflow or underflow to the next.
    fn sweep(&self) -> u64 {
        match self.control.shape {
            Shape::Up | Shape::Down => self.active.reload + 1,
            Shape::Centre { .. } => self.active.reload,
        }
    }

    /// The ticks after which everything repeats.
    fn cycle(&self) -> u64 {
        match self.control.shape {
            Shape::Up | Shape::Down => self.sweep(),
            Shape::Centre { .. } => 2 * self.sweep(),
        }
    }

    fn position(&self, now: u64) -> u64 {
        if !self.runs() {
            return self.origin_position;
        }
        let since = self.tick(now).saturating_sub(self.origin);
        self.origin_position + since / (self.active.prescaler + 1)
    }

    fn tick_of(&self, position: u64) -> u64 {
        self.origin + (position - self.origin_position) * (self.active.prescaler + 1)
    }

    /// Puts the counter at `position` from `now` on.
    fn place(&mut self, now: u64, position: u64) {
        self.origin = if self.clock_hz > 0 { self.tick(now) } else { 0 };
        self.origin_position = position;
        self.seen = position;
    }

    /// `CNT` at `now`, once everything up to `now` has been taken with [`Counter::advance`].
    pub fn count(&self, now: u64) -> u64 {
        let within = self.position(now) % self.cycle().max(1);
        match self.control.shape {
            Shape::Up => within,
            Shape::Down => self.active.reload - within,
            Shape::Centre { .. } => within.min(self.cycle() - within),
        }
    }

    /// `CNT` at `then`, no more than one lap before `now`, of a counter that counts up, once everything up to
    /// `now` has been taken.
    pub fn count_at(&self, then: u64, now: u64) -> u64 {
        let lap = self.active.reload + 1;
        let since = (self.tick(now) - self.tick(then.max(self.clock_since))) / (self.active.prescaler + 1);
        (self.count(now) + lap - since % lap) % lap
    }

    /// Where the counter stands still, for want of a clock.
    pub fn stands_at(&self) -> Option<u64> {
        (self.clock_hz == 0).then(|| self.count(self.clock_since))
    }

    /// Whether it counts down at `now`, which `CR1.DIR` shows.
    pub fn counts_down(&self, now: u64) -> bool {
        match self.control.shape {
            Shape::Up => false,
            Shape::Down => true,
            Shape::Centre { .. } => self.position(now) % self.cycle().max(1) >= self.active.reload,
        }
    }

    /// A write of `CNT`. A count past the reload value runs on to the end of the counter's width on
    /// the part, which nothing here follows: it answers `false`.
    #[must_use]
    pub fn set_count(&mut self, now: u64, count: u64) -> bool {
        let position = match self.control.shape {
            Shape::Up | Shape::Centre { .. } => count,
            Shape::Down => self.active.reload.saturating_sub(count),
        };
        self.place(now, position);
        count <= self.active.reload
    }

    /// The clock changed to `hz` \[Hz\].
    pub fn set_clock(&mut self, now: u64, hz: u64) {
        let position = self.position(now) % self.cycle().max(1);
        self.clock_hz = hz;
        self.clock_since = now;
        self.place(now, position);
    }

    /// `CR1` or `CCMRx` was written.
    pub fn set_control(&mut self, now: u64, control: Control) {
        let count = self.count(now);
        let same_sweep = control.shape == self.control.shape;
        let position = self.position(now) % self.cycle().max(1);
        for channel in 0..4 {
            if !control.compare_preloaded[channel] {
                self.active.compare[channel] = self.written.compare[channel];
            }
        }
        self.control = control;
        if same_sweep {
            self.place(now, position);
        } else {
            // Changed only while stopped or between edge modes, so the count is inside the sweep.
            let _ = self.set_count(now, count);
        }
    }

    /// A write of `PSC` or `RCR`, which always wait for an update event.
    pub fn write_prescaler(&mut self, value: u64) {
        self.written.prescaler = value & 0xFFFF;
    }

    /// See [`Counter::write_prescaler`].
    pub fn write_repetition(&mut self, value: u64) {
        self.written.repetition = value & 0xFF;
    }

    /// A write of `ARR`. Answers `false` for what is not followed here: a reload value moved under
    /// the running count.
    #[must_use]
    pub fn write_reload(&mut self, now: u64, value: u64) -> bool {
        self.written.reload = value & self.kind.top();
        if self.control.reload_preloaded {
            return true;
        }
        let count = self.count(now);
        let ran = self.runs();
        self.active.reload = self.written.reload;
        let inside = self.set_count(now, count.min(self.kind.top()));
        inside || !ran
    }

    /// A write of `CCRx`.
    pub fn write_compare(&mut self, channel: usize, value: u64) {
        self.written.compare[channel] = value & self.kind.top();
        if !self.control.compare_preloaded[channel] {
            self.active.compare[channel] = self.written.compare[channel];
        }
    }

    /// `EGR.UG`: the sweep starts afresh, with everything preloaded in effect unless `UDIS` says no.
    pub fn restart(&mut self, now: u64) {
        if !self.control.updates_disabled {
            self.load();
        }
        self.place(now, 0);
    }

    fn load(&mut self) {
        let compare = self.written.compare;
        self.active = Values { compare, ..self.written };
        self.repetitions_left = self.active.repetition;
    }

    /// Takes every event up to `now`.
    pub fn advance(&mut self, now: u64) -> Passed {
        let mut passed = Passed::default();
        while self.runs() {
            let (start, end, sweep) = (self.seen, self.position(now), self.sweep());
            let overflows = end / sweep - start / sweep;
            if self.control.updates_disabled || overflows <= self.repetitions_left {
                if !self.control.updates_disabled {
                    self.repetitions_left -= overflows;
                }
                self.note_matches(start, end, &mut passed.matched);
                self.seen = end;
                break;
            }
            let update = (start / sweep + 1 + self.repetitions_left) * sweep;
            self.note_matches(start, update, &mut passed.matched);
            passed.updates += 1;
            self.pass_update(update);
            if self.control.one_pulse {
                self.control.enabled = false;
                passed.stopped = true;
                break;
            }
            self.skip_whole_periods(now, &mut passed);
        }
        passed
    }

    /// The update event at `update`: the sweep goes on from there with the preloaded values.
    fn pass_update(&mut self, update: u64) {
        let at_the_top = !update.is_multiple_of(self.cycle());
        self.origin = self.tick_of(update);
        self.load();
        self.origin_position = if at_the_top { self.active.reload } else { 0 };
        self.seen = self.origin_position;
    }

    /// After an update event nothing changes until the next write, so an even number of update
    /// periods (even, for the centre-aligned sweep to come out the same way round) passes at once.
    fn skip_whole_periods(&mut self, now: u64, passed: &mut Passed) {
        if !self.runs() {
            return;
        }
        let period = (self.active.repetition + 1) * self.sweep();
        let elapsed = self.position(now) - self.seen;
        let periods = (elapsed / period) & !1;
        if periods == 0 {
            return;
        }
        let skipped = periods * period;
        self.note_matches(self.seen, self.seen + skipped, &mut passed.matched);
        passed.updates += periods;
        self.origin += skipped * (self.active.prescaler + 1);
    }

    /// The positions within a cycle at which channel `channel` matches and flags it.
    fn match_positions(&self, channel: usize) -> [Option<u64>; 2] {
        let (compare, reload) = (self.active.compare[channel], self.active.reload);
        if compare > reload {
            // 17.4.5, CC1IF: a compare value past the reload value flags at the overflow.
            return [Some(0), None];
        }
        match self.control.shape {
            Shape::Up => [Some(compare), None],
            Shape::Down => [Some(reload - compare), None],
            Shape::Centre { flag_up, flag_down } => {
                [flag_up.then_some(compare), flag_down.then_some(2 * reload - compare)]
            }
        }
    }

    /// The first position past `start` at which `channel` matches.
    fn next_match(&self, channel: usize, start: u64) -> Option<u64> {
        let cycle = self.cycle();
        let first = |within: u64| {
            let base = start / cycle * cycle + within % cycle;
            if base > start { base } else { base + cycle }
        };
        self.match_positions(channel).into_iter().flatten().map(first).min()
    }

    fn note_matches(&self, start: u64, end: u64, matched: &mut [bool; 4]) {
        for (channel, matched) in matched.iter_mut().enumerate() {
            *matched |= self.next_match(channel, start).is_some_and(|position| position <= end);
        }
    }

    /// The instant \[ns\] of the next event among update events and the channels asked for.
    pub fn next_event(&self, updates: bool, channels: [bool; 4]) -> Option<u64> {
        if !self.runs() {
            return None;
        }
        let sweep = self.sweep();
        let update = (self.seen / sweep + 1 + self.repetitions_left) * sweep;
        let pending = self.active != self.written;
        let matches = (0..4)
            .filter(|&channel| channels[channel])
            .filter_map(|channel| self.next_match(channel, self.seen));
        let wanted = !self.control.updates_disabled && (updates || (pending && channels.contains(&true)));
        matches.chain(wanted.then_some(update)).min().map(|position| self.instant(self.tick_of(position)))
    }
}
