//! The tick: an interrupt of the highest priority, every millisecond, around the core's control loop.

use crate::clock::{self, Clock};
use crate::port::{PlantPort, Port, Sensed};
use crate::quiesce::{self, TickAside};
use crate::shared::{
    CHANGES, Change, Commands, FRAME_EVERY, FRAMES, FRAMES_DROPPED, Flag, Flags, LED_PATTERN, Reports,
    STATUS, TICK_COUNTS_MAX, TICKS, VERDICTS,
};
use crate::{led, slot, wake, watchdog};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::Ordering;
use heapless::spsc::{Producer, Queue};
use static_cell::StaticCell;
use twinrotor::control_loop::{ControlLoop, Inputs, OperatorCommand};
use twinrotor::conversation::commands;
use twinrotor::first_power::Verdict;
use twinrotor::parameters::{Parameters, Provenance};
use twinrotor::rig_port::RigPort;
use twinrotor::sequence::Numbered;
use twinrotor::supervisor::{Condition, Conditions};
use twinrotor::telemetry::Frame;

/// \[counts\] More than this from one tick to the next, and one has been missed.
const TOO_LATE: u32 = clock::COUNTS * 3 / 2;

/// What the interrupt owns beside the control loop.
struct Tick {
    clock: Clock,
    port: Port,
    commands: commands::Receiver<'static>,
    frames: Producer<'static, Frame>,
    verdicts: Producer<'static, Verdict>,
    changes: Producer<'static, Change>,
    until_frame: u16,
    last_begin: u32,
    /// \[counts of the stopwatch\]
    longest: u32,
    /// The last tick ended too late, or this one began too late.
    overrun: bool,
}

/// What the thread has while the tick stands aside.
struct Control {
    core: ControlLoop,
    rig: <Port as PlantPort>::Rig,
    /// What the parameters' provenance says against arming, and what the board itself does.
    standing: Conditions,
    board: Conditions,
}

struct OfTheInterrupt<T>(UnsafeCell<MaybeUninit<T>>);

#[expect(unsafe_code, reason = "owned by the interrupt")]
// SAFETY: `start` writes it before it enables the interrupt, which alone uses it from then on; but for
// `CONTROL` while the interrupt stands aside.
unsafe impl<T> Sync for OfTheInterrupt<T> {}

static TICK: OfTheInterrupt<Tick> = OfTheInterrupt(UnsafeCell::new(MaybeUninit::uninit()));
static CONTROL: OfTheInterrupt<Control> = OfTheInterrupt(UnsafeCell::new(MaybeUninit::uninit()));

/// Starts the tick, with the watchdog at its heels.
pub(crate) fn start(
    clock: Clock,
    mut port: Port,
    board: Conditions,
    (parameters, provenance): (&Parameters, Provenance),
    reset_cause: Option<Condition>,
) -> (Reports, Commands) {
    static FRAME_QUEUE: StaticCell<Queue<Frame, FRAMES>> = StaticCell::new();
    static VERDICT_QUEUE: StaticCell<Queue<Verdict, VERDICTS>> = StaticCell::new();
    static CHANGE_QUEUE: StaticCell<Queue<Change, CHANGES>> = StaticCell::new();
    static COMMAND_QUEUE: StaticCell<commands::Commands> = StaticCell::new();
    let (frames, frame_end) = FRAME_QUEUE.init(Queue::new()).split();
    let (verdicts, verdict_end) = VERDICT_QUEUE.init(Queue::new()).split();
    let (changes, change_end) = CHANGE_QUEUE.init(Queue::new()).split();
    let (wish_end, commands) = COMMAND_QUEUE.init(Queue::new()).split();
    #[expect(unsafe_code, reason = "the interrupt is not enabled yet")]
    // SAFETY: nobody else uses them now.
    unsafe {
        let rig = Port::rig(parameters);
        (*CONTROL.0.get()).write(Control {
            core: ControlLoop::new(
                parameters,
                Port::COUNTER_WIDTH,
                port.counters(&rig),
                port.drive(),
                reset_cause,
            ),
            rig,
            standing: provenance.conditions().union(board),
            board,
        });
        (*TICK.0.get()).write(Tick {
            clock,
            port,
            commands,
            frames,
            verdicts,
            changes,
            until_frame: 0,
            last_begin: clock.now(),
            longest: 0,
            overrun: false,
        });
    }
    watchdog::guard_ticks();
    clock.run();
    let reports = Reports { frames: frame_end, verdicts: verdict_end, changes: change_end, longest_tick: 0 };
    (reports, wish_end)
}

