//! The paper reproduced: every table, figure and claim beside what this implementation gets, computed anew.

mod claims;
mod grid;
mod html;
mod measure;
mod responses;
mod rivals;
mod search;
mod tables;

use crate::error::Outcome;
use crate::files::output::Outputs;
pub use grid::Grid;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use twinrotor::controller::ControllerSettings;
use twinrotor_plot::Figure;

/// How a statement of the paper stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It comes out.
    Reproduced,
    /// It comes out under one reading of what the paper leaves open.
    WithinAmbiguity,
    /// It does not.
    NotReproduced,
    /// What was computed does not tell the two apart.
    Undecided,
    /// The paper says it in two ways: nothing to reproduce, but a choice to make.
    Contradictory,
    /// Nothing to reproduce: taken as it is printed.
    Given,
}

/// All there are.
const VERDICTS: [Verdict; 6] = [
    Verdict::Reproduced,
    Verdict::WithinAmbiguity,
    Verdict::NotReproduced,
    Verdict::Undecided,
    Verdict::Contradictory,
    Verdict::Given,
];

impl Verdict {
    fn of(holds: bool) -> Self {
        if holds { Self::Reproduced } else { Self::NotReproduced }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::WithinAmbiguity => "within its ambiguity",
            Self::NotReproduced => "not reproduced",
            Self::Undecided => "undecided",
            Self::Contradictory => "contradicts itself",
            Self::Given => "given",
        }
    }
}

/// One statement of the paper, and ours.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// What it is about.
    pub what: String,
    /// What the paper says.
    pub paper: String,
    /// What comes out here.
    pub ours: String,
    /// How they compare.
    pub verdict: Verdict,
    /// Why.
    pub remark: String,
}

fn entry(
    what: &str,
    paper: &str,
    ours: impl Into<String>,
    verdict: Verdict,
    remark: impl Into<String>,
) -> Entry {
    Entry {
        what: what.to_owned(),
        paper: paper.to_owned(),
        ours: ours.into(),
        verdict,
        remark: remark.into(),
    }
}

/// A picture with what it shows.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Its file's stem.
    pub name: String,
    /// Beneath it.
    pub caption: String,
    /// What is drawn.
    pub figure: Figure,
}

/// A table or figure of the paper, or a chapter of what it leaves out.
#[derive(Debug, Clone, Default)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// What one must know first.
    pub text: String,
    /// Statements.
    pub entries: Vec<Entry>,
    /// What was measured for them, where it is more than a statement holds.
    pub measured: Vec<Grid>,
    /// Pictures.
    pub pictures: Vec<Picture>,
}

/// How much is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Size {
    /// Seeds of each search.
    pub seeds: u64,
    /// Evaluations of each search when methods are compared.
    pub evaluations: usize,
    /// Plants of the fan.
    pub fan: usize,
    /// Evaluations of each round of tuning a controller of Table 6.
    pub tuning: usize,
    /// Rounds that each of them gets.
    pub rounds: usize,
    /// Rounds that they get at most, while one that loses is not done.
    pub most_rounds: usize,
    /// Times that each of them is tuned, each with another seed.
    pub tunings: u64,
    /// Plants that it is tested on.
    pub plants: usize,
}

impl Size {
    /// For a first look, in a second or two: it decides nothing about tuned controllers.
    pub const QUICK: Self = Self {
        seeds: 3,
        evaluations: 300,
        fan: 12,
        tuning: 60,
        rounds: 1,
        most_rounds: 1,
        tunings: 3,
        plants: 32,
    };
    /// What verdicts are worth.
    pub const FULL: Self = Self {
        seeds: 30,
        evaluations: 1550,
        fan: 60,
        tuning: 500,
        rounds: 4,
        most_rounds: 8,
        tunings: 3,
        plants: 300,
    };
}

