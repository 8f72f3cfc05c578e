//! Flags that several commands share, and how they are resolved.

use crate::error::{Failure, Outcome};
use crate::files::output::Outputs;
use crate::files::{checkpoint, figure};
use crate::{device, files, threads};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use twinrotor::axes::PerMotor;
use twinrotor::board::{self, Board};
use twinrotor::defaults;
use twinrotor::plant::presets::Rig;
use twinrotor::settings::LARGEST;
use twinrotor_sim::Error;
use twinrotor_sim::error::at_least;
use twinrotor_sim::flight::Fidelity;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::rig::NamedRig;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::robust::Scatter;

/// The preset and the gains that are taken where none are named.
pub(super) const PAPER: &str = "paper";

/// Of every command that computes.
#[derive(Debug, Args)]
pub(super) struct Common {
    /// Rig: paper, paper-fixed, aero, aero2, aero-lab, heli, or a FILE.toml of your own [default: paper]
    #[arg(long, help_heading = "Rig")]
    preset: Option<String>,
    /// Board that flies it, which decides how fine its PWM is: f405, feather-f405, f407, black-pill,
    /// nucleo-f411, nucleo-f446 or nucleo-g474; acts with --fidelity rig
    #[arg(long, value_name = "NAME", default_value = "f405", value_parser = board, help_heading = "Rig")]
    pub board: Board,
    /// Rotor lag of both motors, in s, instead of the preset's; it acts with --fidelity rig
    #[arg(long, value_name = "S", help_heading = "Rig")]
    pub rotor_lag: Option<f64>,
    /// Of everything random
    #[arg(long, default_value_t = 1, help_heading = "Computing")]
    pub seed: u64,
    /// Print one JSON document and nothing else
    #[arg(long, help_heading = "Output")]
    pub json: bool,
    /// Threads to compute on [default: all]; the results do not depend on it
    #[arg(long, value_name = "N", help_heading = "Computing")]
    pub threads: Option<usize>,
}

impl Common {
    /// As it was typed.
    pub(super) fn preset(&self) -> &str {
        self.preset.as_deref().unwrap_or(PAPER)
    }

    /// What was taken for the rig, and for the `gains` of a command that flies some, because nothing was
    /// said: a line that tells how others are chosen, or none where both were named.
    pub(super) fn unsaid(&self, gains: Option<&Option<String>>) -> String {
        let own = |_| format!(" (gains/{}.toml: its own)", self.preset());
        let own = defaults::named(self.preset()).map(own);
        match (self.preset.is_none(), gains.is_some_and(Option::is_none)) {
            (true, true) => {
                "by default: preset paper, the paper's gains; --preset and --gains choose others\n".to_owned()
            }
            (true, false) => "by default: preset paper; --preset chooses another\n".to_owned(),
            (false, true) => {
                format!("by default: the paper's gains; --gains chooses others{}\n", own.unwrap_or_default())
            }
            (false, false) => String::new(),
        }
    }

    /// Reads the rig and sets the threads.
    pub(super) fn resolve(&self) -> Outcome<NamedRig> {
        let mut named = files::rig(self.preset())?;
        named.rig.board = self.board;
        if let Some(lag) = self.rotor_lag {
            named.rig.plant.rotor_time_constant = PerMotor::both(at_least("--rotor-lag", lag, 0.0, false)?);
        }
        if let Some(threads) = self.threads {
            within("--threads", threads, 1, 1024)?;
        }
        threads::begin(self.threads);
        Ok(named)
    }

    /// The rig's file and others that the flags named are read.
    pub(super) fn outputs(&self) -> Outputs {
        let mut outputs = Outputs::new();
        outputs.reads("--preset", self.preset());
        outputs
    }
}

/// A board's name.
pub(super) fn board(name: &str) -> Result<Board, String> {
    let allowed = || board::ALL.map(|board| board.name).join(", ");
    Board::named(name).ok_or_else(|| format!("allowed: {}", allowed()))
}

/// What flies.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Device {
    /// What flies: cpu, or cuda for an NVIDIA card; the bytes that come out are the same
    #[arg(long = "device", value_name = "NAME", default_value = "cpu")]
    choice: device::Choice,
}

impl Device {
    /// Looks for it.
    pub(super) fn find(self) -> Outcome<device::Found> {
        self.choice.find()
    }
}

/// How far drawn plants lie apart.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Spreads {
    /// How far a drawn plant's constants and thrust lie from the preset's at most, as a part of them, 0 to .9
    /// [default: 0.3]
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    pub spread: Option<f64>,
    /// The same for each rotor's lag, 0 to .95 [default: 0.7]
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    pub lag_spread: Option<f64>,
}

impl Spreads {
    /// What is left out is the usual.
    pub(super) fn scatter(&self) -> Outcome<Scatter> {
        let usual = Scatter::default();
        let scatter = Scatter {
            constants: self.spread.unwrap_or(usual.constants),
            lag: self.lag_spread.unwrap_or(usual.lag),
        };
        scatter.validate().map_err(Failure::of_flag)?;
        Ok(scatter)
    }
}

/// The rig that is flown where the controllers believe in `named`.
pub(super) fn truth(rig: Option<&str>, lag: Option<f64>, named: &NamedRig) -> Outcome<Rig> {
    let mut truth = match rig {
        Some(name) => files::rig(name)?.rig,
        None => named.rig,
    };
    if let Some(lag) = lag {
        truth.plant.rotor_time_constant = PerMotor::both(at_least("--true-lag", lag, 0.0, false)?);
    }
    Ok(truth)
}

