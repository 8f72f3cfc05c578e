//! A DMA stream that is stopped and started again, by every reading of the manual: RM0090 10.3.14 and 10.5.6.

use virtual_board::chip::{Settings, StreamStop};

use super::whole::{US, Whole};

const USART2: u64 = 0x4000_4400;
const STREAM5: u64 = 0x4002_6088;
const NDTR: u64 = STREAM5 + 4;
const HISR: u64 = 0x4002_6004;
const HIFCR: u64 = 0x4002_600C;
const TCIF5: u64 = 1 << 11;
/// DMA1_Stream5, table 61.
const INTERRUPT: u16 = 16;
/// Channel 4, MINC, CIRC, TCIE; and EN.
const CONTROL: u64 = 4 << 25 | 1 << 10 | 1 << 8 | 1 << 4;
const EN: u64 = 1;

/// USART2 at 1 Mbaud whose words a circular stream takes to the RAM, eight to a lap.
pub(crate) fn receiving(stream_stop: StreamStop) -> Whole {
    let mut whole = Whole::new(Settings { stream_stop, ..Settings::default() });
    whole.write(STREAM5 + 8, USART2 + 4);
    whole.write(STREAM5 + 12, 0x2000_0000);
    whole.write(NDTR, 8);
    whole.write(STREAM5, CONTROL | EN);
    whole.write(USART2 + 0x08, 16);
    whole.write(USART2 + 0x14, 1 << 6);
    whole.write(USART2 + 0x0C, 1 << 13 | 1 << 2);
    whole
}

fn hear(whole: &mut Whole, bytes: &[u8]) {
    whole.line().say(bytes);
    whole.pass(10 * US * bytes.len() as u64 + 5 * US);
}

/// Three words, then the stream is stopped.
fn stopped(reading: StreamStop) -> Whole {
    let mut whole = receiving(reading);
    hear(&mut whole, &[1, 2, 3]);
    assert_eq!(([0, 1, 2].map(|nth| whole.ram(nth)), whole.read(NDTR)), ([1, 2, 3], 5));
    assert_eq!((whole.read(HISR) & TCIF5, whole.raised.clone()), (0, vec![]));
    whole.write(STREAM5, CONTROL);
    assert_eq!(whole.read(STREAM5), CONTROL, "stopped, and nothing else of it changed");
    whole
}

#[test]
fn stopping_ends_the_block_or_does_not_as_the_reading_has_it() {
    for reading in StreamStop::READINGS {
        let mut whole = stopped(reading);
        assert_eq!(whole.read(NDTR), 5, "what was left, {reading:?}");
        let flag = if reading.completes { TCIF5 } else { 0 };
        assert_eq!(whole.read(HISR) & TCIF5, flag, "{reading:?}");
        let raised = if reading.completes { vec![INTERRUPT] } else { vec![] };
        assert_eq!(whole.raised, raised, "{reading:?}");
    }
}

#[test]
fn started_again_the_count_is_the_programmed_one_or_what_was_left() {
    for reading in StreamStop::READINGS {
        let mut whole = stopped(reading);
        whole.write(HIFCR, TCIF5);
        whole.write(STREAM5, CONTROL | EN);
        assert_eq!(whole.read(NDTR), if reading.reloads { 8 } else { 5 }, "{reading:?}");
        hear(&mut whole, &[4, 5, 6, 7, 8]);
        let five = [0, 1, 2, 3, 4].map(|nth| whole.ram(nth));
        assert_eq!(five, [4, 5, 6, 7, 8], "from the start of the buffer either way, {reading:?}");
        // By the short lap's end the count is whole again, and so is the next lap.
        let (left, flag) = if reading.reloads { (3, 0) } else { (8, TCIF5) };
        assert_eq!((whole.read(NDTR), whole.read(HISR) & TCIF5), (left, flag), "{reading:?}");
        hear(&mut whole, &[9, 10, 11, 12, 13, 14, 15]);
        let (left, first) = if reading.reloads { (4, 12) } else { (1, 9) };
        assert_eq!((whole.read(NDTR), whole.ram(0)), (left, first), "{reading:?}");
    }
}

#[test]
fn a_count_that_is_programmed_anew_is_taken_by_every_reading() {
    for reading in StreamStop::READINGS {
        let mut whole = stopped(reading);
        whole.write(NDTR, 6);
        whole.write(STREAM5, CONTROL | EN);
        assert_eq!(whole.read(NDTR), 6, "{reading:?}");
        hear(&mut whole, &[1, 2, 3, 4, 5, 6, 7]);
        assert_eq!((whole.read(NDTR), whole.ram(0)), (5, 7), "{reading:?}");
    }
}
