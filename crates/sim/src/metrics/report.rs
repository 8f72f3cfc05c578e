//! What was measured, in numbers and in plain text.

use super::Criterion;
use serde::Serialize;
#[cfg(feature = "std")]
use std::fmt;

/// A flight in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Report {
    /// Pitch.
    pub pitch: AxisReport,
    /// Yaw.
    pub yaw: AxisReport,
    /// Main motor.
    pub main: MotorReport,
    /// Tail motor.
    pub tail: MotorReport,
}

impl Report {
    /// The paper's objective, both axes together.
    pub fn ise(&self) -> f64 {
        self.integral(Criterion::Ise)
    }

    /// Any of the three, both axes together.
    pub fn integral(&self, criterion: Criterion) -> f64 {
        self.pitch.integral(criterion) + self.yaw.integral(criterion)
    }
}

/// One axis in numbers. What needs a step in the reference is `None` without one, or when it never settles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AxisReport {
    /// \[s\] From the last step to when the error came within 2 % of it for good.
    pub settling_time_2: Option<f64>,
    /// \[s\] The same at 5 %.
    pub settling_time_5: Option<f64>,
    /// \[%\] Of the step, beyond the goal.
    pub overshoot_percent: Option<f64>,
    /// \[deg\] Reference minus angle at the end.
    pub final_error_deg: f64,
    /// \[rad² s\] ∫ e² dt.
    pub ise: f64,
    /// \[rad s\] ∫ |e| dt.
    pub iae: f64,
    /// \[rad s²\] ∫ t |e| dt.
    pub itae: f64,
}

impl AxisReport {
    const fn integral(&self, criterion: Criterion) -> f64 {
        match criterion {
            Criterion::Ise => self.ise,
            Criterion::Iae => self.iae,
            Criterion::Itae => self.itae,
        }
    }
}

/// One motor in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MotorReport {
    /// \[s\] For how long more was asked of it than its limit.
    pub saturation_time: f64,
    /// \[%\] The same, of the flight.
    pub saturation_percent: f64,
    /// \[V/s\] Σ|ΔV| a second of what was applied, over the whole flight: how much it chatters.
    pub voltage_variation: f64,
    /// \[V\] Most that was asked.
    pub peak_demand: f64,
    /// \[V\] Most that was applied.
    pub peak_volts: f64,
}

/// Two tables in plain text: the axes, and the motors.
#[cfg(feature = "std")]
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row =
            |name: &str, [first, second]: [String; 2]| writeln!(f, "{name:<30} {first:>12} {second:>12}");
        let seconds = |time: Option<f64>| time.map_or_else(|| "never".to_owned(), |t| format!("{t:.3}"));
        // Without a step there is nothing to settle on and nothing to shoot over.
        let of_step = |axis: &AxisReport, text: String| match axis.overshoot_percent {
            Some(_) => text,
            None => "–".to_owned(),
        };
        let axes = [&self.pitch, &self.yaw];
        row("", ["pitch", "yaw"].map(str::to_owned))?;
        row("settling 2 % [s]", axes.map(|a| of_step(a, seconds(a.settling_time_2))))?;
        row("settling 5 % [s]", axes.map(|a| of_step(a, seconds(a.settling_time_5))))?;
        row("overshoot [%]", axes.map(|a| of_step(a, format!("{:.2}", a.overshoot_percent.unwrap_or(0.0)))))?;
        // Adding zero makes a negative zero positive.
        row("final error [°]", axes.map(|a| format!("{:.5}", a.final_error_deg + 0.0)))?;
        row("ISE [rad² s]", axes.map(|a| format!("{:.6}", a.ise)))?;
        row("IAE [rad s]", axes.map(|a| format!("{:.6}", a.iae)))?;
        row("ITAE [rad s²]", axes.map(|a| format!("{:.6}", a.itae)))?;
        let motors = [&self.main, &self.tail];
        row("", ["main motor", "tail motor"].map(str::to_owned))?;
        row("asked beyond its limit [ms]", motors.map(|m| format!("{:.0}", 1e3 * m.saturation_time)))?;
        row("the same, of the flight [%]", motors.map(|m| format!("{:.1}", m.saturation_percent)))?;
        row("voltage variation [V/s]", motors.map(|m| format!("{:.1}", m.voltage_variation)))?;
        row("peak demand [V]", motors.map(|m| format!("{:.2}", m.peak_demand)))?;
        row("peak volts [V]", motors.map(|m| format!("{:.2}", m.peak_volts)))
    }
}
