//! What one page has: a desk with a board, and a search if one runs.

use crate::desk::{Choice, Desk};
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
}

impl Default for Page {
    fn default() -> Self {
        Self::new()
    }
}
