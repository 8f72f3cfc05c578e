use super::*;
use std::collections::VecDeque;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::control_loop::Status;
use twinrotor::conversation::{self, Action, Conversation, Loop};
use twinrotor::gains;
use twinrotor::link::{ChipSerial, Refusal};
use twinrotor::parameters::Provenance;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets;
use twinrotor::replay::Replay;
use twinrotor::rig_port::RigPort;
use twinrotor::sequence::Numbered;
use twinrotor::telemetry::{Frame, TrialPhase};

fn parameters() -> Parameters {
    Parameters::new(&presets::AERO, &Settings::paper(&presets::AERO, gains::PAPER, SAMPLE_TIME))
}

/// A board's loop, with room for everything.
const IDLE: Loop = Loop {
    takes_command: true,
    takes_candidate: true,
    status: Status { armed: false, flash_may_be_written: true, trial: TrialPhase::None, accepted: None },
};

fn board(nonce: u32) -> Conversation {
    let board = conversation::Board {
        firmware: "0.1.0",
        chip: "stm32f405rg",
        port: RigPort::Pwm,
        serial: ChipSerial::default(),
        nonce: Nonce(nonce),
        reset: None,
        baud: link::BAUD,
    };
    Conversation::new(board, parameters(), Provenance::Missing)
}

/// A board that answers as the firmware does, telemetry and noise in between.
struct Wire {
    decoder: Decoder,
    board: Conversation,
    refuses: bool,
    forgets: bool,
    version: u16,
    /// Which of its messages from now on does not arrive.
    loses: Option<u32>,
    out: VecDeque<u8>,
}

impl Default for Wire {
    fn default() -> Self {
        let mut board = board(7);
        // It has talked to somebody before.
        board.receive(Ok(ToBoard::Alive.numbered(Sequence(20_000))), &IDLE);
        Self {
            decoder: Decoder::new(),
            board,
            refuses: false,
            forgets: false,
            version: parameters::VERSION,
            loses: None,
            out: VecDeque::new(),
        }
    }
}

impl Wire {
    fn say(&mut self, message: &ToHost) {
        let lost = self.loses == Some(0);
        self.loses = self.loses.and_then(|more| more.checked_sub(1));
        if lost {
            return;
        }
        self.out.extend([7, 0]);
        for message in [&ToHost::Frame(Frame::default()), message] {
            self.out.extend(link::encode(message, &mut [0; MAX_FRAME]).unwrap());
        }
    }

    fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let Some(received) = self.decoder.push(byte) else { continue };
            match self.board.receive(received, &IDLE).action {
                Action::Answer(ToHost::Identity(identity)) => {
                    self.say(&ToHost::Identity(Identity { parameters: self.version, ..identity }));
                }
                Action::Answer(answer) => self.say(&answer),
                Action::Keep(_) if self.forgets => self.say(&ToHost::Saved),
                Action::Keep(new) => {
                    let outcome = if self.refuses { Err(Refusal::MotorsMayTurn) } else { Ok(()) };
                    let answer = self.board.kept(&new, outcome);
                    self.say(&answer);
                }
                _ => {}
            }
        }
    }
}

/// Asks and carries bytes to and fro, as fast as they come.
fn ask(wire: &mut Wire, question: Question) -> Outcome<Answer> {
    let mut client = Client::new();
    client.resynchronise();
    client.ask(question, Duration::ZERO);
    let mut now = Duration::ZERO;
    loop {
        if let Some(Event::Answered(outcome)) = client.poll(now) {
            return outcome;
        }
        wire.take(&client.take_outgoing());
        let bytes: Vec<u8> = wire.out.drain(..).collect();
        for event in client.push(&bytes, now) {
            if let Event::Answered(outcome) = event {
                return outcome;
            }
        }
        now += Duration::from_millis(10);
    }
}

fn write(wire: &mut Wire, parameters: Parameters) -> Outcome<Answer> {
    ask(wire, Question::Write(Box::new(parameters)))
}

#[test]
fn parameters_are_sent_read_back_and_compared() {
    let mut wire = Wire::default();
    let Answer::Identity(identity) = ask(&mut wire, Question::Identify).unwrap() else { panic!("who") };
    assert_eq!(identity.chip, "stm32f405rg");
    let mut other = parameters();
    other.limits.command_timeout = 250;
    write(&mut wire, other).unwrap();
    assert_eq!(wire.board.parameters(), &other);
}

#[test]
fn a_board_that_forgets_refuses_or_speaks_another_version_is_told() {
    let mut other = parameters();
    other.limits.command_timeout = 250;
    let error = write(&mut Wire { forgets: true, ..Wire::default() }, other).unwrap_err();
    assert!(error.to_string().contains("other parameters"), "{error}");
    let error = write(&mut Wire { refuses: true, ..Wire::default() }, other).unwrap_err();
    assert!(error.to_string().contains("disarm"), "{error}");
    let error = ask(&mut Wire { version: 99, ..Wire::default() }, Question::Identify).unwrap_err();
    assert!(error.to_string().contains("version 99") && !error.is_input(), "{error}");
}

/// What was asked twice may be answered once more when something else has been asked.
#[test]
fn a_late_answer_to_a_reading_is_not_taken_for_what_was_written() {
    let mut wire = Wire::default();
    wire.say(&ToHost::Parameters(parameters()));
    let mut other = parameters();
    other.limits.command_timeout = 250;
    write(&mut wire, other).unwrap();
    assert_eq!(wire.board.parameters(), &other);
}

