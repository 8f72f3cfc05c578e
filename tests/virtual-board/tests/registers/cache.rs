//! The caches before the flash: RM0090 3.5.2 and 3.9.1.

use rigless::soc::Width;
use rigless::soc::stm32f427::generated::flash::Register as R;
use virtual_board::chip::flash::{BASE, Flash};

use super::Alone;

const PRFTEN: u64 = 1 << 8;
const ICEN: u64 = 1 << 9;
const DCEN: u64 = 1 << 10;
const ICRST: u64 = 1 << 11;
const DCRST: u64 = 1 << 12;
const NONE: [bool; 2] = [false; 2];

fn flash() -> Alone<Flash> {
    let mut flash = Alone::new("FLASH", Flash::new(7));
    flash.write(R::Keyr, 0x4567_0123);
    flash.write(R::Keyr, 0xCDEF_89AB);
    flash
}

fn program(flash: &mut Alone<Flash>) {
    flash.write(R::Cr, 2 << 8 | 1);
    flash.store(BASE + 0x4000, Width::W32, 0);
    flash.pass(16_000);
}

fn stale(flash: &mut Alone<Flash>) -> [bool; 2] {
    flash.model().serves_stale_lines()
}

#[test]
fn the_access_control_register_reads_back_its_enables_but_not_icrst() {
    let mut flash = flash();
    flash.write(R::Acr, 5 | PRFTEN | ICEN | DCEN);
    assert_eq!(flash.read(R::Acr), 5 | PRFTEN | ICEN | DCEN);
    flash.write(R::Acr, 5 | ICRST | DCRST);
    assert_eq!(flash.read(R::Acr), 5 | DCRST);
}

#[test]
fn a_cache_that_was_on_while_the_array_changed_is_stale_until_reset_while_off() {
    let mut flash = flash();
    flash.write(R::Acr, ICEN | DCEN);
    assert_eq!(stale(&mut flash), NONE);
    program(&mut flash);
    assert_eq!(stale(&mut flash), [true; 2]);
    flash.write(R::Acr, ICEN | DCEN | ICRST | DCRST);
    assert_eq!(stale(&mut flash), [true; 2], "a reset while on does nothing");
    flash.write(R::Acr, 0);
    assert_eq!(stale(&mut flash), NONE, "off it serves nothing");
    flash.write(R::Acr, ICEN | DCEN);
    assert_eq!(stale(&mut flash), [true; 2], "but keeps what it had");
    flash.write(R::Acr, 0);
    flash.write(R::Acr, DCRST);
    flash.write(R::Acr, ICEN | DCEN);
    assert_eq!(stale(&mut flash), [true, false]);
}

#[test]
fn switching_off_alone_does_not_save_a_cache_that_was_filled() {
    let mut flash = flash();
    flash.write(R::Acr, DCEN);
    flash.write(R::Acr, 0);
    program(&mut flash);
    flash.write(R::Acr, DCEN);
    assert_eq!(stale(&mut flash), [false, true]);
}

#[test]
fn caches_that_were_never_on_have_nothing_to_lose() {
    let mut flash = flash();
    program(&mut flash);
    flash.write(R::Acr, ICEN | DCEN);
    assert_eq!(stale(&mut flash), NONE);
}
