//! The report as one HTML file: no network, no script; light and dark, wide and narrow, screen and paper.

use super::{Entry, Grid, Picture, Report, Section, Size, Verdict};
use crate::error::Outcome;
use std::collections::BTreeMap;
use std::fmt::Write;
use twinrotor_plot::{COLOURS, Colour, GRID, Layout, SOFT};

/// Columns that a telephone shows at once.
const FEW: usize = 2;
/// Columns that a desk shows at once.
const MANY: usize = 10;

const STYLE: &str = include_str!("style.css");

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A drawing in the colours of the page, which are other ones in the dark.
fn themed(svg: &str) -> String {
    let hex = |c: &Colour| format!("\"#{:02X}{:02X}{:02X}\"", c.0, c.1, c.2);
    let fixed = [
        ("\"#FFFFFF\"".to_owned(), "paper".to_owned()),
        ("\"#000000\"".to_owned(), "ink".to_owned()),
        (hex(&SOFT), "soft".to_owned()),
        (hex(&GRID), "grid".to_owned()),
    ];
    let colours = COLOURS.iter().enumerate().map(|(k, c)| (hex(c), format!("c{k}")));
    fixed
        .into_iter()
        .chain(colours)
        .fold(svg.to_owned(), |text, (from, to)| text.replace(&from, &format!("\"var(--{to})\"")))
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reproduced => "r",
        Verdict::WithinAmbiguity => "w",
        Verdict::NotReproduced => "n",
        Verdict::Undecided => "u",
        Verdict::Contradictory => "x",
        Verdict::Given => "g",
    }
}

/// A row that a chip leads to; its verdict leads to the next of the same kind.
fn row(text: &mut String, e: &Entry, number: usize) {
    let remark = if e.remark.is_empty() {
        String::new()
    } else {
        format!("<span class=remark>{}</span>", escaped(&e.remark))
    };
    let kind = class(e.verdict);
    let _ = writeln!(
        text,
        "<tr id={kind}{number}><td>{}</td><td data-l=paper>{}</td><td data-l=here>{}{remark}</td>\
         <td><a class={kind} href=#{kind}{} title=\"to the next\">{}</a></td></tr>",
        escaped(&e.what),
        escaped(&e.paper),
        escaped(&e.ours),
        number + 1,
        e.verdict.words()
    );
}

fn picture(text: &mut String, p: &Picture) -> Outcome<()> {
    let _ = write!(text, "<figure id={}>", p.name);
    for (class, layout) in [("wide", Layout::Wide), ("narrow", Layout::Narrow)] {
        let svg = themed(&p.figure.to_svg(layout)?);
        let _ = write!(
            text,
            "<div class={class} role=img aria-label=\"{}\">{svg}</div>",
            escaped(&p.figure.title)
        );
    }
    let _ = writeln!(
        text,
        "<figcaption>{} <a href={}.csv>data</a></figcaption></figure>",
        escaped(&p.caption),
        p.name
    );
    Ok(())
}

fn section(
    text: &mut String,
    number: usize,
    s: &Section,
    counts: &mut BTreeMap<&'static str, usize>,
) -> Outcome<()> {
    let _ = writeln!(text, "<h2 id=s{number}>{}</h2>", escaped(&s.title));
    if !s.text.is_empty() {
        let _ = writeln!(text, "<p>{}</p>", escaped(&s.text));
    }
    if !s.entries.is_empty() {
        text.push_str(
            "<table><thead><tr><th></th><th>paper</th><th>here</th><th>verdict</th></tr></thead><tbody>\n",
        );
        for e in &s.entries {
            let count = counts.entry(class(e.verdict)).or_default();
            row(text, e, *count);
            *count += 1;
        }
        text.push_str("</tbody></table>\n");
    }
    s.measured.iter().for_each(|measured| grid(text, measured));
    s.pictures.iter().try_for_each(|p| picture(text, p))
}

