//! The parameters' place in flash: sectors 1 to 3, 16 KiB each.

use embassy_stm32::Peri;
use embassy_stm32::flash::{Bank1Region1, Blocking, Flash};
use embassy_stm32::peripherals::FLASH;

/// What is written there.
pub(crate) type ParameterFlash = Bank1Region1<'static, Blocking>;

/// The sectors of 16 KiB.
pub(crate) fn parameters(flash: Peri<'static, FLASH>) -> ParameterFlash {
    Flash::new_blocking(flash).into_blocking_regions().bank1_region1
}

/// Was it the flash that interrupted the core, over what may lie there? This one never does.
pub(crate) fn tolerates() -> bool {
    false
}
