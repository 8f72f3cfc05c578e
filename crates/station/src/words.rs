//! What a board says, in words for its operator.

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Faults, Injection};
use twinrotor::first_power::{Fault, Motor, Verdict};
use twinrotor::link::{Refusal, ResetReport};
use twinrotor::supervisor::{ArmState, Condition, Conditions};

/// A state in a word.
pub const fn state(state: ArmState) -> &'static str {
    match state {
        ArmState::Disarmed => "disarmed",
        ArmState::Ready => "ready",
        ArmState::Checking => "checking",
        ArmState::Armed => "armed",
        ArmState::Fault(_) => "fault",
    }
}

/// What is wrong, and where it helps what to do.
pub const fn condition(condition: Condition) -> &'static str {
    match condition {
        Condition::EmergencyStop => "the emergency stop is pressed, or its cable is broken",
        Condition::CurrentLimit => "the amplifier reports its current limit or a fault",
        Condition::SupplyRange => "the amplifiers' supply is out of its range",
        Condition::SupplyJump => "the reading of the supply jumped",
        Condition::SensorStale => "the supply was not measured, or an encoder's timer does not count",
        Condition::PitchJump => "pitch jumped further in a tick than the rig can move",
        Condition::YawJump => "yaw jumped further in a tick than the rig can move",
        Condition::PitchMotion => "the pitch encoder does not show the motion that the motors must cause",
        Condition::YawMotion => "the yaw encoder does not show the motion that the motors must cause",
        Condition::AngleEnvelope => "an angle left its envelope",
        Condition::RateEnvelope => "a rate left its envelope",
        Condition::NonFinite => "a number was not finite",
        Condition::TickOverrun => "a tick came late or was left out",
        Condition::CommandTimeout => "the host was silent for too long",
        Condition::StackGuard => "the firmware's stack came close to its end",
        Condition::ParametersInvalid => "the stored parameters are damaged or of another version",
        Condition::ParametersMissing => "no parameters are stored",
        Condition::NotZeroed => "the encoders have no zero yet",
        Condition::NotChecked => "the first-power check has not been passed",
        Condition::ResetByWatchdog => "the watchdog ended a stalled loop",
        Condition::ResetByPanic => "a panic ended the firmware",
        Condition::ResetByFault => "a fault exception ended the firmware",
        Condition::ResetByStackOverflow => "the firmware's stack overflowed",
        Condition::ResetByBrownOut => "the board's own supply broke down",
        Condition::ResetByClock => "the board's crystal stopped",
        Condition::ClockFallback => "the board runs from its inexact internal oscillator",
        Condition::DebugBuild => "the firmware is built for a debugger",
    }
}

/// All that is wrong.
pub fn conditions(all: Conditions) -> String {
    let told: Vec<&str> = all.iter().map(condition).collect();
    if told.is_empty() { "nothing is wrong".to_owned() } else { told.join("; ") }
}

/// Why the board began anew.
pub fn reset(report: &ResetReport) -> String {
    let ticks = match report.ticks {
        0 => String::new(),
        ticks => format!(" after {:.3} s", f64::from(ticks) * 1e-3),
    };
    let place = match report.program_counter {
        0 => String::new(),
        at => format!(", at {at:#010x}"),
    };
    format!("{}{ticks}{place}", condition(report.cause))
}

/// What the first-power check found.
pub fn verdict(verdict: &Verdict) -> String {
    let motor = |motor: &Motor| match motor {
        Motor::Main => "main",
        Motor::Tail => "tail",
    };
    match verdict {
        Verdict::Passed => "both motors turn the rig as they should".to_owned(),
        Verdict::NoMotion { motor: which } => format!(
            "the {} motor moved nothing: is supply, amplifier, motor or encoder not connected?",
            motor(which)
        ),
        Verdict::Wrong(fault) => format!("the wiring is wrong: {}", wiring(fault)),
        Verdict::Restless => "the rig did not come to rest".to_owned(),
    }
}

const fn wiring(fault: &Fault) -> &'static str {
    match fault {
        Fault::MotorsSwapped => "the motors are swapped",
        Fault::MainReversed => "the main motor turns backwards",
        Fault::TailReversed => "the tail motor turns backwards",
        Fault::BothReversed => "both motors turn backwards, or both encoders count backwards",
        Fault::PitchReversed => "the pitch encoder counts backwards",
        Fault::YawReversed => "the yaw encoder counts backwards",
        Fault::EncodersSwapped => "the encoders are swapped",
    }
}

