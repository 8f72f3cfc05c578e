//! A simulated rig and its loop, for the tests around them.

use super::*;

/// \[rad\]
pub(super) const DEGREE: f32 = core::f32::consts::PI / 180.0;

/// Gains that every preset flies with, if not well.
pub(super) const SOFT: Gains<f64> =
    Gains { pitch: AxisGains { position: 1.2, rate: 2.0 }, yaw: AxisGains { position: 1.0, rate: 1.5 } };

/// The paper's own where the plant is as strong as the paper's, else [`SOFT`].
pub(super) fn gains(rig: &Rig) -> Gains<f64> {
    if rig.plant.effectiveness.main_on_pitch == 0.022 { crate::gains::PAPER } else { SOFT }
}

/// Makes a fault in the cables.
pub(super) type Spoil = fn(&mut Faults);

/// A simulated rig and its loop.
pub(super) struct Flight {
    pub(super) bench: Bench<f32>,
    pub(super) control: ControlLoop,
    pub(super) parameters: Parameters,
    /// \[V\] What is read of the supply, if that is wrong.
    pub(super) supply: Option<f32>,
    pub(super) current_limit: bool,
    pub(super) senses: Conditions,
    pub(super) heard: bool,
    pub(super) disarm: bool,
    pub(super) candidate: Option<Candidate>,
}

impl Flight {
    pub(super) fn new(rig: &Rig, checked: bool) -> Self {
        Self::with(rig, &Settings::paper(rig, gains(rig), SAMPLE_TIME), checked)
    }

    pub(super) fn with(rig: &Rig, settings: &Settings<f64>, checked: bool) -> Self {
        let mut parameters = Parameters::new(rig, settings);
        parameters.checked = checked;
        let bench = Bench::at_rest(rig, SAMPLE_TIME);
        Self {
            bench,
            control: ControlLoop::new(
                &parameters,
                CounterWidth::Bits16,
                bench.counters(),
                Drive::new(rig.board.pwm_steps()),
                None,
            ),
            parameters,
            supply: None,
            current_limit: false,
            senses: Conditions::NONE,
            heard: true,
            disarm: false,
            candidate: None,
        }
    }

    /// Zeroed, armed, on the way to the setpoint.
    pub(super) fn armed(rig: &Rig) -> Self {
        Self::new(rig, true).arm()
    }

    pub(super) fn arm(self) -> Self {
        let mut flight = self;
        flight.run(REST_TICKS + 1, None);
        flight.tick(Some(OperatorCommand::Zero));
        flight.tick(None);
        flight.tick(None);
        assert_eq!(flight.control.state(), ArmState::Ready);
        flight.tick(Some(OperatorCommand::Request(Request::Arm)));
        assert_eq!(flight.control.state(), ArmState::Armed);
        flight
    }

    pub(super) fn tick(&mut self, command: Option<OperatorCommand>) -> Outputs {
        let trial = self.candidate.take();
        let tried =
            trial.map(|candidate| Numbered { sequence: candidate.sequence(), message: OperatorCommand::Try });
        assert!(tried.is_none() || command.is_none(), "one command a tick");
        self.tick_with(trial.as_ref(), tried.or(command.map(numbered)).as_ref())
    }

    pub(super) fn tick_with(
        &mut self,
        trial: Option<&Candidate>,
        command: Option<&Numbered<OperatorCommand>>,
    ) -> Outputs {
        let outputs = self.control.tick(&Inputs {
            counters: self.bench.counters(),
            supply: self.supply.unwrap_or(self.bench.supply),
            current_limit: self.current_limit,
            senses: self.senses,
            heard: self.heard,
            disarm: core::mem::take(&mut self.disarm),
            trial,
            command,
        });
        // It lies on a table until it is armed.
        self.bench.set_table(self.control.state() != ArmState::Armed);
        self.bench.tick(outputs.duty, outputs.enable);
        outputs
    }

    /// A tick, and what telemetry says of it.
    pub(super) fn frame(&mut self, command: Option<OperatorCommand>) -> Frame {
        self.tick(command);
        self.control.frame()
    }

    /// Up to `ticks` ticks; ends with the first fault and gives its cause and tick.
    pub(super) fn run(&mut self, ticks: u32, command: Option<OperatorCommand>) -> Option<(Condition, u32)> {
        let mut command = command;
        for tick in 0..ticks {
            self.tick(command.take());
            if let ArmState::Fault(cause) = self.control.state() {
                return Some((cause, tick));
            }
        }
        None
    }
}

pub(super) fn numbered(message: OperatorCommand) -> Numbered<OperatorCommand> {
    Numbered { sequence: Sequence(1), message }
}

/// Rest at these angles \[rad\].
pub(super) fn setpoint(pitch: f32, yaw: f32) -> Option<OperatorCommand> {
    Some(OperatorCommand::Setpoint(Reference::at_rest(PerAxis::new(pitch, yaw))))
}

/// Every rig with the paper's law and with what its boards boot with.
pub(super) fn flown() -> impl Iterator<Item = (String, Rig, Settings<f64>)> {
    presets::ALL.into_iter().flat_map(|(name, rig)| {
        let tuned = crate::defaults::named(name).expect("a controller for every preset");
        let laws = Settings::paper(&rig, gains(&rig), SAMPLE_TIME);
        let tuned = Settings::new(&rig, tuned, SAMPLE_TIME);
        [(format!("{name}, the paper's law"), rig, laws), (format!("{name}, tuned"), rig, tuned)]
    })
}
