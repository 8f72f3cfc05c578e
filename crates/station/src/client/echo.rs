//! A line that hands back what is said to it.

/// \[byte\] How much of what was said is remembered, and how much must come back.
const ENOUGH: usize = 24;

/// Compares what comes with what was said first.
#[derive(Debug, Default)]
pub struct Echo {
    said: Vec<u8>,
    heard: Vec<u8>,
}

impl Echo {
    /// This was said.
    pub fn say(&mut self, bytes: &[u8]) {
        let room = ENOUGH.saturating_sub(self.said.len());
        self.said.extend(bytes.iter().take(room));
    }

    /// This came.
    pub fn hear(&mut self, bytes: &[u8]) {
        let room = ENOUGH.saturating_sub(self.heard.len());
        self.heard.extend(bytes.iter().take(room));
    }

    /// What came is what was said.
    #[must_use]
    pub fn is_one(&self) -> bool {
        self.heard.len() == ENOUGH && self.heard == self.said
    }
}
