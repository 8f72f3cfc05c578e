//! The supply goes in the middle of a save: afterwards the old record or the new one is in force, whole, and the next save
//! holds. Every flash operation of a save that stays on its page and of one that turns to each page, cut off at 0, 25, 50,
//! 75 and 100 % of its duration; and two cuts in a row, sampled.

use twinrotor::link::ToBoard;
use twinrotor::parameters::Parameters;
use twinrotor::parameters::ram_flash::{AREA_SIZE, PAGE_SIZE};
use twinrotor::parameters::store::SLOT_SIZE;
use twinrotor::plant::presets;
use virtual_board::chip::flash::{Cut, Operation};
use virtual_board::machine::Setup;
use virtual_board::station::Station;

use super::parameters::{read, save, variant};
use super::{PARAMETERS, firmware, image, start};

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

/// Boots the board with `bytes` in its parameter sectors.
fn boot_with(station: &mut Station, bytes: &[u8]) {
    let bytes = bytes.to_vec();
    station.machine.with(move |board| {
        board.replace_flash(PARAMETERS, &bytes);
        board.cut_power();
    });
    station.run(30);
}

fn plan(station: &mut Station, cuts: &[Cut]) {
    let cuts = cuts.to_vec();
    station.machine.with(move |board| board.board().chip().flash().plan(&cuts));
}

/// Writes a record with a cut under way: it may be answered or not. Runs until the board has booted again.
fn save_in_vain(station: &mut Station, record: u16) {
    let boots = station.heard.identities.len();
    station.send(&ToBoard::WriteParameters(variant(record)));
    let rebooted = station.run_until(2_000, |heard| heard.identities.len() > boots);
    assert!(rebooted, "{}", station.heard.summary());
    station.run(10);
}

/// One save with these cuts; whatever happens, the record in force is one of those allowed and the next save holds.
fn survive(station: &mut Station, start: &[u8], cuts: &[Cut]) {
    boot_with(station, start);
    let mut allowed = vec![variant(OLD)];
    let saved = station.heard.saved;
    for (&cut, record) in cuts.iter().zip([NEW, LATER]) {
        plan(station, &[cut]);
        save_in_vain(station, record);
        let all_cut = station.machine.with(|board| board.board().chip().flash().all_cut());
        assert!(all_cut, "{cut:?} never came");
        let force = read(station);
        allowed.push(variant(record));
        assert!(allowed.contains(&force), "after {cuts:?}: a record that was never written: {force:?}");
        if station.heard.saved > saved {
            assert_eq!(force, variant(record), "after {cuts:?}: it said that it had saved");
        }
        allowed = vec![force];
    }
    save(station, &variant(NEXT));
    station.machine.with(|board| board.cut_power());
    station.run(30);
    assert_eq!(read(station), variant(NEXT), "after {cuts:?}, the next save");
}

/// How many flash operations the next save on `start` takes, and whether it erases.
fn operations(station: &mut Station, start: &[u8]) -> (u64, usize) {
    boot_with(station, start);
    let before = station.machine.with(|board| board.board().chip().flash().log.len());
    save(station, &variant(NEW));
    let log = station.machine.with(|board| board.board().chip().flash().log.clone());
    let erases = log[before..].iter().filter(|(_, each)| matches!(each, Operation::Erase { .. })).count();
    ((log.len() - before) as u64, erases)
}

/// Cuts every operation of the save that follows on `saves` saves.
fn cut_everywhere(saves: usize, erases: usize) {
    let start = after_saves(saves);
    assert_eq!(start.len(), AREA_SIZE);
    let mut station = board(7);
    let (count, erased) = operations(&mut station, &start);
    assert_eq!(erased, erases, "a save of another kind than meant");
    assert!(count > 10, "{count} operations");
    for operation in 1..=count {
        for share in SHARES {
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
fn a_save_that_turns_to_the_third_page_survives_a_cut_anywhere() {
    cut_everywhere(2 * SLOTS, 1);
}

#[test]
fn a_save_that_turns_back_to_the_first_page_survives_a_cut_anywhere() {
    cut_everywhere(3 * SLOTS, 1);
}

#[test]
fn two_cuts_in_a_row_are_survived() {
    let mut station = board(11);
    let mut random = 0x1234_5678_9ABC_DEF1_u64;
    let mut draw = |limit: u64| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        random % limit
    };
    for (saves, samples) in [(3, 20), (SLOTS, 40), (SLOTS - 1, 20), (3 * SLOTS, 40)] {
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
