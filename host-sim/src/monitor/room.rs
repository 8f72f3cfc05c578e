//! Where the board is: its line, its operator's desk, and the pages that look at it. One of them controls. If
//! it is closed or says nothing for more than a second while motors may turn, they are switched off.

use super::visitor::numbered;
use crate::line::{self, Line};
use crate::stop;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError};
use std::time::{Duration, Instant};
use twinrotor::supervisor::Request as Wanted;
use twinrotor::telemetry::Frame;
use twinrotor_sim::Error;
use twinrotor_station::pace::Pace;
use twinrotor_web::desk::Desk;
use twinrotor_web::request::{self, Request};

/// How long the page that controls may say nothing while motors may turn. It says something ten times a
/// second; what else it takes to switch them off must be done within 1.5 s.
const HEARTBEAT: Duration = Duration::from_millis(1_200);
/// From one packet of samples to the next.
const PACKET: Duration = Duration::from_millis(10);
/// From one try to open a line again to the next.
const REOPEN: Duration = Duration::from_secs(1);
/// What to do about a line that is broken.
const REMEDY: &str = "plug it in: it is opened again by itself";
/// How long the room rests where nothing else makes it wait.
const REST: Duration = Duration::from_millis(1);

/// What a visitor wants.
pub(super) enum Ask {
    /// To look on, and to hear by this.
    Come(u64, SyncSender<Told>),
    /// It is still there.
    Alive(u64),
    /// Something of the desk, under a number of its own.
    Say(u64, Value, Request),
    /// To control.
    Take(u64, Value),
    /// To look on from now on: its page shows something else than the board.
    Look(u64, Value),
    /// It has gone.
    Leave(u64),
}

/// What it is told.
pub(super) enum Told {
    Text(String),
    Rows(Vec<u8>),
    GoodBye,
}

/// Where the board's bytes go.
pub(super) enum Way {
    /// To a board that the desk simulates, in real time.
    Here(Box<Pace>),
    /// To a line of this name, if it is open.
    There(String, Option<Box<dyn Line>>),
}

/// The room.
pub(super) struct Room {
    desk: Desk,
    way: Way,
    visitors: BTreeMap<u64, SyncSender<Told>>,
    control: Option<u64>,
    /// When the page that controls was heard last; nothing until it asks something of the desk for the first
    /// time, which is when it is ready to show it.
    heard: Option<Instant>,
    rows: Vec<f32>,
    packet: Instant,
    reopen: Instant,
    begun: Instant,
    /// Somebody has controlled, and nobody does.
    left: bool,
    /// Something was said that may turn a motor.
    turns: bool,
    over: bool,
}

impl Room {
    pub(super) fn new(desk: Desk, way: Way) -> Self {
        let now = Instant::now();
        Self {
            turns: desk.motors_may_turn(),
            desk,
            way,
            visitors: BTreeMap::new(),
            control: None,
            heard: None,
            left: false,
            rows: Vec::new(),
            packet: now,
            reopen: now,
            begun: now,
            over: false,
        }
    }

    /// Until a signal asks to stop.
    pub(super) fn run(&mut self, asks: &Receiver<Ask>) {
        while !stop::requested() {
            while let Ok(ask) = asks.try_recv() {
                self.take(ask);
            }
            self.watch_over();
            self.turn();
            self.tell_samples();
        }
    }

    /// The motors off before the end: whether that was seen, or nothing if none could have turned.
    pub(super) fn close(&mut self) -> Option<bool> {
        self.over = true;
        for visitor in self.visitors.values() {
            let _ = visitor.try_send(Told::GoodBye);
        }
        self.turns.then(|| match &mut self.way {
            Way::Here(_) => {
                self.desk.request(Wanted::Disarm);
                self.desk.advance(20);
                !self.desk.motors_may_turn()
            }
            Way::There(_, Some(line)) => line::switch_off(&mut **line),
            Way::There(_, None) => false,
        })
    }

    /// What was recorded, once.
    pub(super) fn recorded(&mut self) -> Vec<Frame> {
        std::mem::take(&mut self.desk.recorder).into_frames()
    }

    fn take(&mut self, ask: Ask) {
        match ask {
            Ask::Come(id, to) => {
                self.visitors.insert(id, to);
                if self.control.is_none() {
                    self.give_control(Some(id));
                } else {
                    self.tell_control();
                }
            }
            Ask::Alive(id) if self.heard.is_some() => self.hear(id),
            Ask::Alive(_) => {}
            Ask::Take(id, number) => {
                self.give_control(Some(id));
                self.heard = Some(Instant::now());
                self.tell(id, Told::Text(numbered(&number, json!({ "ok": null }))));
            }
            Ask::Look(id, number) => {
                let answer = self.look(id).map(|()| Value::Null);
                self.tell(id, Told::Text(numbered(&number, request::worded(answer))));
            }
            Ask::Say(id, number, request) => {
                self.hear(id);
                let answer = self.answer(id, request);
                self.tell(id, Told::Text(numbered(&number, request::worded(answer))));
            }
            Ask::Leave(id) => {
                self.visitors.remove(&id);
                if self.control == Some(id) {
                    self.desk.cut("the page that controls was closed: motors off");
                    self.give_control(None);
                } else {
                    self.tell_control();
                }
            }
        }
    }

