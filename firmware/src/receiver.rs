//! The serial line's way in: a DMA stream that writes a ring for ever, and a reader that follows it by the
//! stream's own count.
//!
//! Nothing stops the stream or starts it again, since a stopped one may hand out old bytes. A word that
//! comes with noise, without its stop bit or too late is a byte like any other: the message's CRC decides.
//! The port raises no interrupt, so that a noisy line cannot keep the program busy, and nothing but the
//! stream reads its data register, which would take a byte from it: after each tick the ring is looked at
//! instead ([`crate::wake`]).
//!
//! A reader that comes later than a lap (the flash stalls the core) finds bytes of two laps mixed, and may
//! see some twice: CRC and sequence numbers are for that.

use crate::boards::{SERIAL, SERIAL_IN};
use crate::family::stream;
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU16, Ordering};
use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::usart::{Instance, RxDma, RxPin};

/// \[byte\] Five milliseconds of a full line.
const RING: u16 = 512;

/// Written by the DMA only.
struct Ring(UnsafeCell<[u8; RING as usize]>);

#[expect(unsafe_code, reason = "shared with the DMA")]
// SAFETY: the program only ever reads it, a volatile byte at a time.
unsafe impl Sync for Ring {}

static BYTES: Ring = Ring(UnsafeCell::new([0; RING as usize]));
/// Which byte the reader takes next.
static NEXT: AtomicU16 = AtomicU16::new(0);

/// The receiver, which works.
pub(crate) struct Receiver {
    _pin: Flex<'static>,
    request: u8,
}

impl Receiver {
    /// Starts the port's receiver; its transmitter is set up already, and with it the port's clock and speed.
    pub(crate) fn start<T: Instance, P: RxPin<T>, D: RxDma<T>>(
        pin: Peri<'static, P>,
        stream: &Peri<'static, D>,
    ) -> Self {
        let function = pin.af_num();
        let mut pin = Flex::new(pin);
        // A line that is not plugged in is quiet.
        pin.set_as_af_unchecked(function, AfType::input(Pull::Up));
        let receiver = Self { _pin: pin, request: stream.request() };
        receiver.start_stream();
        stream::receive(SERIAL);
        receiver
    }

    fn start_stream(&self) {
        stream::start(SERIAL_IN, SERIAL, self.request, BYTES.0.get().cast(), RING);
        NEXT.store(0, Ordering::Relaxed);
    }

    /// The next byte that came, if there is one.
    pub(crate) fn next(&mut self) -> Option<u8> {
        if !stream::runs(SERIAL_IN) {
            // Only an error of the bus ends the stream, which nothing here can bring about. What is in the
            // ring was read, or is lost.
            self.start_stream();
        }
        let next = NEXT.load(Ordering::Relaxed);
        if next == written() {
            return None;
        }
        #[expect(unsafe_code, reason = "what the DMA has written")]
        // SAFETY: `next` is below `RING`; the DMA writes whole bytes.
        let byte = unsafe { BYTES.0.get().cast::<u8>().add(usize::from(next)).read_volatile() };
        NEXT.store((next + 1) % RING, Ordering::Relaxed);
        Some(byte)
    }
}

/// Where the stream writes next.
fn written() -> u16 {
    (RING - stream::left(SERIAL_IN)) % RING
}

/// Has anything come that was not read, or has the stream ended?
#[inline(always)]
pub(crate) fn waits() -> bool {
    NEXT.load(Ordering::Relaxed) != written() || !stream::runs(SERIAL_IN)
}
