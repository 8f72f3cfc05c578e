//! What `identify` and `coverage` fit, and the gains that fly for it.

use crate::error::{Failure, Outcome};
use crate::files;
use twinrotor_identify::WINDOW;
use twinrotor_identify::identification::Question;
use twinrotor_identify::search::Effort;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig::NamedRig;

/// What is fitted, and with how much effort.
#[derive(Debug, clap::Args)]
pub(super) struct Fitted {
    /// Constants to fit beside the usual ones, such as inertia.yaw
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub free: Vec<String>,
    /// Constants to leave as the preset has them, such as rotor_time_constant.tail
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub fix: Vec<String>,
    /// Length of the windows that are fitted, in s
    #[arg(long, value_name = "S", default_value_t = WINDOW, allow_negative_numbers = true)]
    pub window: f64,
    /// Flowers of the search for where to begin
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub population: usize,
    /// Generations after the first
    #[arg(long, value_name = "T", default_value_t = 3)]
    pub iterations: usize,
}

impl Fitted {
    /// What is asked of logs of `named`.
    pub(super) fn question(&self, named: NamedRig, seed: u64) -> Outcome<Question> {
        let effort = Effort { population: self.population, iterations: self.iterations, seed };
        Question::new(named, &self.free, &self.fix, self.window, effort).map_err(Failure::of_flag)
    }
}

/// Those of `--gains`, else the preset's, else the paper's.
pub(super) fn gains(given: Option<&str>, named: &NamedRig) -> Outcome<GainsFile> {
    if let Some(name) = given {
        return files::gains("--gains", name);
    }
    let own = twinrotor::defaults::named(&named.name);
    Ok(own.map_or_else(GainsFile::paper, |controller| GainsFile { controller, provenance: None }))
}
