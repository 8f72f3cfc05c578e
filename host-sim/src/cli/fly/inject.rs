//! What is to befall a rig that the board simulates, by `--inject` and by its scenario, in order.

use crate::error::{Failure, Outcome};
use twinrotor::bench::Injection;
use twinrotor_sim::scenario::Inject;

/// By the tick of a flight of `duration` \[s\], in order.
pub(super) fn by_tick(injects: &[Inject], duration: f64) -> Outcome<Vec<(u32, Injection)>> {
    if let Some(late) = injects.iter().find(|inject| inject.seconds >= duration) {
        return Err(Failure::Input(format!(
            "--inject is at {} s; allowed: before the scenario's end at {duration} s",
            late.seconds
        )));
    }
    let mut all: Vec<_> = injects.iter().map(|inject| (inject.tick(), inject.injection)).collect();
    all.sort_by_key(|(tick, _)| *tick);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_come_in_order_and_before_the_end() {
        let parsed = ["stop@2", "stuck-yaw@0.5"].map(|text| text.parse().unwrap());
        let ticks: Vec<u32> = by_tick(&parsed, 5.0).unwrap().into_iter().map(|(tick, _)| tick).collect();
        assert_eq!(ticks, [500, 2_000]);
        assert!(by_tick(&parsed, 2.0).is_err());
    }
}
