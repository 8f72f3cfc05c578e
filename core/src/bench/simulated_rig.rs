//! A rig that a board computes itself: a bench with somebody beside it, and what may befall it.

use super::{Bench, Faults, Injection};
use crate::SAMPLE_TIME;
use crate::axes::{PerAxis, PerMotor};
use crate::board::Board;
use crate::drive::Duty;
use crate::parameters::Parameters;
use crate::plant::PlantParameters;
use crate::plant::presets::Rig;
use crate::real::Real;
use crate::supervisor::ArmState;

/// A simulated rig, as a board's port sees it. Lies on a table until it is armed.
#[derive(Debug, Clone, Copy)]
pub struct SimulatedRig {
    /// Its plant, encoders, amplifiers.
    pub bench: Bench<f32>,
    /// In its rest pose, sound.
    rest: Bench<f32>,
    body: PlantParameters<f32>,
    current_limit: bool,
    emergency_stop: bool,
    /// \[ticks\]
    stall: u8,
}

impl SimulatedRig {
    /// `rig` in its rest pose.
    pub fn new(rig: &Rig) -> Self {
        let bench = Bench::at_rest(rig, SAMPLE_TIME);
        let body = rig.plant.map(f32::from_f64);
        Self { bench, rest: bench, body, current_limit: false, emergency_stop: false, stall: 0 }
    }

    /// The rig of which the record speaks, at `board`.
    pub fn of(parameters: &Parameters, board: Board) -> Self {
        Self::new(&parameters.rig(board))
    }

    /// What counters of 16 bits show.
    pub fn counters(&self) -> PerAxis<u32> {
        self.bench.counters()
    }

    /// \[V\] Supply of the amplifiers.
    pub fn supply(&self) -> f32 {
        self.bench.supply
    }

    /// The amplifiers' fault line.
    pub fn current_limit(&self) -> bool {
        self.current_limit
    }

    /// The emergency stop is pressed.
    pub fn emergency_stop(&self) -> bool {
        self.emergency_stop
    }

    /// \[ticks\] By which this tick is to be too long; asked once.
    pub fn take_stall(&mut self) -> u8 {
        core::mem::take(&mut self.stall)
    }

    /// From now on.
    pub fn inject(&mut self, injection: &Injection) {
        match *injection {
            Injection::Rest => {
                self.bench.put_back(&self.rest);
                self.bench.become_plant(&self.body);
                self.current_limit = false;
                self.emergency_stop = false;
            }
            Injection::Wiring(faults) => self.bench.faults = faults,
            Injection::Supply(volts) => self.bench.supply = volts,
            Injection::Disturbance(volts) => self.bench.disturbance = volts,
            Injection::CurrentLimit(limits) => self.current_limit = limits,
            Injection::EmergencyStop(pressed) => self.emergency_stop = pressed,
            Injection::Weight { mass, arm } => self.bench.become_plant(&self.body.with_weight(mass, arm)),
            Injection::Stall { ticks } => self.stall = ticks,
        }
    }

    /// A tick passes, in which the board came to `duty` and is in `state`.
    #[inline]
    pub fn tick(&mut self, duty: PerMotor<Duty<f32>>, state: ArmState) {
        self.bench.set_table(state != ArmState::Armed);
        self.bench.tick(duty, state.motors_may_turn());
    }
}

impl Bench<f32> {
    /// Somebody lays it down as `rest` lies, and repairs it. Its encoders count the way.
    fn put_back(&mut self, rest: &Self) {
        self.plant = rest.plant.on_cable_of(&self.plant);
        self.held = false;
        self.supply = rest.supply;
        self.disturbance = PerMotor::zero();
        self.faults = Faults::default();
        self.count();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::F405;
    use crate::defaults;
    use crate::drive::Drive;
    use crate::pipeline::Settings;
    use crate::plant::presets;

    fn record(name: &str, rig: &Rig) -> Parameters {
        Parameters::new(rig, &Settings::new(rig, defaults::named(name).unwrap(), SAMPLE_TIME))
    }

    /// What a record keeps of a rig is all that its bench needs: constants, encoders, supply as `f32` has
    /// them, the rest pose to a count.
    #[test]
    fn the_rig_of_a_record_is_the_presets() {
        for (name, preset) in presets::ALL {
            let rig = record(name, &preset).rig(preset.board);
            assert_eq!(rig.plant.map(f32::from_f64), preset.plant.map(f32::from_f64), "{name}");
            assert_eq!(rig.encoder_counts, preset.encoder_counts, "{name}");
            assert_eq!(rig.volts_limit.cast::<f32>(), preset.volts_limit.cast::<f32>(), "{name}");
            let off = rig.rest_angle.minus(preset.rest_angle);
            let count = preset.encoder_counts.map(|counts| core::f64::consts::TAU / f64::from(counts));
            assert!(off.pitch.abs() <= 0.5 * count.pitch && off.yaw.abs() <= 0.5 * count.yaw, "{name}");
        }
    }

    /// A rig that lies does not move at all, so that it does not matter for how long it lay.
    #[test]
    fn every_rig_lies_still_until_it_is_armed() {
        for (name, preset) in presets::ALL {
            let mut rig = SimulatedRig::of(&record(name, &preset), F405);
            let begin = rig.bench.state();
            (0..3_000).for_each(|_| rig.tick(PerMotor::default(), ArmState::Ready));
            assert_eq!(rig.bench.state(), begin, "{name}");
            assert_eq!(rig.counters(), PerAxis::both(0), "{name}");
        }
    }

    #[test]
    fn put_back_it_is_as_it_was_and_its_encoders_have_counted_the_way() {
        let (name, preset) = ("heli", presets::HELI);
        let mut rig = SimulatedRig::of(&record(name, &preset), F405);
        let begin = rig.bench.state();
        let duty = Drive::new(F405.pwm_steps()).duty(PerMotor::new(20.0, 9.0), rig.supply());
        rig.inject(&Injection::Weight { mass: 0.01, arm: 0.1 });
        rig.inject(&Injection::CurrentLimit(true));
        (0..1_000).for_each(|_| rig.tick(duty, ArmState::Armed));
        assert_ne!(rig.bench.counted(), PerAxis::both(0));
        rig.tick(PerMotor::default(), ArmState::Disarmed);
        rig.inject(&Injection::Rest);
        assert_eq!((rig.bench.state(), rig.bench.counted()), (begin, PerAxis::both(0)));
        assert!(!rig.current_limit());
        // From here on it flies as a new one does.
        let mut new = SimulatedRig::of(&record(name, &preset), F405);
        for _ in 0..500 {
            rig.tick(duty, ArmState::Armed);
            new.tick(duty, ArmState::Armed);
            assert_eq!(rig.bench.state(), new.bench.state());
        }
    }

    #[test]
    fn a_weight_turns_the_nose_down_and_a_disturbance_the_yaw_axis() {
        let flown = |injection: Option<Injection>| {
            let mut rig = SimulatedRig::of(&record("aero2", &presets::AERO2), F405);
            injection.iter().for_each(|injection| rig.inject(injection));
            (0..500).for_each(|_| rig.tick(PerMotor::default(), ArmState::Armed));
            rig.bench.state().angle
        };
        let sound = flown(None);
        assert!(flown(Some(Injection::Weight { mass: 0.05, arm: 0.1 })).pitch < sound.pitch - 0.01);
        let disturbed = flown(Some(Injection::Disturbance(PerMotor::new(0.0, 10.0))));
        assert!((disturbed.yaw - sound.yaw).abs() > 0.01);
    }
}
