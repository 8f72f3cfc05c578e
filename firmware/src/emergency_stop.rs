//! The emergency stop's edge: motors off at once. The timer's break input has cut the PWM by then.

use crate::boards::STOP_EDGE;
use crate::pins::EMERGENCY_STOP;
use crate::port::{PlantPort, Port};
use crate::shared::Flag;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac;

const LINE: usize = EMERGENCY_STOP.number as usize;

/// Listens to the rising edge.
pub(crate) fn listen() {
    pac::SYSCFG.exticr(LINE / 4).modify(|w| w.set_exti(LINE % 4, EMERGENCY_STOP.port));
    pac::EXTI.rtsr(0).modify(|w| w.set_line(LINE, true));
    pac::EXTI.imr(0).modify(|w| w.set_line(LINE, true));
    let edge = STOP_EDGE;
    edge.set_priority(Priority::P0);
    #[expect(unsafe_code, reason = "an interrupt is enabled")]
    // SAFETY: its handler uses registers and an atomic only.
    unsafe {
        edge.enable();
    }
}

/// For the interrupt of the pin's line.
#[inline(always)]
pub(crate) fn edge() {
    Port::off();
    Flag::StopEdge.raise();
    pac::EXTI.pr(0).write(|w| w.set_line(LINE, true));
}
