//! The supply goes in the middle of a save: afterwards the old record or the new one is in force, whole, and
//! the next save holds. Every flash operation of a save that stays on its page and of one that turns to each
//! page, cut off at 0, 25, 50, 75 and 100 % of its duration; and two cuts in a row, sampled.

use embedded_storage::nor_flash::NorFlash;
use twinrotor::link::{Nonce, ToBoard};
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::{AREA_SIZE, PAGE_SIZE, RamFlash};
use twinrotor::parameters::store::{SLOT_SIZE, Store};
use twinrotor::plant::presets;
use virtual_board::chip::flash::{Cut, Operation};
use virtual_board::machine::Setup;
use virtual_board::station::Station;

use super::parameters::{read, save, variant};
use super::{ADDRESS, firmware, image, start};

const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const SLOTS: usize = PAGE_SIZE / SLOT_SIZE;

/// The record in force before the save that is cut off, and those written in it and after it.
const OLD: u16 = 5_000;
const NEW: u16 = 5_001;
const LATER: u16 = 5_002;
const NEXT: u16 = 5_003;

/// The parameter sectors after so many saves, the last of them `OLD`.
fn after_saves(saves: usize) -> Vec<u8> {
    let nth = |save: usize| if save + 1 == saves { OLD } else { u16::try_from(save).expect("few") };
    let records: Vec<Parameters> = (0..saves).map(|save| variant(nth(save))).collect();
    image(&records)
}

fn board(seed: u64) -> Station {
    let mut station = start(Setup::new(firmware()).with_seed(seed), &presets::PAPER);
    station.run(50);
    station
}

/// Puts `bytes` into the parameter sectors of a board that runs: it looks for the record in force at every
/// save.
fn put(station: &mut Station, bytes: &[u8]) {
    let bytes = bytes.to_vec();
    station.machine.with(move |board| board.replace_flash(ADDRESS, &bytes));
}

/// The parameter sectors.
fn sectors(station: &mut Station) -> Vec<u8> {
    station.machine.with(|board| board.flash().bytes(ADDRESS, AREA_SIZE).to_vec())
}

/// The record in force in the parameter sectors, as the host's copy of the storage code finds it.
fn in_force(bytes: &[u8]) -> Option<Parameters> {
    let mut flash = RamFlash::default();
    for (word, four) in (0_u32..).zip(bytes.chunks_exact(4)) {
        // Words that are erased may still be programmed later.
        if four != [0xFF; 4] {
            flash.write(4 * word, four).expect("erased before");
        }
    }
    let mut buffer = [0; SLOT_SIZE];
    let found = Store::new(flash, 0).load(&mut buffer).expect("a flash that never fails")?;
    Some(Parameters::decode(found).expect("its CRC held"))
}

/// Writes a record and lets the supply go meanwhile. Runs until the board has booted again.
fn save_in_vain(station: &mut Station, record: u16, cut: Cut) {
    let boots = station.heard.identities.len();
    station.machine.with(move |board| board.flash().plan(&[cut]));
    station.send(&ToBoard::WriteParameters(Nonce::default(), variant(record)));
    let rebooted = station.run_until(2_000, |heard| heard.identities.len() > boots);
    assert!(rebooted, "{cut:?}: {}", station.heard.summary());
    let all_cut = station.machine.with(|board| board.flash().all_cut());
    assert!(all_cut, "{cut:?} never came");
}

/// Saves with a cut in each: whatever happens, the record in force is the old one or the new one, the board
/// booted with it, and the next save holds.
fn survive(station: &mut Station, start: &[u8], cuts: &[Cut]) {
    put(station, start);
    let mut before = variant(OLD);
    for (&cut, record) in cuts.iter().zip([NEW, LATER]) {
        let saved = station.heard.saved;
        save_in_vain(station, record, cut);
        let force = in_force(&sectors(station));
        let new = force == Some(variant(record));
        assert!(new || force == Some(before), "after {cuts:?}: neither old nor new: {force:?}");
        assert!(new || station.heard.saved == saved, "after {cuts:?}: it said that it had saved");
        assert_eq!(Some(read(station)), force, "after {cuts:?}, what the board booted with");
        before = force.expect("old or new");
    }
    save(station, &variant(NEXT));
    assert_eq!(in_force(&sectors(station)), Some(variant(NEXT)), "after {cuts:?}, the next save");
}

/// How many flash operations the next save on `start` takes, and how many of them are erases.
fn operations(station: &mut Station, start: &[u8]) -> (u64, usize) {
    put(station, start);
    let before = station.machine.with(|board| board.flash().log.len());
    save(station, &variant(NEW));
    let log = station.machine.with(|board| board.flash().log.clone());
    let erases = log[before..].iter().filter(|(_, each)| matches!(each, Operation::Erase { .. })).count();
    ((log.len() - before) as u64, erases)
}

/// Cuts every operation of the save that follows on `saves` saves.
fn cut_everywhere(saves: usize, erases: usize) {
    let start = after_saves(saves);
    let mut station = board(7);
    let (count, erased) = operations(&mut station, &start);
    assert_eq!(erased, erases, "a save of another kind than meant");
    assert!(count > 10, "{count} operations");
    for operation in 1..=count {
        // The end of one operation is the beginning of the next.
        let shares = if operation == 1 { &SHARES[..] } else { &SHARES[1..] };
        for &share in shares {
            survive(&mut station, &start, &[Cut { operation, share }]);
        }
    }
}

#[test]
fn a_save_that_stays_on_its_page_survives_a_cut_anywhere() {
    cut_everywhere(3, 0);
}

#[test]
fn a_save_that_turns_to_the_second_page_survives_a_cut_anywhere() {
    cut_everywhere(SLOTS, 1);
}

#[test]
#[ignore = "long: as to the second page, 12 s of a processor"]
fn a_save_that_turns_to_the_third_page_survives_a_cut_anywhere() {
    cut_everywhere(2 * SLOTS, 1);
}

#[test]
#[ignore = "long: as to the second page, 12 s of a processor"]
fn a_save_that_turns_back_to_the_first_page_survives_a_cut_anywhere() {
    cut_everywhere(3 * SLOTS, 1);
}

#[test]
fn two_cuts_in_a_row_are_survived() {
    cut_twice([(3, 4), (SLOTS, 8), (SLOTS - 1, 4), (3 * SLOTS, 8)]);
}

#[test]
#[ignore = "long: as above with five times the cuts"]
fn many_times_two_cuts_in_a_row_are_survived() {
    cut_twice([(3, 20), (SLOTS, 40), (SLOTS - 1, 20), (3 * SLOTS, 40)]);
}

/// Cuts the save that follows on so many saves, and the next one, so many times.
fn cut_twice(cases: [(usize, usize); 4]) {
    let mut station = board(11);
    let mut random = 0x1234_5678_9ABC_DEF1_u64;
    let mut draw = |limit: u64| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        random % limit
    };
    for (saves, samples) in cases {
        let start = after_saves(saves);
        let (count, _) = operations(&mut station, &start);
        for sample in 0..samples {
            // Every other sample cuts the first operation, where the erase is.
            let first = if sample % 2 == 0 { 1 } else { 1 + draw(count) };
            let second = if sample % 4 < 2 { 1 } else { 1 + draw(count - 1) };
            let mut cut =
                |operation| Cut { operation, share: SHARES[usize::try_from(draw(5)).expect("few")] };
            let cuts = [cut(first), cut(second)];
            survive(&mut station, &start, &cuts);
        }
    }
}
