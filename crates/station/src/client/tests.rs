use super::*;
use std::collections::VecDeque;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::gains;
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets;
use twinrotor::replay::Replay;
use twinrotor::telemetry::Frame;

fn parameters() -> Parameters {
    Parameters::new(&presets::AERO, &Settings::paper(&presets::AERO, gains::PAPER, SAMPLE_TIME))
}

/// A board that answers as the firmware does, telemetry and noise in between.
#[derive(Default)]
struct Wire {
    decoder: Decoder,
    kept: Option<Parameters>,
    forgets: bool,
    version: u16,
    replay: Option<Replay>,
    out: VecDeque<u8>,
}

impl Wire {
    fn say(&mut self, message: &ToHost) {
        self.out.extend([7, 0]);
        for message in [&ToHost::Frame(Frame::default()), message] {
            self.out.extend(link::encode(message, &mut [0; MAX_FRAME]).unwrap());
        }
    }
}

impl Wire {
    fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            match self.decoder.push::<ToBoard>(byte) {
                Some(Ok(ToBoard::Identify)) => self.say(&ToHost::Identity(Identity {
                    firmware: link::text("0.1.0"),
                    chip: link::text("stm32f405rg"),
                    parameters: self.version,
                    reset: None,
                })),
                Some(Ok(ToBoard::WriteParameters(new))) if new.limits.command_timeout == 1 => {
                    self.say(&ToHost::Refused(Refusal::MotorsMayTurn));
                }
                Some(Ok(ToBoard::WriteParameters(new))) => {
                    self.kept = Some(new);
                    self.say(&ToHost::Saved);
                }
                Some(Ok(ToBoard::ReadParameters)) => {
                    let kept = if self.forgets { None } else { self.kept };
                    self.say(&ToHost::Parameters(
                        kept.unwrap_or(Parameters { checked: true, ..parameters() }),
                    ));
                }
                Some(Ok(ToBoard::Replay(sample))) => {
                    if sample.number == 0 {
                        self.replay = Some(Replay::new(&parameters(), &sample));
                    }
                    let answer = self.replay.as_mut().map(|replay| replay.step(&sample));
                    self.say(&answer.map_or(ToHost::Refused(Refusal::NoReplay), ToHost::Replayed));
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
    let mut wire = Wire { version: parameters::VERSION, ..Wire::default() };
    let Answer::Identity(identity) = ask(&mut wire, Question::Identify).unwrap() else { panic!("who") };
    assert_eq!(identity.chip, "stm32f405rg");
    write(&mut wire, parameters()).unwrap();
    assert_eq!(wire.kept, Some(parameters()));
}

#[test]
fn a_board_that_forgets_refuses_or_speaks_another_version_is_told() {
    let mut forgetful = Wire { forgets: true, ..Wire::default() };
    let error = write(&mut forgetful, parameters()).unwrap_err();
    assert!(error.to_string().contains("other parameters"), "{error}");
    let mut refused = parameters();
    refused.limits.command_timeout = 1;
    let error = write(&mut Wire::default(), refused).unwrap_err();
    assert!(error.to_string().contains("disarm"), "{error}");
    let error = ask(&mut Wire { version: 99, ..Wire::default() }, Question::Identify).unwrap_err();
    assert!(error.to_string().contains("version 99") && !error.is_input(), "{error}");
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
    let mut client = Client::new();
    let mut decoder = Decoder::new();
    let mut said = |client: &mut Client| {
        (0..1_000).for_each(|k| assert!(client.poll(Duration::from_millis(k)).is_none()));
        client.alive_at = Duration::ZERO;
        let mut alive = |byte: &u8| matches!(decoder.push(*byte), Some(Ok(ToBoard::Alive)));
        let bytes = client.take_outgoing();
        bytes.iter().filter(|byte| alive(byte)).count()
    };
    assert_eq!(said(&mut client), 10);
    client.set_attentive(false);
    assert_eq!(said(&mut client), 0);
}
