//! What JavaScript calls: JSON in the buffer that `input` gives, `ask`, JSON in the buffer at `output`.
//! `advance` lets simulated time pass and leaves rows of `f32` at `samples`.

use crate::desk::samples::COLUMNS;
use crate::page::Page;
use crate::{recorded, request};
use std::cell::RefCell;
use std::time::Duration;

thread_local! {
    static PAGE: RefCell<Page> = RefCell::new(Page::new());
    static RECORD: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static OUTPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// A buffer for `length` bytes of a question. It is there until the next call.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn input(length: u32) -> *mut u8 {
    INPUT.with_borrow_mut(|input| {
        input.clear();
        input.resize(length as usize, 0);
        input.as_mut_ptr()
    })
}

/// Answers what is in the input. Gives the answer's length in bytes.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> u32 {
    say(INPUT.with_borrow(|input| PAGE.with_borrow_mut(|page| request::answer(page, input))))
}

/// Where the last answer is.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn output() -> *const u8 {
    OUTPUT.with_borrow(|output| output.as_ptr())
}

/// Lets so many ticks of simulated time pass. Gives how many rows of numbers there are for them, each of
/// [`crate::desk::samples::COLUMNS`].
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn advance(ticks: u32) -> u32 {
    PAGE.with_borrow_mut(|page| length(page.desk.advance(ticks)))
}

/// Where they are.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn samples() -> *const f32 {
    PAGE.with_borrow(|page| page.desk.samples().as_ptr())
}

/// A board at a line, where the page has one: what came over it is in the input. Gives how many bytes are to
/// be said over it, which are at `output`; `now` \[ms\] is any time that does not run backwards.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn exchange(now: f64) -> u32 {
    let now = Duration::try_from_secs_f64(now * 1e-3).unwrap_or_default();
    say(INPUT.with_borrow(|came| PAGE.with_borrow_mut(|page| page.desk.exchange(came, now))))
}

/// How many rows it made.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn rows() -> u32 {
    PAGE.with_borrow(|page| length(page.desk.samples().len() / COLUMNS))
}

/// The other end of such a line: the simulated board, to which was said what is in the input, after so many
/// ticks. Gives how many bytes it says, which are at `output`.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn serve(ticks: u32) -> u32 {
    let serve = |said: &Vec<u8>| PAGE.with_borrow_mut(|page| page.desk.serve(said, ticks));
    say(INPUT.with_borrow(serve).unwrap_or_default())
}

/// Reads the recorded flight whose CSV is in the input. Gives the length of the answer at `output`: how many
/// numbers its rows have together, which are at `record` until the next is read, or what is wrong.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn open() -> u32 {
    let file = INPUT.with_borrow_mut(std::mem::take);
    let numbers = recorded::read(&file).map(|rows| {
        RECORD.with_borrow_mut(|record| {
            *record = rows;
            serde_json::json!(record.len())
        })
    });
    say(request::worded(numbers).to_string().into_bytes())
}

/// Where they are.
#[expect(unsafe_code, reason = "the name by which JavaScript calls it, once in the module")]
#[unsafe(no_mangle)]
pub extern "C" fn record() -> *const f32 {
    RECORD.with_borrow(|record| record.as_ptr())
}

fn say(bytes: Vec<u8>) -> u32 {
    OUTPUT.with_borrow_mut(|output| {
        *output = bytes;
        length(output.len())
    })
}

fn length(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}
