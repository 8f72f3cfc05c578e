//! What a session is to do, and what it has to tell.

use crate::differences::Difference;
use twinrotor::bench::Injection;
use twinrotor::board::Board;
use twinrotor::link::Health;
use twinrotor::parameters::Parameters;
use twinrotor::reference::Reference;
use twinrotor::telemetry::Frame;
use twinrotor::trial::Attempt;

/// What is to be done with a board.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The kind of board that is expected: one whose PWM is of other steps is refused.
    pub board: Board,
    /// What it should fly with.
    pub parameters: Parameters,
    /// What is done about a board that has other ones.
    pub write: Write,
    /// Ask before anything turns or is moved by hand.
    pub ask: bool,
    /// \[ticks\] From frame to frame.
    pub frame_every: u16,
    /// What befalls a rig that the board simulates, and in which tick of the first flight; in order.
    pub injections: Vec<(u32, Injection)>,
    /// What to fly, one after the other, each from level.
    pub legs: Vec<Leg>,
    /// Keep a controller that was accepted in flight, once the motors are off.
    pub save: bool,
}

/// What is done about a board with other parameters than are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Write {
    /// The session ends.
    Never,
    /// The operator is asked.
    Ask,
    /// They are written.
    Always,
}

/// A part of a flight.
#[derive(Debug, Clone, PartialEq)]
pub enum Leg {
    /// These references, a tick each, from level.
    Fly(Vec<Reference<f32>>),
    /// To have this controller tried, until it flies alone.
    Try(Box<Attempt>),
    /// To keep the controller that flies alone.
    Accept,
    /// To go back to the accepted controller.
    Revert,
}

/// What a session needs the operator's word for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wish {
    /// To write the parameters that are asked for over those of the board.
    Write,
    /// To run the first-power check.
    Check,
    /// To have the rig lie still in its rest pose.
    Rest,
    /// To turn the motors.
    Arm,
}

/// What a session has to tell.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A step, in a word, and what came of it.
    Step(&'static str, String),
    /// What the board has otherwise than is asked for.
    Differs(Vec<Difference>),
    /// It waits for [`super::Session::answer`].
    Asks(Wish),
    /// A tick of the board.
    Frame(Frame),
    /// How the board is.
    Health(Health),
    /// A leg has begun in that tick: its first setpoint was taken.
    Begins {
        /// Of the plan's legs, counted from 0.
        leg: usize,
        /// The board's.
        tick: u32,
    },
    /// It is over.
    Over(End),
}

/// How a session ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct End {
    /// Why.
    pub ending: Ending,
    /// What became of the motors.
    pub motors: Motors,
}

/// Why a session ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// All was flown.
    Flown,
    /// It could not go on.
    Trouble(String),
    /// The board ended the flight.
    Stopped(String),
    /// It was to end.
    Interrupted,
}

/// What became of the motors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motors {
    /// Nothing was ever said that turns them.
    NeverTurned,
    /// The board has said that they are off.
    SeenOff,
    /// It was told to, and has not said so.
    NotSeenOff,
}