/// Of all that a board says, each message in turn is lost.
#[test]
fn what_is_lost_on_the_line_is_asked_for_again() {
    let other = || Question::Write(Box::new(Parameters { checked: true, ..parameters() }));
    for question in [|| Question::Identify, || Question::Read, other as fn() -> Question] {
        for lost in 0..4 {
            let mut wire = Wire { loses: Some(lost), ..Wire::default() };
            assert!(ask(&mut wire, question()).is_ok(), "{lost}");
        }
    }
}

#[test]
fn a_record_comes_back_answered_in_order_and_its_beginning_must_be_there() {
    let sample =
        |number| Sample { number, counts: PerAxis::new(3, -5), volts: PerMotor::new(6.0, 0.5), wanted: None };
    // More than a board takes in one go.
    let samples: Vec<Sample> = (0..20).map(sample).collect();
    let headless = ask(&mut Wire::default(), Question::Replay(samples[1..].to_vec()));
    assert!(headless.unwrap_err().to_string().contains("beginning"));
    let whole = ask(&mut Wire::default(), Question::Replay(samples.clone())).unwrap();
    let Answer::Replayed(answers) = whole else { panic!("a record") };
    let mut here = Replay::new(&parameters(), &samples[0]);
    assert!(samples.iter().zip(&answers).all(|(sample, answer)| here.step(sample).same_bits(answer)));
    assert_eq!(answers.len(), samples.len());
}

#[test]
fn a_board_that_says_nothing_is_given_up_and_one_that_answers_slowly_is_not() {
    let mut client = Client::new();
    client.ask(Question::Read, Duration::ZERO);
    let mut now = Duration::ZERO;
    while client.poll(now).is_none() {
        assert!(client.due() > now && now < 2 * PATIENCE);
        now = client.due();
    }
    assert_eq!(now, PATIENCE);
    assert!(client.poll(now + PATIENCE).is_none(), "it is told once");
}

#[test]
fn an_attentive_operator_says_so_ten_times_a_second() {
    let mut client = Client { nonce: Some(Nonce(1)), ..Client::new() };
    let mut decoder = Decoder::new();
    let mut said = |client: &mut Client| {
        (0..1_000).for_each(|k| assert!(client.poll(Duration::from_millis(k)).is_none()));
        client.alive_at = Duration::ZERO;
        let mut alive = |byte: &u8| {
            let said = decoder.push::<Numbered<ToBoard>>(*byte);
            matches!(said, Some(Ok(Numbered { message: ToBoard::Alive, .. })))
        };
        let bytes = client.take_outgoing();
        bytes.iter().filter(|byte| alive(byte)).count()
    };
    assert_eq!(said(&mut client), 10);
    client.set_attentive(false);
    assert_eq!(said(&mut client), 0);
}

/// What a client has to say, as a board takes it.
fn said(client: &mut Client) -> Vec<Numbered<ToBoard>> {
    let mut decoder = Decoder::new();
    client.take_outgoing().iter().filter_map(|&byte| decoder.push(byte)).map(Result::unwrap).collect()
}

/// Motors off needs to know nothing of the board; all else waits until it has said who it is.
#[test]
fn a_board_is_met_before_it_is_asked_for_anything_but_motors_off() {
    let mut client = Client::new();
    client.request(Request::Arm);
    client.aim(PerAxis::new(0.1, 0.2));
    client.request(Request::Disarm);
    let kinds: Vec<ToBoard> = said(&mut client).into_iter().map(|numbered| numbered.message).collect();
    assert_eq!(kinds, [ToBoard::Identify, ToBoard::Disarm]);
    let mut wire = Wire::default();
    let identity = link::encode(&wire.board.identity(), &mut [0; MAX_FRAME]).unwrap().to_vec();
    client.push(&identity, Duration::ZERO);
    let setpoint = ToBoard::Setpoint(Reference::at_rest(PerAxis::new(0.1, 0.2)));
    let expected = [ToBoard::Arm(Nonce(7)).numbered(Sequence(20_001)), setpoint.numbered(Sequence(20_002))];
    assert_eq!(said(&mut client), expected);
    // The board's own word of what it expects comes late: what is on its way is not said twice.
    client.push(&identity, Duration::ZERO);
    client.request(Request::Check);
    assert_eq!(said(&mut client), [ToBoard::Check(Nonce(7)).numbered(Sequence(20_003))]);
    // Another boot has another nonce.
    wire.board = board(8);
    let identity = link::encode(&wire.board.identity(), &mut [0; MAX_FRAME]).unwrap().to_vec();
    client.push(&identity, Duration::ZERO);
    client.request(Request::Check);
    assert_eq!(said(&mut client), [ToBoard::Check(Nonce(8)).numbered(Sequence(20_004))]);
}

/// Older firmware: its telemetry alone tells.
#[test]
fn another_version_of_the_link_says_who_must_be_updated() {
    let mut client = Client::new();
    client.ask(Question::Identify, Duration::ZERO);
    // A frame of version 2: COBS of version, variant 4 (saved) and CRC-32.
    let old = [0x07, 0x02, 0x04, 0x64, 0xB4, 0x82, 0x74, 0x00];
    let events = client.push(&old, Duration::ZERO);
    let [Event::Answered(Err(error))] = events.as_slice() else { panic!("{events:?}") };
    assert!(error.to_string().ends_with("update the board's firmware"), "{error}");
}
