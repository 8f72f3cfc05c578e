//! Parameter records as flash may hand them out.

use super::{Chance, inputs, sound};
use twinrotor::axes::PerAxis;
use twinrotor::board::F405;
use twinrotor::control_loop::{ControlLoop, Inputs};
use twinrotor::drive::Drive;
use twinrotor::encoder::CounterWidth;
use twinrotor::parameters::Parameters;
use twinrotor::parameters::store::MAX_PAYLOAD;

#[test]
fn whatever_a_record_says_is_refused_or_runs_without_a_panic() {
    let mut chance = Chance(3);
    let mut buffer = [0; MAX_PAYLOAD];
    let whole = sound().encode(&mut buffer).expect("it has room").to_vec();
    let (mut taken, mut refused) = (0_u64, 0_u64);
    for _ in 0..inputs() {
        let mut bytes = whole.clone();
        match chance.below(4) {
            0 => bytes = (0..chance.below(600)).map(|_| chance.byte()).collect(),
            1 => bytes.truncate(chance.index(whole.len())),
            2 => {
                let at = chance.index(bytes.len() - 4);
                bytes[at..at + 4].copy_from_slice(&chance.float().to_le_bytes());
            }
            _ => {
                for _ in 0..=chance.below(3) {
                    let at = chance.index(bytes.len());
                    bytes[at] ^= 1 << chance.below(8);
                }
            }
        }
        match Parameters::decode(&bytes) {
            Ok(parameters) if parameters.validate().is_ok() => {
                taken += 1;
                if taken % 16 == 0 {
                    runs(&parameters, &mut chance);
                }
            }
            _ => refused += 1,
        }
    }
    println!("{taken} records taken, {refused} refused");
    assert!(taken > 1_000 && refused > inputs() / 4);
}

/// A few ticks, motors off: nothing panics and nothing turns.
fn runs(parameters: &Parameters, chance: &mut Chance) {
    let counters = PerAxis::both(chance.word());
    let drive = Drive::new(F405.pwm_steps());
    let mut control = ControlLoop::new(parameters, CounterWidth::Bits16, counters, drive, None);
    for _ in 0..4 {
        let outputs = control.tick(&Inputs::sound(counters, 24.0));
        assert!(!outputs.enable && outputs.duty.to_array().iter().all(|duty| duty.steps() == 0));
    }
}
