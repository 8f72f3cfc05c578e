//! What this boot is known by on the link: another number than the last boot's.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use twinrotor::link::Nonce;

/// Kept over a reset; after power-on, what the RAM wakes up with.
struct Kept(UnsafeCell<MaybeUninit<u32>>);

#[expect(unsafe_code, reason = "shared between one boot and the next")]
// SAFETY: used once, before anything else runs.
unsafe impl Sync for Kept {}

#[expect(unsafe_code, reason = "a section of the linker's that start-up does not clear")]
#[unsafe(link_section = ".uninit.NONCE")]
static LAST: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

/// The next number of a sequence that comes back to one only after 2^32 (Numerical Recipes' generator).
/// Called once.
pub(crate) fn draw() -> Nonce {
    #[expect(unsafe_code, reason = "a word of RAM that nobody initialises")]
    // SAFETY: any bits are a number; nobody else uses it.
    let number = unsafe {
        let place = LAST.0.get().cast::<u32>();
        let number = place.read_volatile().wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        place.write_volatile(number);
        number
    };
    Nonce(number)
}
