//! The watchdog's period, with a tick in every gap of the code that sets it.

use twinrotor::link::ToBoard;
use twinrotor::plant::presets;

use super::super::{board_with, firmware, paper_parameters};

/// `IWDG_PR` and `IWDG_RLR`, and what they say of 10 ms.
const PR: u64 = 0x4000_3004;
const RLR: u64 = 0x4000_3008;
const NORMAL: (u64, u64) = (0, 79);

#[test]
fn no_tick_at_any_instruction_leaves_another_period_than_the_ordinary() {
    let rig = presets::PAPER;
    let parameters = paper_parameters(&rig);
    let mut station = board_with(&rig, &parameters);
    station.run(100);
    let set = firmware().closure("firmware::watchdog::set");
    let read = |board: &mut virtual_board::machine::Live<'_>| (board.register(PR), board.register(RLR));
    assert_eq!(station.machine.with(read), NORMAL);
    let mut waits = 0;
    // The save's first setting, longer, and its second, ordinary again; a save that erases bears both too.
    for nth in [1, 2] {
        for &address in &set {
            let known = station.machine.with(move |board| {
                board.wait_there_for_a_tick(address, nth);
                board.waited().len()
            });
            let saved = station.heard.saved;
            station.send(&ToBoard::WriteParameters(twinrotor::link::Nonce::default(), parameters));
            assert!(station.run_until(2_000, |heard| heard.saved > saved), "at {address:#x}");
            let (found, waited) =
                station.machine.with(move |board| (read(board), board.waited().len() - known));
            assert_eq!(found, NORMAL, "a tick at {address:#x}, arrival {nth}");
            waits += waited;
        }
    }
    assert!(waits > 20, "{waits} instructions of the function were reached");
    assert_eq!(station.machine.resets(), [], "and none bit during an erase");
}
