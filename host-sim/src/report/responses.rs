//! Figures 4a to 9 and Table 5: what flies.

use super::measure::{errors, fly, fly_in, peak_deg, pitch, rms_deg, within_deg, yaw};
use super::{Picture, Section, Size, Verdict, entry};
use crate::error::Outcome;
use crate::figures;
use crate::files;
use rayon::prelude::*;
use twinrotor::plant::presets::{self, PAPER, Rig};
use twinrotor_plot::flight::flight as flight_figure;
use twinrotor_plot::{Figure, Line, Stroke};
use twinrotor_sim::flight::{Fidelity, Flight};
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::scenario::Scenario;
use twinrotor_tune::robust;

/// The panels of a flight that `wanted` names by their place in [`flight_figure`].
fn panels(title: &str, flight: &Flight, until: f64, wanted: &[usize]) -> Figure {
    // Jumps come at whole seconds: what is left out is smooth.
    let thin = if until > 10.0 { 10 } else { 1 };
    let shown = Flight {
        rows: flight.rows.iter().copied().step_by(thin).filter(|r| r.time <= until).collect(),
        report: flight.report,
        board: flight.board,
        left_envelope: flight.left_envelope,
    };
    let whole = flight_figure(title, &shown, PAPER.volts_limit);
    Figure { panels: wanted.iter().map(|k| whole.panels[*k].clone()).collect(), ..whole }
}

/// The same with what the paper says as rings: where it says so, and in its words.
fn marked(mut figure: Figure, panel: usize, marks: &[(f64, f64, &str)]) -> Figure {
    let panel = &mut figure.panels[panel];
    panel.lines.push(Line {
        name: "the paper says".to_owned(),
        points: marks.iter().map(|(x, y, _)| (*x, *y)).collect(),
        colour: 6,
        stroke: Stroke::Rings,
    });
    panel.labels.extend(marks.iter().map(|(x, y, words)| (*x, *y, format!("  {words}"))));
    figure
}

fn picture(name: &str, caption: &str, figure: Figure) -> Picture {
    Picture { name: name.to_owned(), caption: caption.to_owned(), figure }
}

/// The paper's helicopter with the main motor's own thrust gain as the manufacturer has it, or nearly.
fn with_main_gain(gain: f64) -> Rig {
    let mut rig = PAPER;
    rig.plant.effectiveness.main_on_pitch = gain;
    rig
}

/// Fig. 4a with Table 5, and Fig. 5.
pub(super) fn step() -> Outcome<Vec<Section>> {
    let flown = fly(&PAPER, &GainsFile::paper(), "step", 1)?;
    Ok(vec![table_5(&flown), fig_5(&flown)?])
}

