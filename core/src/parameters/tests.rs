use super::ram_flash::{AREA_SIZE, PAGE_SIZE, PowerCut, RamFlash, RamFlashError};
use super::store::{MAX_PAYLOAD, SLOT_SIZE, Store, StoreError};
use super::*;
use crate::gains::{self, Gains};
use crate::law::{LawSettings, StateSpaceGains};
use crate::plant::presets;
use std::boxed::Box;
use std::vec::Vec;

/// Saves that fill a page.
const SLOTS: u32 = (PAGE_SIZE / SLOT_SIZE) as u32;

fn parameters(rig: &Rig) -> Parameters {
    Parameters::new(rig, &Settings::paper(rig, gains::PAPER, SAMPLE_TIME))
}

/// A short payload that says which save it was.
fn payload(save: u32) -> [u8; 6] {
    let [a, b, c, d] = save.to_le_bytes();
    [a, b, c, d, 0xA5, 0x00]
}

fn load<const WORD: usize>(flash: RamFlash<WORD>) -> (RamFlash<WORD>, Option<Vec<u8>>) {
    let mut store = Store::new(flash, 0);
    let found = store.load(&mut [0; SLOT_SIZE]).unwrap().map(<[u8]>::to_vec);
    (store.into_flash(), found)
}

fn save<const WORD: usize>(
    flash: RamFlash<WORD>,
    number: u32,
) -> (RamFlash<WORD>, Result<(), StoreError<RamFlashError>>) {
    let mut store = Store::new(flash, 0);
    let result = store.save(&payload(number), &mut [0; SLOT_SIZE]);
    (store.into_flash(), result)
}

/// A flash on which saves 0 to `count` - 1 were made.
fn after<const WORD: usize>(count: u32) -> RamFlash<WORD> {
    (0..count).fold(RamFlash::erased(), |flash, number| {
        let (flash, result) = save(flash, number);
        assert_eq!(result, Ok(()));
        flash
    })
}

/// Save `number` on a flash that holds the one before, with the supply cut in the middle; then it returns.
fn cut_save<const WORD: usize>(mut flash: RamFlash<WORD>, number: u32, cut: PowerCut) -> RamFlash<WORD> {
    flash.cut = Some(cut);
    let (mut flash, result) = save(flash, number);
    assert_eq!(result, Err(StoreError::Flash(RamFlashError::PowerOff)));
    flash.power_on();
    flash
}

/// What must hold after any cut of save `number`: the old or the new record, and the next save holds.
fn check<const WORD: usize>(flash: RamFlash<WORD>, number: u32) {
    let (flash, found) = load(flash);
    let (old, new) = (payload(number - 1).to_vec(), payload(number).to_vec());
    assert!(found == Some(old) || found == Some(new), "after a cut save {number}: {found:?}");
    let (flash, result) = save(flash, number + 1);
    assert_eq!(result, Ok(()));
    assert_eq!(load(flash).1, Some(payload(number + 1).to_vec()));
}

/// Flash operations of save `number`.
fn operations<const WORD: usize>(flash: &RamFlash<WORD>, number: u32) -> u32 {
    let (after, result) = save(flash.clone(), number);
    assert_eq!(result, Ok(()));
    after.operations - flash.operations
}

const PROGRESS: [u16; 5] = [0, 64, 128, 192, 256];

#[test]
fn an_erased_flash_holds_nothing() {
    assert_eq!(load(RamFlash::default()).1, None);
}

#[test]
fn a_thousand_saves_each_hold() {
    let mut flash = RamFlash::default();
    for number in 0..1_000 {
        let (saved, result) = save(flash, number);
        assert_eq!(result, Ok(()));
        let (read, found) = load(saved);
        assert_eq!(found, Some(payload(number).to_vec()));
        flash = read;
    }
}

/// Every flash operation of saves that stay on a page, turn a page and erase each of the three, at every
/// progress, with several random patterns.
fn a_cut_anywhere_leaves_one_of_the_records<const WORD: usize>() {
    let mut erases = 0;
    for page in 0..4 {
        for number in [SLOTS * page + 1, SLOTS * page + SLOTS - 1, SLOTS * page + SLOTS] {
            let flash = after::<WORD>(number);
            let count = operations(&flash, number);
            erases += u32::from(number % SLOTS == 0);
            for operation in 0..count {
                for progress in PROGRESS {
                    for seed in 0..4 {
                        check(
                            cut_save(flash.clone(), number, PowerCut { operation, progress, seed }),
                            number,
                        );
                    }
                }
            }
        }
    }
    assert_eq!(erases, 4);
}

#[test]
fn a_cut_anywhere_leaves_the_old_or_the_new_record() {
    a_cut_anywhere_leaves_one_of_the_records::<4>();
}

