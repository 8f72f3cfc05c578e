//! What a unit was told since it began: with it, whatever it stands for is reached again, bit for bit. That
//! is how a state becomes bytes, whatever a board's loop is made of inside.

use twinrotor_sim::{Error, Outcome};

/// Inputs that any unit has at most.
pub(crate) const INPUTS: usize = 5;
/// First bytes of a state.
const MAGIC: &[u8] = b"twinrotor fmu state 1\n";

/// Inputs that were held from a tick on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Held {
    /// The first tick that they were held in.
    pub(crate) tick: u64,
    pub(crate) inputs: [f64; INPUTS],
}

/// A parameter that was set in flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tuned {
    /// The first tick that knew of it.
    pub(crate) tick: u64,
    pub(crate) reference: u32,
    pub(crate) value: f64,
}

/// A state, taken apart.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Course {
    /// Whose: another unit cannot take it.
    pub(crate) guid: String,
    /// The gains file of the controller that it began with.
    pub(crate) gains: String,
    pub(crate) begun: bool,
    /// How many have passed.
    pub(crate) ticks: u64,
    /// Those of the next one.
    pub(crate) inputs: [f64; INPUTS],
    pub(crate) held: Vec<Held>,
    pub(crate) tuned: Vec<Tuned>,
}

impl Course {
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut payload = Vec::with_capacity(64 + self.gains.len() + self.held.len() * 8 * (INPUTS + 1));
        for text in [&self.guid, &self.gains] {
            payload.extend((text.len() as u64).to_le_bytes());
            payload.extend(text.as_bytes());
        }
        payload.extend(u64::from(self.begun).to_le_bytes());
        payload.extend((self.tuned.len() as u64).to_le_bytes());
        for Tuned { tick, reference, value } in &self.tuned {
            payload.extend(tick.to_le_bytes());
            payload.extend(u64::from(*reference).to_le_bytes());
            payload.extend(value.to_le_bytes());
        }
        let last = Held { tick: self.ticks, inputs: self.inputs };
        for Held { tick, inputs } in self.held.iter().chain([&last]) {
            payload.extend(tick.to_le_bytes());
            inputs.iter().for_each(|input| payload.extend(input.to_le_bytes()));
        }
        [MAGIC, &crc32fast::hash(&payload).to_le_bytes(), &payload].concat()
    }

    /// From bytes that [`Course::to_bytes`] gave.
    ///
    /// # Errors
    ///
    /// If they are others.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Outcome<Self> {
        let read = || {
            let (sum, payload) = bytes.strip_prefix(MAGIC)?.split_first_chunk::<4>()?;
            let mut rest = (crc32fast::hash(payload) == u32::from_le_bytes(*sum)).then_some(payload)?;
            let (guid, gains) = (text(&mut rest)?, text(&mut rest)?);
            let begun = number(&mut rest)? != 0;
            let mut tuned = Vec::new();
            for _ in 0..number(&mut rest)? {
                let (tick, reference) = (number(&mut rest)?, u32::try_from(number(&mut rest)?).ok()?);
                tuned.push(Tuned { tick, reference, value: f64::from_bits(number(&mut rest)?) });
            }
            let mut held = Vec::new();
            while !rest.is_empty() {
                let tick = number(&mut rest)?;
                let mut inputs = [0.0; INPUTS];
                for input in &mut inputs {
                    *input = Some(f64::from_bits(number(&mut rest)?)).filter(|value| value.is_finite())?;
                }
                held.push(Held { tick, inputs });
            }
            let Held { tick: ticks, inputs } = held.pop()?;
            let in_order = held.is_sorted_by(|one, next| one.tick < next.tick);
            let ends = held.last().is_none_or(|last| last.tick < ticks);
            let known =
                tuned.is_sorted_by_key(|tuned| tuned.tick) && tuned.last().is_none_or(|t| t.tick <= ticks);
            (in_order && ends && known).then_some(Self { guid, gains, begun, ticks, inputs, held, tuned })
        };
        let told =
            || Error::invalid("serialized state", format!("{} bytes", bytes.len()), "one of this unit's");
        read().ok_or_else(told)
    }
}

fn number(rest: &mut &[u8]) -> Option<u64> {
    let (number, others) = rest.split_first_chunk::<8>()?;
    *rest = others;
    Some(u64::from_le_bytes(*number))
}

fn text(rest: &mut &[u8]) -> Option<String> {
    let length = usize::try_from(number(rest)?).ok()?;
    let (text, others) = rest.split_at_checked(length)?;
    *rest = others;
    String::from_utf8(text.to_vec()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_is_read_back_and_nothing_else_is() {
        let course = Course {
            guid: "{1}".to_owned(),
            gains: "controller = \"pid\"\n".to_owned(),
            begun: true,
            ticks: 7,
            inputs: [0.1, -0.0, 3.0, f64::MIN_POSITIVE, 1e300],
            held: vec![Held { tick: 0, inputs: [0.0; INPUTS] }, Held { tick: 4, inputs: [1.5; INPUTS] }],
            tuned: vec![
                Tuned { tick: 3, reference: 9, value: 2.5 },
                Tuned { tick: 7, reference: 8, value: 0.1 },
            ],
        };
        let bytes = course.to_bytes();
        assert_eq!(Course::from_bytes(&bytes), Ok(course.clone()));
        for k in 0..bytes.len() {
            let mut wrong = bytes.clone();
            wrong[k] ^= 0x10;
            assert!(Course::from_bytes(&wrong).is_err() && Course::from_bytes(&bytes[..k]).is_err(), "{k}");
        }
        let late = Course { ticks: 4, ..course.clone() };
        assert!(Course::from_bytes(&late.to_bytes()).is_err(), "held from a tick on that has not been");
        let wild = Course { inputs: [f64::NAN; INPUTS], ..course };
        assert!(Course::from_bytes(&wild.to_bytes()).is_err());
    }
}
