//! A recorded flight, out of the CSV or MCAP that `fly --record` or `simulate` writes, as rows to be drawn.

mod csv;
mod mcap;

use crate::desk::samples::{self, COLUMNS};
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::telemetry::Frame;
use twinrotor_sim::{Error, Outcome};

/// \[byte\] The longest file that is read: ten minutes of every tick have 100 MB.
pub const MOST_BYTES: u32 = 128_000_000;
/// \[ticks\] The longest flight.
const MOST_TICKS: u32 = 600_000;
/// Where a row has the board's state, which is not read.
const STATE: usize = 18;

/// What is read, as `fly` and as `simulate` name it; SI units. The first three must be there.
const NAMES: [[&str; 2]; 14] = [
    ["t", "t"],
    ["pitch", "theta"],
    ["yaw", "psi"],
    ["ref_pitch", "theta_ref"],
    ["ref_yaw", "psi_ref"],
    ["rate_pitch", "theta_dot"],
    ["rate_yaw", "psi_dot"],
    ["v0", "v_main"],
    ["v1", "v_tail"],
    ["demand_main", ""],
    ["demand_tail", ""],
    ["disturbance_pitch", ""],
    ["disturbance_yaw", ""],
    ["supply", ""],
];

/// The rows of [`samples::TABLE`], one every [`samples::EVERY`] ticks, from 0 s on.
///
/// # Errors
///
/// If the file has no flight, is longer than ten minutes, or a row is not as it should be: which, and why.
pub fn read(file: &[u8]) -> Outcome<Vec<f32>> {
    let mut flight = if file.starts_with(mcap::MAGIC) { mcap::read(file) } else { csv::read(file) }?;
    flight.note_last();
    if flight.rows.is_empty() { Err(unusable("it has no rows")) } else { Ok(flight.rows) }
}

fn unusable(why: &str) -> Error {
    Error::Unusable(format!("the recorded flight: {why}"))
}

/// A column that must be there is not.
fn without(column: usize) -> Error {
    let [one, other] = NAMES[column];
    let names = if one == other { one.to_owned() } else { format!("{one} or {other}") };
    unusable(&format!("it has no column {names}; fly --record and simulate --csv write such files"))
}

/// What has been read.
struct Flight {
    rows: Vec<f32>,
    /// A record has the volts that act in a tick, those of the tick before; a page draws what a tick decides.
    acting: bool,
    /// \[s\] When it begins.
    begun: Option<f64>,
    /// The last row, which waits for the volts of the next.
    last: Option<Frame>,
}

impl Flight {
    const fn new(acting: bool) -> Self {
        Self { rows: Vec::new(), acting, begun: None, last: None }
    }

    /// A row, in the order of [`NAMES`]: not a number where there is none.
    fn take(&mut self, values: &[f64; NAMES.len()]) -> Result<(), &'static str> {
        let time = values[0];
        if !time.is_finite() {
            return Err("t is no number");
        }
        let begun = *self.begun.get_or_insert(time);
        let ticks = ((time - begun) / SAMPLE_TIME).round();
        if ticks > f64::from(MOST_TICKS) {
            return Err("longer than ten minutes");
        }
        if ticks < self.last.map_or(0.0, |last| f64::from(last.tick)) {
            return Err("t runs backwards");
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 600,000")]
        let tick = ticks as u32;
        #[expect(clippy::cast_possible_truncation, reason = "what telemetry told, or is drawn")]
        let drawn = values.map(|value| value as f32);
        let [_, pitch, yaw, to_pitch, to_yaw, pitch_rate, yaw_rate, main, tail, rest @ ..] = drawn;
        let [demand_main, demand_tail, pitch_disturbance, yaw_disturbance, supply] = rest;
        let volts = PerMotor::new(main, tail);
        if let Some(last) = self.last.as_mut().filter(|last| self.acting && last.tick + 1 == tick) {
            last.volts = volts;
        }
        self.note_last();
        self.last = Some(Frame {
            tick,
            angle: PerAxis::new(pitch, yaw),
            reference: PerAxis::new(to_pitch, to_yaw),
            rate: PerAxis::new(pitch_rate, yaw_rate),
            volts,
            demand: PerMotor::new(demand_main, demand_tail),
            disturbance: PerAxis::new(pitch_disturbance, yaw_disturbance),
            supply,
            ..Frame::default()
        });
        Ok(())
    }