    fn hear(&mut self, id: u64) {
        if self.control == Some(id) {
            self.heard = Some(Instant::now());
        }
    }

    fn answer(&mut self, id: u64, request: Request) -> twinrotor_sim::Outcome<Value> {
        // Anybody may stop it.
        if !request.stops() && !request.only_looks() && self.control != Some(id) {
            return Err(Error::Unusable("another page controls: take over first".to_owned()));
        }
        self.turns |= request.turns();
        request::at_desk(&mut self.desk, request)
    }

    /// A page that shows something else controls no more; not while motors may turn, which nobody would see.
    fn look(&mut self, id: u64) -> twinrotor_sim::Outcome<()> {
        if self.control != Some(id) {
            return Ok(());
        }
        if self.desk.motors_may_turn() {
            let why = "the motors may turn, and a record would hide the board: stop it first";
            return Err(Error::Unusable(why.to_owned()));
        }
        self.give_control(None);
        Ok(())
    }

    fn give_control(&mut self, id: Option<u64>) {
        self.control = id;
        self.left = id.is_none();
        self.heard = None;
        self.tell_control();
    }

    fn tell_control(&mut self) {
        let ids: Vec<u64> = self.visitors.keys().copied().collect();
        for &id in &ids {
            let told = json!({ "controls": self.control == Some(id), "controlled": self.control.is_some() });
            self.tell(id, Told::Text(told.to_string()));
        }
    }

    /// Tells a visitor. One that has not listened for long is let go; samples it may lose.
    fn tell(&mut self, id: u64, told: Told) {
        let Some(to) = self.visitors.get(&id) else { return };
        let loses = matches!(told, Told::Rows(_));
        match to.try_send(told) {
            Err(TrySendError::Full(_)) if loses => {}
            Err(_) => drop(self.visitors.remove(&id)),
            Ok(()) => {}
        }
    }

    /// Is the page that controls still there?
    fn watch_over(&mut self) {
        // What it said last may have been to arm.
        if self.left {
            self.desk.cut("nobody controls the board any more: motors off");
        }
        if self.heard.is_some_and(|heard| heard.elapsed() > HEARTBEAT) {
            self.desk.cut("the page that controls was not heard for more than a second: motors off");
        }
    }

    /// To the board and back.
    fn turn(&mut self) {
        let now = self.begun.elapsed();
        match &mut self.way {
            Way::Here(pace) => {
                let due = pace.due(now);
                if due == 0 {
                    std::thread::sleep(REST);
                } else {
                    self.desk.advance(u32::try_from(due).unwrap_or(u32::MAX));
                }
            }
            Way::There(_, Some(line)) => {
                let said = self.desk.due(now);
                match line.exchange(&said) {
                    Ok(came) => self.desk.hear(&came),
                    Err(error) => {
                        self.desk.line_lost(&error.to_string(), REMEDY);
                        self.way = match std::mem::replace(&mut self.way, Way::There(String::new(), None)) {
                            Way::There(name, _) => Way::There(name, None),
                            here @ Way::Here(_) => here,
                        };
                        self.reopen = Instant::now() + REOPEN;
                    }
                }
            }
            Way::There(name, line) => {
                self.desk.due(now);
                std::thread::sleep(REST);
                if Instant::now() >= self.reopen {
                    self.reopen = Instant::now() + REOPEN;
                    if let Ok((_, opened)) = line::open(name) {
                        *line = Some(opened);
                        self.desk.line_found();
                    }
                }
            }
        }
        self.rows.extend(self.desk.take_samples());
    }

    fn tell_samples(&mut self) {
        if self.rows.is_empty() || self.packet.elapsed() < PACKET {
            return;
        }
        self.packet = Instant::now();
        let bytes: Vec<u8> =
            std::mem::take(&mut self.rows).iter().flat_map(|number| number.to_le_bytes()).collect();
        let ids: Vec<u64> = self.visitors.keys().copied().collect();
        for id in ids {
            self.tell(id, Told::Rows(bytes.clone()));
        }
    }
}

/// Whatever ends it, a panic too, ends it with the motors off.
impl Drop for Room {
    fn drop(&mut self) {
        if !self.over {
            self.close();
        }
    }
}