fn table_5(flown: &Flight) -> Section {
    let report = &flown.report;
    let settled = |time: Option<f64>| time.unwrap_or(f64::INFINITY);
    let [p2, p5] = [report.pitch.settling_time_2, report.pitch.settling_time_5].map(settled);
    let [y2, y5] = [report.yaw.settling_time_2, report.yaw.settling_time_5].map(settled);
    let near = |value: f64, paper: f64| (value / paper - 1.0).abs() < 0.1;
    let overshoot = |o: Option<f64>| o.unwrap_or(f64::INFINITY);
    let entries = vec![
        entry(
            "settling time, pitch",
            "0.9 s",
            format!("{p2:.3} s at 2 %, {p5:.3} s at 5 %"),
            if near(p2, 0.9) || near(p5, 0.9) { Verdict::WithinAmbiguity } else { Verdict::NotReproduced },
            "the paper names no band; .9 s is the time at a band of 2.7 %",
        ),
        entry(
            "settling time, yaw",
            "1.4 s",
            format!("{y2:.3} s at 2 %, {y5:.3} s at 5 %"),
            if near(y2, 1.4) || near(y5, 1.4) { Verdict::WithinAmbiguity } else { Verdict::NotReproduced },
            "only the 5 % band comes near, while pitch is nearest with 2 %: the bands are mixed",
        ),
        entry(
            "overshoot, pitch and yaw",
            "0 %",
            format!(
                "{:.3} %, {:.3} %",
                overshoot(report.pitch.overshoot_percent),
                overshoot(report.yaw.overshoot_percent)
            ),
            Verdict::of(
                overshoot(report.pitch.overshoot_percent).max(overshoot(report.yaw.overshoot_percent)) < 0.05,
            ),
            "not the search's merit: with no motor at its limit an axis has the poles of s² + (μ1 + μ2) s + \
             1 + μ1 μ2 and overshoots only where its two gains differ by less than 2, by 4.3 % where both \
             are 1, the least allowed; Table 4's differ by 20 and by 8.5",
        ),
        entry(
            "steady error, pitch",
            "0.02°",
            format!(
                "{:.1e}° after 5 s; it passes .02° at {:.2} s",
                report.pitch.final_error_deg.abs(),
                within_deg(flown, 0.02, pitch)
            ),
            Verdict::WithinAmbiguity,
            "the error goes to zero; .02° is a reading on the way",
        ),
        entry(
            "steady error, yaw",
            "0.007°",
            format!(
                "{:.1e}° after 5 s; it passes .007° at {:.2} s",
                report.yaw.final_error_deg.abs(),
                within_deg(flown, 0.007, yaw)
            ),
            Verdict::WithinAmbiguity,
            "likewise, but read at another time: no single time gives both",
        ),
    ];
    Section {
        title: "Table 5 and Fig. 4a: the step".to_owned(),
        text: "15° of pitch and 40° of yaw from rest, Table 4's gains, Table 3's constants, ±24 V, held for \
            1 ms."
            .to_owned(),
        entries,
        measured: vec![],
        pictures: vec![picture(
            "fig-4a-responses",
            "Fig. 4a: pitch and yaw step responses, with Table 5's settling times as rings.",
            marked(
                panels("Fig. 4a: step responses", flown, 3.0, &[0]),
                0,
                &[(0.9, 15.0, "settled, .9 s"), (1.4, 40.0, "settled, 1.4 s")],
            ),
        )],
    }
}

fn fig_5(flown: &Flight) -> Outcome<Section> {
    let saturated = |f: &Flight| 1e3 * f.report.main.saturation_time.max(f.report.tail.saturation_time);
    let ms = saturated(flown);
    let alternatives = [0.0022, 0.0011].map(|gain| {
        let rig = with_main_gain(gain);
        fly(&rig, &GainsFile::paper(), "step", 1).map(|f| (gain, saturated(&f)))
    });
    let [a, b] = alternatives;
    let (a, b) = (a?, b?);
    let peak = flown.rows.iter().map(|r| r.volts.main.abs().max(r.volts.tail.abs())).fold(0.0, f64::max);
    let at = flown.rows.iter().find(|r| r.time >= 0.8).map(errors).unwrap_or(errors(&flown.rows[0]));
    let (left_pitch, left_yaw) = (at.pitch.to_degrees().abs(), at.yaw.to_degrees().abs());
    let entries = vec![
        entry(
            "volts stay within ±24 V",
            "yes",
            format!("peak {peak:.1} V"),
            Verdict::of(peak <= 24.0),
            "they are clamped there",
        ),
        entry(
            "saturation at the start",
            "< 8 ms",
            format!(
                "{ms:.0} ms with Table 3; {:.0} ms with k_pp = {}; {:.0} ms with k_pp = {}",
                a.1, a.0, b.1, b.0
            ),
            if ms < 8.0 {
                Verdict::Reproduced
            } else if b.1 < 8.0 {
                Verdict::WithinAmbiguity
            } else {
                Verdict::NotReproduced
            },
            "Table 3 does not give it, ten to twenty times less k_pp does: .022 is probably a misprint of \
             the manufacturer's .0011",
        ),
        entry(
            "both errors are about 0° after 0.8 s",
            "≈ 0°",
            format!("{left_pitch:.2}° of pitch and {left_yaw:.2}° of yaw are left"),
            Verdict::of(left_pitch < 0.1 && left_yaw < 0.1),
            "yaw settles at half the speed; Table 5 itself says 1.4 s",
        ),
    ];
    Ok(Section {
        title: "Fig. 5: volts and squared errors".to_owned(),
        text: String::new(),
        entries,
        measured: vec![],
        pictures: vec![picture(
            "fig-5-volts-errors",
            "Fig. 5: input voltages with their limits, and squared errors; a ring where the paper's are 0.",
            marked(
                panels("Fig. 5: volts and squared errors of the step", flown, 2.0, &[1, 2]),
                1,
                &[(0.8, 0.0, "both 0, .8 s")],
            ),
        )],
    })
}

