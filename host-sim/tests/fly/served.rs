//! A simulated board at the other end of a TCP connection or a pseudo-terminal, and what may go wrong there.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use twinrotor::SAMPLE_TIME;
use twinrotor::defaults;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::parameters::{self, Parameters};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::AERO2;
use twinrotor::supervisor::ArmState;
use twinrotor_station::SimulatedBoard;
use twinrotor_station::pace::Pace;

/// \[ticks\] In the air, before something happens there.
const AIRBORNE: u64 = 500;
/// \[ticks\] That a board goes on when nobody is at its line any more.
const LEFT: u64 = 2_000;

/// What happens to a board or its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mishap {
    /// Nothing.
    None,
    /// There is no board: nothing is ever said.
    Silent,
    /// There is no board: what is said comes back.
    Echo,
    /// Firmware of link version 2.
    Old,
    /// In flight the board's sending line breaks.
    Mute,
    /// In flight both lines break.
    Cut,
    /// In flight the connection is closed.
    HangUp,
    /// In flight the board is reset.
    Reset,
    /// From the start noise, as much as a line of a megabaud carries.
    Flood,
    /// The same from some time in flight on.
    Drown,
    /// Every seventh millisecond half of what the board says is lost.
    Halves,
}

/// A board on a thread of its own.
pub(crate) struct Served {
    /// What `--port` is to name.
    pub(crate) port: String,
    goes_on: Arc<AtomicBool>,
    thread: Option<JoinHandle<bool>>,
}

/// A record for the rig that the firmware has built in.
fn record(checked: bool) -> Parameters {
    Parameters { checked, ..Parameters::new(&AERO2, &Settings::new(&AERO2, defaults::AERO2, SAMPLE_TIME)) }
}

fn board(stored: bool) -> SimulatedBoard {
    let mut store = Store::new(RamFlash::default(), 0);
    if stored {
        parameters::save(&mut store, &record(true), &mut [0; SLOT_SIZE]).unwrap();
    }
    SimulatedBoard::new(&AERO2, record(false), store.into_flash())
}

impl Served {
    /// Over TCP; `stored` is whether the board has been written and checked before.
    pub(crate) fn over_tcp(stored: bool, mishap: Mishap) -> Self {
        Self::listening("127.0.0.1:0", stored, mishap)
    }

    /// At an address, as where another board was before.
    pub(crate) fn listening(at: &str, stored: bool, mishap: Mishap) -> Self {
        let listener = TcpListener::bind(at).unwrap();
        let port = format!("tcp://{}", listener.local_addr().unwrap());
        Self::spawn(port, move |goes_on| {
            let (line, _) = listener.accept().unwrap();
            line.set_nodelay(true).unwrap();
            let [said, closed] = [(); 2].map(|()| line.try_clone().unwrap());
            let close = move || drop(closed.shutdown(std::net::Shutdown::Both));
            serve(board(stored), listen(line), (said, close), mishap, goes_on)
        })
    }

    /// At a pseudo-terminal.
    #[cfg(unix)]
    pub(crate) fn at_a_terminal() -> Self {
        use serialport::{SerialPort, TTYPort};
        let (mut master, slave) = TTYPort::pair().unwrap();
        let port = slave.name().unwrap();
        // Open without the lock that the program will want.
        let open = std::fs::File::options().read(true).write(true).open(&port).unwrap();
        drop(slave);
        master.set_timeout(Duration::from_millis(1)).unwrap();
        Self::spawn(port, move |goes_on| {
            // Kept open, or the terminal would be gone before the program opens it.
            let _open = open;
            let heard = listen(master.try_clone_native().unwrap());
            serve(board(true), heard, (master, || {}), Mishap::None, goes_on)
        })
    }

    fn spawn(port: String, run: impl FnOnce(&AtomicBool) -> bool + Send + 'static) -> Self {
        let goes_on = Arc::new(AtomicBool::new(true));
        let asked = Arc::clone(&goes_on);
        Self { port, goes_on, thread: Some(std::thread::spawn(move || run(&asked))) }
    }

    /// Ends it a moment after the program has gone. Do its motors turn?
    pub(crate) fn turns(mut self) -> bool {
        self.goes_on.store(false, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap()
    }
}

/// What comes over a line, from a thread of its own; it ends with the line.
fn listen(mut line: impl Read + Send + 'static) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let mut bytes = vec![0; 4096];
        loop {
            let count = match line.read(&mut bytes) {
                Ok(0) => return,
                Ok(count) => count,
                Err(error) if error.kind() == ErrorKind::TimedOut => 0,
                Err(_) => return,
            };
            if sender.send(bytes[..count].to_vec()).is_err() {
                return;
            }
        }
    });
    receiver
}

/// Until nobody is at the line any more and a lost link would have been found. Do the motors turn then?
fn serve<W: Write, C: FnOnce()>(
    mut board: SimulatedBoard,
    heard: Receiver<Vec<u8>>,
    (said, close): (W, C),
    mishap: Mishap,
    goes_on: &AtomicBool,
) -> bool {
    let begun = Instant::now();
    let mut line = Some((said, close));
    let mut pace = Pace::new(false, Duration::ZERO);
    let (mut airborne, mut left, mut happened) = (0, 0, false);
    let mut waited_for = Vec::new();
    while left < LEFT {
        let mut bytes = std::mem::take(&mut waited_for);
        loop {
            match heard.try_recv() {
                Ok(more) => bytes.extend(more),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    line = None;
                    break;
                }
            }
        }
        if !goes_on.load(Ordering::Relaxed) {
            line = None;
        }
        if !bytes.is_empty() {
            pace.hear(&bytes, begun.elapsed());
        }
        if let (Mishap::Silent | Mishap::Echo | Mishap::Old, Some((said, _))) = (mishap, &mut line) {
            // COBS of version 2, variant 4 (saved) and its CRC-32.
            const OLD: [u8; 8] = [0x07, 0x02, 0x04, 0x64, 0xB4, 0x82, 0x74, 0x00];
            let answer = match mishap {
                Mishap::Echo => bytes.as_slice(),
                Mishap::Old => &OLD,
                _ => &[],
            };
            let _ = said.write_all(answer);
            std::thread::sleep(Duration::from_millis(1));
            continue;
        }
        if !(happened && mishap == Mishap::Cut) {
            board.push(&bytes);
        }
        let due = if line.is_none() { 10 } else { (0..4).map(|_| pace.due(begun.elapsed())).sum() };
        if due == 0 {
            // It goes on at once when something comes, and does not ask a processor all the time.
            waited_for = heard.recv_timeout(Duration::from_micros(500)).unwrap_or_default();
        }
        for _ in 0..due {
            board.tick();
            airborne += u64::from(board.frame().state == ArmState::Armed);
            left += u64::from(line.is_none());
            let mut said = board.take_outgoing();
            let now = !happened && airborne > AIRBORNE;
            happened |= now;
            match mishap {
                Mishap::Mute | Mishap::Cut if happened => said.clear(),
                Mishap::HangUp if now => {
                    if let Some((_, close)) = line.take() {
                        close();
                    }
                }
                Mishap::Reset if now => board = board.reset(),
                Mishap::Flood => said = vec![0x55; 100],
                Mishap::Drown if happened => said = vec![0x55; 100],
                Mishap::Halves if board.frame().tick.is_multiple_of(7) => said.truncate(said.len() / 2),
                _ => {}
            }
            if line.as_mut().is_some_and(|(line, _)| line.write_all(&said).is_err()) {
                line = None;
            }
        }
    }
    board.frame().state.motors_may_turn()
}
