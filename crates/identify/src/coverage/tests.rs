//! A few rigs, and what must hold of any study.

use super::*;
use crate::search::Effort;
use std::fs;
use std::sync::OnceLock;
use twinrotor::plant::presets::AERO2;
use twinrotor_sim::rig::NamedRig;
use twinrotor_tune::parallel::NEVER;

/// Few constants and a short flight: what is tested is the counting, not the fit.
fn study(seed: u64, rigs: usize) -> Study {
    let named = NamedRig { name: "aero2".to_owned(), rig: AERO2 };
    let fixed = ["effectiveness", "quadratic_effectiveness", "rotor_time_constant", "rotor_reaction"];
    let effort = Effort { population: 2, iterations: 0, seed };
    let question = Question::new(named, &[], &fixed.map(str::to_owned), 1.5, effort).unwrap();
    let gains = GainsFile { controller: twinrotor::defaults::AERO2, provenance: None };
    let scenario = Scenario::parse("short", &EXCITATION.replace("30.0", "9.0")).unwrap();
    Study::new(question, &gains, scenario, rigs, Scatter::default()).unwrap()
}

/// A study of four rigs, and what comes of it.
fn four() -> (Study, &'static [Verdict]) {
    static WHOLE: OnceLock<Vec<Verdict>> = OnceLock::new();
    let study = study(4, 4);
    let whole = WHOLE.get_or_init(|| study.verdicts(0..4, NEVER, &|| ()).unwrap());
    (study, whole)
}

#[test]
fn a_rigs_verdict_does_not_depend_on_its_neighbours() {
    let (study, whole) = four();
    // The two in the middle by themselves, without the one before them and the one behind.
    let alone = study.verdicts(1..3, NEVER, &|| ()).unwrap();
    let parts = [(1, alone), (3, whole[3..].to_vec()), (0, whole[..1].to_vec())];
    let mut joined = vec![Vec::new(); 4];
    for (first, verdicts) in parts {
        let bytes = study.encode(first, &verdicts);
        let (begins, read) = study.decode(&bytes).unwrap();
        assert_eq!(begins, first);
        for (k, verdict) in read.into_iter().enumerate() {
            joined[first + k] = vec![verdict];
        }
    }
    let joined: Vec<Verdict> = joined.into_iter().flatten().collect();
    assert_eq!(joined, whole);
    assert_eq!(study.report(&joined), study.report(whole));
    assert_eq!(study.verdicts(0..4, &|| true, &|| ()), None);
}

/// Every constant that is fitted is drawn, and each is found nearer to the truth than the preset has it.
#[test]
fn what_is_fitted_is_drawn_and_found() {
    let (study, verdicts) = four();
    let answered: Vec<_> = verdicts.iter().flatten().collect();
    assert!(answered.len() >= 3, "{verdicts:?}");
    let preset = to_array(&AERO2.plant);
    let place = study.question.free().iter().position(|k| CONSTANTS[*k].name == "stiffness").unwrap();
    let nominal = preset[study.question.free()[place]];
    for estimates in answered {
        let Estimate { truth, value, .. } = estimates[place];
        assert!((truth / nominal - 1.0).abs() <= 0.3 && truth != nominal, "{truth}");
        assert!((value - truth).abs() < 0.05 * truth, "{value} for {truth}");
    }
    for (k, (drawn, same)) in to_array(&study.truths[0].plant).into_iter().zip(preset).enumerate() {
        assert!(study.question.free().contains(&k) || drawn == same, "{}", CONSTANTS[k].name);
    }
}

#[test]
fn verdicts_of_another_study_are_refused() {
    let bytes = study(3, 5).encode(0, &[Err("it fell".to_owned())]);
    let told = study(4, 5).decode(&bytes).unwrap_err().to_string();
    assert_eq!(told, "belongs to another run: seed is 3 there, 4 here");
    let too_many = study(3, 5).encode(4, &vec![Err(String::new()); 2]);
    assert!(study(3, 5).decode(&too_many).is_err());
    let short = study(3, 5).encode(0, &[Ok(Vec::new())]);
    assert!(study(3, 5).decode(&short).is_err());
}

/// The flight that is studied is the one that is recommended.
#[test]
fn the_flight_is_the_documents() {
    let document =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/identify.md")).unwrap();
    assert!(document.contains(&format!("cat > excite.toml <<'END'\n{EXCITATION}END\n")));
}
