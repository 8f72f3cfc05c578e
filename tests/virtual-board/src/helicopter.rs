//! The rig at the end of the board's cables: the core's own plant, seen through encoders and moved by
//! amplifiers, either of which can be made to fail.

use twinrotor::axes::{PerAxis, PerMotor};
use twinrotor::encoder::angle_per_count;
use twinrotor::parameters::SAMPLE_TIME;
use twinrotor::plant::presets;
use twinrotor::plant::{PlantParameters, RealPlant, State};
use twinrotor::real::Real;

use crate::board::{Inputs, Outputs};
use crate::machine::Rig;
use crate::wiring;

/// The converter's whole scale, and its reference \[V\].
const ADC_SCALE: f32 = 4095.0;
const ADC_REFERENCE: f32 = 3.3;

/// What is broken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Broken {
    /// The encoder's cable is off: its count stays.
    pub stuck: PerAxis<bool>,
    /// The encoder's channels are swapped: it counts backwards from here on.
    pub reversed: PerAxis<bool>,
    /// \[counts\] Added once: edges that were none, or were lost.
    pub slipped: PerAxis<i64>,
    /// \[counts\] Added every millisecond.
    pub drifting: PerAxis<i64>,
    /// The motors' cables are swapped.
    pub motors_swapped: bool,
}

/// A helicopter on the bench.
#[derive(Debug, Clone)]
pub struct Helicopter {
    parameters: PlantParameters<f64>,
    plant: RealPlant<f32>,
    counts_per_angle: PerAxis<f32>,
    /// \[counts\] What the shafts have turned, and what the encoders have shown of it.
    turned: PerAxis<i64>,
    shown: PerAxis<i64>,
    inputs: Inputs,
    /// \[V\] The supply as the board measures it.
    supply: f32,
    full_steps: f32,
    /// Somebody holds it where it rests until the amplifiers are switched on.
    held: bool,
    /// \[rad\] The pitch of its rest pose, if its weight pulls its nose down.
    lowest: Option<f32>,
    /// See [`Helicopter::stand`].
    stands: bool,
    /// What is broken.
    pub broken: Broken,
    /// \[V\] Added to what the motors get.
    pub disturbance: PerMotor<f32>,
    /// Where it was at each millisecond, and the volts that the motors then got for the next.
    pub flown: Vec<(State<f32>, PerMotor<f32>)>,
}

impl Helicopter {
    /// `rig` at rest, on a supply that reads as near `supply` \[V\] as the converter can tell.
    pub fn new(rig: &presets::Rig, supply: f64) -> Self {
        let start = State::at_rest(rig.rest_angle.map(f32::from_f64));
        let mut helicopter = Self {
            parameters: rig.plant,
            plant: RealPlant::new(&rig.plant, start, SAMPLE_TIME),
            counts_per_angle: rig.encoder_counts.map(|counts| 1.0 / angle_per_count::<f32>(counts)),
            turned: PerAxis::both(0),
            shown: PerAxis::both(0),
            inputs: Inputs::default(),
            supply: 0.0,
            full_steps: f32::from_i32(rig.pwm_steps.cast_signed()),
            held: true,
            lowest: (rig.plant.center_of_mass > 0.0).then_some(f32::from_f64(rig.rest_angle.pitch)),
            stands: false,
            broken: Broken::default(),
            disturbance: PerMotor::zero(),
            flown: Vec::new(),
        };
        helicopter.set_supply(supply);
        // An incremental encoder counts from where it was switched on.
        helicopter.turned = helicopter.position();
        helicopter
    }

    /// Sets the supply \[V\].
    pub fn set_supply(&mut self, supply: f64) {
        self.inputs.supply = supply;
        self.supply = measured(supply);
    }

    /// \[V\] The supply as the board measures it, which is what the amplifiers get: so that board and host
    /// compute the same volts.
    pub fn measured_supply(&self) -> f32 {
        self.supply
    }

    /// The emergency stop, and the amplifiers' fault line.
    pub fn press(&mut self, emergency_stop: bool, amplifier_fault: bool) {
        self.inputs.emergency_stop = emergency_stop;
        self.inputs.amplifier_fault = amplifier_fault;
    }

