//! A driver without a card: the kernels' own functions, thread by thread on this processor, and the faults
//! that a card can have. What is tested with it is everything but the card.

use super::driver::{Argument, Driver, Fault};
use crate::integral;
use crate::robust::{self, Given};
use rayon::prelude::*;
use std::string::{String, ToString};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::vec::Vec;
use twinrotor_sim::judged::Flown;

/// It.
#[derive(Debug)]
pub struct StandIn {
    /// \[bytes\] What it says is free.
    said: u64,
    /// \[bytes\] What is.
    free: Arc<AtomicU64>,
    /// Launches until it is lost.
    left: AtomicU64,
    launches: AtomicU64,
}

/// Words in it; given back when dropped.
#[derive(Debug)]
pub struct Memory {
    words: Mutex<Vec<u32>>,
    free: Arc<AtomicU64>,
}

fn bytes(words: usize) -> u64 {
    (words * size_of::<u32>()) as u64
}

impl Drop for Memory {
    fn drop(&mut self) {
        let words = self.words.get_mut().map_or(0, |words| words.len());
        self.free.fetch_add(bytes(words), Ordering::Relaxed);
    }
}

impl Default for StandIn {
    fn default() -> Self {
        Self::with(1 << 30, u64::MAX)
    }
}

impl StandIn {
    /// With so much `memory` \[bytes\], lost after so many `launches`.
    pub fn with(memory: u64, launches: u64) -> Self {
        Self::claiming(memory, memory, launches)
    }

    /// As [`StandIn::with`], but `said` \[bytes\] is what it claims to have.
    pub fn claiming(said: u64, memory: u64, launches: u64) -> Self {
        Self {
            said,
            free: Arc::new(AtomicU64::new(memory)),
            left: AtomicU64::new(launches),
            launches: AtomicU64::new(0),
        }
    }

    /// How many launches there were.
    pub fn launches(&self) -> u64 {
        self.launches.load(Ordering::Relaxed)
    }

    fn take(&self, words: Vec<u32>) -> Result<Memory, Fault> {
        let size = bytes(words.len());
        let taken =
            self.free.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |free| free.checked_sub(size));
        taken.map_err(|_| Fault::Memory)?;
        Ok(Memory { words: Mutex::new(words), free: Arc::clone(&self.free) })
    }
}

impl Driver for StandIn {
    type Memory = Memory;

    fn name(&self) -> String {
        "stand-in".to_string()
    }

    fn free(&self) -> Result<u64, Fault> {
        Ok(self.said)
    }

    fn upload(&self, words: &[u32]) -> Result<Memory, Fault> {
        self.take(words.to_vec())
    }

    fn reserve(&self, words: usize) -> Result<Memory, Fault> {
        self.take(std::vec![0; words])
    }

    fn launch(&self, kernel: &str, arguments: &[Argument<'_, Memory>], threads: u32) -> Result<(), Fault> {
        let lost = |what: &str| Fault::Lost(what.to_string());
        let left = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        left.map_err(|_| lost("unplugged"))?;
        self.launches.fetch_add(1, Ordering::Relaxed);
        // In the order of the kernels' parameters (`ptx.rs`): behind each pointer its length.
        let [
            Argument::Copied(common),
            Argument::Words(settings),
            Argument::Number(_),
            Argument::Number(each),
            Argument::Words(plants),
            Argument::Number(_),
            Argument::Number(count),
            Argument::Words(course),
            Argument::Number(_),
            Argument::Words(out),
            Argument::Number(flights),
        ] = arguments
        else {
            return Err(lost("invalid argument"));
        };
        let read = |memory: &Memory| memory.words.lock().map(|words| words.clone()).unwrap_or_default();
        let [settings, plants, course] = [settings, plants, course].map(|m| read(m));
        let given = Given {
            common: *common,
            settings: &settings,
            each: *each,
            plants: &plants,
            count: *count,
            course: &course,
        };
        let flown = |flown: Option<Flown>| flown.map(|flown| robust::to_words(&flown).to_vec());
        let fly = |k: u32| match kernel {
            "robust_any" => flown(robust::flight(&given, k, Some, |motion| motion)),
            "robust_usual" => flown(robust::flight(&given, k, robust::usual, |motion| motion)),
            "integral_ideal" => integral::ideal(&given, k).map(|words| words.to_vec()),
            "integral_rig" => integral::rig(&given, k).map(|words| words.to_vec()),
            "robust_trace" => robust::trace(&given, k).map(|words| words.to_vec()),
            _ => None,
        };
        let mut words = out.words.lock().map_err(|_| lost("out of order"))?;
        let made: Option<Vec<Vec<u32>>> = (0..(*flights).min(threads)).into_par_iter().map(fly).collect();
        let made = made.ok_or_else(|| lost("unspecified launch failure"))?.concat();
        let place = words.get_mut(..made.len()).ok_or_else(|| lost("illegal address"))?;
        place.copy_from_slice(&made);
        Ok(())
    }

    fn download(&self, memory: &Memory) -> Result<Vec<u32>, Fault> {
        memory.words.lock().map(|words| words.clone()).map_err(|_| Fault::Lost("out of order".to_string()))
    }
}
