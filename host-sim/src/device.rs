//! What flies: this processor, or a GPU.

use crate::error::{Failure, Outcome};
use std::num::NonZero;
use std::str::FromStr;
use std::sync::Arc;
use twinrotor_gpu::host::Card;
use twinrotor_gpu::host::driver::{Driver, Fault};
use twinrotor_gpu::host::stand_in::StandIn;
use twinrotor_sim::device::Device;

/// What was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// This processor.
    Cpu,
    /// The first card that NVIDIA's driver knows.
    Cuda,
    /// What stands in for a card in tests, lost after so many launches.
    StandIn(u64),
}

impl FromStr for Choice {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match (name, name.strip_prefix("stand-in:").map(str::parse)) {
            ("cpu", _) => Ok(Self::Cpu),
            ("cuda", _) => Ok(Self::Cuda),
            (_, Some(Ok(launches))) => Ok(Self::StandIn(launches)),
            _ => Err("allowed: cpu, cuda".to_owned()),
        }
    }
}

/// Flights of a rig that a core flies in the time of one launch, and those of the paper's world: a sixteenth
/// of what the sixteen hardware threads beside one card flew (docs/gpu.md).
pub const RIG_FLIGHTS: usize = 150;
/// See there.
pub const IDEAL_FLIGHTS: usize = 80;

/// A device that was found, or this processor.
#[derive(Debug, Default)]
pub struct Found {
    card: Option<Arc<dyn Failing>>,
}

/// A device that tells what became of it.
trait Failing: Device {
    fn failure(&self) -> Option<Fault>;
}

impl<D: Driver> Failing for Card<D> {
    fn failure(&self) -> Option<Fault> {
        Card::failure(self)
    }
}

impl Choice {
    /// Looks for it.
    ///
    /// # Errors
    /// There is none.
    pub fn find(self) -> Outcome<Found> {
        let card: Arc<dyn Failing> = match self {
            Self::Cpu => return Ok(Found::default()),
            Self::Cuda => cuda()?,
            Self::StandIn(launches) => Arc::new(Card::new(StandIn::with(1 << 30, launches))),
        };
        Ok(Found { card: Some(card) })
    }
}

#[cfg(feature = "cuda")]
fn cuda() -> Outcome<Arc<dyn Failing>> {
    match twinrotor_gpu::host::cuda::Cuda::find() {
        Ok(driver) => Ok(Arc::new(Card::new(driver))),
        Err(fault) => Err(Failure::Run(format!("--device cuda: {fault}; --device cpu gives the same bytes"))),
    }
}

#[cfg(not(feature = "cuda"))]
fn cuda() -> Outcome<Arc<dyn Failing>> {
    Err(Failure::Run(
        "--device cuda: this program was built without it: run scripts/build-ptx.sh, then build with \
         --features cuda; --device cpu gives the same bytes"
            .to_owned(),
    ))
}

impl Found {
    /// What flies instead of this processor, if anything.
    pub fn device(&self) -> Option<Arc<dyn Device>> {
        self.card.clone().map(|card| card as Arc<dyn Device>)
    }

    /// Why it gives nothing more, if it does not.
    pub fn failure(&self) -> Option<String> {
        self.card.as_ref()?.failure().map(|fault| fault.to_string())
    }

    /// What is to be said where so many `flights` at once are too few for it: a launch takes as long as its
    /// longest flight, and in that time this processor's lanes fly `each_core` on a core. Nothing else.
    pub fn note(&self, flights: usize, each_core: usize) -> String {
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        let enough = cores * each_core;
        if self.card.is_none() || flights >= enough {
            return String::new();
        }
        format!(
            "note: {flights} flights go to the card at once; with fewer than about {enough} these {cores} \
             cores are the faster choice (--device cpu; docs/gpu.md)\n"
        )
    }

    /// `flown`, or why there is none, where nothing else stops the flights.
    ///
    /// # Errors
    /// The device has failed.
    pub fn all<T>(&self, flown: Option<T>) -> Outcome<T> {
        flown.ok_or_else(|| {
            let why = self.failure().unwrap_or_else(|| "the flights were stopped".to_owned());
            Failure::Run(format!("{why}; nothing is written; --device cpu gives the same bytes"))
        })
    }
}
