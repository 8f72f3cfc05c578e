//! `margins`: how far a rig may be from what its controller believes.

use super::common::{Common, PAPER};
use super::tables::{add, table};
use super::{print, print_json};
use crate::error::Outcome;
use crate::files;
use serde::Serialize;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::margins::{FARTHEST, LONGEST_DELAY, Margins};

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
}

pub(super) fn run(args: &Args) -> Outcome<()> {
    let named = args.common.resolve()?;
    let gains_name = args.gains.as_deref().unwrap_or(PAPER);
    let gains = files::gains("--gains", gains_name)?;
    let margins = Margins::of(&named.rig, &gains.settings(&named.rig));
    if args.common.json {
        return print_json(&Document { preset: &named.name, gains: &gains, margins });
    }
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
    let pole = margins.slowest_pole;
    print(&format!(
        "{}, {gains_name} gains\n{}{rows}\nslowest pole of the sampled loop: {pole:.2} /s\n",
        named.name,
        args.common.unsaid(Some(&args.gains))
    ))
}