/// An STM32G4's flash is programmed by double words, each once: the same, in fewer operations.
#[test]
fn so_it_does_where_double_words_are_programmed() {
    a_cut_anywhere_leaves_one_of_the_records::<8>();
    let (words, double_words) = (operations(&after::<4>(1), 1), operations(&after::<8>(1), 1));
    assert_eq!(double_words, words.div_ceil(2));
}

/// An image is the same for both, so that no host needs to know which chip it is for.
#[test]
fn what_was_saved_by_double_words_lies_as_by_words() {
    assert!(after::<8>(20).bytes() == after::<4>(20).bytes());
}

/// A second cut in the save that follows, sampled.
#[test]
fn two_cuts_in_a_row_leave_one_of_the_records() {
    let mut seed = 7_u32;
    let mut random = |limit: u32| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) % limit
    };
    let bases: Vec<Box<RamFlash>> = (1..=4 * SLOTS).map(|number| Box::new(after(number))).collect();
    for _ in 0..3_000 {
        let number = 1 + random(4 * SLOTS);
        let base = &bases[number as usize - 1];
        let mut cut = |flash: RamFlash, number: u32| {
            let count = operations(&flash, number);
            let progress = PROGRESS[random(5) as usize];
            cut_save(flash, number, PowerCut { operation: random(count), progress, seed: random(1 << 20) })
        };
        let once = cut((**base).clone(), number);
        let (once, first) = load(once);
        let (twice, second) = load(cut(once, number + 1));
        let allowed = [payload(number - 1), payload(number), payload(number + 1)].map(|p| p.to_vec());
        let place = |found: &Option<Vec<u8>>| allowed.iter().position(|a| Some(a) == found.as_ref());
        assert!(place(&first) < Some(2) && place(&first).is_some());
        // Old or new: the record never goes back behind what the first cut left.
        assert!(place(&second) == place(&first) || place(&second) == Some(2), "{first:?} then {second:?}");
        let (flash, result) = save(twice, number + 2);
        assert_eq!((result, load(flash).1), (Ok(()), Some(payload(number + 2).to_vec())));
    }
}

/// Whatever lies in the area, a save makes the record that is read.
#[test]
fn garbage_is_no_record_and_does_not_stop_a_save() {
    let mut flash = RamFlash::default();
    for operation in 0..3 {
        // Half an erase of nothing leaves it erased; half a word leaves garbage.
        flash.cut = Some(PowerCut { operation: 0, progress: 128, seed: operation });
        let at = operation * PAGE_SIZE as u32;
        assert!(embedded_storage::nor_flash::NorFlash::write(&mut flash, at, &[0; 4]).is_err());
        flash.power_on();
    }
    let (flash, found) = load(flash);
    assert_eq!(found, None);
    let (flash, result) = save(flash, 5);
    assert_eq!((result, load(flash).1), (Ok(()), Some(payload(5).to_vec())));
}

#[test]
fn a_payload_fits_up_to_its_limit() {
    let mut store = Store::new(RamFlash::default(), 0);
    let mut buffer = [0; SLOT_SIZE];
    assert_eq!(store.save(&[1; MAX_PAYLOAD], &mut buffer), Ok(()));
    assert_eq!(store.load(&mut buffer), Ok(Some(&[1; MAX_PAYLOAD][..])));
    assert_eq!(store.save(&[1; MAX_PAYLOAD + 1], &mut buffer), Err(StoreError::TooLong));
    assert_eq!(store.into_flash().bytes().len(), AREA_SIZE);
}

#[test]
fn every_preset_makes_a_record_that_comes_back() {
    for (name, rig) in presets::ALL {
        let before = parameters(&rig);
        assert_eq!(before.validate(), Ok(()), "{name}");
        let mut buffer = [0; MAX_PAYLOAD];
        assert_eq!(Parameters::decode(before.encode(&mut buffer).unwrap()), Ok(before), "{name}");
    }
}

