//! What JavaScript calls: JSON in the buffer that `input` gives, `ask`, JSON in the buffer at `output`.
//! `advance` lets simulated time pass and leaves rows of `f32` at `samples`.

use crate::page::Page;
use crate::request;
use std::cell::RefCell;

thread_local! {
    static PAGE: RefCell<Page> = RefCell::new(Page::new());
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
    let answer = INPUT.with_borrow(|input| PAGE.with_borrow_mut(|page| request::answer(page, input)));
    OUTPUT.with_borrow_mut(|output| {
        *output = answer;
        length(output.len())
    })
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

fn length(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}
