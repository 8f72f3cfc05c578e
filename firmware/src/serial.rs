//! The serial link: commands in, answers and telemetry out, both by DMA, never in the way of a tick.

use crate::boards::BOARD;
use crate::quiesce::TickAside;
use crate::shared::{Commands, FRAME_EVERY, FRAMES_DROPPED, HEARD, Reports, TICK_CYCLES_MAX};
use crate::storage::Storage;
use crate::{stack, tick, wake};
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_executor::Spawner;
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{RingBufferedUartRx, Uart, UartTx};
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant};
use static_cell::StaticCell;
use twinrotor::link::{
    self, Decoder, Health, Identity, LinkError, MAX_FRAME, Refusal, ResetReport, ToBoard, ToHost,
};
use twinrotor::parameters::Parameters;
use twinrotor::replay::{Replay, Replayed, Sample};

/// Answers on their way out.
static ANSWERS: Channel<ThreadModeRawMutex, ToHost, 2> = Channel::new();
/// Messages that were none.
static REJECTED: AtomicU32 = AtomicU32::new(0);

/// Spawns both directions.
pub(crate) fn start(
    spawner: Spawner,
    uart: Uart<'static, Async>,
    storage: Storage,
    parameters: Parameters,
    reset: Option<ResetReport>,
    reports: Reports,
    commands: Commands,
) {
    static DMA_BUFFER: StaticCell<[u8; 512]> = StaticCell::new();
    static REPLAY: StaticCell<Option<Replay>> = StaticCell::new();
    let (sender, receiver) = uart.split();
    let receiver = receiver.into_ring_buffered(DMA_BUFFER.init([0; 512]));
    let replay = REPLAY.init_with(|| None);
    let operator = Operator { storage, parameters, replay, reset, commands };
    spawner.spawn(receive(receiver, operator).expect("spawned once"));
    spawner.spawn(send(sender, reports).expect("spawned once"));
}

/// Takes messages as they come.
#[embassy_executor::task]
async fn receive(mut uart: RingBufferedUartRx<'static>, mut operator: Operator) {
    static DECODER: StaticCell<Decoder> = StaticCell::new();
    let decoder = DECODER.init(Decoder::new());
    let mut bytes = [0; 64];
    answer(operator.identity()).await;
    loop {
        // Noise on the line, or more than we can take: what is lost fails its CRC.
        let Ok(count) = uart.read(&mut bytes).await else { continue };
        for &byte in bytes.iter().take(count) {
            match decoder.push(byte) {
                None => {}
                Some(Ok(message)) => {
                    HEARD.store(true, Ordering::Relaxed);
                    if let Some(message) = operator.deal_with(message).await {
                        answer(message).await;
                    }
                }
                Some(Err(LinkError::Damaged | LinkError::TooLong | LinkError::Version { .. })) => {
                    REJECTED.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }
}

/// Sends answers first, then what the tick reports, once a second how the board is.
#[embassy_executor::task]
async fn send(mut uart: UartTx<'static, Async>, mut reports: Reports) {
    static BUFFER: StaticCell<[u8; MAX_FRAME]> = StaticCell::new();
    let buffer = BUFFER.init([0; MAX_FRAME]);
    let mut next_health = Instant::now();
    wake::listen();
    loop {
        let message = if let Ok(answer) = ANSWERS.try_receive() {
            answer
        } else if let Some(verdict) = reports.verdicts.dequeue() {
            ToHost::Verdict(verdict)
        } else if Instant::now() >= next_health {
            next_health += Duration::from_secs(1);
            ToHost::Health(health())
        } else if let Some(frame) = reports.frames.dequeue() {
            ToHost::Frame(frame)
        } else {
            wake::woken().await;
            continue;
        };
        transmit(&mut uart, &message, buffer).await;
    }
}

async fn transmit(uart: &mut UartTx<'static, Async>, message: &ToHost, buffer: &mut [u8; MAX_FRAME]) {
    if let Ok(frame) = link::encode(message, buffer) {
        // The only error is one of reception.
        let _ = uart.write(frame).await;
    }
}

fn health() -> Health {
    let (stack_used, stack_size) = stack::high_water();
    Health {
        frames_dropped: FRAMES_DROPPED.load(Ordering::Relaxed),
        messages_rejected: REJECTED.load(Ordering::Relaxed),
        tick_cycles_max: TICK_CYCLES_MAX.load(Ordering::Relaxed),
        stack_used,
        stack_size,
    }
}

/// Who does what the messages ask.
struct Operator {
    storage: Storage,
    parameters: Parameters,
    /// The record under way. In a place of its own: the task that has it is moved when it is spawned.
    replay: &'static mut Option<Replay>,
    reset: Option<ResetReport>,
    commands: Commands,
}

impl Operator {
    async fn deal_with(&mut self, message: ToBoard) -> Option<ToHost> {
        match message {
            ToBoard::Alive => None,
            ToBoard::Identify => Some(self.identity()),
            ToBoard::Control(command) => {
                let full = self.commands.enqueue(command).is_err();
                full.then_some(ToHost::Refused(Refusal::Busy))
            }
            ToBoard::Telemetry { every } => {
                FRAME_EVERY.store(every.clamp(1, 1000), Ordering::Relaxed);
                None
            }
            ToBoard::Replay(sample) => Some(match self.replayed(&sample) {
                Some(replayed) => ToHost::Replayed(replayed),
                None => ToHost::Refused(Refusal::NoReplay),
            }),
            ToBoard::ReadParameters => Some(ToHost::Parameters(self.parameters)),
            ToBoard::WriteParameters(parameters) => Some(match self.keep(parameters).await {
                Ok(()) => ToHost::Saved,
                Err(refusal) => ToHost::Refused(refusal),
            }),
        }
    }

    /// Parameters to flash, then to the tick, which keeps the motors off all the while.
    async fn keep(&mut self, parameters: Parameters) -> Result<(), Refusal> {
        parameters.validate()?;
        let aside = TickAside::ask().await.ok_or(Refusal::MotorsMayTurn)?;
        self.storage.save(&parameters)?;
        tick::adopt(&parameters, &aside);
        self.parameters = parameters;
        // Half a record with one controller and half with another would be neither's.
        *self.replay = None;
        Ok(())
    }

    /// One tick of a record; nothing of the control loop's. What it puts on the stack is not always there.
    #[inline(never)]
    fn replayed(&mut self, sample: &Sample) -> Option<Replayed> {
        if sample.number == 0 {
            *self.replay = Some(Replay::new(&self.parameters, sample));
        }
        self.replay.as_mut().map(|replay| replay.step(sample))
    }

    fn identity(&self) -> ToHost {
        ToHost::Identity(Identity {
            firmware: link::text(env!("CARGO_PKG_VERSION")),
            chip: link::text(BOARD.chip),
            parameters: twinrotor::parameters::VERSION,
            reset: self.reset,
        })
    }
}

/// Hands an answer to the sender.
async fn answer(message: ToHost) {
    ANSWERS.send(message).await;
    wake::wake_from_thread();
}
