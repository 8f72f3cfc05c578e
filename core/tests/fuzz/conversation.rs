//! Any message, with any number and nonce, old ones again and again, at a board whose inputs are anything.

use super::{Chance, inputs, sound};
use twinrotor::axes::PerAxis;
use twinrotor::board::F405;
use twinrotor::control_loop::{ControlLoop, Inputs, OperatorCommand};
use twinrotor::controller::ControllerSettings;
use twinrotor::conversation::commands::{self, Commands};
use twinrotor::conversation::{Action, Board, Conversation, Loop};
use twinrotor::drive::Drive;
use twinrotor::encoder::CounterWidth;
use twinrotor::link::{self, ChipSerial, LinkError, Nonce, Refusal, ToBoard};
use twinrotor::parameters::Provenance;
use twinrotor::reference::Reference;
use twinrotor::replay::Sample;
use twinrotor::rig_port::RigPort;
use twinrotor::sequence::{Numbered, Sequence};
use twinrotor::supervisor::{ArmState, Condition, Conditions, Request};
use twinrotor::trial::{Attempt, Candidate};

const NONCE: Nonce = Nonce(0x600D_600D);

fn nonce(chance: &mut Chance) -> Nonce {
    if chance.one_in(3) { Nonce(chance.word()) } else { NONCE }
}

fn message(chance: &mut Chance) -> ToBoard {
    let both = |chance: &mut Chance| PerAxis::new(chance.float(), chance.float());
    match chance.below(18) {
        0 => ToBoard::Identify,
        1 => ToBoard::Disarm,
        2 | 3 => {
            ToBoard::Setpoint(Reference { angle: both(chance), rate: both(chance), accel: both(chance) })
        }
        4 | 5 => ToBoard::Zero,
        6 | 7 => ToBoard::Arm(nonce(chance)),
        8 => ToBoard::ClearFault(nonce(chance)),
        9 => ToBoard::Check(nonce(chance)),
        10 => ToBoard::Telemetry { every: u16::from(chance.byte()) * 5 },
        11 => ToBoard::Replay(Sample {
            number: u32::from(chance.byte() % 3),
            counts: PerAxis::new(chance.word().cast_signed(), chance.word().cast_signed()),
            volts: twinrotor::axes::PerMotor::new(chance.float(), chance.float()),
            wanted: None,
        }),
        12 => ToBoard::WriteParameters(nonce(chance), sound()),
        13 => {
            let controller = sound().settings.controller;
            let law = controller.law.map(|gain| if chance.one_in(20) { chance.float() } else { 0.95 * gain });
            let fade_ms = u32::from(chance.byte());
            ToBoard::Trial(
                nonce(chance),
                Attempt { controller: ControllerSettings { law, ..controller }, fade_ms, revert_ms: 2_000 },
            )
        }
        14 => ToBoard::Accept(nonce(chance)),
        15 => ToBoard::Revert,
        16 => ToBoard::Save(nonce(chance)),
        _ => ToBoard::Alive,
    }
}

/// The board's tick with what it is told, and what it may be given.
struct FuzzedBoard {
    conversation: Conversation,
    control: ControlLoop,
    /// On its way to the loop.
    candidate: Option<Candidate>,
    /// The last command that was dealt with, by its place among all that were said.
    dealt: Option<u64>,
    /// A request of this boot that lets motors turn has been taken, and nothing has ended it since.
    asked: bool,
    turned: u64,
}

impl FuzzedBoard {
    fn boot() -> Self {
        let board = Board {
            firmware: "0",
            chip: "none",
            port: RigPort::Pwm,
            serial: ChipSerial::default(),
            nonce: NONCE,
            reset: None,
            baud: link::BAUD,
        };
        let parameters = sound();
        let drive = Drive::new(F405.pwm_steps());
        Self {
            conversation: Conversation::new(board, parameters, Provenance::Stored),
            control: ControlLoop::new(&parameters, CounterWidth::Bits16, PerAxis::both(0), drive, None),
            candidate: None,
            dealt: None,
            asked: false,
            turned: 0,
        }
    }

