//! `fly` before somebody who sits at a terminal: each question is shown before anything moves, and what is
//! answered, or Ctrl-C, decides.

use super::served::{Mishap, Served};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// What Ctrl-C sends; the terminal makes a signal of it.
const CTRL_C: &str = "\x03";
/// How long a question may take to come: a rig that was pushed swings for a minute, and the machine is busy.
const PATIENCE: Duration = Duration::from_secs(240);

const WRITE: &str = "Write what is asked for to the board? [y/N]";
const CHECK: &str = "keep a hand on the emergency stop. Begin? [y/N]";
const REST: &str = "that becomes its zero. Does it? [y/N]";
const ARM: &str = "The motors turn from now on and the rig rises to level. Keep clear. Begin? [y/N]";

/// Somebody at a terminal of their own, in which `fly` runs.
struct Person {
    program: Child,
    keys: ChildStdin,
    screen: Receiver<Vec<u8>>,
    seen: String,
    /// \[bytes\] Of it, that were read already.
    read: usize,
}

impl Person {
    fn flies(folder: &Path, port: &str) -> Self {
        // With the signals as at a terminal, also where these tests run in the background of a shell.
        let fly = format!("env --default-signal=INT {} fly --port {port}", env!("CARGO_BIN_EXE_host-sim"));
        let mut program = Command::new("script")
            .args(["--quiet", "--flush", "--return", "--command", &fly, "/dev/null"])
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("script of util-linux");
        let (keys, mut shows) = (program.stdin.take().unwrap(), program.stdout.take().unwrap());
        let (sender, screen) = channel();
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = shows.read(&mut bytes) {
                if sender.send(bytes[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        Self { program, keys, screen, seen: String::new(), read: 0 }
    }

    /// Waits for `text`, behind what was read before.
    fn reads(&mut self, text: &str) {
        let begun = Instant::now();
        loop {
            if let Some(at) = self.seen[self.read..].find(text) {
                self.read += at + text.len();
                return;
            }
            let left = PATIENCE.saturating_sub(begun.elapsed());
            match self.screen.recv_timeout(left) {
                Ok(bytes) => self.seen.push_str(&String::from_utf8_lossy(&bytes)),
                Err(_) => panic!("not shown: {text}\n{}", last(&self.seen)),
            }
        }
    }

    fn types(&mut self, keys: &str) {
        self.keys.write_all(keys.as_bytes()).unwrap();
        self.keys.flush().unwrap();
    }

    /// To the end: the exit status, and all that was shown.
    fn waits(mut self) -> (Option<i32>, String) {
        while let Ok(bytes) = self.screen.recv_timeout(PATIENCE) {
            self.seen.push_str(&String::from_utf8_lossy(&bytes));
        }
        (self.program.wait().unwrap().code(), self.seen)
    }
}

/// The end of what was shown: all of it is thousands of lines of progress.
fn last(seen: &str) -> String {
    let from = seen.len().saturating_sub(3_000);
    seen[seen.ceil_char_boundary(from)..].replace('\r', "\n")
}

/// From the bag to the ground again: what differs, what will move, where zero is, when the motors begin.
#[test]
fn every_question_is_asked_in_its_turn_and_yes_flies() {
    let folder = tempfile::tempdir().unwrap();
    let board = Served::over_tcp(false, Mishap::None);
    let mut person = Person::flies(folder.path(), &board.port);
    for (question, answer) in [(WRITE, "y\n"), (CHECK, "yes\n"), (REST, "Y\n"), (ARM, "y\n")] {
        person.reads(question);
        person.types(answer);
    }
    let (status, seen) = person.waits();
    assert_eq!(status, Some(0), "{}", last(&seen));
    assert!(seen.contains("main motor pushes with") && seen.contains("flown less simulated"));
    for question in [WRITE, CHECK, REST, ARM] {
        let (_, behind) = seen.split_once(question).unwrap();
        let line = behind.lines().next().unwrap_or_default();
        assert!(line.len() < 10, "a question has the line for its answer: {line}");
    }
    assert!(!board.turns());
}

/// No, nothing, and what is neither, at any question: nothing is done from there on.
#[test]
fn whoever_does_not_say_yes_has_said_no() {
    let folder = tempfile::tempdir().unwrap();
    // A board from the bag, and one that was written and checked before.
    let cases: [(bool, &[&str], &str); 4] = [
        (false, &[WRITE], "n\n"),
        (false, &[WRITE, CHECK], "\n"),
        (true, &[REST], "perhaps\n"),
        (true, &[REST, ARM], "no\n"),
    ];
    for (stored, questions, answer) in cases {
        let board = Served::over_tcp(stored, Mishap::None);
        let mut person = Person::flies(folder.path(), &board.port);
        for (nth, question) in questions.iter().enumerate() {
            person.reads(question);
            person.types(if nth + 1 == questions.len() { answer } else { "y\n" });
        }
        let (status, seen) = person.waits();
        let shown = last(&seen);
        assert_eq!(status, Some(1), "{questions:?}: {shown}");
        assert!(seen.contains("not agreed to: nothing was done"), "{questions:?}: {shown}");
        assert!(!seen.contains("arming") && !seen.contains("checking"), "{questions:?}: {shown}");
        assert_eq!(seen.contains("written"), questions.contains(&CHECK), "{shown}");
        assert!(!board.turns());
    }
}

#[test]
fn ctrl_c_at_a_question_ends_it_with_no_motor_turning() {
    let folder = tempfile::tempdir().unwrap();
    for asked in [REST, ARM] {
        let board = Served::over_tcp(true, Mishap::None);
        let mut person = Person::flies(folder.path(), &board.port);
        person.reads(REST);
        if asked == ARM {
            person.types("y\n");
            person.reads(ARM);
        }
        person.types(CTRL_C);
        let (status, seen) = person.waits();
        assert_eq!(status, Some(130), "{}", last(&seen));
        assert!(seen.contains("interrupted; no motor had turned"), "{}", last(&seen));
        assert!(!board.turns());
    }
}
