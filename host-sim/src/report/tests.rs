//! What the report says, held against what it says it of.

use super::*;
use twinrotor::gains::Gains;
use twinrotor::plant::presets::PAPER;
use twinrotor_sim::gains_file::GainsFile;

fn statement(what: &str, verdict: Verdict) -> Entry {
    entry(what, "", "", verdict, "")
}

fn report(entries: Vec<Entry>) -> Report {
    let sections = vec![Section { entries, ..Section::default() }, claims::contradictions()];
    Report { size: Size::QUICK, seed: 1, summary: Vec::new(), sections }
}

/// A place where the paper contradicts itself, or a number that is only taken over, is nothing that could
/// come out.
#[test]
fn contradictions_and_given_numbers_are_no_statements_that_were_checked() {
    let told = report(vec![
        statement("a", Verdict::Reproduced),
        statement("b", Verdict::WithinAmbiguity),
        statement("c", Verdict::NotReproduced),
        statement("d", Verdict::Undecided),
        statement("e", Verdict::Given),
    ]);
    let tally = told.tally();
    assert_eq!((tally.checked, tally.given), (4, 1));
    assert_eq!(tally.contradictions, claims::contradictions().entries.len());
    assert_eq!(tally.by_verdict().iter().sum::<usize>(), 5 + tally.contradictions);
}

/// Nor does any statement stand in the report twice.
#[test]
fn each_contradiction_is_listed_once() {
    let mut sections = responses::scenarios(1).unwrap();
    sections.extend(responses::step().unwrap());
    for entry in sections.iter().flat_map(|s| &s.entries) {
        assert!(!entry.remark.contains("disagree"), "{}: {}", entry.what, entry.remark);
    }
}

/// What the remark on Table 5's overshoot says of gains in general.
#[test]
fn gains_that_differ_by_less_than_two_overshoot_and_others_do_not() {
    let overshoot = |gains: [f64; 4]| {
        let file = GainsFile::backstepping(Gains::from_paper_order(gains));
        let report = measure::fly(&PAPER, &file, "step", 1).unwrap().report;
        [report.pitch.overshoot_percent.unwrap(), report.yaw.overshoot_percent.unwrap()]
    };
    for percent in overshoot([1.0; 4]) {
        assert!((percent - 4.3).abs() < 0.1, "{percent}");
    }
    assert!(overshoot([1.0, 1.5, 1.5, 1.0]).iter().all(|percent| *percent > 0.5));
    assert!(overshoot([1.0, 3.0, 3.1, 1.0]).iter().all(|percent| *percent < 0.01));
    let [k1, k2, k3, k4] = twinrotor::gains::PAPER.to_paper_order();
    assert_eq!([(k2 - k1).round(), (10.0 * (k4 - k3)).round()], [20.0, 85.0]);
}

/// Few rounds decide nothing about tuned controllers; what the headline says is what Table 6 says, in the
/// numbers that stand in its table.
#[test]
fn few_rounds_decide_nothing_and_the_headline_is_the_tables() {
    let size = Size { tuning: 10, plants: 32, ..Size::QUICK };
    let section = rivals::table_6(size, 1, &[]).unwrap();
    for what in ["tracking", "disturbance robustness", rivals::ALL] {
        let entry = section.entries.iter().find(|e| e.what.starts_with(what)).unwrap();
        assert_eq!(entry.verdict, Verdict::Undecided, "{entry:?}");
        assert!(entry.remark.contains("1 of 4 rounds"), "{entry:?}");
    }
    let [rivals, tunings] = &section.measured[..] else { panic!("two tables") };
    let of_j = |name: &str| {
        let row = rivals.rows.iter().find(|row| row[0].contains(name)).unwrap();
        row[2].split(' ').next().unwrap().parse::<f64>().unwrap()
    };
    let proposed = of_j("Table 4").min(of_j("FPA, tuned here"));
    let ours = &section.entries.iter().find(|e| e.what == rivals::ALL).unwrap().ours;
    let told = ours.split(' ').next().unwrap().parse::<f64>().unwrap();
    assert!((told - proposed).abs() < 0.02, "{ours} beside {:?}", rivals.rows);
    assert_eq!(tunings.rows.len(), 9);
    assert!(tunings.rows.iter().any(|row| row[7].contains(" bound ")), "{:?}", tunings.rows);
}

/// A verdict is only given against a side whose tunings have come to their end; what has not gets more rounds
/// first, as many for all.
#[test]
fn no_verdict_is_given_against_who_is_at_a_bound() {
    let size = Size { tuning: 15, rounds: 4, most_rounds: 5, plants: 32, ..Size::QUICK };
    let section = rivals::table_6(size, 1, &[]).unwrap();
    let all = section.entries.iter().find(|e| e.what == rivals::ALL).unwrap();
    let rows = &section.measured[1].rows;
    let done = |name: &str| {
        let mut of = rows.iter().filter(|row| row[0].starts_with(name));
        of.all(|row| row[5] == "0" && row[7] == "no")
    };
    assert!(rows.iter().all(|row| row[2] == rows[0][2]), "{rows:?}");
    match all.verdict {
        Verdict::Reproduced => assert!(done("PID") && done("LQR"), "{rows:?}"),
        Verdict::NotReproduced => assert!(done("Proposed"), "{rows:?}"),
        _ => {
            assert_eq!(rows[0][2], "5", "{rows:?}");
            assert!(all.remark.contains("is not done") || !all.remark.contains("open"), "{}", all.remark);
        }
    }
}