fn grid(text: &mut String, g: &Grid) {
    let cells = |tag: &str, cells: &mut dyn Iterator<Item = &str>| {
        cells.map(|c| format!("<{tag}>{}</{tag}>", escaped(c))).collect::<String>()
    };
    // A telephone shows two or three columns at once, a desk a dozen; the rest is beyond the edge.
    let many = if g.heads.len() > MANY { " many" } else { "" };
    if g.heads.len() > FEW {
        let _ =
            write!(text, "<p class=\"hint{many}\">Wider than the screen: the table scrolls sideways →</p>");
    }
    let _ = write!(
        text,
        "<div class=\"grid{many}\" id={} tabindex=0><table><thead><tr>{}</tr></thead><tbody>",
        g.name,
        cells("th", &mut g.heads.iter().map(|h| &**h))
    );
    for row in &g.rows {
        let _ = writeln!(text, "<tr>{}</tr>", cells("td", &mut row.iter().map(String::as_str)));
    }
    let _ = writeln!(
        text,
        "</tbody></table></div><p class=soft>{} <a href={}.csv>data</a></p>",
        escaped(&g.note),
        g.name
    );
}

/// What a page begins with, up to its heading's text.
fn head(title: &str) -> String {
    format!(
        "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport \
         content=\"width=device-width,initial-scale=1\">\
         <meta name=color-scheme content=\"light dark\"><title>{title}</title><style>{STYLE}</style>\n"
    )
}

/// Sections of anything as one self-contained page.
pub(super) fn page(title: &str, about: &str, sections: &[Section]) -> Outcome<String> {
    let title = escaped(title);
    let mut text = head(&title);
    let _ = writeln!(text, "<h1>{title}</h1>\n<p class=soft>{}</p>", escaped(about));
    let mut counts = BTreeMap::new();
    for (k, s) in sections.iter().enumerate() {
        section(&mut text, k, s, &mut counts)?;
    }
    text.push_str("</html>\n");
    Ok(text)
}

impl Report {
    /// As one self-contained page.
    ///
    /// # Errors
    ///
    /// If a figure cannot be drawn.
    pub fn to_html(&self) -> Outcome<String> {
        let mut text = head("The paper, reproduced");
        let own = match &self.own[..] {
            [] => String::new(),
            own => format!(" --controllers {}", own.join(",")),
        };
        let _ = write!(
            text,
            "<h1>Backstepping control of Quanser's 2-DOF Helicopter, reproduced</h1>\n\
             <p class=abstract>{}</p>\n\
             <p class=soft>The paper: “Backstepping control of Quanser's 2-DOF Helicopter under disturbance \
             and actuator saturation based on Flower Pollination Algorithm”. Its tables, figures and claims \
             stand here in its order, each beside what was computed in one run by <code>host-sim \
             reproduce{}{} --seed {}</code>, version {}: {} seeds of each search, {} plants.</p>\n",
            escaped(&self.summary.join(" ")),
            if self.size == Size::QUICK { " --quick" } else { "" },
            escaped(&own),
            self.seed,
            env!("CARGO_PKG_VERSION"),
            self.size.seeds,
            self.size.plants
        );
        text.push_str("<div class=tally>");
        for (verdict, count) in super::VERDICTS.into_iter().zip(self.tally().by_verdict()) {
            let kind = class(verdict);
            let words = if verdict == Verdict::Contradictory { "contradictions" } else { verdict.words() };
            let _ = write!(text, "<a class={kind} href=#{kind}0>{count} {words}</a>");
        }
        text.push_str("</div><nav>\n");
        for (k, s) in self.sections.iter().enumerate() {
            let _ = writeln!(text, "<a href=#s{k}>{}</a>", escaped(&s.title));
        }
        text.push_str("</nav>\n");
        let mut counts = BTreeMap::new();
        for (k, s) in self.sections.iter().enumerate() {
            section(&mut text, k, s, &mut counts)?;
        }
        text.push_str("</html>\n");
        Ok(text)
    }
}
