//! Where in a gains file is what a law's reader does not take.
//!
//! What is read beside other tables comes to its reader without its place. So a text that was refused is read
//! once more, table by table, each with its place.

use crate::error::Error;
use crate::state_space;
use serde::Deserialize;
use toml::de::{DeTable, DeValue, Deserializer, ValueDeserializer};
use twinrotor::law::{LawSettings, MOST_STATES};

/// A gains file's tables that are no law's.
const AROUND: [&str; 7] =
    ["controller", "allocation", "estimator", "filter", "lead", "cancellation", "provenance"];

/// What is wrong with the law in the text called `name`, with its line and field; nothing where nothing is,
/// or where no law of matrices is read, as in a page, which has no room for this either.
pub(crate) fn located(name: &str, text: &str) -> Option<Error> {
    if MOST_STATES == 0 {
        return None;
    }
    let whole = DeTable::parse(text).ok()?;
    let span = whole.span();
    let whole = whole.into_inner();
    let controller = whole.get("controller")?;
    let (kind, its_place) = (controller.get_ref().as_str()?.to_owned(), controller.span());
    let law = whole.iter().filter(|(key, _)| !AROUND.contains(&key.get_ref().as_ref()));
    let law: DeTable<'_> = law.map(|(key, value)| (key.clone(), value.clone())).collect();
    let at = |byte: usize, what: &str| {
        let line = 1 + text.get(..byte).unwrap_or(text).matches('\n').count();
        Error::Unusable(what.replace('\n', "; ")).within(format_args!("{name}, line {line}"))
    };
    let refused = |error: &toml::de::Error| {
        let byte = error.span().map_or(its_place.start, |span| span.start);
        let field = field_at(&whole, byte);
        let message = error.message();
        let colon = if field.is_empty() || message.starts_with(&field) { "" } else { ": " };
        at(byte, &if colon.is_empty() { message.to_owned() } else { format!("{field}{colon}{message}") })
    };
    if kind == state_space::NAME {
        let table = ValueDeserializer::from(law.get(kind.as_str())?.clone());
        if let Some((other, _)) = law.iter().find(|(key, _)| key.get_ref() != kind.as_str()) {
            let what = format!(
                "unknown field `{}`: a law of matrices has the table `{kind}` alone",
                other.get_ref()
            );
            return Some(at(other.span().start, &what));
        }
        return match state_space::Document::deserialize(table) {
            Err(error) => Some(refused(&error)),
            Ok(document) => {
                let error = document.gains().err()?;
                let Error::Invalid { field, .. } = &error else { return None };
                Some(at(byte_of(&whole, field).unwrap_or(its_place.start), &error.to_string()))
            }
        };
    }
    let mut named = DeTable::new();
    let kind = toml::Spanned::new(its_place.clone(), kind.into());
    named.insert(kind, toml::Spanned::new(span.clone(), DeValue::Table(law)));
    let error = LawSettings::<f64>::deserialize(Deserializer::from(toml::Spanned::new(span, named))).err()?;
    Some(refused(&error))
}

/// The field of a table that holds `byte`, such as `state-space.A[1][0]`: as far down as there is one.
fn field_at(table: &DeTable<'_>, byte: usize) -> String {
    fn below(value: &DeValue<'_>, byte: usize, path: &mut String) -> bool {
        match value {
            DeValue::Table(table) => table.iter().any(|(key, value)| {
                let before = path.len();
                path.push_str(if path.is_empty() { "" } else { "." });
                path.push_str(key.get_ref());
                // What is in a table that is written in parts may lie outside of what is called its place.
                let there = below(value.get_ref(), byte, path)
                    || key.span().contains(&byte)
                    || value.span().contains(&byte);
                if !there {
                    path.truncate(before);
                }
                there
            }),
            DeValue::Array(list) => list.iter().enumerate().any(|(k, value)| {
                let there = value.span().contains(&byte);
                if there {
                    path.push_str(&format!("[{k}]"));
                    below(value.get_ref(), byte, path);
                }
                there
            }),
            _ => false,
        }
    }
    let mut path = String::new();
    below(&DeValue::Table(table.clone()), byte, &mut path);
    path
}

/// Where the value of a field such as `state-space.A[1][0]` begins, or the last part of it that is there.
fn byte_of(table: &DeTable<'_>, field: &str) -> Option<usize> {
    let mut found = None;
    let whole = DeValue::Table(table.clone());
    let mut here = &whole;
    for part in field.split(['.', '[']) {
        let next = match part.strip_suffix(']') {
            Some(number) => number.parse::<usize>().ok().and_then(|number| here.get(number)),
            None => here.get(part),
        };
        let Some(next) = next else { break };
        found = Some(next.span().start);
        here = next.get_ref();
    }
    found
}

#[cfg(test)]
mod tests {
    use crate::gains_file::GainsFile;

    const MATRICES: &str = "\
controller = \"state-space\"

[state-space]
inputs = [\"angle_error.pitch\", \"angle_error.yaw\"]
outputs = [\"volts.main\", \"volts.tail\"]
sample_time = 0.001
A = [[1.0, 0.0],
     [0.0, 1.0]]
B = [[0.001, 0.0], [0.0, 0.001]]
C = [[20.0, 0.0], [0.0, 20.0]]
D = [[60.0, 0.0], [0.0, 60.0]]
anti_windup = \"hold\"
";
    const PAPERS: &str = "\
controller = \"backstepping\"

[pitch]
position = 3.0
rate = 20.0

[yaw]
position = 1.0
rate = 3.0
";

    #[test]
    fn what_is_wrong_with_a_law_is_told_with_its_line_and_field() {
        let cases = [
            (
                MATRICES,
                "0.001, 0.0]",
                "\"x\", 0.0]",
                "line 9: state-space.B[0][0]: invalid type: string \"x\"",
            ),
            (MATRICES, "[0.0, 1.0]]", "[0.0]]", "line 8: state-space.A[1] is a list of 1; allowed: 2"),
            (MATRICES, "D = [[60.0", "D = [[nan", "line 11: state-space.D[0][0] is NaN"),
            (MATRICES, "C = ", "c = ", "line 10: state-space.c: unknown field `c`"),
            (MATRICES, "outputs", "#", "line 3: state-space: missing field `outputs`"),
            (MATRICES, "angle_error.yaw", "roll", "line 4: state-space.inputs[1] is \"roll\""),
            (MATRICES, "= 0.001\n", "= 0.01\n", "line 6: state-space.sample_time is 0.01"),
            (MATRICES, "\"hold\"", "\"keep\"", "line 12: state-space.anti_windup is \"keep\""),
            (MATRICES, "\"hold\"", "\"hold\"\n\n[extra]\na = 1", "line 14: unknown field `extra`"),
            (PAPERS, "20.0", "\"x\"", "line 5: pitch.rate: invalid type: string \"x\""),
            (PAPERS, "rate = 3.0", "speed = 3.0", "line 9: yaw.speed: unknown field `speed`"),
            (PAPERS, "rate = 3.0", "", "line 7: yaw: missing field `rate`"),
            (PAPERS, "\"backstepping\"", "\"backstep\"", "line 1: controller: unknown variant `backstep`"),
        ];
        for (text, from, to, expected) in cases {
            let told = GainsFile::parse("it.toml", &text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(told.starts_with(&format!("it.toml, {expected}")), "{told}\nand not {expected}");
        }
        GainsFile::parse("it.toml", PAPERS).unwrap();
        GainsFile::parse("it.toml", MATRICES).unwrap();
    }
}
