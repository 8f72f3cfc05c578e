//! A record of every tick that telemetry tells, in the columns of `host-sim fly --record`.

use serde::Serialize;
use twinrotor::link::{BAUD, ticks_per_frame};
use twinrotor::telemetry::Frame;
use twinrotor_sim::{Error, Outcome};
use twinrotor_station::recording::{self, Gaps};

/// \[frames\] Ten minutes of every tick: what a page keeps.
pub const LONGEST: usize = 600_000;
/// \[frames\] In a part of a CSV file: about a megabyte.
const PART: usize = 5_000;

/// What is recorded, and whether it goes on.
#[derive(Debug, Default)]
pub struct Recorder {
    frames: Vec<Frame>,
    gaps: Gaps,
    longest: usize,
    on: bool,
    /// The program records, not the page.
    by_program: bool,
}

/// Where it stands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Recorded {
    /// It goes on.
    pub on: bool,
    /// How many frames it has.
    pub frames: usize,
    /// The program records, to a file of its own.
    pub by_program: bool,
    #[serde(flatten)]
    gaps: Gaps,
}

/// A part of it as CSV, and the first frame of the next part if there is one.
#[derive(Debug, Serialize)]
pub struct Part {
    /// The first part begins with the line of names.
    pub csv: String,
    /// What is to be asked for next.
    pub next: Option<usize>,
}

impl Recorder {
    /// The program's, of at most so many frames; a page does not end it.
    #[must_use]
    pub fn of_program(longest: usize) -> Self {
        Self { longest, on: true, by_program: true, ..Self::default() }
    }

    /// A page wants a new one, or no more of it. The one before is lost when a new one begins.
    ///
    /// # Errors
    ///
    /// If the program records.
    pub fn wish(&mut self, on: bool) -> Outcome<()> {
        if self.by_program {
            return Err(Error::Unusable("host-sim monitor --record has a record of all of it".to_owned()));
        }
        if on {
            *self = Self { longest: LONGEST, on, ..Self::default() };
        }
        self.on = on;
        Ok(())
    }

    /// The next frame. Gives why the record has ended with the one before, if it has.
    pub fn take(&mut self, frame: &Frame) -> Option<&'static str> {
        if !self.on {
            return None;
        }
        let ended = if self.frames.len() >= self.longest {
            Some("the record is as long as one may be, and has ended")
        } else if self.frames.last().is_some_and(|last| last.tick >= frame.tick) {
            Some("another board, or the board anew: the record has ended with the one before")
        } else {
            if let Some(last) = self.frames.last() {
                self.gaps.count(last, frame, ticks_per_frame(BAUD));
            }
            self.frames.push(*frame);
            None
        };
        self.on = ended.is_none();
        ended
    }

    /// What it has.
    #[must_use]
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// They alone.
    #[must_use]
    pub fn into_frames(self) -> Vec<Frame> {
        self.frames
    }

    /// Where it stands.
    #[must_use]
    pub fn status(&self) -> Recorded {
        let Self { on, by_program, gaps, .. } = *self;
        Recorded { on, frames: self.frames.len(), by_program, gaps }
    }

    /// The part that begins with a frame.
    #[must_use]
    pub fn part(&self, from: usize) -> Part {
        let to = (from.saturating_add(PART)).min(self.frames.len());
        let table = recording::part(&self.frames[..to], ticks_per_frame(BAUD), from);
        let csv = if from == 0 { table.to_csv() } else { table.csv_rows() };
        Part { csv, next: (to < self.frames.len()).then_some(to) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(tick: u32) -> Frame {
        Frame { tick, ..Frame::default() }
    }

    #[test]
    fn parts_are_the_whole_and_a_gap_is_marked() {
        let mut recorder = Recorder::default();
        assert_eq!(recorder.take(&frame(0)), None);
        assert!(recorder.frames().is_empty(), "it has not begun");
        recorder.wish(true).unwrap();
        for tick in (7..9_000).chain(9_010..12_000) {
            assert_eq!(recorder.take(&frame(tick)), None);
        }
        let (mut csv, mut next, mut parts) = (String::new(), Some(0), 0);
        while let Some(from) = next {
            let part = recorder.part(from);
            csv += &part.csv;
            (next, parts) = (part.next, parts + 1);
        }
        assert_eq!((parts, csv.lines().count()), (3, 1 + recorder.frames().len()));
        assert_eq!(csv, recording::table(recorder.frames(), 1).to_csv());
        let Recorded { on, frames, by_program, gaps } = recorder.status();
        assert_eq!((on, frames, by_program), (true, 11_983, false));
        assert_eq!((gaps.gaps, gaps.lost_ticks, gaps), (1, 10, recording::gaps(recorder.frames(), 1)));
        recorder.wish(false).unwrap();
        assert!(recorder.take(&frame(20_000)).is_none() && recorder.frames().len() == 11_983);
    }

    #[test]
    fn it_ends_by_itself_where_it_is_full_or_a_board_begins_anew() {
        let mut recorder = Recorder::of_program(2);
        assert!(recorder.wish(false).unwrap_err().to_string().contains("monitor --record"));
        assert!(recorder.take(&frame(5)).is_none() && recorder.take(&frame(6)).is_none());
        assert!(recorder.take(&frame(7)).unwrap().contains("as long as one may be"));
        assert_eq!((recorder.status().on, recorder.frames().len()), (false, 2));
        let mut recorder = Recorder::of_program(9);
        assert!(recorder.take(&frame(5)).is_none());
        assert!(recorder.take(&frame(0)).unwrap().contains("the board anew"));
        assert!(recorder.take(&frame(1)).is_none() && recorder.frames().len() == 1);
    }
}