/// Why the board would not.
pub fn refusal(refusal: &Refusal) -> String {
    match refusal {
        Refusal::MotorsMayTurn => {
            "the board keeps parameters only while disarmed: disarm it and clear its fault".to_owned()
        }
        Refusal::NoReplay => "the board has lost the beginning of the record: begin again".to_owned(),
        Refusal::Busy => "the board is busy: try again".to_owned(),
        Refusal::Nonce => "the board has been reset since it said who it is: begin again".to_owned(),
        Refusal::NoParameters => {
            "no first-power check with built-in parameters: write those of the rig first".to_owned()
        }
        Refusal::Setpoint { field, low, high } => {
            format!("the board refuses {field}; allowed: {low} to {high}")
        }
        Refusal::Flash => "the board's flash did not hold what was written".to_owned(),
        Refusal::Range { field, allowed } => format!("the board refuses {field}; allowed: {allowed}"),
        Refusal::NotArmed => "a controller is tried in flight: arm the board first".to_owned(),
        Refusal::TrialUnderWay => {
            "the board tries one controller at a time: accept the last one or take it back".to_owned()
        }
        Refusal::NothingToAccept => {
            "no controller that is being tried flies alone now: there is nothing to accept".to_owned()
        }
        Refusal::TooOften { least } => {
            format!("the board's line carries a frame every {least} ms, no more often")
        }
        Refusal::NotSimulated => {
            "the board's rig is real: only a simulated one is told what befalls it".to_owned()
        }
    }
}

/// What befalls a simulated rig.
pub fn injection(injection: &Injection) -> String {
    match injection {
        Injection::Rest => "the rig is laid down in its rest pose, sound".to_owned(),
        Injection::Wiring(faults) => wiring_faults(faults),
        Injection::Supply(volts) => format!("the amplifiers' supply is {volts} V"),
        Injection::Disturbance(PerMotor { main, tail }) => {
            format!("{main} V and {tail} V are added to what the main and the tail motor do")
        }
        Injection::CurrentLimit(true) => "the amplifiers report a fault".to_owned(),
        Injection::CurrentLimit(false) => "the amplifiers report no fault".to_owned(),
        Injection::EmergencyStop(true) => "the emergency stop is pressed".to_owned(),
        Injection::EmergencyStop(false) => "the emergency stop is released".to_owned(),
        Injection::Weight { mass, arm } => format!("{mass} kg hang {arm} m in front of the pivot"),
        Injection::Stall { ticks } => format!("a tick takes {ticks} ms more"),
    }
}

fn wiring_faults(faults: &Faults) -> String {
    let mut told = Vec::new();
    let mut axes = |which: PerAxis<bool>, what: &str| {
        for (is, axis) in [(which.pitch, "pitch"), (which.yaw, "yaw")] {
            told.extend(is.then(|| format!("the {axis} encoder {what}")));
        }
    };
    axes(faults.encoder_stuck, "stands still");
    axes(faults.encoder_reversed, "counts backwards");
    axes(faults.slip.map(|counts| counts != 0), "slips");
    axes(faults.drift.map(|counts| counts != 0), "drifts");
    let mut motors = |which: PerMotor<bool>, what: &str| {
        for (is, motor) in [(which.main, "main"), (which.tail, "tail")] {
            told.extend(is.then(|| format!("the {motor} motor {what}")));
        }
    };
    motors(faults.motor_open, "is not connected");
    motors(faults.motor_reversed, "turns backwards");
    told.extend(faults.motors_swapped.then(|| "the motors are swapped".to_owned()));
    told.extend(faults.encoders_swapped.then(|| "the encoders are swapped".to_owned()));
    if told.is_empty() { "the wiring is sound".to_owned() } else { told.join("; ") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_condition_has_words_of_its_own() {
        let words: BTreeSet<&str> = Condition::ALL.into_iter().map(condition).collect();
        assert_eq!(words.len(), Condition::ALL.len());
    }

    #[test]
    fn a_reset_tells_its_cause_its_time_and_its_place() {
        let report =
            ResetReport { cause: Condition::ResetByPanic, program_counter: 0x0800_1234, ticks: 2_500 };
        assert_eq!(reset(&report), "a panic ended the firmware after 2.500 s, at 0x08001234");
        let unknown = ResetReport { program_counter: 0, ticks: 0, ..report };
        assert_eq!(reset(&unknown), "a panic ended the firmware");
    }
}
