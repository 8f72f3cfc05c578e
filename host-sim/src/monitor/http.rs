//! The little of HTTP that a page needs: its request's head, and files or a refusal as answers.

use crate::page::served::{File, POLICY};
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::handshake::server::{Request, create_response, write_response};

/// \[byte\] The longest head that is read.
const LONGEST: usize = 8_192;
/// How long it may take to come.
const PATIENCE: Duration = Duration::from_secs(5);
/// Most lines that it has.
const LINES: usize = 64;

/// A request whose head has come.
pub(super) struct Asked {
    /// As WebSocket's handshake reads it.
    pub(super) request: Request,
}

impl Asked {
    /// Reads it.
    ///
    /// # Errors
    ///
    /// If it is none, does not come, or is longer than any of ours.
    pub(super) fn read(stream: &mut TcpStream) -> io::Result<Self> {
        let begun = Instant::now();
        stream.set_read_timeout(Some(PATIENCE))?;
        let mut head = Vec::new();
        // A byte at a time: what comes after the head is another's.
        let mut byte = [0];
        while !head.ends_with(b"\r\n\r\n") {
            if head.len() == LONGEST || begun.elapsed() > PATIENCE || stream.read(&mut byte)? == 0 {
                return Err(unreadable());
            }
            head.push(byte[0]);
        }
        let mut lines = [httparse::EMPTY_HEADER; LINES];
        let mut parsed = httparse::Request::new(&mut lines);
        parsed.parse(&head).map_err(|_| unreadable())?;
        let mut request = Request::builder().version(tungstenite::http::Version::HTTP_11);
        request = request.method(parsed.method.unwrap_or_default()).uri(parsed.path.unwrap_or_default());
        for line in parsed.headers {
            request = request.header(line.name, line.value);
        }
        Ok(Self { request: request.body(()).map_err(|_| unreadable())? })
    }

    /// A line of the head, if it is there once: two of them mean a guess.
    #[must_use]
    pub(super) fn line(&self, name: &str) -> Option<&str> {
        let mut lines = self.request.headers().get_all(name).iter();
        let first = lines.next()?;
        if lines.next().is_some() { None } else { first.to_str().ok() }
    }

    /// Agrees to a conversation by WebSocket.
    ///
    /// # Errors
    ///
    /// If it is no such request, or the line is gone.
    pub(super) fn agree(&self, stream: &mut TcpStream) -> io::Result<()> {
        let response = create_response(&self.request).map_err(|_| unreadable())?;
        write_response(&mut *stream, &response).map_err(io::Error::other)?;
        stream.flush()
    }
}

fn unreadable() -> io::Error {
    io::Error::new(ErrorKind::InvalidData, "no request that is read here")
}

/// Gives a file.
///
/// # Errors
///
/// If the line is gone.
pub(super) fn give(stream: &mut TcpStream, file: &File) -> io::Result<()> {
    answer(stream, "200 OK", file.kind, file.text.as_bytes())
}

/// Says no, in words.
///
/// # Errors
///
/// If the line is gone.
pub(super) fn refuse(stream: &mut TcpStream, status: &str, why: &str) -> io::Result<()> {
    answer(stream, status, "text/plain; charset=utf-8", format!("{why}\n").as_bytes())
}

/// Gives bytes of a media type.
///
/// # Errors
///
/// If the line is gone.
pub(super) fn answer(stream: &mut TcpStream, status: &str, kind: &str, bytes: &[u8]) -> io::Result<()> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n\
         Content-Security-Policy: {POLICY}\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCache-Control: no-store\r\n\
         Cross-Origin-Opener-Policy: same-origin\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Connection: close\r\n\r\n",
        bytes.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(bytes)?;
    stream.flush()
}
