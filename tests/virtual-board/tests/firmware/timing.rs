//! The tick's rate, its instructions and the stack, compared with the figures kept for each compiler.

use virtual_board::figures::Figures;
use virtual_board::machine::MILLISECOND;

use super::{firmware, flying};

#[test]
fn the_tick_comes_every_millisecond_to_the_instruction() {
    let mut station = flying();
    station.run(2_000);
    let (_, ticks) = station.machine.trace();
    let late: Vec<u64> =
        ticks.windows(2).map(|pair| (pair[1].at.0 - pair[0].at.0).abs_diff(MILLISECOND)).collect();
    let worst = late.iter().max().copied().expect("ticks");
    // 168 instructions: what the thread holds interrupts off for, and no more.
    assert!(worst <= 1_000, "a tick came {worst} ns off its time");
}

#[test]
fn size_instructions_and_stack_are_within_the_budget_and_have_not_grown() {
    let measured = Figures::measure(&firmware(), &mut flying());
    println!("{measured}");
    measured.within_budget().unwrap_or_else(|why| panic!("{why}"));
    measured.compare(&firmware()).unwrap_or_else(|why| panic!("{why}"));
}
