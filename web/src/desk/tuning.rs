//! The controllers of a desk: the one that is being drawn up, the accepted one, the one that is kept, and
//! those that were tried.

use serde::Serialize;
use twinrotor::controller::ControllerSettings;
use twinrotor::settings::Field;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::{Error, Outcome};

/// What belongs to no law.
const AROUND: [&str; 5] = ["estimator", "filter", "allocation", "lead", "cancellation"];

/// The controllers.
#[derive(Debug, Clone)]
pub struct Tuning {
    /// Drawn up by whoever moves the sliders.
    pub draft: ControllerSettings<f64>,
    /// Flies, or will after arming.
    pub accepted: ControllerSettings<f64>,
    /// In the board's flash.
    pub saved: ControllerSettings<f64>,
    tried: Vec<ControllerSettings<f64>>,
    name: String,
}

/// A setting as a slider needs it.
#[derive(Debug, Serialize)]
pub struct Row {
    name: &'static str,
    part: &'static str,
    unit: &'static str,
    doc: &'static str,
    allowed: &'static str,
    /// What the slider offers; a number that is typed may lie beyond, within what is allowed.
    typical: [f64; 2],
    switch: bool,
    draft: f64,
    accepted: Option<f64>,
    saved: Option<f64>,
}

/// A controller that was tried, by what it had otherwise than the one before.
#[derive(Debug, Serialize)]
pub struct Tried {
    number: usize,
    words: String,
}

/// All that the page shows of it.
#[derive(Debug, Serialize)]
pub struct Document {
    name: String,
    law: String,
    rows: Vec<Row>,
    tried: Vec<Tried>,
    changed: usize,
}

impl Tuning {
    /// One controller for everything, called `name`.
    #[must_use]
    pub fn new(name: &str, controller: ControllerSettings<f64>) -> Self {
        Self {
            draft: controller,
            accepted: controller,
            saved: controller,
            tried: Vec::new(),
            name: name.to_owned(),
        }
    }

    /// Sets a number of the draft.
    ///
    /// # Errors
    ///
    /// If there is none of that name, or the number is not allowed.
    pub fn set(&mut self, name: &str, value: f64) -> Outcome<()> {
        if self.draft.set(name, value)? {
            return Ok(());
        }
        Err(Error::invalid("setting", name, "one that this controller has"))
    }

    /// The draft becomes another controller, called `name`.
    pub fn draw(&mut self, name: &str, controller: ControllerSettings<f64>) {
        name.clone_into(&mut self.name);
        self.draft = controller;
    }

    /// The draft is tried.
    pub fn try_draft(&mut self) {
        if self.tried.last() != Some(&self.draft) {
            self.tried.push(self.draft);
        }
    }

    /// What is tried is accepted.
    pub fn accept(&mut self) {
        if let Some(tried) = self.tried.last() {
            self.accepted = *tried;
        }
    }

    /// Back to one that was tried; 0 is the accepted one.
    ///
    /// # Errors
    ///
    /// If there was none of that number.
    pub fn recall(&mut self, number: usize) -> Outcome<()> {
        self.draft = match number.checked_sub(1) {
            None => self.accepted,
            Some(index) => *self
                .tried
                .get(index)
                .ok_or_else(|| Error::invalid("trial", number, format_args!("0 to {}", self.tried.len())))?,
        };
        Ok(())
    }

    /// The controller in force, with what an operator calls it.
    #[must_use]
    pub fn in_force(&self, trial: bool) -> (String, ControllerSettings<f64>) {
        match self.tried.last() {
            Some(tried) if trial => (format!("trial {}", self.tried.len()), *tried),
            _ if self.accepted == self.saved => (format!("{} as saved", self.name), self.accepted),
            _ => (format!("{} as accepted", self.name), self.accepted),
        }
    }

    /// The draft as a gains file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        GainsFile { controller: self.draft, provenance: None }.to_toml()
    }

    /// For the page.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut rows = Vec::new();
        let same_law = |other: &ControllerSettings<f64>| law(other) == law(&self.draft);
        let of = |other: &ControllerSettings<f64>, name: &str| {
            other.get(name).filter(|_| part(name) != "law" || same_law(other))
        };
        self.draft.visit(|field: &'static Field, draft| {
            rows.push(Row {
                name: field.name,
                part: part(field.name),
                unit: field.unit,
                doc: field.doc,
                allowed: field.range.allowed(),
                typical: field.typical,
                switch: field.range == twinrotor::settings::Range::Switch,
                draft,
                accepted: of(&self.accepted, field.name),
                saved: of(&self.saved, field.name),
            });
        });
        let before = std::iter::once(&self.saved).chain(&self.tried);
        let tried = before.zip(&self.tried).zip(1..);
        Document {
            name: self.name.clone(),
            law: law(&self.draft).to_owned(),
            changed: rows.iter().filter(|row| row.accepted != Some(row.draft)).count(),
            rows,
            tried: tried
                .map(|((before, now), number)| Tried { number, words: change(before, now) })
                .collect(),
        }
    }
}

/// To what a setting belongs.
fn part(name: &str) -> &'static str {
    let belongs = |part: &&str| name.strip_prefix(*part).is_some_and(|rest| rest.starts_with('.'));
    AROUND.into_iter().find(belongs).unwrap_or("law")
}

/// The kind of its law, as gains files spell it.
fn law(controller: &ControllerSettings<f64>) -> &'static str {
    controller.law.kind()
}

/// What `now` has otherwise than `before`, in a few words.
fn change(before: &ControllerSettings<f64>, now: &ControllerSettings<f64>) -> String {
    if law(before) != law(now) {
        return format!("another law: {}", law(now));
    }
    let mut changes = Vec::new();
    now.visit(|field, value| {
        if before.get(field.name) != Some(value) {
            changes.push(format!("{} = {value:.3}", field.name));
        }
    });
    match changes.as_slice() {
        [] => "the same".to_owned(),
        [first, second, third, rest @ ..] if !rest.is_empty() => {
            format!("{first}, {second}, {third} and {} more", rest.len())
        }
        few => few.join(", "),
    }
}
