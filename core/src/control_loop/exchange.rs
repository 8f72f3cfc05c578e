//! What goes into a tick and what comes out of it.

use crate::axes::{PerAxis, PerMotor};
use crate::bench::Injection;
use crate::drive::Duty;
use crate::first_power::Verdict;
use crate::reference::Reference;
use crate::sequence::Numbered;
use crate::supervisor::{Conditions, Request};
use crate::trial::Candidate;
use serde::{Deserialize, Serialize};

/// What the board has read when a tick begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs<'a> {
    /// What each encoder's counter shows.
    pub counters: PerAxis<u32>,
    /// \[V\] Supply of the amplifiers.
    pub supply: f32,
    /// The amplifier says that it limits the current.
    pub current_limit: bool,
    /// What else is wrong, as only the board can see.
    pub senses: Conditions,
    /// A message came since the last tick.
    pub heard: bool,
    /// The operator wants the motors off. Goes before `command`, which is forgotten.
    pub disarm: bool,
    /// The controller that an [`OperatorCommand::Try`] is about.
    pub trial: Option<&'a Candidate>,
    /// What else the operator wants, if anything new.
    pub command: Option<&'a Numbered<OperatorCommand>>,
}

impl Inputs<'_> {
    /// From a rig and a board with nothing wrong, a host there that wants nothing; `supply` in V.
    #[must_use]
    pub const fn sound(counters: PerAxis<u32>, supply: f32) -> Self {
        Self {
            counters,
            supply,
            current_limit: false,
            senses: Conditions::NONE,
            heard: true,
            disarm: false,
            trial: None,
            command: None,
        }
    }
}

/// What the operator may want of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum OperatorCommand {
    /// To arm, to disarm, to clear a fault, to check the wiring.
    Request(Request),
    /// To be there, and to move on at that rate and acceleration until the next setpoint.
    Setpoint(Reference<f32>),
    /// To take where the rig lies now, motors off and still, for its rest pose.
    Zero,
    /// To try the controller that [`Inputs::trial`] then is, if its number is the command's: while armed, and
    /// while none is tried.
    Try,
    /// To keep the controller that is being tried, once it flies alone.
    Accept,
    /// To go back to the accepted controller.
    Revert,
    /// To let this befall a simulated rig, in this tick. The port does it; the loop only forgets, at
    /// [`Injection::Rest`] with the motors off, what they did before.
    Inject(Injection),
}

/// What the board is to do when a tick ends.
#[derive(Debug, Clone, Copy)]
pub struct Outputs {
    /// To be latched by the PWM at the next tick.
    pub duty: PerMotor<Duty<f32>>,
    /// The core's yes to turning motors: without it, the amplifiers are switched off.
    pub enable: bool,
    /// What the first-power check found, in the tick it ends.
    pub verdict: Option<Verdict>,
}
