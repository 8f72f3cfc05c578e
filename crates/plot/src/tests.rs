//! Long figures and strange names.

use super::line::MOST_POINTS;
use super::*;

fn figure(points: Vec<(f64, f64)>, stroke: Stroke) -> Figure {
    let line = Line { name: "a line".to_owned(), points, colour: 0, stroke };
    let panel = Panel { y_label: "y".to_owned(), lines: vec![line], ..Panel::default() };
    Figure { title: "a title".to_owned(), x_label: String::new(), panels: vec![panel] }
}

/// A million points that never rest, in each manner of drawing.
#[test]
fn a_million_ticks_stay_small() {
    let wave = |k: u32| f64::from(k) * 1e-3;
    let points: Vec<(f64, f64)> = (0..1_000_000).map(|k| (wave(k), (20.0 * wave(k)).sin())).collect();
    for stroke in [Stroke::Solid, Stroke::Dashed, Stroke::Thin, Stroke::Dots, Stroke::Rings] {
        let svg = figure(points.clone(), stroke).to_svg(Layout::Wide).unwrap();
        assert!(svg.len() < 300_000, "{stroke:?}: {} bytes", svg.len());
    }
}

/// One tick that is not like the others is seen, wherever it is, up and down, and so are the ends.
#[test]
fn the_least_and_the_greatest_are_drawn() {
    let flat: Vec<(f64, f64)> = (0..1_000_000).map(|k| (f64::from(k), 0.0)).collect();
    for at in [0, 1, 4_321, 500_000, 777_777, 999_998, 999_999] {
        for spike in [5.0, -5.0] {
            let mut points = flat.clone();
            points[at].1 = spike;
            let drawn = figure(points.clone(), Stroke::Solid).panels[0].lines[0].thinned();
            assert!(drawn.len() <= MOST_POINTS + 2 && drawn.contains(&points[at]), "{at}: {spike}");
            assert_eq!((drawn[0].0, drawn[drawn.len() - 1].0), (0.0, 999_999.0));
            assert!(drawn.windows(2).all(|w| w[0].0 < w[1].0));
        }
    }
}

#[test]
fn what_xml_has_no_place_for_is_not_in_it() {
    let mut strange = figure(vec![(0.0, 0.0), (1.0, 1.0)], Stroke::Solid);
    strange.title = "a\u{1}b\u{b}c\u{ffff}d<&>".to_owned();
    strange.panels[0].lines[0].name = "\u{1b}[31mred".to_owned();
    let svg = strange.to_svg(Layout::Wide).unwrap();
    assert!(!svg.contains(is_no_xml) && svg.contains("a\u{fffd}b\u{fffd}c\u{fffd}d&lt;&amp;&gt;"), "{svg}");
}

/// As large as it is said to be.
#[cfg(feature = "png")]
fn picture(figure: &Figure) -> resvg::tiny_skia::Pixmap {
    let picture = resvg::tiny_skia::Pixmap::decode_png(&figure.to_png().unwrap()).unwrap();
    let (width, height) = figure.size(Layout::Wide);
    let scale = u32::from(pixels::SCALE);
    assert_eq!((picture.width(), picture.height()), (scale * width, scale * height));
    picture
}

/// Volts that jump from limit to limit in every tick: thick lines whose corners would stand far out.
#[cfg(feature = "png")]
#[test]
fn a_picture_in_pixels_has_nothing_outside_its_panels() {
    let volts = |sign: f64| (0..400).map(|k| (f64::from(k), if k % 2 == 0 { sign } else { -sign })).collect();
    let mut hammered = figure(volts(24.0), Stroke::Solid);
    hammered.panels.push(figure(volts(-24.0), Stroke::Solid).panels.remove(0));
    let calm = |f: &mut Figure| f.panels.iter_mut().for_each(|p| p.lines.iter_mut().for_each(flatten));
    let mut flat = hammered.clone();
    calm(&mut flat);
    let (hammered, flat) = (picture(&hammered), picture(&flat));
    // Where the axes end: 12 for the margin, 72 for the labels; 14 before the legend. A line is as wide as 2.
    let scale = u32::from(pixels::SCALE);
    let (left, right) = (scale * (12 + 72 - 2), scale * (1_000 - LEGEND_WIDTH - 14 + 2));
    let tops = [TITLE_HEIGHT + 8, TITLE_HEIGHT + PANEL_HEIGHT + 8];
    let inside = |x: u32, y: u32| {
        let down = |top: &u32| (scale * top..scale * (top + PANEL_HEIGHT - 26 - 8)).contains(&y);
        (left..=right).contains(&x) && tops.iter().any(down)
    };
    let mut differ = 0;
    for (k, (a, b)) in (0_u32..).zip(hammered.pixels().iter().zip(flat.pixels())) {
        let (x, y) = (k % hammered.width(), k / hammered.width());
        if a != b {
            assert!(inside(x, y), "pixel {x}, {y} of a line is outside the panels");
            differ += 1;
        }
    }
    assert!(differ > 10_000, "{differ} pixels of lines");
}

/// The same range of values from fewer points: the two ends of the range, and the last.
#[cfg(feature = "png")]
fn flatten(line: &mut Line) {
    let ends = [line.points[0], line.points[1], line.points[line.points.len() - 1]];
    line.points = ends.to_vec();
}

#[cfg(feature = "png")]
#[test]
fn a_picture_in_pixels_is_the_figure_with_smooth_edges() {
    let picture = picture(&figure(vec![(0.0, 0.0), (1.0, 1.0)], Stroke::Solid));
    assert_eq!(picture.pixel(0, 0).unwrap().green(), 255);
    // The line's blue, and shades between it and white.
    let (line, shades) = picture.pixels().iter().fold((0, 0), |(line, shades), p| {
        let blue = (p.red(), p.green(), p.blue()) == (0, 114, 178);
        (line + u32::from(blue), shades + u32::from(p.red() > 0 && p.red() < 255 && p.blue() > 178))
    });
    assert!(line > 1_000 && shades > 1_000, "{line} of the line, {shades} between");
}
