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

/// By PNG's own decoder: as large as it is said to be, white at the edge, not white everywhere.
#[cfg(feature = "png")]
#[test]
fn a_picture_in_pixels_is_the_figure() {
    let figure = figure(vec![(0.0, 0.0), (1.0, 1.0)], Stroke::Solid);
    let bytes = figure.to_png().unwrap();
    let mut reader = png::Decoder::new(bytes.as_slice()).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size()];
    let told = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((told.width, told.height), figure.size(Layout::Wide));
    assert_eq!(pixels[..3], [255; 3]);
    assert!(pixels.iter().any(|x| *x < 100));
}
