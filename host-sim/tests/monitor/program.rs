//! The program on a free port, and pages that ask it.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// How long anything may take on a machine that is busy.
const PATIENCE: Duration = Duration::from_secs(20);

/// `host-sim monitor`.
pub(crate) struct Program {
    child: Child,
    url: String,
}

impl Program {
    pub(crate) fn start(flags: &[&str]) -> Self {
        let mut command = Command::new("env");
        // A hang-up as at a terminal, also where these tests run under `nohup`.
        if cfg!(target_os = "linux") {
            command.arg("--default-signal=HUP");
        }
        command.args([env!("CARGO_BIN_EXE_host-sim"), "monitor"]).args(flags);
        let command = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut url = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut url).unwrap();
        assert!(url.starts_with("http://127.0.0.1:"), "{url}");
        Self { child, url: url.trim().to_owned() }
    }

    /// `127.0.0.1:PORT`.
    pub(crate) fn host(&self) -> String {
        self.url.split('/').nth(2).unwrap().to_owned()
    }

    /// With the token.
    pub(crate) fn path(&self) -> String {
        format!("/{}/", self.url.split('/').nth(3).unwrap())
    }

    /// Its status after a signal, and what it says on standard error.
    #[cfg(unix)]
    pub(crate) fn signal(&mut self, signal: &str) -> (Option<i32>, String) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-s", signal, &id]).status().unwrap().success());
        let status = self.child.wait().unwrap();
        let mut told = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut told).unwrap();
        (status.code(), told)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The answer to a request.
pub(crate) fn get(host: &str, path: &str, named: &str, lines: &[(&str, &str)]) -> String {
    String::from_utf8(send("GET", host, path, named, lines, b"")).unwrap()
}

/// The answer to a request that brings something.
pub(crate) fn send(
    method: &str,
    host: &str,
    path: &str,
    named: &str,
    lines: &[(&str, &str)],
    what: &[u8],
) -> Vec<u8> {
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut head = format!("{method} {path} HTTP/1.1\r\nHost: {named}\r\n");
    for (name, value) in lines {
        head.push_str(&format!("{name}: {value}\r\n"));
    }
    stream.write_all(format!("{head}\r\n").as_bytes()).unwrap();
    stream.write_all(what).unwrap();
    // Whoever was refused by the head alone has hung up.
    let _ = stream.shutdown(Shutdown::Write);
    let mut answer = Vec::new();
    // A line on which something was left unread breaks when its answer has come.
    let _ = stream.read_to_end(&mut answer);
    answer
}

/// A page, as far as the program sees one.
pub(crate) struct Operator {
    socket: WebSocket<TcpStream>,
    number: u64,
    columns: Vec<String>,
    rows: Vec<f32>,
    pub(crate) controls: bool,
    /// Some page does, as it was told.
    pub(crate) controlled: bool,
}

impl Operator {
    pub(crate) fn enter(program: &Program) -> Self {
        let (host, path) = (program.host(), program.path());
        let mut request = format!("ws://{host}{path}socket").into_client_request().unwrap();
        request.headers_mut().insert("Origin", format!("http://{host}").parse().unwrap());
        let stream = TcpStream::connect(&host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (socket, _) = tungstenite::client(request, stream).unwrap();
        let (columns, rows) = (Vec::new(), Vec::new());
        let mut page = Self { socket, number: 0, columns, rows, controls: false, controlled: false };
        let about = page.ask(&json!("about")).unwrap();
        let columns = about["columns"].as_array().unwrap().iter();
        page.columns = columns.map(|column| column["name"].as_str().unwrap().to_owned()).collect();
        page
    }

    pub(crate) fn ask(&mut self, request: &Value) -> Result<Value, String> {
        self.say(json!({ "request": request }))
    }

    pub(crate) fn take(&mut self) {
        self.say(json!({ "take": true })).unwrap();
    }

    /// To look on from now on.
    pub(crate) fn look(&mut self) -> Result<Value, String> {
        self.say(json!({ "look": true }))
    }

    /// Asks, and waits for no answer.
    pub(crate) fn shout(&mut self, request: &Value) {
        self.send(json!({ "request": request }));
    }

    fn send(&mut self, mut what: Value) {
        self.number += 1;
        what["number"] = json!(self.number);
        self.socket.send(Message::text(what.to_string())).unwrap();
    }

    fn say(&mut self, what: Value) -> Result<Value, String> {
        self.send(what);
        loop {
            match self.socket.read().unwrap() {
                Message::Binary(bytes) => self.rows.extend(
                    bytes
                        .chunks_exact(4)
                        .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]])),
                ),
                Message::Text(text) => {
                    let told: Value = serde_json::from_str(&text).unwrap();
                    if let Some(controls) = told["controls"].as_bool() {
                        self.controls = controls;
                        self.controlled = told["controlled"] == true;
                    } else if told["number"] == json!(self.number) {
                        return match told["error"].as_str() {
                            Some(error) => Err(error.to_owned()),
                            None => Ok(told["ok"].clone()),
                        };
                    }
                }
                _ => {}
            }
        }
    }

    pub(crate) fn status(&mut self) -> Value {
        self.ask(&json!({ "status": { "since": 0 } })).unwrap()
    }

    /// The status, once it is so.
    pub(crate) fn wait(&mut self, what: &str, done: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let status = self.status();
            if done(&status) {
                return status;
            }
            assert!(begun.elapsed() < PATIENCE, "{what}: {status}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    pub(crate) fn reach(&mut self, state: &str) {
        self.wait(state, |status| status["state"] == state);
    }

    /// A board whose wiring has been checked, into the air.
    pub(crate) fn fly(&mut self) {
        self.wait("it answers", |status| status["next"] == "zero");
        self.ask(&json!("zero")).unwrap();
        self.reach("ready");
        self.ask(&json!({ "supervisor": "arm" })).unwrap();
        self.reach("armed");
    }

    /// Until it is so of what has come.
    pub(crate) fn until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        while !done(self) {
            assert!(begun.elapsed() < PATIENCE, "{what}");
            self.status();
        }
    }

    /// All samples of a column.
    pub(crate) fn column(&self, name: &str) -> Vec<f32> {
        let place = self.columns.iter().position(|column| column == name).unwrap();
        self.rows.chunks_exact(self.columns.len()).map(|row| row[place]).collect()
    }

    pub(crate) fn last(&self, name: &str) -> Option<f32> {
        self.column(name).last().copied()
    }
}
