//! The external interrupts: RM0090 chapter 12 and 9.2.3.

use rigless::device::{Device, Level, RequestChange};
use rigless::soc::stm32f427::generated::exti::Register as R;
use virtual_board::chip::exti::{Exti, VOLTAGE_DETECTOR};

use super::Alone;

fn exti() -> Alone<Exti> {
    Alone::new("EXTI", Exti::default())
}

fn request(exti: &mut Alone<Exti>, instance: &'static str, request: usize, high: bool) {
    let change = RequestChange { instance, request, level: Level::from(high) };
    exti.drive(|exti, registers, context| exti.on_request(change, registers, context));
}

/// Chooses port B for line 12, as `SYSCFG_EXTICR4` does.
fn choose_b12(exti: &mut Alone<Exti>) {
    for (bit, high) in [true, false, false, false].into_iter().enumerate() {
        request(exti, "SYSCFG", 4 * 12 + bit, high);
    }
}

#[test]
fn a_rising_edge_on_the_chosen_port_interrupts_until_cleared() {
    let mut exti = exti();
    choose_b12(&mut exti);
    exti.write(R::Imr, 1 << 12);
    exti.write(R::Rtsr, 1 << 12);
    request(&mut exti, "GPIOA", 12, true);
    request(&mut exti, "GPIOB", 11, true);
    assert_eq!(exti.raised(), []);
    request(&mut exti, "GPIOB", 12, true);
    assert_eq!(exti.raised(), [(40, true)], "EXTI15_10");
    assert_eq!(exti.read(R::Pr), 1 << 12);
    exti.write(R::Pr, 1 << 12);
    assert_eq!(exti.raised(), [(40, false)]);
    request(&mut exti, "GPIOB", 12, false);
    assert_eq!(exti.read(R::Pr), 0, "the falling edge was not asked for");
}

#[test]
fn a_masked_line_becomes_pending_and_interrupts_once_unmasked() {
    let mut exti = exti();
    exti.write(R::Ftsr, 1 << 3);
    request(&mut exti, "GPIOA", 3, true);
    request(&mut exti, "GPIOA", 3, false);
    assert_eq!((exti.read(R::Pr), exti.raised()), (1 << 3, vec![]));
    exti.write(R::Imr, 1 << 3);
    assert_eq!(exti.raised(), [(9, true)], "EXTI3");
}

#[test]
fn lines_five_to_nine_share_an_interrupt() {
    let mut exti = exti();
    exti.write(R::Imr, 0x3E0);
    exti.write(R::Rtsr, 0x3E0);
    request(&mut exti, "GPIOA", 5, true);
    request(&mut exti, "GPIOA", 9, true);
    assert_eq!(exti.raised(), [(23, true)]);
    exti.write(R::Pr, 1 << 5);
    assert_eq!(exti.raised(), [], "line 9 still asks");
    exti.write(R::Pr, 1 << 9);
    assert_eq!(exti.raised(), [(23, false)]);
}

#[test]
fn software_can_ask_and_clearing_takes_it_back() {
    let mut exti = exti();
    exti.write(R::Imr, 1);
    exti.write(R::Swier, 1);
    assert_eq!((exti.read(R::Pr), exti.raised()), (1, vec![(6, true)]));
    exti.write(R::Pr, 1);
    assert_eq!((exti.read(R::Pr), exti.read(R::Swier)), (0, 0));
}

#[test]
fn the_voltage_detector_has_line_16() {
    let mut exti = exti();
    exti.write(R::Imr, 1 << 16);
    exti.write(R::Rtsr, 1 << 16);
    exti.drive(|exti, registers, context| exti.set_line(VOLTAGE_DETECTOR, true, registers, context));
    assert_eq!(exti.raised(), [(1, true)], "PVD");
}

#[test]
fn what_is_not_modelled_is_told() {
    let mut exti = exti();
    exti.write(R::Emr, 1);
    exti.write(R::Imr, 1 << 22);
    assert_eq!(exti.told().len(), 2);
}
