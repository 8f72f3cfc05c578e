//! The boards that there is firmware for, as far as a flight depends on which one flies: how finely its timer
//! divides the supply. Their pins and clocks are the firmware's alone.

use crate::drive::full_steps;

/// A board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// What people call it.
    pub name: &'static str,
    /// Its chip, as the board tells it to its host.
    pub chip: &'static str,
    /// \[Hz\] What the timer of the PWM counts.
    pub pwm_timer_hz: u32,
}

/// STM32F405RG with an 8 MHz crystal; what is taken where nothing else is said.
pub const F405: Board = Board { name: "f405", chip: "stm32f405rg", pwm_timer_hz: 168_000_000 };
/// Adafruit Feather STM32F405 Express, with a 12 MHz crystal.
pub const FEATHER_F405: Board =
    Board { name: "feather-f405", chip: "stm32f405rg", pwm_timer_hz: 168_000_000 };
/// STM32F4-Discovery.
pub const F407: Board = Board { name: "f407", chip: "stm32f407vg", pwm_timer_hz: 168_000_000 };
/// WeAct Black Pill with an STM32F411CE.
pub const BLACK_PILL: Board = Board { name: "black-pill", chip: "stm32f411ce", pwm_timer_hz: 100_000_000 };
/// ST Nucleo-F446RE.
pub const NUCLEO_F446: Board = Board { name: "nucleo-f446", chip: "stm32f446re", pwm_timer_hz: 168_000_000 };
/// ST Nucleo-F411RE.
pub const NUCLEO_F411: Board = Board { name: "nucleo-f411", chip: "stm32f411re", pwm_timer_hz: 100_000_000 };
/// ST Nucleo-G474RE.
pub const NUCLEO_G474: Board = Board { name: "nucleo-g474", chip: "stm32g474re", pwm_timer_hz: 170_000_000 };

/// All of them.
pub const ALL: [Board; 7] = [F405, FEATHER_F405, F407, BLACK_PILL, NUCLEO_F411, NUCLEO_F446, NUCLEO_G474];

impl Board {
    /// Compare steps between zero and full voltage.
    #[must_use]
    pub const fn pwm_steps(self) -> u32 {
        full_steps(self.pwm_timer_hz)
    }

    /// The one of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        ALL.into_iter().find(|board| board.name == name)
    }

    /// One with that chip, as a board names it: where there are several, a chip has one PWM all the same.
    #[must_use]
    pub fn with_chip(chip: &str) -> Option<Self> {
        ALL.into_iter().find(|board| board.chip == chip)
    }
}

impl Default for Board {
    fn default() -> Self {
        F405
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Centre-aligned at 20 kHz: a quarter of the 8,400 counts of 168 MHz, of the 5,000 of 100 MHz, of the
    /// 8,500 of 170 MHz.
    #[test]
    fn a_timers_counts_are_the_steps() {
        assert_eq!(ALL.map(Board::pwm_steps), [2_100, 2_100, 2_100, 1_250, 1_250, 2_100, 2_125]);
    }

    #[test]
    fn a_board_is_found_by_its_name_and_by_its_chip() {
        for board in ALL {
            assert_eq!(Board::named(board.name), Some(board));
            let same = Board::with_chip(board.chip).map(|found| (found.chip, found.pwm_timer_hz));
            assert_eq!(same, Some((board.chip, board.pwm_timer_hz)), "{}", board.name);
        }
        assert_eq!((Board::named("f103"), Board::with_chip("simulated")), (None, None));
    }
}
