//! The paper's stability claim: M of eq. (18) falls, as long as no voltage clips.

use proptest::prelude::*;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::gains::Gains;
use twinrotor::law::Backstepping;
use twinrotor::plant::State;
use twinrotor::plant::presets;
use twinrotor::reference::Reference;
use twinrotor_sim::closed_loop::{ClosedLoop, IdealLoop};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::scenario::SAMPLE_TIME;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// In f64, with a constant reference, over unsaturated ticks of random runs: M_{k+1} <= M_k + 1e-20. (The
    /// reference is constant from the start, so there is no tick after a jump to leave out.)
    #[test]
    fn m_never_rises_while_nothing_clips(
        k in prop::array::uniform4(1.0..25.0_f64),
        start in prop::array::uniform2(-0.6..0.6), goal in prop::array::uniform2(-0.6..0.6),
        preset in 0..presets::ALL.len(),
    ) {
        let rig = presets::ALL[preset].1;
        let gains = Gains::from_paper_order(k);
        let settings = GainsFile::backstepping(gains).settings(&rig);
        let state = State::at_rest(PerAxis::new(start[0], start[1]));
        let mut closed_loop = IdealLoop::<f64>::new(&rig, &settings, state, SAMPLE_TIME);
        let reference = Reference::at_rest(PerAxis::new(goal[0], goal[1]));
        let law = Backstepping::new(gains);
        let mut before: Option<f64> = None;
        let mut compared = 0;
        for _ in 0..4_000 {
            let tick = closed_loop.tick(&reference, PerMotor::zero());
            let m = law.errors(&tick.decision.estimate, &reference).lyapunov();
            if let Some(before) = before {
                prop_assert!(m <= before + 1e-20, "{m:e} after {before:e}");
                compared += 1;
            }
            let clips = tick.decision.allocation.saturated(rig.volts_limit);
            before = (!clips.main && !clips.tail).then_some(m);
        }
        // A run that clips all the way says nothing.
        prop_assume!(compared > 1_000);
    }
}
