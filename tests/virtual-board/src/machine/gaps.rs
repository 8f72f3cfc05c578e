//! What a firmware reached that the board has no answer to.

use rigless::session::Session;
use rigless::soc::Fault;

use super::Failure;
use crate::board::Board;
use crate::firmware::Firmware;

/// The first gap in what the board models that the run has met, if any.
pub(super) fn first(
    session: &Session<Board>,
    firmware: &Firmware,
    refusals_allowed: bool,
) -> Option<Failure> {
    let at = |counter: u64| firmware.locate(counter);
    if let Some(gap) = session.unmapped().first() {
        return Some(Failure(format!(
            "{} reached {:#010x}, where the board has nothing",
            at(gap.program_counter),
            gap.address
        )));
    }
    if let Some(gap) = session.unimplemented().values().next() {
        return Some(Failure(format!(
            "{} reached {}.{}, which the board does not model ({} reads, {} writes)",
            at(gap.program_counter),
            gap.instance,
            gap.register,
            gap.reads,
            gap.writes
        )));
    }
    let allowed =
        |fault: &Fault| refusals_allowed && matches!(fault, Fault::BusError { .. } | Fault::Gated { .. });
    let refused = session.refused().iter().find(|(_, fault)| !allowed(fault));
    if let Some((address, fault)) = refused {
        return Some(Failure(format!("an access to {address:#010x} was refused: {fault}")));
    }
    if let Some((instance, line)) = session.unrouted().iter().next() {
        return Some(Failure(format!("{instance} raised interrupt {line}, which the core has not")));
    }
    let told = session.told().next();
    told.map(|told| Failure(format!("{}.{}: {}", told.instance, told.register, told.reason)))
}