/// Figs 6 to 9.
pub(super) fn scenarios(seed: u64) -> Outcome<Vec<Section>> {
    Ok(vec![fig_6()?, fig_7()?, figs_8_9(seed)?])
}

fn fig_6() -> Outcome<Section> {
    let flown = fly(&PAPER, &GainsFile::paper(), "1", 1)?;
    let (p, y) = (peak_deg(&flown, [3.0, 41.0], pitch), peak_deg(&flown, [3.0, 41.0], yaw));
    Ok(Section {
        title: "Fig. 6: scenario 1".to_owned(),
        text: "Pitch held at 20°, yaw along 40° sin(.08 t).".to_owned(),
        entries: vec![
            entry(
                "yaw follows the sine with almost no error",
                "almost zero",
                format!("at most {y:.4}° from 3 s on"),
                Verdict::of(y < 0.1),
                "the model is exact, the state known and the reference slow: .5 rad/min",
            ),
            entry(
                "pitch is not disturbed by yaw",
                "not disturbed",
                format!("at most {p:.4}° from 3 s on"),
                Verdict::of(p < 0.01),
                "the law cancels the coupling exactly",
            ),
        ],
        measured: vec![],
        pictures: vec![picture(
            "fig-6-scenario-1",
            "Fig. 6: pitch step and yaw sine.",
            panels("Fig. 6: scenario 1", &flown, 40.0, &[0, 1]),
        )],
    })
}

/// \[deg\] Largest pitch error in the second after each yaw jump, beyond what it was just before.
fn deviations(flown: &Flight) -> [f64; 4] {
    [8.0, 16.0, 24.0, 32.0].map(|jump| {
        let before = peak_deg(flown, [jump - 0.1, jump], pitch);
        (peak_deg(flown, [jump, jump + 1.0], pitch) - before).max(0.0)
    })
}

fn fig_7() -> Outcome<Section> {
    let flown = fly(&PAPER, &GainsFile::paper(), "2", 1)?;
    let aero = fly(&presets::AERO, &GainsFile::paper(), "2", 1)?;
    let most = |f: &Flight| deviations(f).into_iter().fold(0.0, f64::max);
    let (ours, real) = (most(&flown), most(&aero));
    let overshoot = flown.report.yaw.overshoot_percent.unwrap_or(f64::INFINITY);
    Ok(Section {
        title: "Fig. 7: scenario 2".to_owned(),
        text:
            "Pitch held at 10°, yaw by eq. (35): jumps at 8, 16, 24 and 32 s, where the text has 23 and 30 s."
                .to_owned(),
        entries: vec![
            entry(
                "yaw follows without overshoot",
                "no overshoot",
                format!("{overshoot:.4} %"),
                Verdict::of(overshoot < 0.05),
                "",
            ),
            entry(
                "pitch deviates a little at each yaw jump, by the model's coupling",
                "small, gone in 10 to 20 ms",
                format!("{ours:.1e}° with Table 3; {real:.2}° with the manufacturer's constants"),
                Verdict::of(ours > 0.01),
                "the law cancels the coupling and no motor reaches its limit; with the manufacturer's thrust \
                 gains one does, and then the deviation lasts a second",
            ),
        ],
        measured: vec![],
        pictures: vec![picture(
            "fig-7-scenario-2",
            "Fig. 7: pitch step and yaw square.",
            panels("Fig. 7: scenario 2", &flown, 40.0, &[0, 1]),
        )],
    })
}

