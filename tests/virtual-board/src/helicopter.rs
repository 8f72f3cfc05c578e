//! The rig at the end of the board's cables: the core's simulated bench, and what the board's pins and
//! converter make of it.

use twinrotor::SAMPLE_TIME;
use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::bench::{Bench, Faults};
use twinrotor::plant::{PlantParameters, State, presets};
use twinrotor::real::Real;
use twinrotor_sim::scenario::Now;

use crate::board::{Inputs, Outputs};
use crate::machine::Rig;
use crate::wiring::SUPPLY_DIVIDER;

/// The converter's whole scale, and its reference \[V\].
const ADC_SCALE: f32 = 4095.0;
const ADC_REFERENCE: f32 = 3.3;

/// A helicopter on the bench.
#[derive(Debug, Clone)]
pub struct Helicopter {
    bench: Bench<f32>,
    /// \[V\] The supply as it was set.
    sound_supply: f64,
    inputs: Inputs,
    full_steps: f32,
}

impl Helicopter {
    /// `rig` at rest, held there until it is powered, on a supply that reads as near `supply` \[V\] as the
    /// converter can tell.
    pub fn new(rig: &presets::Rig, supply: f64) -> Self {
        let mut helicopter = Self {
            bench: Bench::at_rest(rig, SAMPLE_TIME),
            sound_supply: supply,
            inputs: Inputs::default(),
            full_steps: f32::from_i32(rig.board.pwm_steps().cast_signed()),
        };
        helicopter.bench.hold();
        helicopter.set_supply(supply);
        helicopter
    }

    /// What is broken in its cables.
    pub fn faults(&mut self) -> &mut Faults {
        &mut self.bench.faults
    }

    /// What befalls it in a tick of a scenario, and what its plant becomes, if it becomes another.
    pub fn befall(&mut self, now: &Now, plant: Option<&PlantParameters<f32>>) {
        self.bench.disturbance = now.volts.cast();
        self.bench.set_load(now.torque.cast());
        self.show_supply(now.supply(self.sound_supply));
        if let Some(plant) = plant {
            self.bench.become_plant(plant);
        }
    }

    /// Sets the supply \[V\].
    pub fn set_supply(&mut self, supply: f64) {
        self.sound_supply = supply;
        self.show_supply(supply);
    }

    fn show_supply(&mut self, supply: f64) {
        self.inputs.supply = supply;
        self.bench.supply = measured(supply);
    }

    /// \[V\] The supply as the board measures it, which is what the amplifiers get: so that board and host
    /// compute the same volts.
    pub fn measured_supply(&self) -> f32 {
        self.bench.supply
    }

    /// The emergency stop, and the amplifiers' fault line.
    pub fn press(&mut self, emergency_stop: bool, amplifier_fault: bool) {
        self.inputs.emergency_stop = emergency_stop;
        self.inputs.amplifier_fault = amplifier_fault;
    }

    /// Puts a table under it that bears its weight in its rest pose, or takes it away.
    pub fn set_table(&mut self, table: bool) {
        self.bench.set_table(table);
    }

    /// Somebody catches it, and holds it there until the amplifiers are switched on again.
    pub fn hold(&mut self) {
        self.bench.hold();
    }

    /// Where it is.
    pub fn state(&self) -> State<f32> {
        self.bench.state()
    }

    /// A millisecond passes with these volts from the amplifiers.
    pub fn advance(&mut self, volts: PerMotor<f32>, enabled: bool) {
        self.bench.advance(volts, enabled);
        self.inputs.counts = self.bench.counted().to_array().map(i64::from);
    }

    /// What the encoders' counters show, 16 bits of them.
    pub fn counters(&self) -> PerAxis<u32> {
        self.bench.counters()
    }

    /// \[V\] What the board's outputs give the motors: to the bit what the core's drive says of them.
    fn volts(&self, outputs: &Outputs) -> PerMotor<f32> {
        let volts_per_step = self.bench.supply / self.full_steps;
        let [main, tail] = outputs.steps().map(|steps| {
            let steps = i32::try_from(steps).expect("a compare value's 16 bits");
            f32::from_i32(steps) * volts_per_step
        });
        PerMotor::new(main, tail)
    }
}

impl Rig for Helicopter {
    fn step(&mut self, outputs: &Outputs) -> Inputs {
        self.advance(self.volts(outputs), outputs.enabled);
        self.inputs
    }
}

/// \[V\] What the board's converter makes of a supply \[V\].
fn measured(supply: f64) -> f32 {
    // As the converter's model has it: whole millivolts at the pin, then whole codes.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few volts")]
    let millivolts = (supply / SUPPLY_DIVIDER * 1000.0).round().max(0.0) as u32;
    let code = u16::try_from((millivolts * 4095 / 3300).min(4095)).expect("12 bits");
    #[expect(clippy::cast_possible_truncation, reason = "11, exactly")]
    let divider = SUPPLY_DIVIDER as f32;
    f32::from(code) * (ADC_REFERENCE * divider / ADC_SCALE)
}
