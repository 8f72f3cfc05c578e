//! A recorded flight that somebody opens in a served page: read here by the code that a page from a file has
//! in its module, and given back as rows. No word of it goes to the room: the board flies on beside it, and
//! what a page says over its socket waits for no file.

use super::http::{self, Asked};
use std::io::{self, ErrorKind, Read};
use std::net::TcpStream;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use twinrotor_web::recorded::{self, MOST_BYTES};

/// Where a file is sent.
pub(super) const NAME: &str = "record";
/// How long a file may take to come.
const PATIENCE: Duration = Duration::from_secs(60);
/// One file at a time: each may be large.
static READING: Mutex<()> = Mutex::new(());

/// Takes a file and gives its rows, as little-endian `f32`, or says what is wrong with it.
///
/// # Errors
///
/// If the line is gone.
pub(super) fn read(stream: &mut TcpStream, asked: &Asked) -> io::Result<()> {
    let Some(length) = asked.line("content-length").and_then(|length| length.parse::<u64>().ok()) else {
        return http::refuse(stream, "411 Length Required", "a flight is sent with its length");
    };
    if length > u64::from(MOST_BYTES) {
        let told = format!("the recorded flight has {length} bytes; at most {MOST_BYTES} are read");
        return http::refuse(stream, "413 Content Too Large", &told);
    }
    let _alone = READING.lock().unwrap_or_else(PoisonError::into_inner);
    match recorded::read(&file(stream, length)?) {
        Ok(rows) => {
            let bytes: Vec<u8> = rows.iter().flat_map(|number| number.to_le_bytes()).collect();
            http::answer(stream, "200 OK", "application/octet-stream", &bytes)
        }
        Err(error) => http::refuse(stream, "422 Unprocessable Content", &error.to_string()),
    }
}

/// As it comes: what was only promised takes no room.
fn file(stream: &mut TcpStream, length: u64) -> io::Result<Vec<u8>> {
    let begun = Instant::now();
    let mut part = vec![0; 1 << 16];
    let mut file = Vec::new();
    let mut from = stream.take(length);
    loop {
        match from.read(&mut part)? {
            0 if from.limit() == 0 => return Ok(file),
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            _ if begun.elapsed() > PATIENCE => return Err(ErrorKind::TimedOut.into()),
            came => file.extend_from_slice(&part[..came]),
        }
    }
}
