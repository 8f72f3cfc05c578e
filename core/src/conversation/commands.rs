//! How the tick takes the operator's commands: one a tick, in order, and none that is older than a disarming.

use crate::control_loop::OperatorCommand;
use crate::sequence::Numbered;
use crate::trial::Candidate;
use heapless::spsc::{Consumer, Producer, Queue};

/// Commands that may wait; a burst of [clear, zero, setpoint, arm] is ordinary.
pub const ROOM: usize = 7;

/// Commands on their way from the conversation to the tick.
pub type Commands = Queue<Numbered<OperatorCommand>, { ROOM + 1 }>;
/// The conversation's end.
pub type Sender<'q> = Producer<'q, Numbered<OperatorCommand>>;
/// The tick's end.
pub type Receiver<'q> = Consumer<'q, Numbered<OperatorCommand>>;

/// The command of this tick, which stays in the queue until [`done`]. Where the operator disarms, what waits
/// is forgotten: an `Arm` that was said before must not be taken after.
#[inline(always)]
pub fn next<'a>(queue: &'a mut Receiver<'_>, disarm: bool) -> Option<&'a Numbered<OperatorCommand>> {
    if disarm {
        while queue.dequeue().is_some() {}
    }
    queue.peek()
}

/// The command that [`next`] gave has been taken.
#[inline(always)]
pub fn done(queue: &mut Receiver<'_>) {
    let _ = queue.dequeue();
}

/// Whether the candidate that waits beside the queue is of no more use after a tick of `command` and
/// `disarm`: it was taken, or forgotten with what waited for it.
#[inline(always)]
pub fn is_done_with(
    candidate: &Candidate,
    command: Option<&Numbered<OperatorCommand>>,
    disarm: bool,
) -> bool {
    disarm || command.is_some_and(|command| candidate.is_asked_for_by(command))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::Sequence;
    use crate::supervisor::Request;

    #[test]
    fn what_was_said_before_a_disarming_is_forgotten_and_what_is_said_after_is_taken() {
        let mut queue = Commands::new();
        let (mut sender, mut receiver) = queue.split();
        let arm =
            |number| Numbered { sequence: Sequence(number), message: OperatorCommand::Request(Request::Arm) };
        for number in 0..ROOM as u16 {
            sender.enqueue(arm(number)).unwrap();
        }
        assert!(!sender.ready());
        assert_eq!(next(&mut receiver, false), Some(&arm(0)));
        done(&mut receiver);
        assert_eq!(next(&mut receiver, true), None);
        sender.enqueue(arm(99)).unwrap();
        assert_eq!(next(&mut receiver, false), Some(&arm(99)));
    }
}
