//! The flash interface: RM0090 3.6 and 3.9, and what a supply that goes leaves behind.

use rigless::soc::Width;
use rigless::soc::stm32f427::generated::flash::Register as R;
use virtual_board::chip::flash::{BASE, Cut, Flash, Operation, sector};

use super::Alone;

const LOCK: u64 = 1 << 31;
const STRT: u64 = 1 << 16;
const BSY: u64 = 1 << 16;
const PSIZE_X32: u64 = 2 << 8;
const PG: u64 = 1;
const SER: u64 = 2;
const PARAMETERS: u64 = BASE + 0x4000;

fn flash() -> Alone<Flash> {
    Alone::new("FLASH", Flash::new(7))
}

fn unlocked() -> Alone<Flash> {
    let mut flash = flash();
    flash.write(R::Keyr, 0x4567_0123);
    flash.write(R::Keyr, 0xCDEF_89AB);
    assert_eq!(flash.read(R::Cr) & LOCK, 0);
    flash
}

fn word(flash: &mut Alone<Flash>, address: u64) -> u32 {
    let bytes = flash.model().bytes(address, 4);
    u32::from_le_bytes(bytes.try_into().unwrap())
}

fn program(flash: &mut Alone<Flash>, address: u64, value: u64) {
    flash.write(R::Cr, PSIZE_X32 | PG);
    flash.store(address, Width::W32, value);
    flash.pass(16_000);
}

#[test]
fn the_control_register_is_locked_until_both_keys_and_for_good_after_a_wrong_one() {
    let mut flash = flash();
    flash.write(R::Cr, PG);
    assert_eq!(flash.read(R::Cr), LOCK);
    flash.write(R::Keyr, 0x4567_0123);
    flash.write(R::Keyr, 1);
    flash.write(R::Keyr, 0x4567_0123);
    flash.write(R::Keyr, 0xCDEF_89AB);
    assert_eq!(flash.read(R::Cr), LOCK);
}

#[test]
fn locking_again_locks() {
    let mut flash = unlocked();
    flash.write(R::Cr, LOCK);
    flash.write(R::Cr, PG);
    assert_eq!(flash.read(R::Cr), LOCK);
}

#[test]
fn programming_takes_its_time_and_clears_bits_only() {
    let mut flash = unlocked();
    flash.write(R::Cr, PSIZE_X32 | PG);
    flash.store(PARAMETERS, Width::W32, 0x00FF_00FF);
    assert_ne!(flash.read(R::Sr) & BSY, 0);
    assert!(flash.model().busy());
    flash.pass(15_999);
    assert_eq!(word(&mut flash, PARAMETERS), 0xFFFF_FFFF);
    flash.pass(1);
    assert_eq!(flash.read(R::Sr) & BSY, 0);
    assert_eq!(word(&mut flash, PARAMETERS), 0x00FF_00FF);
    program(&mut flash, PARAMETERS, 0xFFFF_000F);
    assert_eq!(word(&mut flash, PARAMETERS), 0x00FF_000F);
}

#[test]
fn a_store_without_pg_is_a_sequence_error_and_of_another_size_a_parallelism_error() {
    let mut flash = unlocked();
    flash.store(PARAMETERS, Width::W32, 0);
    assert_eq!(flash.read(R::Sr), 1 << 7);
    flash.write(R::Sr, 1 << 7);
    assert_eq!(flash.read(R::Sr), 0);
    flash.write(R::Cr, PSIZE_X32 | PG);
    flash.store(PARAMETERS, Width::W16, 0);
    assert_eq!(flash.read(R::Sr), 1 << 6);
    assert_eq!(word(&mut flash, PARAMETERS), 0xFFFF_FFFF);
}

#[test]
fn an_erase_sets_its_sector_to_ones_after_a_quarter_of_a_second_and_no_other() {
    let mut flash = unlocked();
    let last = PARAMETERS + 0x4000 - 4;
    for address in [PARAMETERS - 4, PARAMETERS, last, last + 4] {
        program(&mut flash, address, 0);
    }
    flash.write(R::Cr, PSIZE_X32 | SER | 1 << 3 | STRT);
    flash.pass(249_999_999);
    assert_ne!(flash.read(R::Sr) & BSY, 0);
    assert_eq!(word(&mut flash, last), 0);
    flash.pass(1);
    assert_eq!(flash.read(R::Sr) & BSY, 0);
    let words = [PARAMETERS - 4, PARAMETERS, last, last + 4].map(|at| word(&mut flash, at));
    assert_eq!(words, [0, 0xFFFF_FFFF, 0xFFFF_FFFF, 0]);
    assert_eq!(flash.read(R::Cr) & STRT, 0);
}