/// Everything.
#[derive(Debug, Clone)]
pub struct Report {
    /// How much was computed.
    pub size: Size,
    /// Of everything random.
    pub seed: u64,
    /// Controllers of one's own that were asked for, as they were named.
    pub own: Vec<String>,
    /// The result, in three sentences.
    pub summary: Vec<String>,
    /// In the paper's order.
    pub sections: Vec<Section>,
}

impl Report {
    /// Computes all of it, with controllers of one's `own` as rows of Table 6. `seen` is told what comes
    /// next.
    ///
    /// # Errors
    ///
    /// If a flight or a search cannot be done.
    pub fn compute(
        size: Size,
        seed: u64,
        own: &[(String, ControllerSettings<f64>)],
        seen: &dyn Fn(&str),
    ) -> Outcome<Self> {
        let mut sections = Vec::new();
        seen("searching with every method");
        let searches = search::searches(size, seed)?;
        sections.push(search::table_1(&searches));
        seen("the paper's algorithm");
        sections.push(search::table_2(&searches, seed)?);
        sections.push(tables::table_3()?);
        sections.push(tables::table_4(&searches)?);
        seen("responses");
        sections.extend(responses::step()?);
        seen("tuning the rivals");
        sections.push(rivals::table_6(size, seed, own)?);
        sections.extend(responses::scenarios(seed)?);
        seen("claims");
        sections.push(claims::claims(&searches, seed)?);
        sections.push(claims::contradictions());
        sections.push(responses::fan(size, seed)?);
        let own = own.iter().map(|(name, _)| name.trim_end_matches(" (untuned)").to_owned()).collect();
        let mut report = Self { size, seed, own, summary: vec![], sections };
        report.summary = report.summarised(&searches);
        Ok(report)
    }

    fn summarised(&self, searches: &search::Searches) -> Vec<String> {
        let Tally {
            checked, reproduced, within_ambiguity, not_reproduced, undecided, contradictions, ..
        } = self.tally();
        let all_together = self.sections.iter().flat_map(|s| &s.entries).find(|e| e.what == rivals::ALL);
        let stands = match all_together.map(|e| e.verdict) {
            Some(Verdict::Reproduced) => "is better than",
            Some(Verdict::NotReproduced) => "is not better than",
            _ => "is undecided (why: Table 6) beside",
        };
        vec![
            format!(
                "Of {checked} statements that can be checked, {reproduced} come out, {within_ambiguity} do \
                 under one reading of what the paper leaves open, {not_reproduced} do not; undecided: \
                 {undecided}. In {contradictions} places the paper contradicts itself, which is counted \
                 apart."
            ),
            format!(
                "Table 4's gains are not what the paper's algorithm finds with the paper's model, objective \
                 and bounds: their cost is {:.0} % above the lowest known.",
                100.0 * (searches.paper / searches.best_known - 1.0)
            ),
            format!(
                "With rotor lag, encoders, delay and unknown constants the proposed controller {stands} \
                 the better of PID and LQR tuned in the same way{}.",
                all_together.map(|e| format!(": {}", e.ours)).unwrap_or_default()
            ),
        ]
    }

    /// Writes `index.html`, `report.json`, `statements.csv` and a CSV file for each figure into `folder`.
    ///
    /// # Errors
    ///
    /// If a figure cannot be drawn; `outputs` tells what cannot be written.
    pub fn write(&self, folder: &Path, outputs: &mut Outputs) -> Outcome<()> {
        outputs.write(&folder.join("index.html"), self.to_html()?.as_bytes());
        let json = serde_json::to_string_pretty(&self.document()).expect("plain data");
        outputs.write(&folder.join("report.json"), format!("{json}\n").as_bytes());
        outputs.write(&folder.join("statements.csv"), self.to_csv().as_bytes());
        data(&self.sections, folder, outputs);
        Ok(())
    }

