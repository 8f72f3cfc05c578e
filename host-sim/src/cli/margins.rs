//! `margins`: how far a rig may be from what its controller believes.

use super::common::{Common, PAPER};
use super::tables::{add, table};
use super::{print, print_json};
use crate::error::{Failure, Outcome};
use crate::files;
use serde::Serialize;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::linear::{Linear, Sampled};
use twinrotor_sim::margins::{FARTHEST, LONGEST_DELAY, Margins};
use twinrotor_sim::scenario::SAMPLE_TIME;

/// Flags of `margins`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: Common,
    /// Gains: 'paper' (Table 4) or a gains file [default: paper]
    #[arg(long, value_name = "paper|FILE")]
    gains: Option<String>,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    preset: &'a str,
    gains: &'a GainsFile,
    #[serde(flatten)]
    margins: Margins,
    plant: Plant,
}

/// The rig near its level pose, as matrices.
#[derive(Debug, Serialize)]
struct Plant {
    #[serde(flatten)]
    linear: Linear,
    sampled: Sampled,
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let gains_name = args.gains.as_deref().unwrap_or(PAPER);
    let gains = files::gains("--gains", gains_name)?;
    let margins = Margins::of(&named.rig, &gains.settings(&named.rig));
    let told = format!("{}, {gains_name} gains", named.name);
    if args.common.json {
        let linear = Linear::of(&named.rig.plant, 0.0);
        let plant = Plant { sampled: linear.sampled(SAMPLE_TIME), linear };
        print_json(&Document { preset: &named.name, gains: &gains, margins, plant })?;
    } else if margins.stable {
        print(&format!("{told}\n{}{}", args.common.unsaid(Some(&args.gains)), edges(&margins)))?;
    } else {
        let grows = -margins.slowest_pole;
        print(&format!(
            "{told}: unstable; a small error grows by {grows:.2} /s, and there are no margins\n{}",
            args.common.unsaid(Some(&args.gains))
        ))?;
    }
    if margins.stable {
        return Ok(());
    }
    Err(Failure::Flight(format!("{told}: the sampled loop is unstable on the rig as it is believed to be")))
}

fn edges(margins: &Margins) -> String {
    let mut rows = table(&["stable from .. to", "least", "most"]);
    let [least, most] = FARTHEST;
    for (what, [low, high]) in
        [("thrust of both motors", margins.thrust), ("rotor lag", margins.lag), ("inertia", margins.inertia)]
    {
        let low = low.map_or_else(|| format!("below x{least}"), |x| format!("x{x:.2}"));
        let high = high.map_or_else(|| format!("over x{most}"), |x| format!("x{x:.2}"));
        add(&mut rows, [what.to_owned(), low, high]);
    }
    let delay = margins.delay_ms.map_or_else(|| format!("over {LONGEST_DELAY} ms"), |ms| format!("{ms} ms"));
    add(&mut rows, ["added delay".to_owned(), "0 ms".to_owned(), delay]);
    format!("{rows}\nstable; slowest pole of the sampled loop: {:.2} /s\n", margins.slowest_pole)
}
