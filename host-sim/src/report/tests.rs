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
    Report { size: Size::QUICK, seed: 1, own: Vec::new(), summary: Vec::new(), sections }
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

/// Lab of a colour to eyes that see linear light through `cones` (D65).
fn lab(colour: [u8; 3], cones: [[f64; 3]; 3]) -> [f64; 3] {
    let linear = colour.map(|c| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    });
    let dot = |row: [f64; 3], of: [f64; 3]| row.iter().zip(of).map(|(a, b)| a * b).sum::<f64>();
    let seen = cones.map(|row| dot(row, linear).clamp(0.0, 1.0));
    let root = |t: f64| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
    let [x, y, z] = [
        dot([0.4124, 0.3576, 0.1805], seen) / 0.95047,
        dot([0.2126, 0.7152, 0.0722], seen),
        dot([0.0193, 0.1192, 0.9505], seen) / 1.08883,
    ]
    .map(root);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// In the light and in the dark, to everyone (Machado, Oliveira, Fernandes 2009, severity 1).
#[test]
fn any_two_series_of_a_figure_have_colours_that_can_be_told_apart() {
    let eyes = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    ];
    let style = include_str!("style.css");
    let themes: Vec<Vec<[u8; 3]>> = style
        .split(":root{")
        .skip(1)
        .map(|theme| {
            let of = |k: usize| {
                let hex = theme.split(&format!("--c{k}:#")).nth(1).unwrap().get(..6).unwrap();
                [0, 2, 4].map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap())
            };
            (0..twinrotor_plot::SERIES).map(of).collect()
        })
        .collect();
    assert_eq!(themes.len(), 2);
    let drawn: Vec<[u8; 3]> = twinrotor_plot::COLOURS.iter().map(|c| [c.0, c.1, c.2]).collect();
    assert_eq!(themes[0], drawn[..twinrotor_plot::SERIES], "a figure alone and on the page");
    for (theme, colours) in themes.iter().enumerate() {
        for (k, one) in colours.iter().enumerate() {
            for other in &colours[..k] {
                for cones in eyes {
                    let [a, b] = [one, other].map(|c| lab(*c, cones));
                    let apart = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                    assert!(apart > 20.0, "theme {theme}: {one:?} and {other:?} are {apart} apart");
                }
            }
        }
    }
    // Beyond six the stroke tells.
    let all: std::collections::BTreeSet<String> =
        (0..13).map(|k| format!("{:?}", twinrotor_plot::series(k))).collect();
    assert_eq!(all.len(), 13);
}

/// A table that does not fit says so, and how the page was made says with which controllers.
#[test]
fn a_wide_table_has_a_hint_and_the_command_its_controllers() {
    let grid = |columns: usize| Grid {
        name: format!("of-{columns}"),
        heads: (0..columns).map(|k| k.to_string().into()).collect(),
        rows: Vec::new(),
        note: String::new(),
    };
    let mut told = report(Vec::new());
    told.own = vec!["mine.toml".to_owned(), "lqi-plus".to_owned()];
    told.sections[0].measured = vec![grid(2), grid(6), grid(14)];
    let page = told.to_html().unwrap();
    assert!(page.contains("reproduce --quick --controllers mine.toml,lqi-plus --seed 1"), "{page}");
    assert_eq!(page.matches("<p class=\"hint\">").count(), 1);
    assert_eq!(page.matches("<p class=\"hint many\">").count(), 1);
}
