//! The independent watchdog's keys and its clock: RM0090 21.3 and 21.4.

use virtual_board::chip::Settings;

use super::whole::{MS, Whole};

const KR: u64 = 0x4000_3000;
const PR: u64 = KR + 4;
const RLR: u64 = KR + 8;
const UNLOCK: u64 = 0x5555;
const FEED: u64 = 0xAAAA;
const START: u64 = 0xCCCC;

fn started() -> Whole {
    let mut whole = Whole::new(Settings::default());
    whole.write(KR, START);
    whole.pass(MS);
    whole
}

/// Both values once they have arrived.
fn values(whole: &mut Whole) -> (u64, u64) {
    whole.pass(MS);
    (whole.read(PR), whole.read(RLR))
}

#[test]
fn the_unlocked_registers_take_a_value_and_read_it_back() {
    let mut whole = started();
    whole.write(KR, UNLOCK);
    whole.write(PR, 4);
    whole.write(RLR, 1999);
    assert_eq!(values(&mut whole), (4, 1999));
}

#[test]
fn any_other_key_locks_them_again() {
    for key in [FEED, START, 0, 0x5554] {
        let mut whole = started();
        whole.write(KR, UNLOCK);
        whole.write(PR, 4);
        whole.write(KR, key);
        whole.write(RLR, 1999);
        assert_eq!(values(&mut whole), (4, 0xFFF), "locked between the two by {key:#x}");
        whole.write(PR, 0);
        assert_eq!(values(&mut whole), (4, 0xFFF), "and for good");
    }
}

#[test]
fn its_period_follows_the_oscillator_of_the_part() {
    for (lsi_hz, milliseconds) in [(17_000, 963), (32_000, 512), (47_000, 348)] {
        let mut whole = Whole::new(Settings { lsi_hz, ..Settings::default() });
        whole.write(KR, START);
        let reset = whole.until_reset(2_000 * MS).expect("it bites");
        // 4,096 of a quarter of the oscillator, and what the oscillator takes to start.
        assert!((reset / MS).abs_diff(milliseconds) <= 1, "{reset} ns at {lsi_hz} Hz");
    }
}
