//! The serial port's way in: a DMA stream that writes a ring (reference manual RM0090, 10.5).

use crate::boards::Stream;
use embassy_stm32::pac::dma::vals::{Dir, Pl, Size};
use embassy_stm32::pac::dma::{Dma, St};
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::{DMA1, DMA2};

const fn unit(stream: Stream) -> Dma {
    if stream.controller == 1 { DMA1 } else { DMA2 }
}

const fn registers(stream: Stream) -> St {
    unit(stream).st(stream.number as usize)
}

/// Lets the port hand its bytes to the stream.
pub(crate) fn receive(port: Usart) {
    port.cr3().modify(|w| w.set_dmar(true));
    port.cr1().modify(|w| w.set_re(true));
}

/// Has the stream write what `port` receives into `ring`, round and round.
pub(crate) fn start(stream: Stream, port: Usart, request: u8, ring: *mut u8, length: u16) {
    let (half, place) = (usize::from(stream.number / 4), usize::from(stream.number % 4));
    // Without this it does not start.
    unit(stream).ifcr(half).write(|w| {
        w.set_feif(place, true);
        w.set_dmeif(place, true);
        w.set_teif(place, true);
        w.set_htif(place, true);
        w.set_tcif(place, true);
    });
    let stream = registers(stream);
    stream.par().write_value(port.dr().as_ptr() as u32);
    stream.m0ar().write_value(ring as u32);
    stream.ndtr().write(|w| w.set_ndt(length));
    stream.cr().write(|w| {
        w.set_chsel(request);
        w.set_dir(Dir::PERIPHERAL_TO_MEMORY);
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
