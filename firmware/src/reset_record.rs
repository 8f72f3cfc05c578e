//! When the program must end: motors off first, then a note for the next boot, then a reset.

use crate::family;
use crate::family::interrupts::SUPPLY;
use crate::port::{PlantPort, Port};
use crate::shared::TICKS;
use crate::stack;
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::Ordering;
use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac;
use twinrotor::link::ResetReport;
use twinrotor::supervisor::Condition;

/// Says that [`Note::code`] and the rest mean something; RAM after power-on is random.
const MAGIC: u32 = 0x7477_696E;

/// Kept over a reset, lost with the supply.
#[repr(C)]
struct Note {
    magic: u32,
    code: u32,
    program_counter: u32,
    ticks: u32,
    /// The exclusive or of all before it.
    check: u32,
}

struct Kept(UnsafeCell<MaybeUninit<Note>>);

#[expect(unsafe_code, reason = "shared between the end of one boot and the beginning of the next")]
// SAFETY: written only when nothing else runs any more, read once before anything else runs.
unsafe impl Sync for Kept {}

#[expect(unsafe_code, reason = "a section of the linker's that start-up does not clear")]
#[unsafe(link_section = ".uninit.RESET_RECORD")]
#[unsafe(no_mangle)]
static RESET_RECORD: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

/// What the note's code means.
const CAUSES: [Condition; 5] = [
    Condition::ResetByPanic,
    Condition::ResetByFault,
    Condition::ResetByStackOverflow,
    Condition::ResetByBrownOut,
    Condition::ResetByClock,
];

/// What ended the program before this boot, if it should not have; forgets it.
pub(crate) fn read_and_clear() -> Option<ResetReport> {
    #[expect(unsafe_code, reason = "the record in RAM")]
    // SAFETY: any bits are a Note; nobody else uses it now.
    let note = unsafe {
        let place = RESET_RECORD.0.get().cast::<Note>();
        let note = place.read_volatile();
        (&raw mut (*place).magic).write_volatile(0);
        note
    };
    let seen = family::reset_cause();
    let written =
        note.magic == MAGIC && note.check == note.magic ^ note.code ^ note.program_counter ^ note.ticks;
    match CAUSES.get(note.code as usize) {
        Some(&cause) if written => {
            Some(ResetReport { cause, program_counter: note.program_counter, ticks: note.ticks })
        }
        _ => seen.map(|cause| ResetReport { cause, program_counter: 0, ticks: 0 }),
    }
}

/// Ends the program.
fn end(cause: Condition, program_counter: u32) -> ! {
    Port::off();
    let code = (0..).zip(CAUSES).find(|&(_, known)| known == cause).map_or(u32::MAX, |(code, _)| code);
    let ticks = TICKS.load(Ordering::Relaxed);
    let check = MAGIC ^ code ^ program_counter ^ ticks;
    #[expect(unsafe_code, reason = "the record in RAM")]
    // SAFETY: nothing else runs any more, and after the reset only `read_and_clear` looks.
    unsafe {
        RESET_RECORD.0.get().cast::<Note>().write_volatile(Note {
            magic: MAGIC,
            code,
            program_counter,
            ticks,
            check,
        });
    }
    SCB::sys_reset()
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    end(Condition::ResetByPanic, caller())
}

/// Where this function's caller will return to.
#[inline(always)]
fn caller() -> u32 {
    cortex_m::register::lr::read()
}

// A stack that has overflowed cannot be used, not even by the fault's handler: begin it anew, after keeping
// where it was.
#[expect(unsafe_code, reason = "a handler that must not touch its stack")]
mod hard_fault {
    core::arch::global_asm!(
    ".section .text.HardFault, \"ax\"",
    ".global HardFault",
    ".type HardFault, %function",
    ".thumb_func",
    "HardFault:",
    "mrs r0, msp",
    "ldr r1, =_stack_start",
    "msr msp, r1",
    "b {fault}",
    ".size HardFault, . - HardFault",
    ".ltorg",
    fault = sym super::fault,
    );
}

/// Any fault: none of the others is enabled, so all of them arrive here.
extern "C" fn fault(stack_pointer: u32) -> ! {
    Port::off();
    // Of the memory's protection and of the bus, of the integer and, lazily, of the floating-point registers:
    // MSTKERR, MLSPERR, STKERR, LSPERR (ARMv7-M reference manual, B3.2.15).
    const STACKING_FAILED: u32 = 1 << 4 | 1 << 5 | 1 << 12 | 1 << 13;
    /// \[byte\] Of an exception's frame, with the floating-point registers.
    const FRAME: u32 = 104;
    let (start, end_of_stack) = stack::bounds();
    #[expect(unsafe_code, reason = "a register of the core")]
    // SAFETY: reading it changes nothing.
    let status = unsafe { (*SCB::PTR).cfsr.read() };
    if stack_pointer < end_of_stack + FRAME || status & STACKING_FAILED != 0 {
        end(Condition::ResetByStackOverflow, 0);
    }
    let frame = stack_pointer + 24;
    let program_counter = if frame < start && frame.is_multiple_of(4) {
        #[expect(unsafe_code, reason = "the exception's frame")]
        // SAFETY: within the stack and aligned: the program counter that the core has stacked.
        unsafe {
            (frame as *const u32).read_volatile()
        }
    } else {
        0
    };
    end(Condition::ResetByFault, program_counter)
}

#[exception]
#[allow(unsafe_code, reason = "the attribute asks for it")]
unsafe fn DefaultHandler(_: i16) -> ! {
    end(Condition::ResetByFault, 0)
}

/// The clock security has found that the crystal stopped, and has broken the PWM; or it was only the flash.
#[exception]
#[allow(unsafe_code, reason = "the attribute asks for it")]
unsafe fn NonMaskableInt() {
    if !family::flash::tolerates() {
        end(Condition::ResetByClock, 0)
    }
}

/// From here on, too low a voltage of the chip's own supply ends the program: the amplifiers must not outlive
/// it.
pub(crate) fn listen_to_supply() {
    const LINE: usize = 16;
    family::detect_low_supply();
    pac::EXTI.rtsr(0).modify(|w| w.set_line(LINE, true));
    pac::EXTI.imr(0).modify(|w| w.set_line(LINE, true));
    let detector = SUPPLY;
    detector.set_priority(Priority::P0);
    #[expect(unsafe_code, reason = "an interrupt is enabled")]
    // SAFETY: its handler does not return.
    unsafe {
        detector.enable();
    }
    // Below already: there will be no edge.
    if family::supply_is_low() {
        end(Condition::ResetByBrownOut, 0);
    }
}

/// For the detector's interrupt.
#[inline(always)]
pub(crate) fn end_for_supply() -> ! {
    end(Condition::ResetByBrownOut, 0)
}
