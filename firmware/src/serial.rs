//! The serial link: bytes in ([`crate::receiver`]) and out by DMA, never in the way of a tick. What is
//! answered is the core's [`Conversation`]; here is what it asks for: flash, and the tick.

use crate::boards::BOARD;
use crate::port::{PlantPort, Port};
use crate::quiesce::TickAside;
use crate::receiver::Receiver;
use crate::shared::{Commands, FRAME_EVERY, FRAMES_DROPPED, Flag, Reports, STATUS, TICK_COUNTS_MAX, TICKS};
use crate::storage::Storage;
use crate::{clock, log, nonce, slot, stack, tick, wake};
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_executor::Spawner;
use embassy_stm32::mode::Async;
use embassy_stm32::usart::UartTx;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::channel::Channel;
use static_cell::StaticCell;
use twinrotor::control_loop::Status;
use twinrotor::conversation::outgoing::{Outgoing, Waiting};
use twinrotor::conversation::{Action, Board, Conversation, Loop};
use twinrotor::first_power::Verdict;
use twinrotor::link::{
    self, ChipSerial, Decoder, Health, LinkError, MAX_FRAME, Refusal, ResetReport, ToBoard, ToHost,
};
use twinrotor::parameters::{Parameters, Provenance};
use twinrotor::sequence::Numbered;
use twinrotor::telemetry::Frame;

/// Answers on their way out.
static ANSWERS: Channel<ThreadModeRawMutex, ToHost, 2> = Channel::new();
/// Messages that were none.
static REJECTED: AtomicU32 = AtomicU32::new(0);
/// Messages that were old.
static STALE: AtomicU32 = AtomicU32::new(0);

