//! Words that arrive badly: RM0090 30.3.3 and 30.6.1.

use virtual_board::chip::StreamStop;
use virtual_board::serial::Flaw;

use super::stream_stop::receiving;
use super::whole::{US, Whole};

const SR: u64 = 0x4000_4400;
const DR: u64 = SR + 4;
const CR3: u64 = SR + 0x14;
const FE: u64 = 1 << 1;
const NF: u64 = 1 << 2;
const ORE: u64 = 1 << 3;
const RXNE: u64 = 1 << 5;

/// A word's flags and what it is read as.
fn word(whole: &mut Whole) -> (u64, u64) {
    whole.pass(10 * US);
    (whole.read(SR) & (FE | NF | ORE | RXNE), whole.read(DR))
}

#[test]
fn one_chosen_word_comes_with_its_error_and_none_beside_it() {
    for (flaw, flag) in [(Flaw::Framing, FE), (Flaw::Noise, NF)] {
        let mut whole = receiving(StreamStop::default());
        whole.write(CR3, 0);
        whole.line().say(&[0x11]);
        whole.line().say_flawed(0x55, flaw);
        whole.line().say(&[0x22]);
        assert_eq!(word(&mut whole), (RXNE, 0x11));
        let (flags, value) = word(&mut whole);
        assert_eq!(flags, RXNE | flag, "{flaw:?}");
        assert_ne!(value, 0x55, "an errored word is not the one that was sent");
        assert_eq!(word(&mut whole), (RXNE, 0x22));
    }
}

#[test]
fn an_overrun_loses_the_word_after_the_one_that_was_not_fetched() {
    let mut whole = receiving(StreamStop::default());
    whole.line().say(&[1]);
    whole.line().say_flawed(2, Flaw::Overrun);
    whole.line().say(&[3, 4]);
    whole.pass(25 * US);
    assert_eq!((whole.read(SR) & (RXNE | ORE), whole.ram(1)), (RXNE, 0), "not fetched");
    whole.pass(20 * US);
    assert_eq!(whole.read(SR) & (RXNE | ORE), ORE);
    assert_eq!([0, 1, 2].map(|nth| whole.ram(nth)), [1, 2, 4]);
    assert_eq!(whole.read(CR3), 1 << 6, "the request's enable was the firmware's all along");
}

#[test]
fn a_word_fetched_late_on_a_line_that_falls_silent_is_not_lost() {
    let mut whole = receiving(StreamStop::default());
    whole.line().say_flawed(7, Flaw::Overrun);
    whole.pass(15 * US);
    assert_eq!(whole.ram(0), 0);
    whole.pass(20 * US);
    assert_eq!((whole.ram(0), whole.read(SR) & ORE), (7, 0));
}

#[test]
fn the_error_interrupts_where_the_firmware_asked_for_it() {
    let mut whole = receiving(StreamStop::default());
    whole.write(CR3, 1 << 6 | 1);
    whole.line().say(&[1]);
    whole.pass(15 * US);
    assert!(whole.raised.is_empty());
    whole.line().say_flawed(2, Flaw::Framing);
    whole.pass(15 * US);
    assert_eq!(whole.raised, [38], "USART2");
}
