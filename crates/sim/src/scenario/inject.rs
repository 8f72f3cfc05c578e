//! What is to befall a rig that a board simulates, and when: in words such as `stuck-pitch@2`, on a command
//! line or in a scenario's `inject`.

use serde::Deserialize;
use std::str::FromStr;
use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Faults, Injection};

/// What there is, as it is asked for.
const KINDS: &str = "stuck-AXIS, reversed-AXIS, slip-AXIS=COUNTS, drift-AXIS=COUNTS, open-MOTOR, \
                                backwards-MOTOR, sound, supply=VOLTS, disturbance=MAIN:TAIL, fault, stop, \
                                weight=KG:METRES, stall=TICKS";

/// Something at a time.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Inject {
    /// What.
    pub injection: Injection,
    /// \[s\] Since the scenario began.
    pub seconds: f64,
}

impl Inject {
    /// \[ticks\] Since the scenario began.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 3,600 s")]
    pub fn tick(&self) -> u32 {
        (self.seconds / SAMPLE_TIME).round() as u32
    }
}

impl TryFrom<String> for Inject {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl FromStr for Inject {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (what, when) = text.rsplit_once('@').ok_or("KIND@SECONDS is wanted, such as stuck-pitch@2")?;
        let seconds: f64 = when.parse().map_err(|_| format!("'{when}' is no number of seconds"))?;
        if !(0.0..=3_600.0).contains(&seconds) {
            return Err(format!("{seconds} s after the scenario's begin; allowed: 0 to 3600 s"));
        }
        let injection = kind(what).ok_or_else(|| format!("'{what}' is none; allowed: {KINDS}"))?;
        injection.validate().map_err(|invalid| {
            format!("{} is {}; allowed: {}", invalid.field, invalid.value, invalid.allowed)
        })?;
        Ok(Self { injection, seconds })
    }
}

fn kind(text: &str) -> Option<Injection> {
    let (name, value) = text.split_once('=').unwrap_or((text, ""));
    let (what, whose) = name.split_once('-').unwrap_or((name, ""));
    let pair = || {
        let (a, b) = value.split_once(':')?;
        Some((a.parse::<f32>().ok()?, b.parse::<f32>().ok()?))
    };
    let wiring = |spoil: &dyn Fn(&mut Faults) -> Option<()>| {
        let mut faults = Faults::default();
        spoil(&mut faults)?;
        Some(Injection::Wiring(faults))
    };
    let bare = value.is_empty() && !text.contains('=');
    match what {
        "slip" => wiring(&|faults| set(axis(&mut faults.slip, whose), value.parse().ok())),
        "drift" => wiring(&|faults| set(axis(&mut faults.drift, whose), value.parse().ok())),
        "stuck" if bare => wiring(&|faults| set(axis(&mut faults.encoder_stuck, whose), Some(true))),
        "reversed" if bare => wiring(&|faults| set(axis(&mut faults.encoder_reversed, whose), Some(true))),
        "open" if bare => wiring(&|faults| set(motor(&mut faults.motor_open, whose), Some(true))),
        "backwards" if bare => wiring(&|faults| set(motor(&mut faults.motor_reversed, whose), Some(true))),
        _ if !whose.is_empty() => None,
        "sound" if bare => Some(Injection::Wiring(Faults::default())),
        "fault" if bare => Some(Injection::CurrentLimit(true)),
        "stop" if bare => Some(Injection::EmergencyStop(true)),
        "supply" => Some(Injection::Supply(value.parse().ok()?)),
        "stall" => Some(Injection::Stall { ticks: value.parse().ok()? }),
        "disturbance" => pair().map(|(main, tail)| Injection::Disturbance(PerMotor::new(main, tail))),
        "weight" => pair().map(|(mass, arm)| Injection::Weight { mass, arm }),
        _ => None,
    }
}

fn set<T>(place: Option<&mut T>, value: Option<T>) -> Option<()> {
    *place? = value?;
    Some(())
}

fn axis<'a, T>(axes: &'a mut PerAxis<T>, name: &str) -> Option<&'a mut T> {
    match name {
        "pitch" => Some(&mut axes.pitch),
        "yaw" => Some(&mut axes.yaw),
        _ => None,
    }
}

fn motor<'a, T>(motors: &'a mut PerMotor<T>, name: &str) -> Option<&'a mut T> {
    match name {
        "main" => Some(&mut motors.main),
        "tail" => Some(&mut motors.tail),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_understood() {
        for (text, at) in [
            ("stuck-pitch@2", 2.0),
            ("reversed-yaw@0", 0.0),
            ("slip-yaw=-400@1.5", 1.5),
            ("drift-pitch=3@2", 2.0),
            ("open-main@2", 2.0),
            ("backwards-tail@2", 2.0),
            ("sound@3", 3.0),
            ("fault@2", 2.0),
            ("stop@2", 2.0),
            ("stall=3@2", 2.0),
        ] {
            assert_eq!(text.parse::<Inject>().unwrap().seconds, at, "{text}");
        }
        let injection = |text: &str| text.parse::<Inject>().unwrap().injection;
        assert_eq!(injection("supply=9.5@2"), Injection::Supply(9.5));
        assert_eq!(injection("disturbance=2:-1@2"), Injection::Disturbance(PerMotor::new(2.0, -1.0)));
        assert_eq!(injection("weight=0.02:0.1@2"), Injection::Weight { mass: 0.02, arm: 0.1 });
        let slip = Faults { slip: PerAxis::new(0, -400), ..Faults::default() };
        assert_eq!(injection("slip-yaw=-400@1.5"), Injection::Wiring(slip));
    }

    #[test]
    fn what_is_none_is_told_with_what_is_allowed() {
        for text in ["stuck@2", "stuck-roll@2", "slip-yaw@2", "supply@2", "stuck-pitch=1@2", "fault-main@2"] {
            assert!(text.parse::<Inject>().unwrap_err().contains("allowed: stuck-AXIS"), "{text}");
        }
        assert_eq!("supply=80@2".parse::<Inject>().unwrap_err(), "inject.supply is 80; allowed: 0 to 75 V");
        assert!("stuck-pitch".parse::<Inject>().is_err() && "stuck-pitch@x".parse::<Inject>().is_err());
    }
}