/// The longest record, which a law of matrices makes: saved over another with the supply cut in every word,
/// it is one of the two, whole, and the next save holds.
#[test]
fn a_record_of_matrices_comes_back_and_survives_a_cut_in_every_word() {
    let record = |gain: f32| {
        let mut record = parameters(&presets::AERO2);
        let mut law = StateSpaceGains::<f32>::none();
        (law.states, law.inputs, law.corrected) = (8, 4, true);
        law.a = [[gain; 8]; 8];
        law.b = [[-gain; 4]; 8];
        record.settings.controller.law = LawSettings::StateSpace(law);
        record
    };
    let (old, new) = (record(0.25), record(0.5));
    let put = |flash, record: &Parameters| {
        let mut store = Store::new(flash, 0);
        let result = super::save(&mut store, record, &mut [0; SLOT_SIZE]);
        (store.into_flash(), result)
    };
    let found = |flash: &RamFlash| {
        let (_, bytes) = load(flash.clone());
        Parameters::decode(&bytes.unwrap()).unwrap()
    };
    let (before, result) = put(RamFlash::default(), &old);
    assert_eq!((result, found(&before)), (Ok(()), old));
    let (after, result) = put(before.clone(), &new);
    assert_eq!((result, found(&after)), (Ok(()), new));
    let count = after.operations - before.operations;
    assert!(count > 200, "a long record: {count} words");
    for operation in 0..count {
        for progress in PROGRESS {
            let mut flash = before.clone();
            flash.cut = Some(PowerCut { operation, progress, seed: operation });
            let (mut flash, result) = put(flash, &new);
            assert!(result.is_err());
            flash.power_on();
            assert!([old, new].contains(&found(&flash)), "cut at {operation}");
            let (flash, result) = put(flash, &old);
            assert_eq!((result, found(&flash)), (Ok(()), old), "the save after a cut at {operation}");
        }
    }
}

/// The gains of the law that [`parameters`] has.
fn gain(p: &mut Parameters) -> &mut Gains<f32> {
    match &mut p.settings.controller.law {
        LawSettings::Backstepping(gains) => gains,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_value_out_of_range_is_named() {
    type Spoil = fn(&mut Parameters);
    let cases: [(&str, Spoil); 19] = [
        ("settings", |p| gain(p).pitch.rate = f32::NAN),
        ("settings", |p| p.settings.model.damping.yaw = f32::INFINITY),
        ("sample_time", |p| p.settings.sample_time = 2e-3),
        ("model.inertia.yaw", |p| p.settings.model.inertia.yaw = 0.0),
        ("effectiveness", |p| p.settings.effectiveness = crate::plant::Effectiveness::zero()),
        ("volts_limit.tail", |p| p.settings.volts_limit.tail = -1.0),
        ("pitch.position", |p| gain(p).pitch.position = 0.0),
        ("encoders.yaw.angle_per_count", |p| p.encoders.yaw.angle_per_count = 0.0),
        ("limits.pitch", |p| p.limits.pitch = 1.6),
        ("limits.supply_high", |p| p.limits.supply_high = p.limits.supply_low),
        ("limits.supply_high", |p| p.limits.supply_high = 22_500.0),
        ("limits.rate.yaw", |p| p.limits.rate.yaw = 573.0),
        ("limits.rate.pitch", |p| p.limits.rate.pitch = 1e30),
        ("limits.approach_rate", |p| p.limits.approach_rate = 573.0),
        ("encoders.yaw.angle_per_count", |p| p.encoders.yaw.angle_per_count = 1e-30),
        ("encoders.pitch.angle_per_count", |p| p.encoders.pitch.angle_per_count = 1.0),
        ("limits.command_timeout", |p| p.limits.command_timeout = 0),
        ("limits.check.main.volts", |p| p.limits.check.main.volts = 25.0),
        ("limits.check.tail.motion", |p| p.limits.check.tail.motion = PerAxis::zero()),
    ];
    for (name, spoil) in cases {
        let mut spoilt = parameters(&presets::AERO);
        spoil(&mut spoilt);
        match spoilt.validate() {
            Err(ParameterError::Range { field, .. }) => assert_eq!(field, name),
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn bytes_that_are_no_record_are_refused() {
    let mut buffer = [0; MAX_PAYLOAD];
    let whole = parameters(&presets::AERO).encode(&mut buffer).unwrap().to_vec();
    for length in 0..whole.len() {
        assert_eq!(Parameters::decode(&whole[..length]), Err(ParameterError::Damaged), "cut at {length}");
    }
    let longer = [&whole[..], &[0]].concat();
    assert_eq!(Parameters::decode(&longer), Err(ParameterError::Damaged));
    let mut other = whole;
    other[0] = 1;
    assert_eq!(Parameters::decode(&other), Err(ParameterError::Version { found: 1 }));
}

/// The same at boot: flash that was written by a firmware for another kind of rig.
#[test]
fn a_board_boots_unchecked_with_what_was_checked_at_another_kind_of_port() {
    for (stored, own, checked) in [
        (RigPort::Pwm, RigPort::Pwm, true),
        (RigPort::Simulated, RigPort::Pwm, false),
        (RigPort::Pwm, RigPort::Simulated, false),
    ] {
        let mut store = Store::new(RamFlash::default(), 0);
        let record = Parameters { checked: true, port: stored, ..parameters(&presets::AERO2) };
        super::save(&mut store, &record, &mut [0; SLOT_SIZE]).unwrap();
        let (loaded, provenance) =
            super::load(&mut store, &mut [0; SLOT_SIZE], own, || panic!("one is stored"));
        assert_eq!((loaded.checked, loaded.port, provenance), (checked, own, Provenance::Stored));
    }
}