    fn hear(
        &mut self,
        (place, said): &(u64, Numbered<ToBoard>),
        queue: &mut commands::Sender<'_>,
    ) -> (bool, bool) {
        let response = self.conversation.receive(Ok(said.clone()), &self.now(queue.ready()));
        let mut disarm = false;
        match response.action {
            Action::Try(command) => {
                assert!(self.candidate.is_none() && said.message.nonce() == Some(NONCE));
                self.candidate = self.conversation.candidate();
                assert!(self.candidate.is_some());
                queue.enqueue(command).expect("the conversation was told that there is room");
            }
            Action::Command(command) => {
                assert!(self.dealt.is_none_or(|last| *place > last), "dealt with twice");
                assert!(said.message.nonce().is_none_or(|nonce| nonce == NONCE));
                self.dealt = Some(*place);
                queue.enqueue(command).expect("the conversation was told that there is room");
            }
            Action::Disarm => disarm = true,
            Action::Keep(parameters) => {
                let may = self.control.state().lets_flash_be_written();
                if may {
                    self.control.adopt(&parameters);
                }
                let outcome = if may { Ok(()) } else { Err(Refusal::MotorsMayTurn) };
                let _ = self.conversation.kept(&parameters, outcome);
            }
            Action::Nothing | Action::Answer(_) | Action::FrameEvery(_) => {}
        }
        (response.heard, disarm)
    }

    fn now(&self, takes_command: bool) -> Loop {
        Loop { takes_command, takes_candidate: self.candidate.is_none(), status: self.control.status() }
    }

    fn tick(&mut self, given: &Inputs<'_>) {
        let before = self.control.state();
        if let Some(Numbered { message: OperatorCommand::Request(request), .. }) = given.command
            && matches!(request, Request::Arm | Request::Check)
        {
            self.asked = true;
        }
        let outputs = self.control.tick(given);
        let turns = outputs.duty.main.steps() != 0 || outputs.duty.tail.steps() != 0;
        let may = self.control.state().motors_may_turn();
        assert_eq!(outputs.enable, may);
        assert!(!turns || may, "volts in {:?}", self.control.state());
        assert!(!may || self.asked, "nobody asked for {:?}", self.control.state());
        assert!(!(given.disarm && may), "a Disarm was not obeyed");
        assert!(given.senses.intersection(Conditions::HAZARDS).is_empty() || !may, "with a hazard");
        if before.motors_may_turn() && !may {
            self.asked = false;
        }
        self.turned += u64::from(turns);
    }
}

#[test]
fn nothing_is_dealt_with_twice_and_no_motor_turns_without_two_yeses() {
    let mut chance = Chance(2);
    let mut board = FuzzedBoard::boot();
    let mut queue = Commands::new();
    let (mut sender, mut receiver) = queue.split();
    let mut said: Vec<(u64, Numbered<ToBoard>)> = Vec::new();
    let (mut next, mut counters, mut armed) = (Sequence(1), PerAxis::both(0_u32), 0_u64);
    let mut tried = 0_u64;
    let (mut quiet, mut place) = (0, 0_u64);
    for _ in 0..inputs() {
        let (mut heard, mut disarm) = (false, false);
        // Long enough for the rig to lie still now and then, as a zero wants.
        if quiet == 0 {
            quiet = if chance.one_in(50) { 3_000 } else { chance.below(30) };
            let again = !said.is_empty() && chance.one_in(3);
            if !again {
                if chance.one_in(200) {
                    // A line does not keep half of all numbers.
                    next = Sequence(next.0.wrapping_add(20_000));
                    said.clear();
                }
                next = next.next();
                place += 1;
                said.truncate(60);
                said.insert(0, (place, message(&mut chance).numbered(next)));
            }
            let numbered = &said[if again { chance.index(said.len()) } else { 0 }];
            (heard, disarm) = board.hear(numbered, &mut sender);
            if chance.one_in(5) {
                let damaged = board.conversation.receive(Err(LinkError::Damaged), &board.now(true));
                assert!(!damaged.heard && damaged.action == Action::Nothing);
            }
        }
        quiet = quiet.saturating_sub(1);
        let wild = chance.one_in(5_000);
        if wild {
            counters = counters.map(|c| c.wrapping_add(chance.word() & 0xFF));
        }
        let senses = Conditions::NONE.with(Condition::EmergencyStop, chance.one_in(3_000));
        let supply = if chance.one_in(10_000) { chance.float() * 60.0 } else { 24.0 };
        let command = commands::next(&mut receiver, disarm).cloned();
        let trial = board.candidate;
        board.tick(&Inputs {
            counters,
            supply,
            current_limit: chance.one_in(500),
            senses,
            heard: heard || chance.one_in(100),
            disarm,
            trial: trial.as_ref(),
            command: command.as_ref(),
        });
        board.candidate.take_if(|trial| commands::is_done_with(trial, command.as_ref(), disarm));
        tried += u64::from(board.control.is_trying());
        if command.is_some() {
            commands::done(&mut receiver);
        }
        armed += u64::from(board.control.state() == ArmState::Armed);
    }
    println!(
        "{armed} ticks armed, {tried} with a trial, {} with volts, {} messages stale",
        board.turned,
        board.conversation.stale()
    );
    assert!(armed > 100 && tried > 100 && board.turned > 100, "the experiment reaches what it is about");
}
