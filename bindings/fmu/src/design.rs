//! What a unit is of: as texts in its resources.

use twinrotor::defaults;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig::{self, NamedRig};
use twinrotor_sim::{Error, Outcome};

/// What a unit simulates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The rig: volts in, counts out.
    Plant,
    /// The board: setpoints and counts in, volts out.
    Controller,
    /// Both, as `host-sim simulate --fidelity rig` flies them.
    Loop,
}

impl What {
    /// All there are, as they are typed.
    pub const NAMES: [(&str, Self); 3] =
        [("plant", Self::Plant), ("controller", Self::Controller), ("loop", Self::Loop)];

    /// As it is typed.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, what)| *what == self).map_or("", |(name, _)| name)
    }
}

/// A unit's contents.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Which of the three.
    pub what: What,
    /// The rig.
    pub named: NamedRig,
    /// Its controller.
    pub gains: GainsFile,
}

impl Design {
    /// From a preset and gains by name or path; without gains, what the preset's board boots with.
    ///
    /// # Errors
    ///
    /// If one of them is none, or a rig of your own has no gains.
    pub fn load(
        what: What,
        preset: &str,
        gains: Option<&str>,
        read: twinrotor_sim::Read<'_>,
    ) -> Outcome<Self> {
        let named = rig::load(preset, read)?;
        let gains = match gains {
            Some(name) => {
                let gains = GainsFile::load(name, read)?;
                gains.require_stable(&named.name, &named.rig).map_err(|error| error.within(name))?;
                gains
            }
            None => {
                let controller = defaults::named(&named.name).ok_or_else(|| {
                    Error::invalid("gains", "left out", "a gains file: a rig of your own has none of its own")
                })?;
                GainsFile { controller, provenance: None }
            }
        };
        Ok(Self { what, named, gains })
    }

    /// The files of its resources.
    pub fn resources(&self) -> [(&'static str, String); 3] {
        [
            ("unit.txt", format!("{}\n{}\n", self.what.name(), self.named.name)),
            ("rig.toml", rig::to_toml(&self.named.rig)),
            ("gains.toml", self.gains.to_toml()),
        ]
    }

    /// From the files of a unit's resources.
    ///
    /// # Errors
    ///
    /// If one of them is missing or not what this wrote.
    pub fn from_resources(read: impl Fn(&str) -> Outcome<String>) -> Outcome<Self> {
        let unit = read("unit.txt")?;
        let mut lines = unit.lines();
        let (kind, name) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
        let what = *twinrotor_sim::error::known_name("unit", kind, &What::NAMES)?;
        let named = NamedRig { name: name.to_owned(), rig: rig::parse("rig.toml", &read("rig.toml")?)? };
        let gains = GainsFile::parse("gains.toml", &read("gains.toml")?)?;
        Ok(Self { what, named, gains })
    }

    /// What tells this unit from any other: of the contents and of the version.
    pub fn guid(&self) -> String {
        let sums: Vec<u32> =
            self.resources().iter().map(|(_, text)| crc32fast::hash(text.as_bytes())).collect();
        let version = crc32fast::hash(env!("CARGO_PKG_VERSION").as_bytes());
        format!("{{{:08x}-{:08x}-{:08x}-{version:08x}}}", sums[0], sums[1], sums[2])
    }
}
