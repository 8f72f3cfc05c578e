//! What an owner of a board sends back: which board it is, what its tick costs, and whether it flew as the
//! host does.

use super::desk::Desk;
use super::task::Task;
use crate::error::{Failure, Outcome};
use serde::Serialize;
use twinrotor::link::{self, ChipSerial};
use twinrotor::rig_port::RigPort;
use twinrotor_sim::Outcome as Verified;
use twinrotor_station::session::End;

/// One document.
#[derive(Debug, Serialize)]
struct Document<'a> {
    host: &'static str,
    firmware: &'a str,
    link: u8,
    chip: &'a str,
    /// Which one of these, if it is a chip.
    serial: Option<String>,
    port: RigPort,
    preset: &'a str,
    gains: &'a str,
    scenarios: Vec<&'a str>,
    notes: &'a [String],
    ended: String,
    /// Ticks in the air that were the host's, bit for bit.
    equal_ticks: Option<usize>,
    /// The first tick and field that were not.
    differs: Option<String>,
    /// \[cycles\] The longest tick since the board's boot.
    tick_cycles_max: Option<u32>,
    stack_used: Option<u32>,
    stack_size: Option<u32>,
    frames: usize,
    frames_dropped: Option<u32>,
}

/// As JSON.
pub(super) fn report(
    task: &Task,
    desk: &Desk,
    end: &End,
    verified: Option<&Verified<usize>>,
) -> Outcome<Vec<u8>> {
    let unknown = || Failure::Run("the board did not say who it is: there is nothing to report".to_owned());
    let identity = desk.session.identity().ok_or_else(unknown)?;
    let health = desk.flown.health;
    let document = Document {
        host: env!("CARGO_PKG_VERSION"),
        firmware: &identity.firmware,
        link: link::VERSION,
        chip: &identity.chip,
        serial: (identity.serial != ChipSerial::default()).then(|| identity.serial.to_string()),
        port: identity.port,
        preset: &task.named.name,
        gains: &task.gains_name,
        scenarios: std::iter::once(&task.scenario).chain(&task.others).map(|s| s.name.as_str()).collect(),
        notes: &task.notes,
        ended: super::why(end).unwrap_or_else(|| "flown".to_owned()),
        equal_ticks: verified.and_then(|verified| verified.as_ref().ok()).copied(),
        differs: verified.and_then(|verified| verified.as_ref().err()).map(ToString::to_string),
        tick_cycles_max: health.map(|health| health.tick_cycles_max),
        stack_used: health.map(|health| health.stack_used),
        stack_size: health.map(|health| health.stack_size),
        frames: desk.flown.frames.len(),
        frames_dropped: health.map(|health| health.frames_dropped),
    };
    let mut text = serde_json::to_string_pretty(&document).map_err(|why| Failure::Run(why.to_string()))?;
    text.push('\n');
    Ok(text.into_bytes())
}