/// A command as it was typed, but for flags with a value and `switches` that change nothing of what comes
/// out.
pub(super) fn typed(args: impl Iterator<Item = String>, without: &[&str], switches: &[&str]) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=:+@%".contains(c);
    let quoted = |arg: &str| {
        let bare = !arg.is_empty() && arg.chars().all(plain);
        if bare { arg.to_owned() } else { format!("'{}'", arg.replace('\'', "'\\''")) }
    };
    let mut kept = vec!["host-sim".to_owned()];
    let mut args = args;
    while let Some(arg) = args.next() {
        let (flag, value) = arg.split_once('=').map_or((&*arg, false), |(flag, _)| (flag, true));
        if without.contains(&flag) {
            if !value {
                args.next();
            }
        } else if !switches.contains(&flag) {
            kept.push(quoted(&arg));
        }
    }
    kept.join(" ")
}

/// Refuses, in the paper's world, what of a scenario it does not have.
pub(super) fn refuse_in_ideal_world(scenario: &Scenario, fidelity: Fidelity) -> Outcome<()> {
    match scenario.of_the_rigs_world() {
        Some(field) if fidelity == Fidelity::Ideal => Err(Failure::Input(format!(
            "{field} of scenario {} has no effect with --fidelity ideal: the paper's world has none; fly it \
             with --fidelity rig, or leave it out",
            scenario.name
        ))),
        _ => Ok(()),
    }
}

/// Of every command that searches.
#[derive(Debug, Args)]
pub(super) struct Checkpoint {
    /// Keep the state of the search in this file, so that it can be resumed
    #[arg(id = "checkpoint", long = "checkpoint", value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Go on from --checkpoint, or begin if it is not there yet
    #[arg(long, requires = "checkpoint", help_heading = "Computing")]
    pub resume: bool,
}

impl Checkpoint {
    /// Says that it is written, and refuses one that is there unless it is to be gone on from.
    pub(super) fn check(&self, outputs: &mut Outputs) -> Outcome<()> {
        let Some(path) = &self.file else { return Ok(()) };
        if !self.resume {
            checkpoint::check_fresh(path)?;
        }
        outputs.writes("--checkpoint", path)
    }

    /// `begun`, or with `--resume` what `resume` makes of it and of the file, if there is one yet.
    pub(super) fn resume_or<S>(
        &self,
        begun: S,
        resume: impl FnOnce(S, &[u8]) -> Result<S, Error>,
    ) -> Outcome<S> {
        match &self.file {
            Some(path) if self.resume && path.exists() => {
                Ok(resume(begun, &checkpoint::read(path)?).map_err(|e| e.within(path.display()))?)
            }
            _ => Ok(begun),
        }
    }
}

/// What says that gains are of another rig than `preset`.
pub(super) fn tuned_elsewhere(preset: &str, gains: &GainsFile) -> Option<String> {
    let tuned = &gains.provenance.as_ref()?.preset;
    (tuned != preset).then(|| format!("these gains were tuned on '{tuned}', not on '{preset}'"))
}

/// What says that a flag would not be heeded, and why.
pub(super) fn no_effect(flag: &str, when: &str, why: &str) -> Failure {
    Failure::Input(format!("{flag} has no effect {when}: {why}; leave it out"))
}

/// Requires a number of at least `least` and at most `most`.
pub(super) fn within(flag: &str, value: usize, least: usize, most: usize) -> Outcome<usize> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(Failure::Input(format!("{flag} is {value}; allowed: {least} to {most}")))
}

/// A bar on a terminal for `total` pieces of work, drawn as `template` says.
pub(super) fn bar(total: usize, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).expect("the template is well-formed");
    ProgressBar::new(total as u64).with_style(style)
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The budget is used up.
    Complete,
    /// The time limit came first.
    TimeLimit,
    /// It was interrupted.
    Interrupted,
    /// What flew has failed.
    Device,
}

/// Two numbers with a comma between them.
pub(super) fn pair(flag: &str, text: &str) -> Outcome<[f64; 2]> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let usable = |number: &f64| number.is_finite() && number.abs() <= LARGEST;
    match numbers.as_deref() {
        Some([first, second]) if usable(first) && usable(second) => Ok([*first, *second]),
        _ => Err(Failure::Input(format!(
            "{flag} is '{text}'; allowed: two finite numbers such as 1,25, each at most {LARGEST:e} in size"
        ))),
    }
}

/// Where a figure goes: to `plot`, or beside `out` as SVG.
pub(super) fn beside(plot: Option<&Path>, out: &Path, outputs: &mut Outputs) -> Outcome<PathBuf> {
    let path = plot.map_or_else(|| out.with_extension("svg"), Path::to_owned);
    let flag = if plot.is_some() { "--plot" } else { "--plot (beside --out, if it is left out)" };
    figure::check(flag, &path)?;
    outputs.writes(flag, &path)?;
    Ok(path)
}

/// Where a figure goes, if one is wanted.
pub(super) fn drawn(plot: Option<&Path>, outputs: &mut Outputs) -> Outcome<()> {
    let Some(path) = plot else { return Ok(()) };
    figure::check("--plot", path)?;
    outputs.writes("--plot", path)
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_command_is_told_without_where_its_outputs_go() {
        let typed =
            "compare --report=page --preset aero2 --controllers a.toml,pid --plot x.svg --json --tune 4";
        let args = typed.split(' ').chain(["--gains", "my gains"]).map(str::to_owned);
        assert_eq!(
            super::typed(args, &["--report", "--plot"], &["--json"]),
            "host-sim compare --preset aero2 --controllers a.toml,pid --tune 4 --gains 'my gains'"
        );
    }
}
