//! The flash array: what it holds, and what an operation makes of it, whether it ends or is cut off.

use rigless::device::DeviceContext;
use rigless::soc::Width;

/// Where the array begins.
pub const BASE: u64 = 0x0800_0000;
/// Its size.
pub const SIZE: usize = 1 << 20;

/// Typical durations with `PSIZE` x32 [ns], datasheet table 40: a word, and a sector by its size.
pub(super) const PROGRAM_NS: u64 = 16_000;
const ERASE_NS: [(u64, u64); 3] =
    [(16 << 10, 250_000_000), (64 << 10, 550_000_000), (128 << 10, 1_000_000_000)];
/// How much longer an erase takes with narrower parallelism, by `PSIZE`, in hundredths.
const ERASE_BY_PSIZE: [u64; 4] = [160, 120, 100, 100];

/// An operation of the array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// A sector set to ones: its first address and size.
    Erase { address: u64, size: u64 },
    /// Bits of a word, or less, set to zero.
    Program { address: u64, width: Width, value: u64 },
}

/// The first address and the size of sector `number` of twelve, table 5.
pub fn sector(number: u64) -> Option<(u64, u64)> {
    match number {
        0..=3 => Some((BASE + number * (16 << 10), 16 << 10)),
        4 => Some((BASE + (64 << 10), 64 << 10)),
        5..=11 => Some((BASE + (number - 4) * (128 << 10), 128 << 10)),
        _ => None,
    }
}

/// How long a sector of `size` bytes takes to erase with the parallelism `psize` \[ns\].
pub(super) fn erase_ns(size: u64, psize: u64) -> u64 {
    let parallelism = usize::try_from(psize).expect("two bits");
    let typical = ERASE_NS.iter().find(|(bytes, _)| *bytes == size);
    typical.expect("every sector's size is listed").1 * ERASE_BY_PSIZE[parallelism] / 100
}

/// When to cut the supply: in an operation of the array, at a share of its duration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// Which operation, counting from 1 for the next one that starts.
    pub operation: u64,
    /// The share of its duration that passes before the supply goes, 0 to 1. Of the bits the operation
    /// changes, about this share have changed by then, drawn at random.
    pub share: f64,
}

/// The bytes, and chance.
#[derive(Debug)]
pub(super) struct Array {
    bytes: Vec<u8>,
    /// For the bits that a cut leaves to chance.
    random: u64,
}

impl Array {
    /// An erased array.
    pub(super) fn new(seed: u64) -> Self {
        Self { bytes: vec![0xFF; SIZE], random: seed | 1 }
    }

    /// The array's bytes from `address` on.
    pub(super) fn bytes(&self, address: u64, length: usize) -> &[u8] {
        let start = offset(address);
        &self.bytes[start..start + length]
    }

    /// Puts `bytes` at `address`, without the part knowing.
    pub(super) fn place(&mut self, address: u64, bytes: &[u8]) {
        let start = offset(address);
        self.bytes[start..start + bytes.len()].copy_from_slice(bytes);
    }

    fn draw(&mut self) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random
    }

    /// 32 bits, each set with probability `share`.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 65536")]
    fn draw_word(&mut self, share: f64) -> u64 {
        let threshold = (share * 65536.0) as u64;
        (0..32).fold(0, |word, bit| {
            let hit = (self.draw() >> 20) & 0xFFFF < threshold;
            word | u64::from(hit) << bit
        })
    }

    fn get(&self, address: u64, width: Width) -> u64 {
        let mut value = [0; 8];
        let length = width.bytes() as usize;
        value[..length].copy_from_slice(self.bytes(address, length));
        u64::from_le_bytes(value)
    }

    pub(super) fn put(&mut self, address: u64, width: Width, value: u64, context: &mut DeviceContext<'_>) {
        let (start, length) = (offset(address), width.bytes() as usize);
        self.bytes[start..start + length].copy_from_slice(&value.to_le_bytes()[..length]);
        context.program(address, width, value, 0);
    }

    /// An operation that ends.
    pub(super) fn finish(&mut self, operation: Operation, context: &mut DeviceContext<'_>) {
        match operation {
            Operation::Erase { address, size } => {
                for word in 0..size / 4 {
                    self.put(address + 4 * word, Width::W32, 0xFFFF_FFFF, context);
                }
            }
            Operation::Program { address, width, value } => {
                let value = self.get(address, width) & value;
                self.put(address, width, value, context);
            }
        }
    }

    /// The bits an interrupted operation would have changed, changed at random.
    pub(super) fn leave_half_done(
        &mut self,
        operation: Operation,
        share: f64,
        context: &mut DeviceContext<'_>,
    ) {
        match operation {
            Operation::Erase { address, size } => {
                for word in 0..size / 4 {
                    let at = address + 4 * word;
                    let value = self.get(at, Width::W32) | self.draw_word(share);
                    self.put(at, Width::W32, value, context);
                }
            }
            Operation::Program { address, width, value } => {
                let cleared = self.draw_word(share) | self.draw_word(share) << 32;
                let value = self.get(address, width) & (value | !cleared);
                self.put(address, width, value & width.mask(), context);
            }
        }
    }
}

fn offset(address: u64) -> usize {
    usize::try_from(address - BASE).expect("an address of the array")
}
