//! A flight as a board's telemetry told it: what the board believed, not what the rig did.

use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::estimator::Estimate;
use twinrotor::pipeline::Decision;
use twinrotor::plant::State;
use twinrotor::plant::presets::Rig;
use twinrotor::telemetry::Frame;
use twinrotor_sim::closed_loop::{Logged, Tick};
use twinrotor_sim::flight::{Flight, Moment, Row};
use twinrotor_sim::metrics::Metrics;
use twinrotor_sim::scenario::Scenario;

/// `scenario`, flown on `rig` from level, begun in the board's tick `begin`. Where the line has lost a frame
/// the one before stands for it. The reference is the scenario's: what telemetry calls so has been through
/// the controller's command filter.
#[must_use]
pub fn flown(frames: &[Frame], begin: u32, rig: &Rig, scenario: &Scenario) -> Flight {
    let references = scenario.references::<f64>();
    let place = |frame: &Frame| frame.tick.wrapping_sub(begin);
    let there = |frame: &&Frame| (place(frame) as usize) < references.len();
    let mut left: Vec<&Frame> = frames.iter().filter(there).collect();
    left.sort_by_key(|frame| place(frame));
    let mut left = left.into_iter().peekable();
    let end = frames.iter().filter(there).map(place).max().map_or(0, |last| last as usize + 1);
    let last = u32::try_from(end.saturating_sub(1)).unwrap_or(u32::MAX);
    let mut metrics = Metrics::<f64>::new(last, scenario.steps(PerAxis::zero()), rig.volts_limit);
    let mut rows = Vec::with_capacity(end);
    let mut left_envelope = None;
    let mut now = Frame::default();
    for (tick, reference) in (0_u32..).zip(&references[..end]) {
        while let Some(frame) = left.next_if(|frame| place(frame) <= tick) {
            now = *frame;
        }
        let state = State { angle: now.angle.map(f64::from), rate: now.rate.map(f64::from) };
        let reference = reference.angle;
        let mut decision = Decision::idle(Estimate::exact(state), reference);
        decision.allocation.demand = now.demand.map(f64::from);
        let volts = now.volts.map(f64::from);
        let logged = Logged { angle: state.angle, volts };
        let counts = PerAxis::zero();
        metrics.add(tick, &Tick { state, setpoint: reference, decision, applied: volts, counts, logged });
        if left_envelope.is_none() && !rig.envelope.holds(&state) {
            left_envelope = Some(Moment::of(tick));
        }
        let time = f64::from(tick) * SAMPLE_TIME;
        rows.push(Row {
            time,
            state,
            reference,
            volts,
            disturbance: PerMotor::zero(),
            load: PerAxis::zero(),
            logged,
        });
    }
    Flight { rows, report: metrics.report(0, SAMPLE_TIME), board: None, left_envelope }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::plant::presets::AERO2;

    /// Frames of a flight that follows its reference at once, some lost, from any tick on.
    #[test]
    fn frames_become_rows_where_they_belong_and_lost_ones_repeat_the_last() {
        let scenario = Scenario::named("step").unwrap();
        let references = scenario.references::<f32>();
        let begin = u32::MAX - 100;
        let frames: Vec<Frame> = (0..references.len() + 50)
            .filter(|k| k % 7 != 3)
            .map(|k| Frame {
                tick: begin.wrapping_add(k as u32),
                angle: references[k.min(references.len() - 1)].angle,
                ..Frame::default()
            })
            .collect();
        let flight = flown(&frames, begin, &AERO2, &scenario);
        assert_eq!(flight.rows.len(), references.len());
        assert!(flight.report.pitch.ise.abs() < 1e-9 && flight.left_envelope.is_none());
        assert_eq!(flight.rows[3].state, flight.rows[2].state);
        let half = flown(&frames[..1_000], begin, &AERO2, &scenario);
        assert!((1_160..1_170).contains(&half.rows.len()), "{}", half.rows.len());
    }
}
