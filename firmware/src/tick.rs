//! The tick: an interrupt of the highest priority, every millisecond, around the core's control loop.

use crate::port::senses::Sensed;
use crate::port::{EncoderPwmPort, PlantPort, amplifier};
use crate::shared::{
    FRAME_EVERY, FRAMES, FRAMES_DROPPED, HEARD, LED_PATTERN, Maintenance, ORDERS, Order, Orders, Reports,
    STACK_LOW, TICK_CYCLES_MAX, TICKS, VERDICTS,
};
use crate::storage::Provenance;
use crate::{led, serial, watchdog};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::Ordering;
use cortex_m::peripheral::{DCB, DWT};
use embassy_stm32::interrupt;
use heapless::spsc::{Consumer, Producer, Queue};
use static_cell::StaticCell;
use twinrotor::axes::PerMotor;
use twinrotor::control_loop::{ControlLoop, Inputs, Wish};
use twinrotor::first_power::Verdict;
use twinrotor::parameters::Parameters;
use twinrotor::supervisor::{Condition, Conditions, State};
use twinrotor::telemetry::Frame;

/// [cycles] More than this from one tick to the next, and one has been missed.
const TOO_LATE: u32 = 168_000 * 3 / 2;

/// What the interrupt owns.
struct Tick {
    port: EncoderPwmPort,
    control: ControlLoop,
    /// What the parameters' provenance says against arming.
    standing: Conditions,
    orders: Consumer<'static, Order>,
    frames: Producer<'static, Frame>,
    verdicts: Producer<'static, Verdict>,
    until_frame: u16,
    last_begin: u32,
    /// The last tick ended too late, or this one began too late.
    overrun: bool,
}

struct OfTheInterrupt(UnsafeCell<MaybeUninit<Tick>>);

#[expect(unsafe_code, reason = "owned by the interrupt")]
// SAFETY: `start` writes it before it enables the interrupt, which alone uses it from then on.
unsafe impl Sync for OfTheInterrupt {}

static TICK: OfTheInterrupt = OfTheInterrupt(UnsafeCell::new(MaybeUninit::uninit()));

/// Starts the watchdog and the tick.
pub(crate) fn start(
    mut port: EncoderPwmPort,
    parameters: &Parameters,
    provenance: Provenance,
    reset_cause: Option<Condition>,
) -> (Reports, Orders) {
    static FRAME_QUEUE: StaticCell<Queue<Frame, FRAMES>> = StaticCell::new();
    static VERDICT_QUEUE: StaticCell<Queue<Verdict, VERDICTS>> = StaticCell::new();
    static ORDER_QUEUE: StaticCell<Queue<Order, ORDERS>> = StaticCell::new();
    let (frames, frame_end) = FRAME_QUEUE.init(Queue::new()).split();
    let (verdicts, verdict_end) = VERDICT_QUEUE.init(Queue::new()).split();
    let (order_end, orders) = ORDER_QUEUE.init(Queue::new()).split();
    let control = ControlLoop::new(parameters, port.counters(), port.drive(), reset_cause);
    start_cycle_counter();
    let tick = Tick {
        port,
        control,
        standing: Conditions::NONE
            .with(Condition::ParametersInvalid, provenance == Provenance::Invalid)
            .with(Condition::ParametersMissing, provenance == Provenance::Missing),
        orders,
        frames,
        verdicts,
        until_frame: 0,
        last_begin: DWT::cycle_count(),
        overrun: false,
    };
    #[expect(unsafe_code, reason = "the interrupt is not enabled yet")]
    // SAFETY: nobody else uses it now.
    unsafe {
        (*TICK.0.get()).write(tick);
    }
    watchdog::start();
    amplifier::run();
    (Reports { frames: frame_end, verdicts: verdict_end }, order_end)
}

#[interrupt]
fn TIM1_UP_TIM10() {
    #[expect(unsafe_code, reason = "owned by this interrupt")]
    // SAFETY: written before the interrupt was enabled; an interrupt does not interrupt itself.
    let tick = unsafe { (*TICK.0.get()).assume_init_mut() };
    tick.run();
}

