//! The pins that are read and written by themselves, not by a peripheral.

#[cfg(feature = "simulated")]
use crate::boards::Button;
use crate::boards::{BOARD, Pin};
use embassy_stm32::pac;
use embassy_stm32::pac::gpio::vals::Idr;
#[cfg(feature = "simulated")]
use embassy_stm32::pac::gpio::vals::Pupdr;

/// The emergency stop.
#[cfg(not(feature = "simulated"))]
pub(crate) const EMERGENCY_STOP: Pin = Pin::named(BOARD.wiring.emergency_stop);
#[cfg(not(feature = "simulated"))]
const CURRENT_LIMIT: Pin = Pin::named(BOARD.wiring.current_limit);
#[cfg(not(feature = "simulated"))]
const ENABLE: Pin = Pin::named(BOARD.wiring.enable);

/// The registers of a pin's port.
const fn port(pin: Pin) -> pac::gpio::Gpio {
    match pin.port {
        0 => pac::GPIOA,
        1 => pac::GPIOB,
        2 => pac::GPIOC,
        3 => pac::GPIOD,
        _ => panic!("a port that not all chips have"),
    }
}

#[inline(always)]
fn level(pin: Pin) -> Idr {
    port(pin).idr().read().idr(usize::from(pin.number))
}

/// The amplifiers' enable pin: on or off.
#[cfg(not(feature = "simulated"))]
#[inline(always)]
pub(crate) fn enable_amplifiers(on: bool) {
    let number = usize::from(ENABLE.number);
    port(ENABLE).bsrr().write(|w| if on { w.set_bs(number, true) } else { w.set_br(number, true) });
}

/// Is the emergency stop pressed, or its cable broken?
#[cfg(not(feature = "simulated"))]
#[inline(always)]
pub(crate) fn emergency_stop() -> bool {
    level(EMERGENCY_STOP) == Idr::HIGH
}

/// Do the amplifiers limit the current, or are they at fault?
#[cfg(not(feature = "simulated"))]
#[inline(always)]
pub(crate) fn current_limit() -> bool {
    level(CURRENT_LIMIT) == Idr::LOW
}

/// The board's button: its pin, an input from reset on, and the level that says that it is pressed.
#[cfg(feature = "simulated")]
const BUTTON: Option<(Pin, Idr)> = match BOARD.button {
    Some(Button { pin, pressed_high: true }) => Some((Pin::named(pin), Idr::HIGH)),
    Some(Button { pin, pressed_high: false }) => Some((Pin::named(pin), Idr::LOW)),
    None => None,
};

/// Not every board has a resistor that holds its button's pin at the level of one that is not pressed: the
/// one inside does.
#[cfg(feature = "simulated")]
pub(crate) fn hold_button() {
    if let Some((pin, pressed)) = BUTTON {
        let pull = if pressed == Idr::HIGH { Pupdr::PULL_DOWN } else { Pupdr::PULL_UP };
        port(pin).pupdr().modify(|w| w.set_pupdr(usize::from(pin.number), pull));
    }
}

/// Is the board's button pressed?
#[cfg(feature = "simulated")]
pub(crate) fn button() -> bool {
    BUTTON.is_some_and(|(pin, pressed)| level(pin) == pressed)
}
