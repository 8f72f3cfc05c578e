//! Rows that two logs share: the same file twice, or a part of it, proves nothing a second time.

use super::Log;
use std::collections::HashSet;

/// Rows that are compared together: long enough that no two flights have them alike by chance.
const BLOCK: usize = 24;
/// Of these, how many at least must differ from the one before: a rig at rest looks the same every time.
const CHANGES: usize = 8;

impl Log {
    /// Which part of the moving pieces of this log is also in `other`, row for row.
    pub fn shared_with(&self, other: &Self) -> f64 {
        let theirs: HashSet<u32> =
            (0..other.angle.len().saturating_sub(BLOCK)).filter_map(|first| other.block(first)).collect();
        let ours: Vec<u32> = (0..self.angle.len().saturating_sub(BLOCK))
            .step_by(BLOCK)
            .filter_map(|first| self.block(first))
            .collect();
        let found = ours.iter().filter(|block| theirs.contains(block)).count();
        if ours.is_empty() { 0.0 } else { found as f64 / ours.len() as f64 }
    }

    fn block(&self, first: usize) -> Option<u32> {
        let rows = first..first + BLOCK;
        let differs = |k: &usize| self.angle[*k] != self.angle[k - 1] || self.volts[*k] != self.volts[k - 1];
        if rows.clone().skip(1).filter(differs).count() < CHANGES {
            return None;
        }
        let mut sum = crc32fast::Hasher::new();
        for row in rows {
            let (angle, volts) = (self.angle[row], self.volts[row]);
            for number in [angle.pitch, angle.yaw, volts.main, volts.tail] {
                sum.update(&number.to_le_bytes());
            }
        }
        Some(sum.finalize())
    }
}
