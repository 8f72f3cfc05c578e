//! The emergency stop's edge: motors off at once. The timer's break input has cut the PWM by then.

use crate::pins::EMERGENCY_STOP;
use crate::port::{PlantPort, Port};
use crate::shared::Flag;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::{interrupt, pac};

const LINE: usize = EMERGENCY_STOP.number as usize;
const _: () = assert!(LINE >= 10, "the interrupt below is that of lines 10 to 15");

/// Listens to the rising edge.
pub(crate) fn listen() {
    pac::SYSCFG.exticr(LINE / 4).modify(|w| w.set_exti(LINE % 4, EMERGENCY_STOP.port));
    pac::EXTI.rtsr(0).modify(|w| w.set_line(LINE, true));
    pac::EXTI.imr(0).modify(|w| w.set_line(LINE, true));
    let edge = interrupt::EXTI15_10;
    edge.set_priority(Priority::P0);
    #[expect(unsafe_code, reason = "an interrupt is enabled")]
    // SAFETY: its handler uses registers and an atomic only.
    unsafe {
        edge.enable();
    }
}

#[interrupt]
fn EXTI15_10() {
    Port::off();
    Flag::StopEdge.raise();
    pac::EXTI.pr(0).write(|w| w.set_line(LINE, true));
}
