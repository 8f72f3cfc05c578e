//! What of a card's driver is used, so that something else can stand in for it.

use crate::told::COMMON;
use std::fmt;
use std::string::String;
use std::vec::Vec;

/// Why a card does not do what it should.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// There is none, or no driver for it; in the driver's words.
    NoDevice(String),
    /// It has not this much memory left.
    Memory,
    /// It does not take the kernels, or was lost in the middle of the work; in the driver's words.
    Lost(String),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDevice(why) => write!(f, "no CUDA device to be had: {why}"),
            Self::Memory => f.write_str("the CUDA device has no memory left, not even for a few flights"),
            Self::Lost(why) => write!(f, "the CUDA device failed: {why}"),
        }
    }
}

/// What a kernel is called with.
#[derive(Debug)]
pub enum Argument<'a, M> {
    /// Words, and not where they are.
    Copied(&'a [u32; COMMON]),
    /// The address of words on the card.
    Words(&'a M),
    /// A number.
    Number(u32),
}

/// A card's driver. Memory is given back when what stands for it is dropped.
pub trait Driver: fmt::Debug + Send + Sync {
    /// Words on the card.
    type Memory;

    /// What the card is called.
    fn name(&self) -> String;

    /// \[bytes\] Memory that is free.
    ///
    /// # Errors
    /// The card is lost.
    fn free(&self) -> Result<u64, Fault>;

    /// Copies `words` to the card.
    ///
    /// # Errors
    /// No memory, or the card is lost.
    fn upload(&self, words: &[u32]) -> Result<Self::Memory, Fault>;

    /// So many words on the card, all 0.
    ///
    /// # Errors
    /// No memory, or the card is lost.
    fn reserve(&self, words: usize) -> Result<Self::Memory, Fault>;

    /// Runs `threads` threads of the kernel of this name to their end.
    ///
    /// # Errors
    /// The card is lost.
    fn launch(
        &self,
        kernel: &str,
        arguments: &[Argument<'_, Self::Memory>],
        threads: u32,
    ) -> Result<(), Fault>;

    /// Copies the words from the card.
    ///
    /// # Errors
    /// The card is lost.
    fn download(&self, memory: &Self::Memory) -> Result<Vec<u32>, Fault>;
}
