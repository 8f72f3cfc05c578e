//! What was found, beside what there was before it: what the same objective says of both.

use serde::Serialize;
use std::fmt::Write;

/// Gains that were there before the search.
#[derive(Debug, Serialize)]
pub(super) struct Before {
    what: What,
    /// What they are called, or the file.
    gains: String,
    /// What the objective says of them; none where they diverge.
    cost: Option<f64>,
    found_is_better: bool,
}

/// Which they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum What {
    /// The search began with them.
    Start,
    /// Table 4.
    Paper,
    /// A board flies the preset with them.
    Own,
}

impl What {
    const fn words(self) -> &'static str {
        match self {
            Self::Start => "the start",
            Self::Paper => "Table 4",
            Self::Own => "the preset's own gains",
        }
    }
}

/// All of them.
#[derive(Debug, Serialize)]
pub(super) struct Beside {
    #[serde(skip)]
    found: f64,
    compared: Vec<Before>,
    verdict: String,
}

impl Beside {
    /// A search of so many candidates, the best of which costs `found` and is written, beside what there was
    /// before: which gains, what they are called, and what they cost.
    pub(super) fn new(
        found: f64,
        candidates: usize,
        before: impl IntoIterator<Item = (What, String, f64)>,
    ) -> Self {
        let compared = before.into_iter().map(|(what, gains, cost)| Before {
            what,
            gains,
            cost: Some(cost).filter(|cost| cost.is_finite()),
            found_is_better: found < cost,
        });
        let compared: Vec<Before> = compared.collect();
        let unbeaten: Vec<What> = compared.iter().filter(|b| !b.found_is_better).map(|b| b.what).collect();
        let holds = if unbeaten.contains(&What::Start) { "the start itself" } else { "the best of these" };
        let verdict = match &unbeaten[..] {
            [] => "the tuned gains are the best of these".to_owned(),
            unbeaten => {
                let names: Vec<&str> = unbeaten.iter().map(|what| what.words()).collect();
                let names = names.join(" and ");
                format!("none of {candidates} candidates is better than {names}: the file holds {holds}")
            }
        };
        Self { found, compared, verdict }
    }

    /// In lines; `what` was minimised.
    pub(super) fn text(&self, what: &str) -> String {
        let mut text = format!("{what}, which was minimised:\n  {:12.6}  tuned\n", self.found);
        for Before { what, gains, cost, .. } in &self.compared {
            let cost = cost.map_or_else(|| "diverges".to_owned(), |cost| format!("{cost:.6}"));
            let _ = writeln!(text, "  {cost:>12}  {}: {gains}", what.words());
        }
        let _ = writeln!(text, "{}", self.verdict);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(found: f64, before: [(What, f64); 2]) -> String {
        let before = before.map(|(what, cost)| (what, "x".to_owned(), cost));
        Beside::new(found, 7, before).text("J")
    }

    #[test]
    fn what_was_found_is_told_beside_both_and_what_the_file_holds() {
        use What::{Own, Paper, Start};
        assert_eq!(
            told(3.0, [(Start, 4.0), (Own, f64::INFINITY)]),
            "J, which was minimised:\n      3.000000  tuned\n      4.000000  the start: x\n      diverges  \
             the preset's own gains: x\nthe tuned gains are the best of these\n"
        );
        let none = |of: &str, holds: &str| {
            format!("\nnone of 7 candidates is better than {of}: the file holds {holds}\n")
        };
        let (start, best) = ("the start itself", "the best of these");
        for (found, before, told_so) in [
            (3.0, [(Start, 4.0), (Own, 1.5)], none("the preset's own gains", best)),
            (3.0, [(Start, 3.0), (Own, 6.0)], none("the start", start)),
            (3.0, [(Start, 3.0), (Own, 1.5)], none("the start and the preset's own gains", start)),
            (3.0, [(Paper, 2.0), (Own, 4.0)], none("Table 4", best)),
        ] {
            let text = told(found, before);
            assert!(text.ends_with(&told_so), "{text}");
        }
    }
}