fn figs_8_9(seed: u64) -> Outcome<Section> {
    let constant = fly(&PAPER, &GainsFile::paper(), "3", seed)?;
    let square = fly(&PAPER, &GainsFile::paper(), "3-square", seed)?;
    let rms = |range| (rms_deg(&constant, range, pitch), rms_deg(&constant, range, yaw));
    let (during, after) = (rms([3.0, 20.0]), rms([25.0, 41.0]));
    let scenario = files::scenario("3")?;
    let disturbance = scenario.disturbance.unwrap_or(twinrotor_sim::scenario::Disturbance {
        volts: 0.0,
        hold: 0.0,
        window: [0.0; 2],
    });
    Ok(Section {
        title: "Figs 8 and 9: scenario 3, disturbed".to_owned(),
        text: format!(
            "Scenario 1 with random volts on both motors for 20 s, by eqs (38)-(39), where the text has \
             them after 20 s. The paper gives neither their size nor how long each value holds, and the \
             errors grow with both; here ±{} V, {} s. Pitch is flown constant, as eq. (36) has it, and \
             square, as the text at Fig. 9 has it.",
            disturbance.volts, disturbance.hold
        ),
        entries: vec![
            entry(
                "responses remain stable under disturbance",
                "stable",
                format!("RMS error {:.3}° of pitch, {:.3}° of yaw from 3 to 20 s", during.0, during.1),
                Verdict::of(during.0 < 5.0 && during.1 < 5.0),
                "nothing in the law rejects a disturbance: it has no integral and no observer; the loop's \
                 stiffness holds the error down",
            ),
            entry(
                "they return when it ends at 20 s",
                "quickly",
                format!("RMS error {:.1e}° and {:.1e}° from 25 s on", after.0, after.1),
                Verdict::of(after.0 < 0.02 && after.1 < 0.02),
                "",
            ),
        ],
        measured: vec![],
        pictures: vec![
            picture("fig-8-disturbance", "Fig. 8: the disturbance of each motor.", disturbances(&constant)),
            picture(
                "fig-9-responses",
                "Fig. 9 by eq. (36): pitch constant.",
                panels("Fig. 9, eq. (36): disturbed, pitch constant", &constant, 40.0, &[0]),
            ),
            picture(
                "fig-9-square",
                "Fig. 9 by its text: pitch square.",
                panels("Fig. 9, text: disturbed, pitch square", &square, 40.0, &[0]),
            ),
        ],
    })
}

fn disturbances(flown: &Flight) -> Figure {
    figures::over_time(
        "Fig. 8: disturbances",
        "added volts [V]",
        &flown.rows,
        &[("on the main motor δp", |r| r.disturbance.main), ("on the tail motor δy", |r| r.disturbance.tail)],
    )
}

/// What the paper leaves out: many plants, in the rig's world.
pub(super) fn fan(size: Size, seed: u64) -> Outcome<Section> {
    let draws = robust::draw(&PAPER, size.fan, seed);
    let mut step = Scenario::named("step")?;
    step.duration = 3.0;
    let fly_one = |draw: &robust::Draw| {
        let rig = Rig { plant: draw.plant, ..PAPER };
        fly_in(&rig, &PAPER, &GainsFile::paper(), &step, Fidelity::Rig, seed)
    };
    let flights: Vec<Outcome<Flight>> = draws.par_iter().map(fly_one).collect();
    let flown: Vec<&Flight> = flights.iter().flatten().collect();
    let settled =
        |f: &&&Flight| f.report.pitch.settling_time_5.is_some() && f.report.yaw.settling_time_5.is_some();
    let count = flown.iter().filter(settled).count();
    let most = |of: fn(&Flight) -> Option<f64>| flown.iter().filter_map(|f| of(f)).fold(0.0, f64::max);
    let (over_pitch, over_yaw) =
        (most(|f| f.report.pitch.overshoot_percent), most(|f| f.report.yaw.overshoot_percent));
    Ok(Section {
        title: "Beyond the paper: a fan over plants".to_owned(),
        text: format!(
            "Table 4's gains on {} plants around Table 3 (inertias, dampings and thrust gains ±30 %, rotor \
             lag .05 s ±70 %), with encoder counts, estimated rates and a tick of delay.",
            size.fan
        ),
        entries: vec![entry(
            "robustness to modelling uncertainty",
            "claimed, not tested",
            format!(
                "{count} of {} settle within 5 % in 3 s: the part of all that does not is below {:.1} %, \
                 95 % sure; overshoot up to {over_pitch:.1} % of pitch, {over_yaw:.1} % of yaw",
                size.fan,
                100.0 * robust::upper_bound(size.fan - count, size.fan)
            ),
            Verdict::of(count == size.fan),
            "",
        )],
        measured: vec![],
        pictures: vec![picture(
            "fan",
            "The step: the median of all plants, and the band that holds nine tenths of them.",
            figures::fan("The step on many plants, in the rig's world", &flown),
        )],
    })
}
