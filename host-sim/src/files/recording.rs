//! A board's telemetry as a table: the columns that `identify` and `replay` read, then all else.

use super::export::{Column, Table};
use twinrotor::SAMPLE_TIME;
use twinrotor::telemetry::{Frame, Kept, TrialPhase};

/// Where telemetry has gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Gaps {
    /// How many.
    pub gaps: usize,
    /// \[ticks\] Lost in all.
    pub lost_ticks: u32,
}

/// \[ticks\] Lost before each frame, for frames that should come every `every` ticks.
fn lost(frames: &[Frame], every: u16) -> Vec<u32> {
    let between =
        frames.windows(2).map(|pair| pair[1].tick.wrapping_sub(pair[0].tick).saturating_sub(every.into()));
    std::iter::once(0).chain(between).take(frames.len()).collect()
}

/// How many ticks of `frames` are missing, one every `every` ticks.
#[must_use]
pub fn gaps(frames: &[Frame], every: u16) -> Gaps {
    let lost = lost(frames, every);
    Gaps { gaps: lost.iter().filter(|lost| **lost > 0).count(), lost_ticks: lost.iter().sum() }
}

/// SI units, a row a frame. Volts are those in effect from the row's tick to the next, which is what the tick
/// before has decided; of the first row and after a gap, those of its own tick.
#[must_use]
pub fn table(frames: &[Frame], every: u16) -> Table {
    let mut table = Table::default();
    let acting: Vec<_> = (0..frames.len())
        .map(|k| match k.checked_sub(1).map(|before| &frames[before]) {
            Some(before) if before.tick.wrapping_add(1) == frames[k].tick => before.volts,
            _ => frames[k].volts,
        })
        .collect();
    let mut numbers = |name: &str, of: &dyn Fn(usize) -> f64| {
        table.push(name, Column::Numbers((0..frames.len()).map(of).collect()));
    };
    // Shortest digits: an f32 as an f64 would show seven more that mean nothing.
    let short = |x: f32| x.to_string().parse().unwrap_or(f64::NAN);
    let first = frames.first().map_or(0, |frame| frame.tick);
    let lost = lost(frames, every);
    let time = |k: usize| {
        let ticks = f64::from(frames[k].tick.wrapping_sub(first));
        (ticks * SAMPLE_TIME * 1e6).round() / 1e6
    };
    numbers("t", &time);
    numbers("pitch", &|k| short(frames[k].angle.pitch));
    numbers("yaw", &|k| short(frames[k].angle.yaw));
    numbers("v0", &|k| short(acting[k].main));
    numbers("v1", &|k| short(acting[k].tail));
    numbers("ref_pitch", &|k| short(frames[k].reference.pitch));
    numbers("ref_yaw", &|k| short(frames[k].reference.yaw));
    numbers("gap", &|k| f64::from(lost[k]));
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
    let mut words = |name: &str, of: &dyn Fn(&Frame) -> &'static str| {
        table.push(name, Column::Words(frames.iter().map(|frame| of(frame).to_owned()).collect()));
    };
    words("state", &|frame| twinrotor_station::words::state(frame.state));
    words("trial", &|frame| trial(frame.controller.trial));
    words("controller", &|frame| match frame.controller.accepted {
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
    }
}
