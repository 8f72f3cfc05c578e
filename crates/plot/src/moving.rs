//! A flight as a moving picture: an SVG that every browser plays by itself, over and over.
//!
//! Two views of the helicopter, from the side (pitch) and from above (yaw), each with the reference as a
//! ghost; beneath them the angles over time with a mark that runs along.

use crate::{COLOURS, GRID, SOFT, is_no_xml};
use plotters::style::RGBColor;
use std::fmt::Write;
use twinrotor_sim::flight::Row;

/// \[px\]
const SIZE: [f64; 2] = [720.0, 400.0];
/// \[px\] Half of the helicopter's length.
const ARM: f64 = 105.0;
/// \[s\] From one picture to the next: what a browser shows between is interpolated.
const STEP: f64 = 0.04;
/// Where each view's pivot stands.
const SIDE: [f64; 2] = [180.0, 125.0];
const ABOVE: [f64; 2] = [540.0, 125.0];
/// \[px\] The plot's left, top, right and bottom.
const PLOT: [f64; 4] = [60.0, 265.0, 700.0, 365.0];

fn hex(c: RGBColor) -> String {
    format!("#{:02X}{:02X}{:02X}", c.0, c.1, c.2)
}

/// A view's name, where its pivot stands, reference and angle \[rad\], and the helicopter in it.
type View = (&'static str, [f64; 2], [fn(&Row) -> f64; 2], String);

/// The flight of `rows` as an animated SVG that lasts as long as the flight did. `title` stands above it.
pub fn moving(title: &str, rows: &[Row]) -> String {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return String::new() };
    let duration = (last.time - first.time).max(STEP);
    // Evenly spaced, as the browser takes them to be, and with the last.
    let pictures = (1..=rows.len()).rev().find(|n| *n as f64 * STEP <= duration + 0.5 * STEP).unwrap_or(1);
    let shown: Vec<&Row> = (0..=pictures).map(|k| &rows[k * (rows.len() - 1) / pictures]).collect();
    let [width, height] = SIZE;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"system-ui,DejaVu Sans,sans-serif\" font-size=\"13\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#FFFFFF\"/>\n\
         <text x=\"16\" y=\"24\" font-size=\"15\">{}</text>\n",
        title.replace(is_no_xml, "\u{fffd}").replace('&', "&amp;").replace('<', "&lt;")
    );
    // Nose up is positive pitch; seen from above, positive yaw turns the nose to the left.
    let views: [View; 2] = [
        ("pitch, from the side", SIDE, [|r| r.reference.pitch, |r| r.state.angle.pitch], side()),
        ("yaw, from above", ABOVE, [|r| r.reference.yaw, |r| r.state.angle.yaw], above()),
    ];
    for (k, (name, [x, y], [reference, angle], body)) in views.into_iter().enumerate() {
        let _ = writeln!(
            text,
            "<text x=\"{x}\" y=\"240\" text-anchor=\"middle\" fill=\"{}\">{name}</text>",
            hex(SOFT)
        );
        let turned = |of: fn(&Row) -> f64, inner: &str| {
            let values: Vec<String> = shown.iter().map(|r| format!("{:.1}", -of(r).to_degrees())).collect();
            format!(
                "<g transform=\"translate({x} {y})\"><g>{inner}<animateTransform attributeName=\"transform\" \
                 type=\"rotate\" dur=\"{duration:.2}s\" repeatCount=\"indefinite\" values=\"{}\"/></g></g>\n",
                values.join(";")
            )
        };
        let ghost = format!(
            "<path d=\"M{} 0H{ARM}\" stroke=\"{}\" stroke-width=\"4\" stroke-dasharray=\"7 6\"/>",
            -ARM,
            hex(COLOURS[6])
        );
        if k == 0 {
            let _ = writeln!(
                text,
                "<path d=\"M{x} {y}V215M{} 215H{}\" stroke=\"{}\" stroke-width=\"5\"/>",
                x - 40.0,
                x + 40.0,
                hex(GRID)
            );
        }
        text += &turned(reference, &ghost);
        text += &turned(angle, &body);
    }
    text += &plot(&shown, first.time, duration);
    text + "</svg>\n"
}

/// Main rotor at the nose, to the right; tail rotor behind, seen along its disc.
fn side() -> String {
    let (body, main, tail) = (hex(SOFT), hex(COLOURS[0]), hex(COLOURS[1]));
    format!(
        "<path d=\"M{} 0H{ARM}\" stroke=\"{body}\" stroke-width=\"9\" stroke-linecap=\"round\"/>\
         <path d=\"M{} -14H{}M{ARM} 0V-14\" stroke=\"{main}\" stroke-width=\"5\" stroke-linecap=\"round\"/>\
         <circle cx=\"{}\" cy=\"0\" r=\"26\" fill=\"none\" stroke=\"{tail}\" stroke-width=\"4\"/>\
         <circle r=\"7\" fill=\"{body}\"/>",
        -ARM,
        ARM - 34.0,
        ARM + 34.0,
        -ARM
    )
}

