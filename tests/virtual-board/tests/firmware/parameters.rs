//! Parameters in flash: read at boot, written over the link, kept.

use twinrotor::link::{Nonce, Refusal, ToBoard};
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets;
use twinrotor::supervisor::{ArmState, Condition};
use virtual_board::chip::flash::Operation;
use virtual_board::machine::Setup;
use virtual_board::station::Station;

use super::{ADDRESS, board_with, firmware, flying, image, paper_parameters, start};

/// A record that no other `nth` shares a value of its limits with.
pub(super) fn variant(nth: u16) -> Parameters {
    let mut record = paper_parameters(&presets::PAPER);
    let share = f32::from(nth) * 1e-4;
    record.limits.approach_rate = 0.3 + share;
    record.limits.rate.pitch = 9.0 + share;
    record.limits.command_timeout = 500 + u32::from(nth);
    record
}

/// What the board says its parameters are.
#[track_caller]
pub(super) fn read(station: &mut Station) -> Parameters {
    let known = station.heard.parameters.len();
    station.send(&ToBoard::ReadParameters);
    let answered = station.run_until(500, |heard| heard.parameters.len() > known);
    assert!(answered, "{}", station.heard.summary());
    station.heard.parameters[known]
}

/// Saves a record over the link.
#[track_caller]
pub(super) fn save(station: &mut Station, record: &Parameters) {
    let known = station.heard.saved;
    station.send(&ToBoard::WriteParameters(Nonce::default(), *record));
    let answered = station.run_until(2_000, |heard| heard.saved > known);
    assert!(answered, "{}", station.heard.summary());
}

#[test]
fn an_image_made_by_the_host_is_what_the_board_flies() {
    let records = [variant(1), variant(2), variant(3)];
    let mut station = start(Setup::new(firmware()).with_image(ADDRESS, image(&records)), &presets::PAPER);
    station.run(50);
    assert_eq!(read(&mut station), variant(3));
    assert_eq!(station.heard.conditions(), [Condition::NotZeroed]);
}

#[test]
fn damaged_parameters_are_named_and_the_board_flies_none_of_them() {
    let mut bytes = image(&[variant(1)]);
    bytes[40] ^= 1;
    let mut station = start(Setup::new(firmware()).with_image(ADDRESS, bytes), &presets::PAPER);
    station.run(100);
    let found = station.heard.conditions();
    let named = [Condition::ParametersMissing, Condition::ParametersInvalid];
    assert!(found.iter().any(|condition| named.contains(condition)), "{found:?}");
    assert_ne!(read(&mut station), variant(1));
}

#[test]
fn parameters_out_of_range_are_refused_by_name() {
    let mut station = board_with(&presets::PAPER, &variant(1));
    station.run(50);
    let mut wrong = variant(2);
    wrong.limits.pitch = -1.0;
    station.send(&ToBoard::WriteParameters(Nonce::default(), wrong));
    station.run(500);
    let named =
        matches!(&station.heard.refusals[..], [Refusal::Range { field, .. }] if field == "limits.pitch");
    assert!(named, "{:?}", station.heard.refusals);
    assert_eq!(read(&mut station), variant(1));
}

#[test]
fn parameters_are_not_written_while_the_motors_turn() {
    let mut station = flying();
    let written = station.machine.with(|board| board.flash().log.len());
    station.send(&ToBoard::WriteParameters(Nonce::default(), variant(9)));
    station.run(500);
    assert_eq!(station.heard.refusals, [Refusal::MotorsMayTurn]);
    assert_eq!(station.heard.state(), Some(ArmState::Armed));
    assert_eq!(station.machine.with(|board| board.flash().log.len()), written);
}

/// The core stands still while a sector is erased, and the tasks' clock loses that time: nothing that is told
/// or shown waits for it.
#[test]
fn health_and_led_go_on_after_a_sector_was_erased() {
    // As many records as fill the first page: the next one needs another.
    let full: Vec<Parameters> = (0..16).map(variant).collect();
    let mut station = start(Setup::new(firmware()).with_image(ADDRESS, image(&full)), &presets::PAPER);
    station.run(1_000);
    save(&mut station, &variant(99));
    let log = station.machine.with(|board| board.flash().log.clone());
    assert!(log.iter().any(|(_, operation)| matches!(operation, Operation::Erase { .. })));
    let (told, shown) = (station.heard.health.len(), station.machine.trace().0.len());
    station.run(5_000);
    assert!((4..=6).contains(&(station.heard.health.len() - told)), "once a second");
    let (trace, _) = station.machine.trace();
    let changes = trace[shown..].windows(2).filter(|pair| pair[0].lit != pair[1].lit).count();
    assert!((9..=11).contains(&changes), "one slow blink a second, {changes} changes in five");
}

/// Saves in a row, unless `TWINROTOR_SAVES` says otherwise: three times around the three pages, after which
/// the flash is as it was but for its contents.
const SAVES: u16 = 150;

#[test]
fn saves_in_a_row_hold_wear_every_page_alike_and_program_no_word_twice() {
    let saves = std::env::var("TWINROTOR_SAVES").map_or(SAVES, |n| n.parse().expect("a number"));
    let mut station = board_with(&presets::PAPER, &variant(0));
    station.run(50);
    for nth in 1..=saves {
        save(&mut station, &variant(nth));
    }
    assert_eq!(read(&mut station), variant(saves));
    assert_eq!(station.machine.resets(), [], "an erase is no missed tick");
    let log = station.machine.with(|board| board.flash().log.clone());
    let mut programmed = std::collections::HashSet::new();
    let mut erases = std::collections::HashMap::new();
    for (_, operation) in log {
        match operation {
            Operation::Erase { address, size } => {
                programmed.retain(|word| !(address..address + size).contains(word));
                *erases.entry(address).or_insert(0_u32) += 1;
            }
            Operation::Program { address, .. } => {
                assert!(programmed.insert(address), "{address:#x} was programmed twice");
                assert!((ADDRESS..ADDRESS + 0xC000).contains(&address), "{address:#x}");
            }
        }
    }
    let (least, most) = (erases.values().min().unwrap(), erases.values().max().unwrap());
    assert!(erases.len() == 3 && most - least <= 1, "{erases:?}");
    station.machine.with(|board| board.cut_power());
    station.run(50);
    assert_eq!(read(&mut station), variant(saves), "after a power cycle");
}
