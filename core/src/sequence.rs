//! Numbers that tell a new message from an old one: a line that hands out bytes twice, or late, must not make
//! a board do a thing again.

use serde::{Deserialize, Serialize};

/// A number that counts up from message to message and begins again at 0 after 65,535.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Sequence(pub u16);

impl Sequence {
    /// The number after this one.
    #[must_use]
    pub const fn next(self) -> Self {
        Self(self.0.wrapping_add(1))
    }

    /// Did this number come after `other`? Of the 65,535 others, the 32,767 that come next did.
    #[must_use]
    pub const fn is_newer_than(self, other: Self) -> bool {
        let ahead = self.0.wrapping_sub(other.0);
        ahead != 0 && ahead < 0x8000
    }
}

/// A message and its number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Numbered<M> {
    /// Higher than that of any message before.
    pub sequence: Sequence,
    /// What is said.
    pub message: M,
}

/// What a receiver remembers: the highest number so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Order {
    last: Sequence,
}

impl Order {
    /// Nothing has come: number 1 is the first.
    #[must_use]
    pub const fn new() -> Self {
        Self { last: Sequence(0) }
    }

    /// Takes a message's number; false if it is not newer than what came before, and nothing changes.
    #[must_use]
    pub fn admit(&mut self, sequence: Sequence) -> bool {
        let newer = sequence.is_newer_than(self.last);
        if newer {
            self.last = sequence;
        }
        newer
    }

    /// What a sender is to number its next message.
    #[must_use]
    pub const fn expected(&self) -> Sequence {
        self.last.next()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;
    use std::vec::Vec;

    /// From every number: itself and the half behind are old, the half ahead is new, and of two different
    /// numbers less than half apart exactly one is newer.
    #[test]
    fn the_next_half_is_newer_from_every_number() {
        for last in 0..=u16::MAX {
            let newer = |ahead: u16| Sequence(last.wrapping_add(ahead)).is_newer_than(Sequence(last));
            assert!(!newer(0) && newer(1) && newer(0x7FFF) && !newer(0x8000) && !newer(0xFFFF));
        }
        for ahead in 0..=u16::MAX {
            let (a, b) = (Sequence(40_000), Sequence(40_000_u16.wrapping_add(ahead)));
            assert_eq!(b.is_newer_than(a), (1..0x8000).contains(&ahead));
            assert!(!(a.is_newer_than(b) && b.is_newer_than(a)));
        }
    }

    /// A sender that follows the rule is heard for ever: five times round.
    #[test]
    fn every_message_of_a_sender_is_admitted_through_every_wrap() {
        let mut order = Order::default();
        for _ in 0..5 * 65_536 {
            let expected = order.expected();
            assert!(order.admit(expected));
            assert!(!order.admit(expected), "and once only");
        }
    }

    proptest! {
        /// A line that repeats any stretch of what it carried (a ring buffer that is read again), loses any
        /// message and damages nothing: each message is admitted at most once, and each that comes for the
        /// first time, in order, is admitted.
        #[test]
        fn whatever_a_line_repeats_is_admitted_once(
            start in any::<u16>(),
            steps in prop::collection::vec((1_usize..40, 0_usize..512), 1..60),
        ) {
            let mut order = Order { last: Sequence(start) };
            let (mut sent, mut admitted): (Vec<Sequence>, BTreeSet<u16>) = (Vec::new(), BTreeSet::new());
            let mut next = order.expected();
            for (fresh, again) in steps {
                for _ in 0..fresh {
                    prop_assert!(order.admit(next));
                    prop_assert!(admitted.insert(next.0), "twice");
                    sent.push(next);
                    next = next.next();
                }
                for &old in sent.iter().rev().take(again).rev() {
                    prop_assert!(!order.admit(old), "{old:?} again");
                }
            }
        }
    }
}