/// The main rotor's disc from above; the tail rotor from its edge.
fn above() -> String {
    let (body, main, tail) = (hex(SOFT), hex(COLOURS[0]), hex(COLOURS[1]));
    format!(
        "<path d=\"M{} 0H{ARM}\" stroke=\"{body}\" stroke-width=\"9\" stroke-linecap=\"round\"/>\
         <circle cx=\"{ARM}\" cy=\"0\" r=\"30\" fill=\"none\" stroke=\"{main}\" stroke-width=\"4\"/>\
         <path d=\"M{} -26V26\" stroke=\"{tail}\" stroke-width=\"5\" stroke-linecap=\"round\"/>\
         <circle r=\"7\" fill=\"{body}\"/>",
        -ARM, -ARM
    )
}

/// Angles and references over time, and where the flight is.
fn plot(rows: &[&Row], begin: f64, duration: f64) -> String {
    let [left, top, right, bottom] = PLOT;
    let all = || {
        rows.iter().flat_map(|r| {
            [r.state.angle.pitch, r.state.angle.yaw, r.reference.pitch, r.reference.yaw].map(f64::to_degrees)
        })
    };
    let least = all().fold(0.0, f64::min);
    let most = all().fold(least + 1.0, f64::max);
    let x = |time: f64| left + (right - left) * (time - begin) / duration;
    let y = |degrees: f64| bottom - (bottom - top) * (degrees - least) / (most - least);
    let mut text = String::new();
    for degrees in [least, 0.0, most] {
        let _ = writeln!(
            text,
            "<path d=\"M{left} {0:.1}H{right}\" stroke=\"{1}\"/><text x=\"{2}\" y=\"{3:.1}\" \
             text-anchor=\"end\" fill=\"{4}\">{degrees:.0}°</text>",
            y(degrees),
            hex(GRID),
            left - 8.0,
            y(degrees) + 4.0,
            hex(SOFT)
        );
    }
    let mut line = |of: &dyn Fn(&Row) -> f64, colour: RGBColor, dashes: &str| {
        let points: Vec<String> =
            rows.iter().map(|r| format!("{:.1},{:.1}", x(r.time), y(of(r).to_degrees()))).collect();
        let _ = writeln!(
            text,
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{dashes} points=\"{}\"/>",
            hex(colour),
            points.join(" ")
        );
    };
    line(&|r| r.reference.pitch, COLOURS[6], " stroke-dasharray=\"4 4\"");
    line(&|r| r.reference.yaw, COLOURS[6], " stroke-dasharray=\"4 4\"");
    line(&|r| r.state.angle.pitch, COLOURS[0], "");
    line(&|r| r.state.angle.yaw, COLOURS[1], "");
    let _ = writeln!(
        text,
        "<path d=\"M0 {top}V{bottom}\" stroke=\"#000000\"><animateTransform attributeName=\"transform\" \
         type=\"translate\" dur=\"{duration:.2}s\" repeatCount=\"indefinite\" values=\"{left} 0;{right} 0\"/>\
         </path>\n<text x=\"{left}\" y=\"{0}\" fill=\"{1}\">pitch</text><text x=\"{2}\" y=\"{0}\" \
         fill=\"{3}\">yaw</text><text x=\"{4}\" y=\"{0}\" fill=\"{5}\">dashed: reference</text>\
         <text x=\"{right}\" y=\"{0}\" text-anchor=\"end\" fill=\"{5}\">{duration:.0} s</text>",
        bottom + 22.0,
        hex(COLOURS[0]),
        left + 46.0,
        hex(COLOURS[1]),
        left + 86.0,
        hex(SOFT),
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::axes::PerAxis;
    use twinrotor::plant::presets::PAPER;
    use twinrotor_sim::flight::{self, Fidelity, Plan, Scalar};
    use twinrotor_sim::gains_file::GainsFile;
    use twinrotor_sim::scenario::Scenario;

    #[test]
    fn it_lasts_as_long_as_the_flight_and_ends_where_the_flight_does() {
        let settings = GainsFile::paper().settings(&PAPER);
        let scenario = Scenario::named("step").unwrap();
        let initial = PerAxis::both(0.0);
        let fidelity = Fidelity::Ideal;
        let plan = Plan {
            rig: &PAPER,
            truth: &PAPER,
            settings: &settings,
            scenario: &scenario,
            initial,
            fidelity,
            seed: 1,
        };
        let rows = flight::fly(&plan, Scalar::F32).unwrap().rows;
        let drawn = moving("a < b\u{1} & c", &rows);
        assert!(drawn.contains("a &lt; b\u{fffd} &amp; c") && drawn.ends_with("</svg>\n"));
        assert_eq!(drawn.matches("dur=\"5.00s\"").count(), 5, "four bodies and a mark");
        // The last of the values of pitch, then of yaw: nose up and to the left are negative angles of SVG.
        let last = |k: usize| {
            let values = drawn.split("values=\"").nth(k).unwrap().split('"').next().unwrap();
            assert_eq!(values.split(';').count(), 126, "25 pictures a second");
            values.split(';').next_back().unwrap()
        };
        assert_eq!([last(1), last(2)], ["-15.0"; 2], "pitch: reference, angle");
        assert_eq!([last(3), last(4)], ["-40.0"; 2], "yaw");
        assert_eq!(moving("", &[]), "");
    }
}
