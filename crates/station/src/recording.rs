//! A board's telemetry as a table: the columns that `identify` and `replay` read, then all else.

use crate::words;
use twinrotor::SAMPLE_TIME;
use twinrotor::telemetry::{Frame, Kept, TrialPhase};
use twinrotor_sim::table::{Column, Table};

/// Where telemetry has gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Gaps {
    /// How many.
    pub gaps: usize,
    /// \[ticks\] Lost in all.
    pub lost_ticks: u32,
}

impl Gaps {
    /// Counts what is lost between two frames that should be `every` ticks apart.
    pub fn count(&mut self, before: &Frame, frame: &Frame, every: u16) {
        let lost_ticks = lost(before, frame, every);
        self.gaps += usize::from(lost_ticks > 0);
        self.lost_ticks += lost_ticks;
    }
}

/// \[ticks\] Lost between two frames that should be `every` ticks apart.
fn lost(before: &Frame, frame: &Frame, every: u16) -> u32 {
    frame.tick.wrapping_sub(before.tick).saturating_sub(every.into())
}

/// How many ticks of `frames` are missing, one every `every` ticks.
#[must_use]
pub fn gaps(frames: &[Frame], every: u16) -> Gaps {
    let mut gaps = Gaps::default();
    for pair in frames.windows(2) {
        gaps.count(&pair[0], &pair[1], every);
    }
    gaps
}

/// SI units, a row a frame. Volts are those in effect from the row's tick to the next, which is what the tick
/// before has decided; of the first row and after a gap, those of its own tick.
#[must_use]
pub fn table(frames: &[Frame], every: u16) -> Table {
    part(frames, every, 0)
}

/// The rows of that table from one on: parts one after the other are the whole.
#[must_use]
pub fn part(frames: &[Frame], every: u16, from: usize) -> Table {
    let mut table = Table::default();
    let rows = from.min(frames.len())..frames.len();
    let mut numbers = |name: &str, of: &dyn Fn(usize) -> f64| {
        table.push(name, Column::Numbers(rows.clone().map(of).collect()));
    };
    // Shortest digits: an f32 as an f64 would show seven more that mean nothing.
    let short = |x: f32| x.to_string().parse().unwrap_or(f64::NAN);
    let before = |k: usize| k.checked_sub(1).map(|before| &frames[before]);
    let acting = |k: usize| match before(k) {
        Some(before) if before.tick.wrapping_add(1) == frames[k].tick => before.volts,
        _ => frames[k].volts,
    };
    let first = frames.first().map_or(0, |frame| frame.tick);
    let time = |k: usize| {
        let ticks = f64::from(frames[k].tick.wrapping_sub(first));
        (ticks * SAMPLE_TIME * 1e6).round() / 1e6
    };
    let gap = |k: usize| before(k).map_or(0, |before| lost(before, &frames[k], every));
    numbers("t", &time);
    numbers("pitch", &|k| short(frames[k].angle.pitch));
    numbers("yaw", &|k| short(frames[k].angle.yaw));
    numbers("v0", &|k| short(acting(k).main));
    numbers("v1", &|k| short(acting(k).tail));
    numbers("ref_pitch", &|k| short(frames[k].reference.pitch));
    numbers("ref_yaw", &|k| short(frames[k].reference.yaw));
    numbers("gap", &|k| f64::from(gap(k)));
    numbers("tick", &|k| f64::from(frames[k].tick));
    numbers("rate_pitch", &|k| short(frames[k].rate.pitch));
    numbers("rate_yaw", &|k| short(frames[k].rate.yaw));
    numbers("disturbance_pitch", &|k| short(frames[k].disturbance.pitch));
    numbers("disturbance_yaw", &|k| short(frames[k].disturbance.yaw));
    numbers("demand_main", &|k| short(frames[k].demand.main));
    numbers("demand_tail", &|k| short(frames[k].demand.tail));
    numbers("unallocated_pitch", &|k| short(frames[k].unallocated_torque.pitch));
    numbers("unallocated_yaw", &|k| short(frames[k].unallocated_torque.yaw));
    numbers("supply", &|k| short(frames[k].supply));
    numbers("message", &|k| f64::from(frames[k].taken.sequence.0));
    numbers("message_ago", &|k| f64::from(frames[k].taken.ago));
    numbers("trial_percent", &|k| f64::from(frames[k].controller.blend));
    let mut told = |name: &str, of: &dyn Fn(&Frame) -> &'static str| {
        table.push(name, Column::Words(rows.clone().map(|k| of(&frames[k]).to_owned()).collect()));
    };
    told("state", &|frame| words::state(frame.state));
    told("trial", &|frame| trial(frame.controller.trial));
    told("controller", &|frame| match frame.controller.accepted {
        Kept::Stored => "stored",
        Kept::Unsaved => "unsaved",
    });
    table
}

const fn trial(phase: TrialPhase) -> &'static str {
    match phase {
        TrialPhase::None => "none",
        TrialPhase::Shadow => "shadow",
        TrialPhase::FadingIn => "fading-in",
        TrialPhase::Flying => "flying",
        TrialPhase::FadingOut => "fading-out",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::axes::PerMotor;

    #[test]
    fn a_gap_is_marked_and_volts_are_those_that_act() {
        let frame = |tick: u32| Frame { tick, volts: PerMotor::both(tick as f32), ..Frame::default() };
        let frames = [frame(7), frame(8), frame(12), frame(13)];
        assert_eq!(gaps(&frames, 1), Gaps { gaps: 1, lost_ticks: 3 });
        let table = table(&frames, 1);
        let column = |name: &str| match &table.columns.iter().find(|(n, _)| n == name).unwrap().1 {
            Column::Numbers(numbers) => numbers.clone(),
            Column::Counts(_) | Column::Words(_) => panic!(),
        };
        assert_eq!(column("t"), [0.0, 0.001, 0.005, 0.006]);
        assert_eq!(column("gap"), [0.0, 0.0, 3.0, 0.0]);
        assert_eq!(column("v0"), [7.0, 7.0, 12.0, 12.0]);
        assert!(table.to_csv().starts_with("t,pitch,yaw,v0,v1,ref_pitch,ref_yaw,gap,"));
        for from in 0..=frames.len() {
            let parts = super::table(&frames[..from], 1).to_csv() + &part(&frames, 1, from).csv_rows();
            assert_eq!(parts, table.to_csv(), "in two parts, from {from}");
        }
    }
}
