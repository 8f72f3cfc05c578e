//! Short lessons: Markdown files that a teacher edits (`web/lessons/`), each with a task that is checked by
//! the numbers of the last two flights.
//!
//! The first line is the title. A line `- check: LEFT OP RIGHT` is a part of the task, where OP is `<`, `<=`,
//! `>`, `>=` or `is`. A side is a number, a word, or what a flight has, `last.` or `before.` and then
//! `pitch.ise` and the like of its report, `setting.` with a setting's name, or `law`, `rig`, `scenario`; and
//! it may be a number times that: `0.9 * before.pitch.ise`.

use crate::desk::flying::{Flights, Flown};
use serde::Serialize;
use serde_json::Value;

/// The lessons, in their order.
const TEXTS: [&str; 9] = [
    include_str!("../lessons/1-rotor-lag.md"),
    include_str!("../lessons/2-pitch-estimation.md"),
    include_str!("../lessons/3-filtering-a-rate.md"),
    include_str!("../lessons/4-pid-by-hand.md"),
    include_str!("../lessons/5-backstepping.md"),
    include_str!("../lessons/6-saturation.md"),
    include_str!("../lessons/7-disturbance.md"),
    include_str!("../lessons/8-tuning-by-search.md"),
    include_str!("../lessons/9-reaction-torque.md"),
];
/// What begins a part of a task.
const CHECK: &str = "- check: ";

/// A lesson with how far its task is.
#[derive(Debug, Serialize)]
pub struct Lesson {
    title: &'static str,
    paragraphs: Vec<String>,
    checks: Vec<Check>,
}

/// A part of a task.
#[derive(Debug, Serialize)]
pub struct Check {
    words: &'static str,
    met: bool,
    /// What the left side is now, if a flight has told.
    now: Option<String>,
}

/// All of them, by what was flown.
#[must_use]
pub fn lessons(flights: &Flights) -> Vec<Lesson> {
    TEXTS.iter().map(|text| lesson(text, flights)).collect()
}

fn lesson(text: &'static str, flights: &Flights) -> Lesson {
    let (title, body) = text.split_once('\n').unwrap_or((text, ""));
    let checks = body.lines().filter_map(|line| line.strip_prefix(CHECK));
    let prose: Vec<&str> = body.lines().filter(|line| !line.starts_with(CHECK)).collect();
    let prose = prose.join("\n");
    let paragraphs = prose.split("\n\n").map(|paragraph| paragraph.trim().replace('\n', " "));
    Lesson {
        title: title.trim_start_matches("# "),
        paragraphs: paragraphs.filter(|paragraph| !paragraph.is_empty()).collect(),
        checks: checks.map(|words| check(words, flights)).collect(),
    }
}

fn check(words: &'static str, flights: &Flights) -> Check {
    let mut parts = words.splitn(3, ' ');
    let [left, relation, right] = [parts.next(), parts.next(), parts.next()].map(Option::unwrap_or_default);
    let now = side(left, flights);
    let met = match (&now, side(right, flights)) {
        (Some(Value::String(now)), Some(Value::String(wanted))) => relation == "is" && *now == wanted,
        (Some(now), Some(wanted)) => match (now.as_f64(), wanted.as_f64()) {
            (Some(now), Some(wanted)) => compare(now, relation, wanted),
            _ => false,
        },
        _ => false,
    };
    Check { words, met, now: now.map(|now| short(&now)) }
}

fn compare(now: f64, relation: &str, wanted: f64) -> bool {
    match relation {
        "<" => now < wanted,
        "<=" => now <= wanted,
        ">" => now > wanted,
        ">=" => now >= wanted,
        _ => false,
    }
}

/// What a side of a check comes to, or nothing as long as no flight tells.
fn side(text: &str, flights: &Flights) -> Option<Value> {
    if let Ok(number) = text.parse::<f64>() {
        return Some(number.into());
    }
    if let Some((factor, name)) = text.split_once(" * ") {
        return Some((factor.parse::<f64>().ok()? * side(name, flights)?.as_f64()?).into());
    }
    let mut kept = flights.kept().iter().rev();
    match text.split_once('.') {
        Some(("last", name)) => of_flight(kept.next()?, name),
        Some(("before", name)) => of_flight(kept.nth(1)?, name),
        _ => Some(text.into()),
    }
}

fn of_flight(flown: &Flown, name: &str) -> Option<Value> {
    if let Some(setting) = name.strip_prefix("setting.") {
        return flown.flew.get(setting).map(Value::from);
    }
    match name {
        "law" => Some(flown.flew.law.kind().into()),
        "rig" => Some(flown.preset.as_str().into()),
        "scenario" => Some(flown.scenario.as_str().into()),
        _ => {
            let report = serde_json::to_value(flown.report).ok()?;
            report.pointer(&format!("/{}", name.replace('.', "/"))).cloned()
        }
    }
}

fn short(value: &Value) -> String {
    match (value.as_f64(), value) {
        (Some(number), _) => format!("{number:.4}"),
        (None, Value::String(word)) => word.clone(),
        (None, _) => "never".to_owned(),
    }
}

#[cfg(test)]
mod tests;