/// Spawns both directions.
pub(crate) fn start(
    spawner: Spawner,
    (receiver, sender): (Receiver, UartTx<'static, Async>),
    storage: Storage,
    (parameters, provenance): (Parameters, Provenance),
    reset: Option<ResetReport>,
    reports: Reports,
    commands: Commands,
) {
    static CONVERSATION: StaticCell<Conversation> = StaticCell::new();
    let board = Board {
        firmware: env!("CARGO_PKG_VERSION"),
        chip: BOARD.known.chip,
        port: Port::KIND,
        serial: ChipSerial(embassy_stm32::uid::uid()),
        nonce: nonce::draw(),
        reset,
        baud: link::BAUD,
    };
    let conversation = CONVERSATION.init_with(|| Conversation::new(board, parameters, provenance));
    let operator = Operator { storage, conversation, commands };
    spawner.spawn(receive(receiver, operator).expect("spawned once"));
    spawner.spawn(send(sender, reports).expect("spawned once"));
}

/// Takes messages as they come.
#[embassy_executor::task]
async fn receive(mut receiver: Receiver, mut operator: Operator) {
    static DECODER: StaticCell<Decoder> = StaticCell::new();
    let decoder = DECODER.init(Decoder::new());
    answer(operator.conversation.identity()).await;
    loop {
        while let Some(byte) = receiver.next() {
            if let Some(received) = decoder.push(byte) {
                operator.deal_with(received).await;
            }
        }
        wake::bytes().await;
    }
}

/// Sends what there is to say.
#[embassy_executor::task]
async fn send(mut uart: UartTx<'static, Async>, mut reports: Reports) {
    static BUFFER: StaticCell<[u8; MAX_FRAME]> = StaticCell::new();
    let buffer = BUFFER.init([0; MAX_FRAME]);
    let mut outgoing = Outgoing::new();
    wake::listen();
    loop {
        reports.log();
        let message = outgoing.next(TICKS.load(Ordering::Relaxed), &mut reports);
        match message.and_then(|message| link::encode(&message, buffer).ok()) {
            // What is waited for is the frame's end: of the message, which is large, there is no copy then.
            Some(frame) => {
                // The only error is one of reception.
                let _ = uart.write(frame).await;
            }
            None => wake::woken().await,
        }
    }
}

impl Reports {
    fn log(&mut self) {
        while let Some(change) = self.changes.dequeue() {
            log::change(&change);
        }
        let longest = longest_tick();
        if longest > self.longest_tick {
            self.longest_tick = longest;
            log::longest_tick(longest);
        }
    }
}

/// \[cycles\] Since boot.
fn longest_tick() -> u32 {
    TICK_COUNTS_MAX.load(Ordering::Relaxed).saturating_mul(clock::CYCLES)
}

impl Waiting for Reports {
    fn answer(&mut self) -> Option<ToHost> {
        ANSWERS.try_receive().ok()
    }

    fn verdict(&mut self) -> Option<Verdict> {
        self.verdicts.dequeue().inspect(|&verdict| log::verdict(verdict))
    }

    fn frame(&mut self) -> Option<Frame> {
        self.frames.dequeue()
    }

    fn health(&mut self) -> Health {
        let (stack_used, stack_size) = stack::high_water();
        Health {
            frames_dropped: FRAMES_DROPPED.load(Ordering::Relaxed),
            messages_rejected: REJECTED.load(Ordering::Relaxed),
            messages_stale: STALE.load(Ordering::Relaxed),
            tick_cycles_max: longest_tick(),
            stack_used,
            stack_size,
        }
    }
}

/// Who does what comes out of the conversation.
struct Operator {
    storage: Storage,
    /// In a place of its own: the task that has it is moved when it is spawned.
    conversation: &'static mut Conversation,
    commands: Commands,
}

impl Operator {
    async fn deal_with(&mut self, received: Result<Numbered<ToBoard>, LinkError>) {
        if let Err(error) = received {
            log::rejected(error);
        }
        let response = self.conversation.receive(received, &self.now());
        REJECTED.store(self.conversation.rejected(), Ordering::Relaxed);
        let stale = self.conversation.stale();
        if stale != STALE.load(Ordering::Relaxed) {
            log::stale(stale);
        }
        STALE.store(stale, Ordering::Relaxed);
        if response.heard {
            Flag::Heard.raise();
        }
        match response.action {
            Action::Nothing => {}
            Action::Answer(message) => answer(message).await,
            Action::Disarm => Flag::Disarm.raise(),
            Action::Command(command) => {
                // There is room: the conversation was told so, and only the tick makes more.
                let _ = self.commands.enqueue(command);
            }
            Action::Try(command) => {
                self.hand_over();
                let _ = self.commands.enqueue(command);
            }
            Action::FrameEvery(ticks) => FRAME_EVERY.store(ticks, Ordering::Relaxed),
            Action::Keep(parameters) => {
                let outcome = self.keep(&parameters).await;
                answer(self.conversation.kept(&parameters, outcome)).await;
            }
        }
    }

    /// Where the loop stands. What it takes is looked at before the status, which is then at least as new.
    fn now(&self) -> Loop {
        let (takes_command, takes_candidate) = (self.commands.ready(), slot::is_free());
        let status = Status::from_word(STATUS.load(Ordering::Acquire));
        Loop { takes_command, takes_candidate, status }
    }

    /// The controller to be tried, made ready here and left for the tick.
    #[inline(never)]
    fn hand_over(&self) {
        if let Some(candidate) = self.conversation.candidate() {
            slot::put(candidate);
        }
    }

    /// Parameters to flash, then to the tick, which keeps the motors off all the while.
    async fn keep(&mut self, parameters: &Parameters) -> Result<(), Refusal> {
        let aside = TickAside::ask().await.ok_or(Refusal::MotorsMayTurn)?;
        self.storage.save(parameters)?;
        tick::adopt(parameters, &aside);
        log::saved();
        Ok(())
    }
}

/// Hands an answer to the sender.
async fn answer(message: ToHost) {
    if let ToHost::Refused(refusal) = &message {
        log::refusal(refusal);
    }
    ANSWERS.send(message).await;
    wake::wake_from_thread();
}