    /// For `report.json`.
    pub fn document(&self) -> Document<'_> {
        let section = |s: &'_ Section| SectionDocument {
            title: s.title.clone(),
            entries: s.entries.clone(),
            measured: s.measured.clone(),
            figures: s.pictures.iter().map(|p| format!("{}.csv", p.name)).collect(),
        };
        Document {
            summary: &self.summary,
            tally: self.tally(),
            size: &self.size,
            seed: self.seed,
            version: env!("CARGO_PKG_VERSION"),
            sections: self.sections.iter().map(section).collect(),
        }
    }

    fn to_csv(&self) -> String {
        let mut text = String::from("section,what,paper,ours,verdict,remark\n");
        for section in &self.sections {
            for e in &section.entries {
                let cells =
                    [&section.title, &e.what, &e.paper, &e.ours, &e.verdict.words().to_owned(), &e.remark];
                let quoted = cells.map(|c| format!("\"{}\"", c.replace('"', "\"\"")));
                let _ = writeln!(text, "{}", quoted.join(","));
            }
        }
        text
    }

    /// How many statements there are of each kind.
    pub fn tally(&self) -> Tally {
        let of = |verdict: Verdict| {
            self.sections.iter().flat_map(|s| &s.entries).filter(|e| e.verdict == verdict).count()
        };
        let [reproduced, within_ambiguity, not_reproduced, undecided, contradictions, given] =
            VERDICTS.map(of);
        let checked = reproduced + within_ambiguity + not_reproduced + undecided;
        Tally { checked, reproduced, within_ambiguity, not_reproduced, undecided, contradictions, given }
    }
}

/// How many statements of the paper are of which kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// That can be checked: those of the four kinds that follow.
    pub checked: usize,
    /// That come out.
    pub reproduced: usize,
    /// That come out under one reading.
    pub within_ambiguity: usize,
    /// That do not.
    pub not_reproduced: usize,
    /// That were not told apart.
    pub undecided: usize,
    /// Places where the paper contradicts itself; no statements.
    pub contradictions: usize,
    /// Numbers taken as they are printed.
    pub given: usize,
}

impl Tally {
    /// In the order of the verdicts.
    fn by_verdict(self) -> [usize; VERDICTS.len()] {
        let Self { reproduced, within_ambiguity, not_reproduced, undecided, contradictions, given, .. } =
            self;
        [reproduced, within_ambiguity, not_reproduced, undecided, contradictions, given]
    }
}

/// Writes `index.html` with sections that are not the paper's, and a CSV file for each table and figure, into
/// `folder`.
///
/// # Errors
///
/// If a figure cannot be drawn; `outputs` tells what cannot be written.
pub fn write_page(
    title: &str,
    text: &str,
    sections: &[Section],
    folder: &Path,
    outputs: &mut Outputs,
) -> Outcome<()> {
    outputs.write(&folder.join("index.html"), html::page(title, text, sections)?.as_bytes());
    data(sections, folder, outputs);
    Ok(())
}

/// What tables and figures show, as files beside them.
fn data(sections: &[Section], folder: &Path, outputs: &mut Outputs) {
    for grid in sections.iter().flat_map(|s| &s.measured) {
        outputs.write(&folder.join(format!("{}.csv", grid.name)), grid.to_csv().as_bytes());
    }
    for picture in sections.iter().flat_map(|s| &s.pictures) {
        let path = folder.join(format!("{}.csv", picture.name));
        outputs.write(&path, picture.figure.to_csv().as_bytes());
    }
}

/// The report as data.
#[derive(Debug, Serialize)]
pub struct Document<'a> {
    summary: &'a [String],
    tally: Tally,
    size: &'a Size,
    seed: u64,
    version: &'static str,
    sections: Vec<SectionDocument>,
}

#[derive(Debug, Serialize)]
struct SectionDocument {
    title: String,
    entries: Vec<Entry>,
    measured: Vec<Grid>,
    figures: Vec<String>,
}

#[cfg(test)]
mod tests;
