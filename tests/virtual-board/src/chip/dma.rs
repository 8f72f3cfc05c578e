//! The DMA controller of RM0090 chapter 10, with every reading of what a stopped stream does: see
//! [`StreamStop`]. The model is the crate's, which has the first of them.

use rigless::device::{Device, DeviceContext, RegisterFile, RequestChange};
use rigless::soc::Layout;
use rigless::soc::stm32f427::generated::dma2::{Register, s0cr, s0fcr, s0ndtr};
use rigless::soc::stm32f427::peripherals::{Controller, dma};

use super::settings::StreamStop;

const STREAMS: usize = dma::STREAMS;
/// The registers of a stream follow the four status registers, six to each: `CR`, `NDTR`, three addresses,
/// `FCR`.
const FIRST_ROW: usize = 4;
const ROWS: usize = 6;
const CONTROL: usize = 0;
const COUNT: usize = 1;
const FIFO: usize = 5;
/// Where `TCIF` lies in `LISR` and `HISR`, by the stream's place in them, 10.5.1.
const COMPLETE: [u32; 4] = [5, 11, 21, 27];

/// What the wrapper knows of a stream.
#[derive(Debug, Clone, Copy, Default)]
struct Stream {
    enabled: bool,
    /// What `NDTR` was last programmed with, and what it kept when the stream was last stopped.
    programmed: u64,
    left: Option<u64>,
    /// It runs a lap of what was left.
    short: bool,
}

/// One controller.
#[derive(Debug)]
pub struct Dma {
    model: dma::Dma,
    reading: StreamStop,
    streams: [Stream; STREAMS],
}

fn register(stream: usize, row: usize) -> Register {
    Register::from_index(FIRST_ROW + ROWS * stream + row).expect("eight streams of six registers")
}

/// The stream and the row of one of its registers.
fn place(register: Register) -> Option<(usize, usize)> {
    let index = register.index().checked_sub(FIRST_ROW)?;
    Some((index / ROWS, index % ROWS))
}

fn status(stream: usize) -> (Register, u64) {
    let register = if stream < 4 { Register::Lisr } else { Register::Hisr };
    (register, 1 << COMPLETE[stream % 4])
}

impl Dma {
    /// A controller out of reset, wired as `wired`, that reads the manual as `reading` says.
    pub fn new(wired: &Controller, reading: StreamStop) -> Self {
        let model = dma::Dma::new(wired.wiring, wired.last_data, wired.reaches_memory);
        Self { model, reading, streams: [Stream::default(); STREAMS] }
    }

    /// Writes one of the stream's registers, which the file holds already, to the model.
    fn pass(
        &mut self,
        (stream, row): (usize, usize),
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let register = register(stream, row);
        let value = registers.get(register);
        Device::write(&mut self.model, register, value, registers, context);
    }

    fn write_control(
        &mut self,
        stream: usize,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let asked = s0cr::EN.is_set(registers.get(register(stream, CONTROL)));
        match (self.streams[stream].enabled, asked) {
            (true, false) => self.stop(stream, registers, context),
            (false, true) => self.start(stream, registers, context),
            _ => self.pass((stream, CONTROL), registers, context),
        }
        self.note(stream, registers);
    }

    fn stop(&mut self, stream: usize, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let control = register(stream, CONTROL);
        if self.reading.completes {
            self.pass((stream, CONTROL), registers, context);
        } else {
            if s0fcr::DMDIS.is_set(registers.get(register(stream, FIFO))) {
                context.tell("CR", "how a stream with a FIFO stops is modelled by the manual's text only");
            }
            let (flags, complete) = status(stream);
            let stood = registers.get(flags) & complete;
            // The model sets the flag; without its interrupt, and taken back, nobody hears of it.
            let interrupts = registers.get(control) & s0cr::TCIE.mask();
            registers.set(control, registers.get(control) & !interrupts);
            self.pass((stream, CONTROL), registers, context);
            registers.set(control, registers.get(control) | interrupts);
            registers.restore(flags, complete, stood);
        }
        let left = s0ndtr::NDT.get(registers.get(register(stream, COUNT)));
        self.streams[stream].left = Some(left);
        self.streams[stream].short = false;
    }

    fn start(&mut self, stream: usize, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let left = self.streams[stream].left.take();
        let kept = left.filter(|&left| !self.reading.reloads && left > 0);
        if let Some(left) = kept {
            let (control, count) = (register(stream, CONTROL), register(stream, COUNT));
            let on = registers.get(control);
            // The model takes a count only while the file says that the stream is off.
            registers.set(control, s0cr::EN.set(on, 0));
            registers.set(count, s0ndtr::NDT.set(registers.get(count), left));
            self.pass((stream, COUNT), registers, context);
            registers.set(control, on);
            self.streams[stream].short = left < self.streams[stream].programmed;
        }
        self.pass((stream, CONTROL), registers, context);
    }

    /// A lap of what was left is over: the next has the programmed count.
    fn whole_laps_again(
        &mut self,
        stream: usize,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.streams[stream].short = false;
        let (control, count) = (register(stream, CONTROL), register(stream, COUNT));
        let on = registers.get(control);
        // The lap set `TCIF` already, so the model's stop changes no flag.
        registers.set(control, s0cr::EN.set(on, 0));
        self.pass((stream, CONTROL), registers, context);
        registers.set(count, s0ndtr::NDT.set(registers.get(count), self.streams[stream].programmed));
        self.pass((stream, COUNT), registers, context);
        registers.set(control, on);
        self.pass((stream, CONTROL), registers, context);
    }

    fn note(&mut self, stream: usize, registers: &RegisterFile) {
        self.streams[stream].enabled = s0cr::EN.is_set(registers.get(register(stream, CONTROL)));
    }
}

impl Device for Dma {
    type Register = Register;

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        match place(register) {
            Some((stream, CONTROL)) => self.write_control(stream, registers, context),
            Some((stream, COUNT)) if !self.streams[stream].enabled => {
                self.streams[stream].programmed = s0ndtr::NDT.get(value);
                self.streams[stream].left = None;
                Device::write(&mut self.model, register, value, registers, context);
            }
            _ => Device::write(&mut self.model, register, value, registers, context),
        }
    }

    fn on_request(
        &mut self,
        change: RequestChange,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        Device::on_request(&mut self.model, change, registers, context);
    }

    fn on_access(
        &mut self,
        token: u64,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let stream = usize::try_from(token / 2).expect("eight streams");
        let before = self.model.remaining(stream).1;
        Device::on_access(&mut self.model, token, value, registers, context);
        self.note(stream, registers);
        if self.streams[stream].short && self.model.remaining(stream).1 > before {
            self.whole_laps_again(stream, registers, context);
        }
    }

    fn on_refused(&mut self, token: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        Device::on_refused(&mut self.model, token, registers, context);
        self.note(usize::try_from(token / 2).expect("eight streams"), registers);
    }

    fn reset(&mut self) {
        Device::reset(&mut self.model);
        self.streams = [Stream::default(); STREAMS];
    }
}