impl Tick {
    fn run(&mut self) {
        let begin = DWT::cycle_count();
        amplifier::take_tick();
        let maintenance = self.maintain();
        let missed = begin.wrapping_sub(self.last_begin) > TOO_LATE && maintenance != Maintenance::Granted;
        self.last_begin = begin;
        let sensed = self.port.sense();
        match self.orders.peek() {
            Some(Order::Adopt(parameters)) => {
                // The motors are off and stay off: this tick has no other work.
                self.port.write(PerMotor::default(), false);
                self.control.adopt(parameters, self.port.counters(), self.port.drive());
                self.standing = Conditions::NONE;
            }
            Some(Order::Wish(wish)) => {
                let wish = Some(*wish);
                self.control(&sensed, missed, maintenance, wish);
            }
            None => self.control(&sensed, missed, maintenance, None),
        }
        // What was peeked at is done with; nothing is moved.
        let _ = self.orders.dequeue();
        LED_PATTERN.store(led::pattern(self.control.state()), Ordering::Relaxed);
        TICKS.store(self.control.next_tick(), Ordering::Relaxed);
        let cycles = DWT::cycle_count().wrapping_sub(begin);
        if cycles > TICK_CYCLES_MAX.load(Ordering::Relaxed) {
            TICK_CYCLES_MAX.store(cycles, Ordering::Relaxed);
        }
        self.overrun = amplifier::tick_due();
        if sensed.fresh && !self.overrun && !missed {
            watchdog::feed();
        }
    }

    /// The core's tick, and what it has to report.
    fn control(&mut self, sensed: &Sensed, missed: bool, maintenance: Maintenance, wish: Option<Wish>) {
        let outputs = self.control.tick(&Inputs {
            counters: self.port.counters(),
            supply: sensed.supply,
            current_limit: sensed.current_limit,
            senses: self
                .standing
                .with(Condition::EmergencyStop, sensed.emergency_stop)
                .with(Condition::SensorStale, !sensed.fresh)
                .with(Condition::TickOverrun, self.overrun | missed)
                .with(Condition::StackGuard, STACK_LOW.load(Ordering::Relaxed))
                .with(Condition::Saving, maintenance == Maintenance::Granted),
            heard: HEARD.swap(false, Ordering::Relaxed),
            wish,
        });
        self.port.write(outputs.duty, outputs.enable);
        if let Some(verdict) = outputs.verdict {
            // There is one verdict a check, and checks take seconds: there is room.
            let _ = self.verdicts.enqueue(verdict);
        }
        self.until_frame = self.until_frame.saturating_sub(1);
        if self.until_frame == 0 {
            self.until_frame = FRAME_EVERY.load(Ordering::Relaxed);
            if self.frames.enqueue(self.control.frame()).is_err() {
                FRAMES_DROPPED.fetch_add(1, Ordering::Relaxed);
            }
            serial::wake();
        }
    }

    /// Answers a thread that wants to write the flash.
    fn maintain(&mut self) -> Maintenance {
        let asked = Maintenance::get();
        if asked != Maintenance::Wanted {
            return asked;
        }
        let answer = match self.control.state() {
            State::Disarmed | State::Ready => Maintenance::Granted,
            State::Checking | State::Armed | State::Fault(_) => Maintenance::Refused,
        };
        answer.set();
        answer
    }
}

fn start_cycle_counter() {
    const TRACE: u32 = 1 << 24;
    const COUNT_CYCLES: u32 = 1;
    #[expect(unsafe_code, reason = "registers of the core")]
    // SAFETY: nobody else uses the debug unit's counter.
    unsafe {
        (*DCB::PTR).demcr.modify(|bits| bits | TRACE);
        (*DWT::PTR).ctrl.modify(|bits| bits | COUNT_CYCLES);
    }
}