/// Other parameters for the tick, which stands aside.
pub(crate) fn adopt(parameters: &Parameters, _: &TickAside) {
    #[expect(unsafe_code, reason = "while the tick stands aside, the thread has its control loop")]
    // SAFETY: there is one `TickAside` at a time, and while there is, the interrupt does not touch `CONTROL`.
    let control = unsafe { (*CONTROL.0.get()).assume_init_mut() };
    control.rig = Port::rig(parameters);
    control.core.adopt(parameters);
    control.standing = control.board;
    tell_status(control);
}

/// Where the loop stands, for the thread.
#[inline(never)]
fn tell_status(control: &Control) {
    STATUS.store(control.core.status().to_word(), Ordering::Release);
}

/// For the timer's interrupt.
#[inline(always)]
pub(crate) fn tick() {
    #[expect(unsafe_code, reason = "owned by this interrupt")]
    // SAFETY: written before the interrupt was enabled; an interrupt does not interrupt itself.
    let tick = unsafe { (*TICK.0.get()).assume_init_mut() };
    tick.run();
}

impl Tick {
    #[inline(always)]
    fn run(&mut self) {
        let begin = self.clock.now();
        self.clock.take_tick();
        let missed = begin.wrapping_sub(self.last_begin) > TOO_LATE;
        self.last_begin = begin;
        let sensed = self.port.sense();
        #[expect(unsafe_code, reason = "owned by this interrupt unless it stands aside")]
        // SAFETY: used where it does not stand aside, or does not yet.
        let control = || unsafe { (*CONTROL.0.get()).assume_init_mut() };
        if quiesce::stands(|| control().core.state()) {
            self.port.rest();
        } else {
            self.control(control(), sensed, missed);
        }
        wake::wake();
        let taken = self.clock.now().wrapping_sub(begin);
        if taken > self.longest {
            self.longest = taken;
            TICK_COUNTS_MAX.store(taken, Ordering::Relaxed);
        }
        self.overrun = self.clock.tick_due();
        if sensed.fresh && !self.overrun && !missed {
            watchdog::feed();
        }
    }

    /// The core's tick, and what it has to report.
    #[inline(always)]
    fn control(&mut self, control: &mut Control, sensed: Sensed, missed: bool) {
        let sensed = Port::seen(sensed, &control.rig);
        let flags = Flags::take();
        let disarm = flags.contain(Flag::Disarm);
        let command = commands::next(&mut self.commands, disarm);
        let trying = control.core.is_trying();
        let outputs = control.core.tick(&Inputs {
            counters: self.port.counters(&control.rig),
            supply: sensed.supply,
            current_limit: sensed.current_limit,
            senses: control
                .standing
                .with(Condition::EmergencyStop, sensed.emergency_stop | flags.contain(Flag::StopEdge))
                .with(Condition::SensorStale, !sensed.fresh)
                .with(Condition::TickOverrun, self.overrun | missed)
                .with(Condition::StackGuard, flags.contain(Flag::StackLow)),
            heard: flags.contain(Flag::Heard),
            disarm,
            trial: if command.is_some() { slot::peek() } else { None },
            command,
        });
        if Port::KIND == RigPort::Simulated
            && let Some(Numbered { message: OperatorCommand::Inject(injection), .. }) = command
        {
            Port::inject(&mut control.rig, injection);
        }
        self.port.write(&mut control.rig, outputs.duty, control.core.state());
        if trying | disarm | command.is_some() {
            slot::settle(command, disarm);
            if command.is_some() {
                commands::done(&mut self.commands);
            }
            tell_status(control);
        }
        if let Some(verdict) = outputs.verdict {
            // There is one verdict a check, and checks take seconds: there is room.
            let _ = self.verdicts.enqueue(verdict);
        }
        self.report(control);
    }

    #[inline(always)]
    fn report(&mut self, control: &Control) {
        TICKS.store(control.core.next_tick(), Ordering::Relaxed);
        if control.core.has_changed() {
            self.tell_change(control);
        }
        if self.until_frame > 1 {
            self.until_frame = self.until_frame.wrapping_sub(1);
        } else {
            self.until_frame = FRAME_EVERY.load(Ordering::Relaxed);
            if self.frames.enqueue(control.core.frame()).is_err() {
                FRAMES_DROPPED.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    #[inline(never)]
    fn tell_change(&mut self, control: &Control) {
        let (tick, state) = (control.core.next_tick(), control.core.state());
        LED_PATTERN.store(led::pattern(state, control.board), Ordering::Relaxed);
        tell_status(control);
        let _ = self.changes.enqueue(Change { tick, state, conditions: control.core.conditions() });
    }
}
