//! Questions to whoever sits at the terminal, while the board goes on.

use std::io::{BufRead, Write};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use twinrotor::parameters::Parameters;
use twinrotor_station::session::Wish;

/// A question that waits for its answer.
pub(super) struct Question(Receiver<bool>);

impl Question {
    /// Asks; whoever says anything but yes says no, and so does a terminal that is gone.
    pub(super) fn put(wish: &Wish, parameters: &Parameters) -> Self {
        let mut terminal = std::io::stderr().lock();
        let _ = write!(terminal, "{} [y/N] ", text(wish, parameters)).and_then(|()| terminal.flush());
        let (sender, receiver) = channel();
        std::thread::spawn(move || {
            let mut line = String::new();
            let read = std::io::stdin().lock().read_line(&mut line);
            // Nobody may wait for it any more.
            let _ = sender.send(read.is_ok() && matches!(line.trim(), "y" | "Y" | "yes"));
        });
        Self(receiver)
    }

    /// The answer, once there is one.
    pub(super) fn answer(&self) -> Option<bool> {
        match self.0.try_recv() {
            Ok(agrees) => Some(agrees),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(false),
        }
    }
}

fn text(wish: &Wish, parameters: &Parameters) -> String {
    let push = parameters.limits.check;
    let degrees = |x: f32| x.abs().to_degrees();
    match wish {
        Wish::Write => "Write what is asked for to the board?".to_owned(),
        Wish::Check => format!(
            "First-power check: the main motor pushes with {:.1} V until the rig has moved, for 1.5 s at \
             most (pitch by about {:.0}°, yaw by {:.0}°), then the tail motor with {:.1} V (pitch by about \
             {:.0}°, yaw by {:.0}°). Put the rig where it rests, keep clear, and keep a hand on the \
             emergency stop. Begin?",
            push.main.volts,
            degrees(push.main.motion.pitch),
            degrees(push.main.motion.yaw),
            push.tail.volts,
            degrees(push.tail.motion.pitch),
            degrees(push.tail.motion.yaw),
        ),
        Wish::Rest => "Let the rig lie still in its rest pose: that becomes its zero. Does it?".to_owned(),
        Wish::Arm => "The motors turn from now on and the rig rises to level. Keep clear. Begin?".to_owned(),
    }
}
