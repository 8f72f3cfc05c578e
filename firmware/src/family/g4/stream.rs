//! The serial port's way in: a DMA channel that writes a ring (reference manual RM0440, 12.4 and 13.4).

use crate::boards::Stream;
use embassy_stm32::pac::bdma::vals::{Dir, Pl, Size};
use embassy_stm32::pac::bdma::{Ch, Dma};
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::{DMA1, DMA2, DMAMUX1};

/// Channels of a controller.
const CHANNELS: usize = 8;

const fn unit(stream: Stream) -> Dma {
    if stream.controller == 1 { DMA1 } else { DMA2 }
}

/// Counted from 0; the names count from 1.
const fn place(stream: Stream) -> usize {
    stream.number as usize - 1
}

const fn registers(stream: Stream) -> Ch {
    unit(stream).ch(place(stream))
}

/// Lets the port hand its bytes to the channel. A byte that nobody has taken in time is overwritten, where
/// the port would else stand still; it is set so while it is off.
pub(crate) fn receive(port: Usart) {
    port.cr1().modify(|w| w.set_ue(false));
    port.cr3().modify(|w| {
        w.set_ovrdis(true);
        w.set_dmar(true);
    });
    port.cr1().modify(|w| {
        w.set_ue(true);
        w.set_re(true);
    });
}

/// Has the channel write what `port` receives into `ring`, round and round.
pub(crate) fn start(stream: Stream, port: Usart, request: u8, ring: *mut u8, length: u16) {
    let channel = registers(stream);
    channel.cr().write(|w| w.set_en(false));
    // The names' first channels come first, all of DMA1's before DMA2's.
    let line = place(stream) + if stream.controller == 1 { 0 } else { CHANNELS };
    DMAMUX1.ccr(line).write(|w| w.set_dmareq_id(request));
    unit(stream).ifcr().write(|w| w.set_gif(place(stream), true));
    channel.par().write_value(port.rdr().as_ptr() as u32);
    channel.mar().write_value(ring as u32);
    channel.ndtr().write(|w| w.set_ndt(length));
    channel.cr().write(|w| {
        w.set_dir(Dir::FROM_PERIPHERAL);
        w.set_psize(Size::BITS8);
        w.set_msize(Size::BITS8);
        w.set_minc(true);
        w.set_circ(true);
        w.set_pl(Pl::VERY_HIGH);
        w.set_en(true);
    });
}

/// Bytes to the ring's end.
#[inline(always)]
pub(crate) fn left(stream: Stream) -> u16 {
    registers(stream).ndtr().read().ndt()
}

/// Has it not ended?
#[inline(always)]
pub(crate) fn runs(stream: Stream) -> bool {
    registers(stream).cr().read().en()
}