    /// The last row is to be drawn, unless one so soon before it is.
    fn note_last(&mut self) {
        let Some(frame) = &self.last else { return };
        let mut row = samples::row(frame, None);
        row[STATE] = f32::NAN;
        let before = self.rows.len().checked_sub(COLUMNS).map(|at| self.rows[at]);
        #[expect(clippy::cast_possible_truncation, reason = "as a row tells the time")]
        let due = (f64::from(frame.tick / samples::EVERY * samples::EVERY) * SAMPLE_TIME) as f32;
        if before.is_none_or(|before| before < due) {
            self.rows.extend(row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::mcap as the_library;

    fn refusal(file: &str) -> String {
        read(file.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn a_record_is_drawn_as_its_board_was() {
        let mut file = "t,pitch,yaw,v0,v1,demand_main,ref_pitch,state\n".to_owned();
        for k in 0..=10 {
            file += &format!("{},{},0.5,{k},-{k},{},0.25,armed\r\n", 3.0 + 1e-3 * f64::from(k), 0.1, k + 1);
        }
        let rows = read(file.as_bytes()).unwrap();
        let times: Vec<f32> = rows.iter().step_by(COLUMNS).copied().collect();
        assert_eq!(times, [0.0, 0.005, 0.01]);
        let row = &rows[COLUMNS..2 * COLUMNS];
        assert_eq!(row[1], 0.1_f32.to_degrees());
        assert_eq!(row[7], (0.25_f32 - 0.1).to_degrees());
        // Decided in tick 5, acting in tick 6; the demand was no more.
        assert_eq!((row[9], row[10], row[11], row[20]), (6.0, -6.0, 6.0, 0.0));
        assert!(row[6].is_nan() && row[17].is_nan() && row[STATE].is_nan());
        // A simulation's volts are those of their own tick.
        let simulated = read(b"t,theta,psi,v_main,v_tail\n0,0,0,1,2\n0.001,0,0,3,4\n").unwrap();
        assert_eq!((simulated[9], simulated[10], simulated.len()), (1.0, 2.0, COLUMNS));
    }

    #[test]
    fn what_is_no_flight_is_told_by_its_line() {
        for (file, told) in [
            ("", "empty"),
            ("t,pitch\n0,0\n", "no column yaw or psi"),
            ("t,pitch,yaw\n", "no rows"),
            ("t,pitch,yaw\n0,0,0\n0.001,0\n", "line 3: 2 values for 3 columns"),
            ("t,pitch,yaw\n0,up,0\n", "line 2: 'up' is no number"),
            ("t,pitch,yaw\nNaN,0,0\n", "line 2: t is no number"),
            ("t,pitch,yaw\n1,0,0\n\n0.5,0,0\n", "line 4: t runs backwards"),
            ("t,pitch,yaw\n0,0,0\n601,0,0\n", "line 3: longer than ten minutes"),
        ] {
            let refusal = refusal(file);
            assert!(refusal.contains(told), "{file:?}: {refusal}");
        }
        assert!(read(&[0xff, 0xfe]).unwrap_err().to_string().contains("no text"));
    }

    /// Messages in a file, as `host-sim` writes them.
    fn mcap(messages: &[&str], topic: &str) -> Vec<u8> {
        let mut writer = the_library::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
        let schema = writer.add_schema("twinrotor.Flight", "jsonschema", b"{}").unwrap();
        let channel_id =
            writer.add_channel(schema, topic, "json", &std::collections::BTreeMap::new()).unwrap();
        for (sequence, message) in (0..).zip(messages) {
            let header =
                the_library::records::MessageHeader { channel_id, sequence, log_time: 0, publish_time: 0 };
            writer.write_to_known_channel(&header, message.as_bytes()).unwrap();
        }
        writer.finish().unwrap();
        writer.into_inner().into_inner()
    }

    #[test]
    fn the_same_record_is_read_out_of_either_format() {
        let csv = b"t,pitch,yaw,v0,v1,state\n0.001,0.25,-1,2,3,armed\n0.002,0.5,-2,4,5,armed\n";
        let messages = [
            r#"{"t": 0.001, "pitch": 0.25, "yaw": -1.0, "v0": 2.0, "v1": 3.0, "state": "armed"}"#,
            r#"{"t": 0.002, "pitch": 0.5, "yaw": -2.0, "v0": 4.0, "v1": 5.0, "state": "armed"}"#,
        ];
        let bits = |rows: Vec<f32>| rows.into_iter().map(f32::to_bits).collect::<Vec<_>>();
        let rows = |file: &[u8]| bits(read(file).unwrap());
        assert_eq!(rows(&mcap(&messages, "/flight")), rows(csv));
        for (messages, topic, told) in [
            (&messages[..], "/odometry", "no channel /flight"),
            (&[r#"{"t": 0, "pitch": 1}"#], "/flight", "no column yaw or psi"),
            (&[messages[0], r#"{"t": 0.002, "pitch": "up"}"#], "/flight", "message 2: 'pitch' is no number"),
            (&[messages[0], "{"], "/flight", "message 2: EOF"),
            (&[messages[1], messages[0]], "/flight", "message 2: t runs backwards"),
        ] {
            let refusal = read(&mcap(messages, topic)).unwrap_err().to_string();
            assert!(refusal.contains(told), "{refusal}");
        }
        let mut cut = mcap(&messages, "/flight");
        for length in (8..cut.len()).rev() {
            cut.truncate(length);
            // Some of it or a refusal, never a panic.
            let _ = read(&cut);
        }
    }
}
