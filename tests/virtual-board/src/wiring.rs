//! What is soldered to which pin: the same table as the firmware's board file, seen from outside.

use twinrotor::board::{self, Board};

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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Encoder {
    pub timer: usize,
    pub pins: [Wire; 2],
}

/// What drives one input of a motor's bridge: a channel of the PWM's timer (0 is 1), its output or the
/// complementary one, and the pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leg {
    pub channel: usize,
    pub side: Side,
    /// The channel is active above its compare value, not below.
    pub above: bool,
    pub pin: Wire,
}

const fn leg(channel: usize, side: Side, pin: Wire) -> Leg {
    Leg { channel, side, above: false, pin }
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

/// A bridge's forward and backward leg. The motor is between the two.
pub type Bridge = [Leg; 2];

/// A board's wiring.
#[derive(Debug, PartialEq, Eq)]
pub struct Wiring {
    pub pitch_encoder: Encoder,
    pub yaw_encoder: Encoder,
    /// The timer that drives the amplifiers (TIM1 is 0).
    pub pwm_timer: usize,
    /// Its update interrupt, the control tick.
    pub tick: &'static str,
    /// The main and the tail motor's bridge, in locked antiphase.
    antiphase: [Bridge; 2],
    /// The same, with sign and magnitude.
    sign_magnitude: Option<[Bridge; 2]>,
    /// High switches the amplifiers on.
    pub amplifier_enable: Wire,
    /// Low reports a fault or the current limit.
    pub amplifier_fault: Wire,
    /// The emergency stop, the break input of the PWM's timer: a contact to ground that opens.
    pub emergency_stop: Wire,
    /// High lights it.
    pub status_led: Wire,
    /// The converter (ADC1 is 0) and its channel that measure the supply through its divider.
    pub supply: (usize, u8),
    /// The serial line: which port of the part's (USART1 is 0), and its pins.
    pub serial: (usize, [Wire; 2]),
}

/// \[V\] At the supply for one at the pin.
pub const SUPPLY_DIVIDER: f64 = 11.0;

/// The control tick of all boards but the Feather.
pub const TICK: &str = "TIM1_UP_TIM10";

/// An F405's, which a Nucleo board of the F4 shares.
static F405: Wiring = Wiring {
    pitch_encoder: Encoder { timer: 1, pins: [alternate(A, 0, 1), alternate(A, 1, 1)] },
    yaw_encoder: Encoder { timer: 2, pins: [alternate(C, 6, 2), alternate(C, 7, 2)] },
    pwm_timer: 0,
    tick: TICK,
    antiphase: [
        [leg(0, Side::Main, alternate(A, 8, 1)), leg(0, Side::Complement, alternate(B, 13, 1))],
        [leg(1, Side::Main, alternate(A, 9, 1)), leg(1, Side::Complement, alternate(B, 14, 1))],
    ],
    sign_magnitude: Some([
        [leg(0, Side::Main, alternate(A, 8, 1)), leg(2, Side::Main, alternate(A, 10, 1))],
        [leg(1, Side::Main, alternate(A, 9, 1)), leg(3, Side::Main, alternate(A, 11, 1))],
    ]),
    amplifier_enable: plain(C, 8),
    amplifier_fault: plain(C, 3),
    emergency_stop: alternate(B, 12, 1),
    status_led: plain(A, 5),
    supply: (0, 10),
    serial: (1, [alternate(A, 2, 7), alternate(A, 3, 7)]),
};

/// A Feather's: TIM4 and TIM3, TIM8, whose channel 3 takes channel 1's place, USART3.
static FEATHER: Wiring = Wiring {
    pitch_encoder: Encoder { timer: 3, pins: [alternate(B, 6, 2), alternate(B, 7, 2)] },
    yaw_encoder: Encoder { timer: 2, pins: [alternate(C, 6, 2), alternate(A, 7, 2)] },
    pwm_timer: 7,
    tick: "TIM8_UP_TIM13",
    antiphase: [
        [
            Leg { channel: 2, side: Side::Complement, above: true, pin: alternate(B, 15, 3) },
            leg(0, Side::Complement, alternate(A, 5, 3)),
        ],
        [leg(1, Side::Main, alternate(C, 7, 3)), leg(1, Side::Complement, alternate(B, 14, 3))],
    ],
    sign_magnitude: None,
    amplifier_enable: plain(B, 8),
    amplifier_fault: plain(B, 9),
    emergency_stop: alternate(A, 6, 3),
    status_led: plain(C, 1),
    supply: (0, 4),
    serial: (2, [alternate(B, 10, 7), alternate(B, 11, 7)]),
};

impl Wiring {
    /// That of a board with a rig.
    pub fn of(known: Board) -> &'static Self {
        if known == board::FEATHER_F405 { &FEATHER } else { &F405 }
    }

    /// The main and the tail motor's bridge.
    ///
    /// # Panics
    ///
    /// If the board cannot drive them so.
    pub fn bridges(&self, amplifiers: Amplifiers) -> [Bridge; 2] {
        match amplifiers {
            Amplifiers::LockedAntiphase => self.antiphase,
            Amplifiers::SignMagnitude => self.sign_magnitude.expect("a board that can"),
        }
    }
}
