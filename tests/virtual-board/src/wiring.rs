//! What is soldered to which pin: the same table as the firmware's board file, seen from outside.

use crate::chip::timer::Side;

/// A pin and the alternate function that connects it to what it is wired for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wire {
    /// 0 is port A.
    pub port: usize,
    /// 0 to 15.
    pub pin: u8,
    /// The alternate function, or `None` for a pin of the port itself.
    pub function: Option<u8>,
}

const fn alternate(port: usize, pin: u8, function: u8) -> Wire {
    Wire { port, pin, function: Some(function) }
}

const fn plain(port: usize, pin: u8) -> Wire {
    Wire { port, pin, function: None }
}

const A: usize = 0;
const B: usize = 1;
const C: usize = 2;

/// An encoder: its timer (TIM1 is 0) and the pins of channels A and B.
#[derive(Debug, Clone, Copy)]
pub struct Encoder {
    pub timer: usize,
    pub pins: [Wire; 2],
}

/// TIM2 and TIM3.
pub const PITCH_ENCODER: Encoder = Encoder { timer: 1, pins: [alternate(A, 0, 1), alternate(A, 1, 1)] };
/// See [`PITCH_ENCODER`].
pub const YAW_ENCODER: Encoder = Encoder { timer: 2, pins: [alternate(C, 6, 2), alternate(C, 7, 2)] };

/// The timer that drives the amplifiers: TIM1.
pub const PWM_TIMER: usize = 0;
/// What drives one input of a motor's bridge: a channel of that timer (0 is 1), its output or the
/// complementary one, and the pin.
#[derive(Debug, Clone, Copy)]
pub struct Leg {
    pub channel: usize,
    pub side: Side,
    pub pin: Wire,
}

const fn leg(channel: usize, side: Side, pin: Wire) -> Leg {
    Leg { channel, side, pin }
}

/// How the amplifiers are connected: the firmware is built for one of the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Amplifiers {
    /// Each bridge gets a PWM and its complement.
    #[default]
    LockedAntiphase,
    /// Each bridge gets a PWM on one of its inputs, one for each direction.
    SignMagnitude,
}

impl Amplifiers {
    /// The forward and the backward leg of the main and the tail motor's bridge. The motor is between the
    /// two.
    pub const fn bridges(self) -> [[Leg; 2]; 2] {
        use Side::{Complement, Main};
        match self {
            Self::LockedAntiphase => [
                [leg(0, Main, alternate(A, 8, 1)), leg(0, Complement, alternate(B, 13, 1))],
                [leg(1, Main, alternate(A, 9, 1)), leg(1, Complement, alternate(B, 14, 1))],
            ],
            Self::SignMagnitude => [
                [leg(0, Main, alternate(A, 8, 1)), leg(2, Main, alternate(A, 10, 1))],
                [leg(1, Main, alternate(A, 9, 1)), leg(3, Main, alternate(A, 11, 1))],
            ],
        }
    }
}

/// High switches the amplifiers on.
pub const AMPLIFIER_ENABLE: Wire = plain(C, 8);
/// Low reports a fault or the current limit.
pub const AMPLIFIER_FAULT: Wire = plain(C, 3);
/// The emergency stop, TIM1's break input: a contact to ground that opens.
pub const EMERGENCY_STOP: Wire = alternate(B, 12, 1);
/// High lights it.
pub const STATUS_LED: Wire = plain(A, 5);

/// The supply, through a divider: converter (ADC1 is 0), channel, and volts at the supply for one at the
/// pin.
pub const SUPPLY: (usize, u8, f64) = (0, 10, 11.0);

/// The serial line: which port of the part's (USART2), and its pins.
pub const SERIAL: (usize, [Wire; 2]) = (1, [alternate(A, 2, 7), alternate(A, 3, 7)]);
