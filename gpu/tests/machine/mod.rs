//! A driver whose card is a program: it runs the text that a card's driver would get, one thread after the
//! other, and counts instructions. What it knows of the language is what the kernels use of it (PTX ISA,
//! chapter 9); it refuses what it does not know.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::neg_cmp_op_on_partial_ord,
    reason = "registers are bits, and what instructions make of them is that"
)]

mod meaning;
mod parse;

use parse::{Kernel, Operand, Program, Step};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use twinrotor_gpu::BLOCK;
use twinrotor_gpu::host::driver::{Argument, Driver, Fault};

/// The card.
#[derive(Debug)]
pub(crate) struct Machine {
    program: Program,
    executed: Mutex<Executed>,
}

/// How often each instruction, by its line in the text and its name.
pub(crate) type Executed = BTreeMap<(usize, String), u64>;

/// Words on it.
#[derive(Debug)]
pub(crate) struct Memory(Mutex<Vec<u8>>);

impl Memory {
    fn lock(&self) -> MutexGuard<'_, Vec<u8>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Machine {
    /// With the kernels of `text`.
    pub(crate) fn new(text: &str) -> Self {
        Self { program: Program::of(text), executed: Mutex::default() }
    }

    /// What all threads together have executed.
    pub(crate) fn executed(&self) -> Executed {
        self.executed.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// \[bytes\] From the beginning of one piece of memory to the next one's.
const APART: u64 = 1 << 32;
/// Pieces that are there beside what a launch is given: what the text declares, of the module and of a block.
const DECLARED: u64 = 2;

impl Driver for Machine {
    type Memory = Memory;

    fn name(&self) -> String {
        "a program that reads PTX".to_owned()
    }

    fn free(&self) -> Result<u64, Fault> {
        Ok(APART)
    }

    fn upload(&self, words: &[u32]) -> Result<Memory, Fault> {
        Ok(Memory(Mutex::new(words.iter().flat_map(|word| word.to_le_bytes()).collect())))
    }

    fn reserve(&self, words: usize) -> Result<Memory, Fault> {
        self.upload(&vec![0; words])
    }

    fn launch(&self, kernel: &str, arguments: &[Argument<'_, Memory>], threads: u32) -> Result<(), Fault> {
        let kernel = self.program.kernels.get(kernel).expect("a kernel of this name");
        let mut parameters = Vec::new();
        let mut pieces = vec![self.program.constants.clone(), Vec::new()];
        let mut held = Vec::new();
        for (argument, (place, size)) in arguments.iter().zip(&kernel.parameters) {
            let bytes = match argument {
                Argument::Copied(words) => words.iter().flat_map(|word| word.to_le_bytes()).collect(),
                Argument::Number(number) => number.to_le_bytes().to_vec(),
                Argument::Words(memory) => {
                    let guard = memory.lock();
                    pieces.push(guard.clone());
                    held.push(guard);
                    ((pieces.len() as u64 - 1) * APART).to_le_bytes().to_vec()
                }
            };
            assert_eq!(bytes.len(), *size, "a parameter's size");
            parameters.resize(*place, 0);
            parameters.extend(bytes);
        }
        assert_eq!(arguments.len(), kernel.parameters.len());
        let mut executed = vec![0; kernel.steps.len()];
        for number in 0..threads.next_multiple_of(BLOCK) {
            // Nothing is in a block's memory that its threads have not put there.
            if number % BLOCK == 0 {
                pieces[1] = vec![0xFF; self.program.shared];
            }
            let special = [number / BLOCK, BLOCK, number % BLOCK].map(u64::from);
            let mut thread =
                Thread { kernel, parameters: &parameters, pieces, special, executed: &mut executed };
            thread.run();
            pieces = thread.pieces;
        }
        let mut all = self.executed.lock().unwrap_or_else(PoisonError::into_inner);
        for (place, times) in kernel.places.iter().zip(executed) {
            *all.entry(place.clone()).or_default() += times;
        }
        for (mut place, piece) in held.into_iter().zip(pieces.into_iter().skip(DECLARED as usize)) {
            *place = piece;
        }
        Ok(())
    }

    fn download(&self, memory: &Memory) -> Result<Vec<u32>, Fault> {
        let bytes = memory.lock();
        let (words, _) = bytes.as_chunks::<4>();
        Ok(words.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }
}

struct Thread<'a> {
    kernel: &'a Kernel,
    parameters: &'a [u8],
    pieces: Vec<Vec<u8>>,
    /// Block, threads in a block, thread.
    special: [u64; 3],
    /// How often each step has been.
    executed: &'a mut [u64],
}

impl Thread<'_> {
    fn run(&mut self) {
        let mut registers = vec![0_u64; self.kernel.widths.len()];
        let mut at = 0;
        loop {
            let step = &self.kernel.steps[at];
            self.executed[at] += 1;
            at += 1;
            if step.guard.is_some_and(|(guard, wanted)| (registers[guard] != 0) != wanted) {
                continue;
            }
            let value = |operand: Operand| match operand {
                Operand::Register(k) => registers[k],
                Operand::Number(number) => number,
                Operand::Special(k) => self.special[k],
            };
            let (to, result) = match &step.what {
                Step::Compute { to, meaning, from } => (*to, meaning(from.map(value))),
                Step::Parameter { to, place, size } => (*to, number(&self.parameters[*place..][..*size])),
                Step::Load { to, base, offset, size } => {
                    let address = value(*base).wrapping_add(*offset);
                    let piece = &self.pieces[(address / APART) as usize];
                    (*to, number(&piece[(address % APART) as usize..][..*size]))
                }
                Step::Store { base, offset, size, from } => {
                    let address = value(*base).wrapping_add(*offset);
                    let (piece, from) = ((address / APART) as usize, value(*from).to_le_bytes());
                    assert_ne!(piece, 0, "what the module declares is constant");
                    let place = &mut self.pieces[piece][(address % APART) as usize..][..*size];
                    place.copy_from_slice(&from[..*size]);
                    continue;
                }
                Step::Halves { to, from } => {
                    let whole = value(*from);
                    registers[to[0]] = whole & 0xFFFF_FFFF;
                    registers[to[1]] = whole >> 32;
                    continue;
                }
                Step::Branch(to) => {
                    at = *to;
                    continue;
                }
                Step::Table { index, to } => {
                    at = to[value(*index) as usize];
                    continue;
                }
                Step::Exit => return,
                Step::Trap => panic!("the kernel gives up"),
            };
            registers[to] = result & mask(self.kernel.widths[to]);
        }
    }
}

fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

fn mask(bits: u32) -> u64 {
    u64::MAX >> (64 - bits)
}
