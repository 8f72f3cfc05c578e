//! A board on its bench, flown through what may happen to it.

use twinrotor::SAMPLE_TIME;
use twinrotor::axes::PerAxis;
use twinrotor::bench::{Bench, Hardware};
use twinrotor::control_loop::{ControlLoop, Inputs, OperatorCommand, Outputs};
use twinrotor::drive::Drive;
use twinrotor::encoder::CounterWidth;
use twinrotor::first_power::REST_TICKS;
use twinrotor::parameters::Parameters;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::Rig;
use twinrotor::plant::{RealPlant, State};
use twinrotor::real::Real;
use twinrotor::reference::Reference;
use twinrotor::sequence::{Numbered, Sequence};
use twinrotor::supervisor::{ArmState, Condition, Request};

/// A cut of the motors, and the tick of the run in which it came.
pub(crate) type Cut = (Condition, u32);

/// A rig and the loop that its board runs.
#[derive(Clone, Copy)]
pub(crate) struct Flight {
    pub(crate) bench: Bench<f32>,
    control: ControlLoop,
}

impl Flight {
    /// Armed at level, on a true `rig` that the board knows as `settings` say, encoders at this phase
    /// \[counts, 0..1\].
    pub(crate) fn armed(rig: &Rig, settings: &Settings<f64>, phase: PerAxis<f64>) -> Self {
        let mut parameters = Parameters::new(rig, settings);
        parameters.checked = true;
        let level = State::at_rest(PerAxis::new(0.0, 0.0));
        let mut bench = Bench::new(RealPlant::new(&rig.plant, level, SAMPLE_TIME), &Hardware::of(rig, phase));
        bench.supply = f32::from_f64(rig.supply.nominal);
        // It was zeroed in its rest pose, and somebody has lifted it since.
        for encoder in [&mut parameters.encoders.pitch, &mut parameters.encoders.yaw] {
            encoder.rest_counts = 0;
        }
        let control = ControlLoop::new(
            &parameters,
            CounterWidth::Bits16,
            bench.counters(),
            Drive::new(rig.board.pwm_steps()),
            None,
        );
        let mut flight = Self { bench, control };
        for _ in 0..=REST_TICKS {
            flight.board(None);
        }
        flight.board(Some(OperatorCommand::Zero));
        flight.board(None);
        flight.board(None);
        flight.board(Some(OperatorCommand::Request(Request::Arm)));
        assert_eq!(flight.control.state(), ArmState::Armed);
        flight
    }

    fn board(&mut self, command: Option<OperatorCommand>) -> Outputs {
        self.control.tick(&Inputs {
            command: command.map(|message| Numbered { sequence: Sequence(1), message }).as_ref(),
            ..Inputs::sound(self.bench.counters(), self.bench.supply)
        })
    }

    /// The setpoint is at rest here \[deg\].
    pub(crate) fn aim(&mut self, pitch: f32, yaw: f32) {
        let angle = PerAxis::new(pitch.to_radians(), yaw.to_radians());
        let outputs = self.board(Some(OperatorCommand::Setpoint(Reference::at_rest(angle))));
        self.bench.tick(outputs.duty, outputs.enable);
    }

    /// `ticks` ticks, each with what `happens` to the flight before it; ends at the first cut.
    pub(crate) fn run(&mut self, ticks: u32, mut happens: impl FnMut(&mut Self, u32)) -> Option<Cut> {
        for tick in 0..ticks {
            happens(self, tick);
            let outputs = self.board(None);
            self.bench.tick(outputs.duty, outputs.enable);
            if let ArmState::Fault(cause) = self.control.state() {
                return Some((cause, tick));
            }
        }
        None
    }
}
