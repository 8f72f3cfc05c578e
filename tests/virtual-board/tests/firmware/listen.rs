//! The board's line over TCP: an operator's whole session flies the released firmware, and the host computes
//! the same flight once more.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use twinrotor::axes::PerAxis;
use twinrotor::board::F405;
use twinrotor::parameters::Parameters;
use twinrotor::reference::Reference;
use twinrotor::telemetry::Frame;
use twinrotor_station::again::again;
use twinrotor_station::session::{End, Ending, Event, Leg, Motors, Plan, Session, Write as Writing};
use virtual_board::helicopter::Helicopter;
use virtual_board::listen::Server;
use virtual_board::machine::{Machine, Setup};
use virtual_board::record::{self, ADDRESS, image};

use super::firmware;

/// A board that is served on a thread of its own.
struct Served {
    address: SocketAddr,
    goes_on: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    fn new(parameters: &Parameters, real: bool) -> Self {
        let (rig, _) = record::tuned(record::BUILT_IN);
        let setup = Setup::new(firmware()).with_image(ADDRESS, image(&[*parameters]));
        let supply = rig.volts_limit.main.max(rig.volts_limit.tail);
        let machine = Machine::start(setup, Helicopter::new(&rig, supply));
        let mut server = Server::new("127.0.0.1:0", machine, real).unwrap();
        let address = server.address().unwrap();
        let goes_on = Arc::new(AtomicBool::new(true));
        let asked = Arc::clone(&goes_on);
        let thread =
            std::thread::spawn(move || server.serve(|| asked.load(Ordering::Relaxed)).expect("it runs"));
        Self { address, goes_on, thread: Some(thread) }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.goes_on.store(false, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn connect(address: SocketAddr) -> TcpStream {
    let line = TcpStream::connect(address).unwrap();
    line.set_nodelay(true).unwrap();
    line.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    line
}

/// A session over `line` to its end, with every frame. Its clock is the board's alone, so that a busy machine
/// changes nothing.
fn run(mut line: TcpStream, session: &mut Session) -> (End, Vec<Frame>) {
    let (begun, mut frames, mut bytes) = (Instant::now(), Vec::new(), [0; 4096]);
    loop {
        session.poll(Duration::ZERO);
        line.write_all(&session.take_outgoing()).unwrap();
        let count = match line.read(&mut bytes) {
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(error) => panic!("{error}"),
        };
        session.push(&bytes[..count], Duration::ZERO);
        while let Some(event) = session.event() {
            match event {
                Event::Frame(frame) => frames.push(frame),
                Event::Over(end) => return (end, frames),
                _ => {}
            }
        }
        assert!(begun.elapsed() < Duration::from_secs(300), "no end");
    }
}

fn plan(parameters: &Parameters, legs: Vec<Leg>) -> Plan {
    Plan {
        board: F405,
        parameters: *parameters,
        write: Writing::Never,
        ask: false,
        frame_every: 1,
        injections: Vec::new(),
        legs,
        save: false,
    }
}

fn step() -> Leg {
    Leg::Fly(vec![Reference::at_rest(PerAxis::new(0.15, 0.4)); 3_000])
}

#[test]
fn a_session_over_tcp_flies_the_board_as_the_host_does_bit_for_bit() {
    let (rig, parameters) = record::tuned(record::BUILT_IN);
    let board = Served::new(&parameters, false);
    let mut session = Session::new(plan(&parameters, vec![step()]), Duration::ZERO);
    let (end, frames) = run(connect(board.address), &mut session);
    assert_eq!(end, End { ending: Ending::Flown, motors: Motors::SeenOff });
    let same = again(&rig, &parameters, &frames, session.said(), None).unwrap_or_else(|e| panic!("{e}"));
    assert!(same > 4_500, "{same}");
    // The line is free again for the next program, and taken for a third.
    let mut line = connect(board.address);
    line.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let mut third = connect(board.address);
    third.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    assert_eq!(third.read(&mut [0; 8]).unwrap(), 0, "closed at once");
    assert!(line.read(&mut [0; 8]).is_ok_and(|count| count > 0), "telemetry comes");
}

/// A program that goes away in flight: the board itself switches off, and says why to the next one.
#[test]
fn a_board_whose_program_goes_away_in_flight_switches_off() {
    let (_, parameters) = record::tuned(record::BUILT_IN);
    let board = Served::new(&parameters, false);
    let mut session = Session::new(plan(&parameters, vec![step()]), Duration::ZERO);
    let (mut line, mut bytes) = (connect(board.address), [0; 4096]);
    'flight: loop {
        session.poll(Duration::ZERO);
        line.write_all(&session.take_outgoing()).unwrap();
        let count = line.read(&mut bytes).unwrap_or_default();
        session.push(&bytes[..count], Duration::ZERO);
        while let Some(event) = session.event() {
            match event {
                Event::Begins { .. } => break 'flight,
                Event::Over(end) => panic!("{end:?}"),
                _ => {}
            }
        }
    }
    drop(line);
    let mut next = Session::new(plan(&parameters, vec![step()]), Duration::ZERO);
    let mut line = connect(board.address);
    let (begun, mut steps) = (Instant::now(), Vec::new());
    while !steps.iter().any(|(step, _)| *step == "cleared") {
        next.poll(Duration::ZERO);
        line.write_all(&next.take_outgoing()).unwrap();
        let count = line.read(&mut bytes).unwrap_or_default();
        next.push(&bytes[..count], Duration::ZERO);
        let step = |event| if let Event::Step(step, told) = event { Some((step, told)) } else { None };
        steps.extend(std::iter::from_fn(|| next.event()).filter_map(step));
        assert!(begun.elapsed() < Duration::from_secs(60), "{steps:?}");
    }
    let fault = steps.iter().find(|(step, _)| *step == "fault").unwrap();
    assert_eq!(fault.1, "the host was silent for too long");
}

/// \[s\] That the clock is looked at for, unless `TWINROTOR_REAL_TIME` says otherwise.
const REAL_TIME: f64 = 5.0;

/// Ticks by the clock, over some seconds: within a hundredth, at least in one of a few tries, since the
/// machine may be busy with something else.
#[test]
fn a_board_in_real_time_keeps_to_the_clock() {
    let (_, parameters) = record::tuned(record::BUILT_IN);
    let board = Served::new(&parameters, true);
    let mut line = connect(board.address);
    let mut decoder = twinrotor::link::Decoder::new();
    let mut last = |until: Duration| {
        let (begun, mut tick, mut bytes) = (Instant::now(), 0, [0; 4096]);
        while begun.elapsed() < until || tick == 0 {
            let count = line.read(&mut bytes).unwrap_or_default();
            for received in bytes[..count].iter().filter_map(|&byte| decoder.push(byte)) {
                if let Ok(twinrotor::link::ToHost::Frame(frame)) = received {
                    tick = frame.tick;
                }
            }
        }
        (tick, Instant::now())
    };
    let wanted = std::env::var("TWINROTOR_REAL_TIME");
    let seconds = wanted.map_or(REAL_TIME, |seconds| seconds.parse().expect("seconds"));
    let mut rate = || {
        let (first, at) = last(Duration::from_millis(500));
        let (end, then) = last(Duration::from_secs_f64(seconds));
        let rate = f64::from(end - first) * 1e-3 / (then - at).as_secs_f64();
        println!("{} ticks in {:.3} s: {rate:.5} of real time", end - first, (then - at).as_secs_f64());
        rate
    };
    let keeps = (0..6).any(|_| (rate() - 1.0).abs() < 0.01);
    assert!(keeps, "never within a hundredth");
}
