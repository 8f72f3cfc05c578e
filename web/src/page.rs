//! What one page has: a desk with a board, and a search if one runs.

use crate::desk::{Choice, Desk};
use crate::request::Line;
use crate::tuner::Tuner;

/// Everything behind a page.
pub struct Page {
    /// The operator's place.
    pub desk: Desk,
    /// A search in progress.
    pub tuner: Option<Tuner>,
}

impl Page {
    /// With an Aero 2 that flies its own gains.
    ///
    /// # Panics
    ///
    /// Never: a test begins with it.
    #[must_use]
    pub fn new() -> Self {
        let desk = Desk::new(&Choice::default()).expect("the preset's own controller fits its board");
        Self { desk, tuner: None }
    }

    /// What became of the line that the page itself has to a board.
    pub fn at(&mut self, line: &Line) {
        match line {
            Line::Opened => self.desk.turn_to(Desk::at_a_line()),
            Line::Lost(why) => self.desk.line_lost(why, "look at its plug, then connect again"),
            Line::Closed => self.desk.turn_to(Self::new().desk),
        }
    }
}

impl Default for Page {
    fn default() -> Self {
        Self::new()
    }
}
