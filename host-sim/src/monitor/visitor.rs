//! A visitor: gets a file, or talks with the room as long as its page is open.
//!
//! A page says `{"number": n, "request": ...}`, what a page from a file asks its own module, and is answered
//! `{"number": n, "ok": ...}` or with an `error`; `{"number": n, "take": true}` takes over and
//! `{"number": n, "look": true}` gives control up, which is refused where motors may turn. Samples come as
//! rows of `f32`, unasked, and `{"controls": ...}` when that changes. A recorded flight is sent beside it.

use super::door::{Door, Knock};
use super::http::{self, Asked};
use super::record;
use super::room::{Ask, Told};
use crate::page::served::File;
use serde_json::{Value, json};
use std::io::{self, ErrorKind};
use std::net::TcpStream;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, sync_channel};
use std::time::Duration;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};
use twinrotor_web::request::{self, Request};
use twinrotor_web::tuner::Tuner;

/// How long a read waits: what is to be said waits no longer.
const MOMENT: Duration = Duration::from_millis(4);
/// \[byte\] The longest message that is taken: a gains file is far shorter.
const LONGEST: usize = 1 << 20;
/// How much may wait for a page that does not listen, before it is let go: seconds.
const WAITING: usize = 512;

/// Whoever has connected is served, or told why not.
///
/// # Errors
///
/// If the line is gone.
pub(super) fn receive(
    mut stream: TcpStream,
    door: &Door,
    files: &[File],
    room: &Sender<Ask>,
    id: u64,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(Duration::from_secs(5)))?;
    let asked = Asked::read(&mut stream)?;
    let converses = asked.line("upgrade").is_some();
    let brings = asked.request.method() == "POST";
    let knock = Knock {
        path: asked.request.uri().path(),
        host: asked.line("host"),
        origin: asked.line("origin"),
        begins: converses || brings,
    };
    let name = match door.opens(&knock) {
        Ok(name) => name,
        Err(why) => return http::refuse(&mut stream, "403 Forbidden", why),
    };
    if converses && name == "socket" {
        asked.agree(&mut stream)?;
        return converse(stream, room, id);
    }
    if brings && name == record::NAME {
        return record::read(&mut stream, &asked);
    }
    match files.iter().find(|file| file.name == name) {
        Some(_) if asked.request.method() != "GET" => {
            http::refuse(&mut stream, "405 Method Not Allowed", "files are only read here")
        }
        Some(file) => http::give(&mut stream, file),
        None => http::refuse(&mut stream, "404 Not Found", "there is no such file"),
    }
}

fn converse(stream: TcpStream, room: &Sender<Ask>, id: u64) -> io::Result<()> {
    stream.set_read_timeout(Some(MOMENT))?;
    stream.set_write_timeout(Some(MOMENT))?;
    let config = WebSocketConfig::default().max_message_size(Some(LONGEST)).max_frame_size(Some(LONGEST));
    let mut talk = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
    let (to, from_room) = sync_channel(WAITING);
    if room.send(Ask::Come(id, to.clone())).is_ok() {
        let answer = move |number: &Value, answer: Value| {
            let _ = to.try_send(Told::Text(numbered(number, answer)));
        };
        talk_on(&mut talk, room, &from_room, id, &answer);
    }
    let _ = room.send(Ask::Leave(id));
    Ok(())
}

/// Until either end has had enough.
fn talk_on(
    talk: &mut WebSocket<TcpStream>,
    room: &Sender<Ask>,
    from_room: &Receiver<Told>,
    id: u64,
    answer: &dyn Fn(&Value, Value),
) {
    let mut tuner = None;
    // A page that does not listen gets no more until it has what it was sent.
    let mut stuck = false;
    loop {
        if stuck {
            stuck = match talk.flush() {
                Ok(()) => false,
                Err(error) if waits(&error) => true,
                Err(_) => return,
            };
        }
        while !stuck {
            let message = match from_room.try_recv() {
                Ok(Told::Text(text)) => Message::text(text),
                Ok(Told::Rows(rows)) => Message::binary(rows),
                Ok(Told::GoodBye) | Err(TryRecvError::Disconnected) => {
                    let _ = talk.close(None).and_then(|()| talk.flush());
                    return;
                }
                Err(TryRecvError::Empty) => break,
            };
            stuck = match talk.send(message) {
                Ok(()) => false,
                Err(error) if waits(&error) => true,
                Err(_) => return,
            };
        }
        match talk.read() {
            Ok(Message::Text(text)) => {
                if !said(&text, room, id, &mut tuner, answer) {
                    return;
                }
            }
            Ok(_) => {}
            Err(error) if waits(&error) => {}
            Err(_) => return,
        }
    }
}

/// Passes on what a page has said. Whether the room is still there.
fn said(
    text: &str,
    room: &Sender<Ask>,
    id: u64,
    tuner: &mut Option<Tuner>,
    answer: &dyn Fn(&Value, Value),
) -> bool {
    let Ok(mut said) = serde_json::from_str::<Value>(text) else { return true };
    let number = said["number"].take();
    if said["take"] == Value::Bool(true) {
        return room.send(Ask::Take(id, number)).is_ok();
    }
    if said["look"] == Value::Bool(true) {
        return room.send(Ask::Look(id, number)).is_ok();
    }
    match serde_json::from_value::<Request>(said["request"].take()) {
        Err(error) => answer(&number, json!({ "error": error.to_string() })),
        Ok(request) => match request::beside(tuner, &request) {
            Some(told) => answer(&number, request::worded(told)),
            None => return room.send(Ask::Say(id, number, request)).is_ok(),
        },
    }
    room.send(Ask::Alive(id)).is_ok()
}

/// An answer with its question's number.
pub(super) fn numbered(number: &Value, mut answer: Value) -> String {
    answer["number"] = number.clone();
    answer.to_string()
}

fn waits(error: &Error) -> bool {
    let moment = [ErrorKind::WouldBlock, ErrorKind::TimedOut, ErrorKind::Interrupted];
    matches!(error, Error::Io(error) if moment.contains(&error.kind()))
}
