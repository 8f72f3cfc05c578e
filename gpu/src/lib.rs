//! Twinrotor's closed loops on a GPU: what one thread flies. The same functions of the same crates as on a
//! board and in the tuner's lanes, so the same bits; nothing is computed here.

#![no_std]
#![cfg_attr(target_arch = "nvptx64", feature(abi_ptx, stdarch_nvptx, asm_experimental_arch))]

#[cfg(feature = "host")]
extern crate std;

#[cfg(feature = "host")]
pub mod host;
pub mod integral;
#[cfg(target_arch = "nvptx64")]
mod ptx;
pub mod robust;
#[cfg(target_arch = "nvptx64")]
mod shared;
pub mod told;
pub mod words;

/// Threads in a block. Each has up to 255 registers, and a multiprocessor 65,536: two blocks.
pub const BLOCK: u32 = 128;
