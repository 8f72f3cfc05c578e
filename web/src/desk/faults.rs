//! What can be made to go wrong with a simulated rig, by a click.

use serde::Serialize;
use twinrotor::axes::PerAxis;
use twinrotor::bench::Faults;
use twinrotor::plant::presets::Rig;
use twinrotor::supervisor::{Condition, Conditions};
use twinrotor_sim::Outcome;
use twinrotor_sim::error::known_name;
use twinrotor_station::SimulatedBoard;

/// A thing that goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// The encoder of pitch stays where it is.
    PitchStuck,
    /// That of yaw.
    YawStuck,
    /// The encoder of pitch counts backwards from now on.
    PitchReversed,
    /// That of yaw.
    YawReversed,
    /// The encoders are swapped.
    EncodersSwapped,
    /// The motors are swapped.
    MotorsSwapped,
    /// The supply sinks below what the rig allows.
    SupplyDip,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// Nothing goes over the line any more, either way.
    LinkLost,
}

/// Each by its name, with what a person reads.
pub const ALL: [(&str, (Fault, &str)); 9] = [
    ("pitch-stuck", (Fault::PitchStuck, "pitch encoder unplugged")),
    ("yaw-stuck", (Fault::YawStuck, "yaw encoder unplugged")),
    ("pitch-reversed", (Fault::PitchReversed, "pitch encoder reversed")),
    ("yaw-reversed", (Fault::YawReversed, "yaw encoder reversed")),
    ("encoders-swapped", (Fault::EncodersSwapped, "encoders swapped")),
    ("motors-swapped", (Fault::MotorsSwapped, "motors swapped")),
    ("supply-dip", (Fault::SupplyDip, "supply dips")),
    ("emergency-stop", (Fault::EmergencyStop, "emergency stop pressed")),
    ("link-lost", (Fault::LinkLost, "link lost")),
];

/// A fault as a page lists it.
#[derive(Debug, Serialize)]
pub struct Listed {
    name: &'static str,
    words: &'static str,
    present: bool,
}

/// Which are there now.
#[derive(Debug, Clone, Default)]
pub struct Present(Vec<Fault>);

impl Present {
    /// Is it there?
    #[must_use]
    pub fn has(&self, fault: Fault) -> bool {
        self.0.contains(&fault)
    }

    /// It comes, or goes.
    ///
    /// # Errors
    ///
    /// If there is none of that name.
    pub fn set(&mut self, name: &str, present: bool) -> Outcome<&'static str> {
        let (fault, words) = *known_name("fault", name, &ALL)?;
        self.0.retain(|&there| there != fault);
        if present {
            self.0.push(fault);
        }
        Ok(words)
    }

    /// All that there can be.
    #[must_use]
    pub fn list(&self) -> Vec<Listed> {
        ALL.iter().map(|&(name, (fault, words))| Listed { name, words, present: self.has(fault) }).collect()
    }

    /// Puts them into the rig, whose `supply` \[V\] is as it should be, and its board. The line is not
    /// theirs.
    pub fn apply(&self, board: &mut SimulatedBoard, rig: &Rig, supply: f32) {
        let has = |fault| self.has(fault);
        board.rig.bench.faults = Faults {
            motors_swapped: has(Fault::MotorsSwapped),
            encoders_swapped: has(Fault::EncodersSwapped),
            encoder_reversed: PerAxis::new(has(Fault::PitchReversed), has(Fault::YawReversed)),
            encoder_stuck: PerAxis::new(has(Fault::PitchStuck), has(Fault::YawStuck)),
            ..Faults::default()
        };
        #[expect(clippy::cast_possible_truncation, reason = "some 16 V")]
        let dip = 0.9 * rig.supply.lowest as f32;
        board.rig.bench.supply = if has(Fault::SupplyDip) { dip } else { supply };
        board.senses = Conditions::NONE.with(Condition::EmergencyStop, has(Fault::EmergencyStop));
    }
}