    /// Something is under it that bears its weight in its rest pose, or is taken away. A rig that rests nose
    /// down always has its stop.
    pub fn stand(&mut self, stands: bool) {
        self.stands = stands;
    }

    fn lie(&mut self) {
        let mut body = self.plant.state();
        let Some(lowest) = self.lowest.filter(|&lowest| self.stands || lowest < 0.0) else { return };
        if body.angle.pitch < lowest {
            body.angle.pitch = lowest;
            body.rate.pitch = 0.0;
            let constants = self.parameters.map(f32::from_f64);
            self.plant = RealPlant::assemble(constants, *self.plant.rotors(), body, SAMPLE_TIME);
        }
    }

    /// Somebody catches it, and holds it there until the amplifiers are switched on again.
    pub fn hold(&mut self) {
        self.held = true;
        let caught = State::at_rest(self.plant.state().angle);
        self.plant = RealPlant::new(&self.parameters, caught, SAMPLE_TIME);
    }

    /// Where it is.
    pub fn state(&self) -> State<f32> {
        self.plant.state()
    }

    /// \[counts\] Whole counts of both shafts, from the horizontal.
    fn position(&self) -> PerAxis<i64> {
        self.plant.state().angle.zip(self.counts_per_angle, |angle, scale| whole((angle * scale).round()))
    }

    /// A millisecond passes with these volts on the motors.
    pub fn advance(&mut self, volts: PerMotor<f32>, enabled: bool) {
        self.flown.push((self.plant.state(), volts));
        self.held &= !enabled;
        if !self.held {
            self.plant.advance(volts, self.disturbance);
            self.lie();
        }
        self.look();
    }

    /// What the encoders' counters show, 16 bits of them.
    pub fn counters(&self) -> PerAxis<u32> {
        self.shown.map(|count| u32::from(count.to_le_bytes()[0]) | u32::from(count.to_le_bytes()[1]) << 8)
    }

    fn look(&mut self) {
        let position = self.position();
        let moved = position.zip(self.turned, |now, before| now - before);
        self.turned = position;
        let seen = |moved: i64, stuck: bool, reversed: bool| match (stuck, reversed) {
            (true, _) => 0,
            (false, true) => -moved,
            (false, false) => moved,
        };
        let Broken { stuck, reversed, slipped, drifting, .. } = &mut self.broken;
        let slipped = std::mem::replace(slipped, PerAxis::both(0));
        self.shown.pitch += seen(moved.pitch, stuck.pitch, reversed.pitch) + slipped.pitch + drifting.pitch;
        self.shown.yaw += seen(moved.yaw, stuck.yaw, reversed.yaw) + slipped.yaw + drifting.yaw;
        self.inputs.counts = [self.shown.pitch, self.shown.yaw];
    }

    /// \[V\] What the board's outputs give the motors: to the bit what the core's drive says of them.
    fn volts(&self, outputs: &Outputs) -> PerMotor<f32> {
        let volts_per_step = self.supply / self.full_steps;
        let [main, tail] = outputs.steps().map(|steps| {
            let steps = i32::try_from(steps).expect("a compare value's 16 bits");
            f32::from_i32(steps) * volts_per_step
        });
        if self.broken.motors_swapped { PerMotor::new(tail, main) } else { PerMotor::new(main, tail) }
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
    let (_, _, divider) = wiring::SUPPLY;
    // As the converter's model has it: whole millivolts at the pin, then whole codes.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few volts")]
    let millivolts = (supply / divider * 1000.0).round().max(0.0) as u32;
    let code = u16::try_from((millivolts * 4095 / 3300).min(4095)).expect("12 bits");
    #[expect(clippy::cast_possible_truncation, reason = "11, exactly")]
    let divider = divider as f32;
    f32::from(code) * (ADC_REFERENCE * divider / ADC_SCALE)
}

#[expect(clippy::cast_possible_truncation, reason = "a whole number of counts, far below 2^31")]
fn whole(counts: f32) -> i64 {
    counts as i64
}
