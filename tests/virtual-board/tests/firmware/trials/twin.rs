//! The host's simulated board, told what the board on the line was told, each command in the tick in which
//! the board's telemetry says that it took it.

use std::collections::HashMap;

use twinrotor::link::{MAX_FRAME, Nonce, ToBoard, ToHost, encode};
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, Parameters};
use twinrotor::plant::presets::Rig;
use twinrotor::sequence::Numbered;
use twinrotor::telemetry::Frame;
use twinrotor_station::SimulatedBoard;
use virtual_board::helicopter::Helicopter;

/// A flight as the board told it.
pub(super) struct Flown {
    pub(super) rig: Rig,
    pub(super) parameters: Parameters,
    pub(super) said: Vec<(u32, Numbered<ToBoard>)>,
    pub(super) frames: Vec<Frame>,
}

/// What the twin is not told.
pub(super) type LeavesOut = fn(&ToBoard) -> bool;

/// What the tick takes, or is refused.
fn acts(message: &ToBoard) -> bool {
    !matches!(
        message,
        ToBoard::Alive | ToBoard::Identify | ToBoard::Telemetry { .. } | ToBoard::ReadParameters
    )
}

/// Of a trial.
pub(super) fn of_a_trial(message: &ToBoard) -> bool {
    matches!(message, ToBoard::Trial(..) | ToBoard::Accept(_) | ToBoard::Revert)
}

impl Flown {
    /// What the twin tells of every tick to the flight's last.
    pub(super) fn twin(&self, leaves_out: LeavesOut) -> Vec<Frame> {
        let mut flash = Store::new(RamFlash::default(), 0);
        parameters::save(&mut flash, &self.parameters, &mut [0; SLOT_SIZE])
            .expect("a flash that never fails");
        let mut board = SimulatedBoard::new(&self.rig, self.parameters, flash.into_flash());
        board.rig.bench.supply = Helicopter::new(&self.rig, supply(&self.rig)).measured_supply();
        let mut said = self.schedule().into_iter().peekable();
        let last = self.frames.last().expect("frames").tick;
        (0..=last)
            .map(|tick| {
                while let Some((_, message)) = said.next_if(|(due, _)| *due <= tick) {
                    if !leaves_out(&message.message) {
                        board.push(encode(&message, &mut [0; MAX_FRAME]).expect("it came over the line"));
                    }
                }
                board.tick();
                board.frame()
            })
            .collect()
    }

    /// Each message and the tick before which it came: a command's own, and what is no command at about its
    /// time, in order.
    fn schedule(&self) -> Vec<(u32, Numbered<ToBoard>)> {
        let taken = self.frames.iter().filter(|frame| frame.taken.ago < u8::MAX);
        let taken: HashMap<u16, u32> =
            taken.map(|frame| (frame.taken.sequence.0, frame.tick - u32::from(frame.taken.ago))).collect();
        // Backwards: no message comes after the tick that took a later one.
        let mut next = u32::MAX;
        let mut schedule: Vec<(u32, Numbered<ToBoard>)> = self
            .said
            .iter()
            .rev()
            .map(|(about, message)| {
                let here = message.message.clone().meant_for(Nonce(0)).numbered(message.sequence);
                let due = match taken.get(&message.sequence.0) {
                    Some(&tick) => {
                        next = tick;
                        tick
                    }
                    // What was refused is told after what it was refused for.
                    None if acts(&message.message) => next,
                    None => next.min(about + 3),
                };
                (due, here)
            })
            .collect();
        schedule.reverse();
        // Forwards: nor before an earlier one.
        let mut last = 0;
        for (due, _) in &mut schedule {
            last = last.max(*due);
            *due = last;
        }
        schedule
    }
}

/// \[V\] Of the amplifiers, as [`super::super::start`] has it.
fn supply(rig: &Rig) -> f64 {
    rig.volts_limit.main.max(rig.volts_limit.tail)
}

/// Every bit of a frame.
pub(super) fn bytes(frame: &Frame) -> Vec<u8> {
    encode(&ToHost::Frame(*frame), &mut [0; MAX_FRAME]).expect("it fits").to_vec()
}