#[test]
fn the_sectors_are_those_of_table_5() {
    let sizes: Vec<u64> = (0..12).map(|nth| sector(nth).unwrap().1 >> 10).collect();
    assert_eq!(sizes, [16, 16, 16, 16, 64, 128, 128, 128, 128, 128, 128, 128]);
    for nth in 1..12 {
        let (before, size) = sector(nth - 1).unwrap();
        assert_eq!(sector(nth).unwrap().0, before + size);
    }
    assert_eq!(sector(12), None);
    let mut flash = unlocked();
    flash.write(R::Cr, PSIZE_X32 | SER | 12 << 3 | STRT);
    assert_eq!(flash.read(R::Sr), 1 << 4, "WRPERR");
}

#[test]
fn the_end_of_an_operation_is_flagged_only_when_asked_for() {
    let mut flash = unlocked();
    program(&mut flash, PARAMETERS, 0);
    assert_eq!(flash.read(R::Sr) & 1, 0);
    flash.write(R::Cr, PSIZE_X32 | PG | 1 << 24);
    flash.store(PARAMETERS + 4, Width::W32, 0);
    flash.pass(16_000);
    assert_eq!(flash.read(R::Sr) & 1, 1);
}

#[test]
fn what_is_not_modelled_is_told() {
    let mut flash = unlocked();
    flash.write(R::Cr, 4);
    assert_eq!(flash.told(), ["mass erase is not modelled"]);
    flash.write(R::Optkeyr, 1);
    assert_eq!(flash.told().len(), 2);
}

/// The share of the bits a cut-off operation leaves changed, and whether the supply went.
fn cut_program(share: f64, seed: u64) -> (u32, bool) {
    let mut flash = Alone::new("FLASH", Flash::new(seed));
    flash.write(R::Keyr, 0x4567_0123);
    flash.write(R::Keyr, 0xCDEF_89AB);
    flash.model().plan(&[Cut { operation: 2, share }]);
    program(&mut flash, PARAMETERS, 0x1234_5678);
    assert_eq!(word(&mut flash, PARAMETERS), 0x1234_5678);
    program(&mut flash, PARAMETERS + 4, 0);
    (word(&mut flash, PARAMETERS + 4).count_zeros(), flash.model().all_cut())
}

#[test]
fn a_cut_in_a_word_leaves_about_the_share_of_its_bits_written() {
    assert_eq!(cut_program(0.0, 3), (0, true));
    assert_eq!(cut_program(1.0, 3), (32, true));
    let halves: u32 = (0..100).map(|seed| cut_program(0.5, 2 * seed + 1).0).sum();
    assert!((1400..1800).contains(&halves), "{halves} of 3200 bits");
}

#[test]
fn a_cut_in_an_erase_leaves_about_the_share_of_its_bits_set_and_nothing_before_or_after() {
    for (share, low, high) in [(0.0, 0, 0), (0.25, 30_000, 35_536), (1.0, 131_072, 131_072)] {
        let mut flash = unlocked();
        let (address, size) = sector(2).unwrap();
        flash.model().place(address - 4, &vec![0; 0x4008]);
        flash.model().plan(&[Cut { operation: 1, share }]);
        flash.write(R::Cr, PSIZE_X32 | SER | 2 << 3 | STRT);
        flash.pass(250_000_000);
        let bytes = flash.model().bytes(address, usize::try_from(size).unwrap());
        let ones: u32 = bytes.iter().map(|byte| byte.count_ones()).sum();
        assert!((low..=high).contains(&ones), "{ones} of 131072 bits at {share}");
        assert_eq!(word(&mut flash, address - 4), 0);
        assert_eq!(word(&mut flash, address + size), 0);
    }
}

#[test]
fn every_operation_is_written_down() {
    let mut flash = unlocked();
    program(&mut flash, PARAMETERS, 5);
    flash.write(R::Cr, PSIZE_X32 | SER | 3 << 3 | STRT);
    let operations: Vec<Operation> = flash.model().log.iter().map(|each| each.1).collect();
    let (address, size) = sector(3).unwrap();
    let word = Operation::Program { address: PARAMETERS, width: Width::W32, value: 5 };
    assert_eq!(operations, [word, Operation::Erase { address, size }]);
}
