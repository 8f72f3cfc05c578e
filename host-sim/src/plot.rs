//! Figures: panels over a common time axis, as SVG or PNG by the file's extension.

use crate::error::{Failure, Outcome};
use crate::output;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::path::Path;
use std::sync::Once;

/// Lines over time.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    /// Above everything.
    pub title: String,
    /// One under the other.
    pub panels: Vec<Panel>,
}

/// One pair of axes.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// Of the vertical axis, with its unit.
    pub y_label: String,
    /// What is drawn, first at the bottom.
    pub lines: Vec<Line>,
    /// Horizontal lines, such as limits.
    pub limits: Vec<f64>,
}

/// A line with a name.
#[derive(Debug, Clone)]
pub struct Line {
    /// In the legend.
    pub name: String,
    /// Time \[s\] and value.
    pub points: Vec<(f64, f64)>,
    /// Which of [`COLOURS`].
    pub colour: usize,
    /// Solid or dashed.
    pub dashed: bool,
}

/// Okabe and Ito's colours, which the colour-blind can tell apart: blue, vermilion, green, purple, orange, sky, grey.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(110, 110, 110),
];

const LIMIT: RGBColor = RGBColor(90, 90, 90);
const WIDTH: u32 = 1_000;
const LEGEND_WIDTH: u32 = 170;
const PANEL_HEIGHT: u32 = 270;
const TITLE_HEIGHT: u32 = 44;
/// More points than this on a line cannot be seen.
const MOST_POINTS: usize = 1_200;

static FONT: Once = Once::new();
/// DejaVu Sans, subset to Latin, Greek and a few signs.
const FONT_DATA: &[u8] = include_bytes!("../assets/DejaVuSans.ttf");

/// Refuses, before any work is done, a figure's path that could not be written.
pub fn check(flag: &str, path: &Path) -> Outcome<()> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("svg" | "png") => output::check(flag, path),
        _ => Err(Failure::Input(format!(
            "{flag} is '{}'; allowed: a name that ends in .svg or .png",
            path.display()
        ))),
    }
}

impl Figure {
    /// Writes it, as SVG or PNG by the extension.
    pub fn write(&self, path: &Path) -> Outcome<()> {
        let bytes = if path.extension().is_some_and(|e| e == "png") {
            self.to_png()?
        } else {
            self.to_svg()?.into_bytes()
        };
        output::write(path, &bytes)
    }

    fn size(&self) -> (u32, u32) {
        let panels = u32::try_from(self.panels.len()).unwrap_or(1);
        (WIDTH, TITLE_HEIGHT + panels * PANEL_HEIGHT)
    }

    /// As an SVG document.
    pub fn to_svg(&self) -> Outcome<String> {
        let mut text = String::new();
        self.draw(SVGBackend::with_string(&mut text, self.size()).into_drawing_area())?;
        Ok(text)
    }

    fn to_png(&self) -> Outcome<Vec<u8>> {
        let failed = |e: std::io::Error| Failure::Run(format!("the figure cannot be drawn: {e}"));
        let file = tempfile::Builder::new().suffix(".png").tempfile().map_err(failed)?;
        self.draw(BitMapBackend::new(file.path(), self.size()).into_drawing_area())?;
        std::fs::read(file.path()).map_err(failed)
    }

    fn draw<B: DrawingBackend>(&self, area: DrawingArea<B, plotters::coord::Shift>) -> Outcome<()> {
        FONT.call_once(|| {
            // It is the one font there is, and a static one: registering it cannot fail.
            let _ = register_font("sans-serif", FontStyle::Normal, FONT_DATA);
        });
        self.try_draw(&area).map_err(|e| Failure::Run(format!("the figure cannot be drawn: {e}")))
    }

    fn try_draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        area.fill(&WHITE)?;
        let (title, body) = area.split_vertically(TITLE_HEIGHT);
        let style = ("sans-serif", 20).into_text_style(&title).color(&BLACK);
        title.draw_text(&self.title, &style, (16, 14))?;
        let count = self.panels.len();
        for (k, (panel, area)) in self.panels.iter().zip(body.split_evenly((count, 1))).enumerate() {
            panel.draw(&area, k + 1 == count)?;
        }
        area.present()
    }
}

impl Panel {
    fn draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
        bottom: bool,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let (area, legend) = area.split_horizontally(WIDTH - LEGEND_WIDTH);
        let (time, value) = self.ranges();
        let mut chart = ChartBuilder::on(&area)
            .margin_left(12)
            .margin_right(14)
            .margin_top(8)
            .x_label_area_size(if bottom { 44 } else { 26 })
            .y_label_area_size(72)
            .build_cartesian_2d(time.0..time.1, value.0..value.1)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .axis_style(RGBColor(90, 90, 90))
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_desc(if bottom { "time [s]" } else { "" })
            .y_desc(self.y_label.as_str())
            .x_labels(11)
            .y_labels(7)
            .y_label_formatter(&|y| number(*y, value.1 - value.0))
            .draw()?;
        for limit in &self.limits {
            let ends = vec![(time.0, *limit), (time.1, *limit)];
            chart.draw_series(DashedLineSeries::new(ends, 4, 4, LIMIT.stroke_width(1)))?;
        }
        for line in &self.lines {
            line.draw(&mut chart)?;
        }
        self.draw_legend(&legend)
    }

    /// Beside the axes, where it hides nothing.
    fn draw_legend<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let text = ("sans-serif", 14).into_text_style(area).color(&BLACK);
        let limit = (!self.limits.is_empty()).then(|| ("limit".to_owned(), LIMIT.stroke_width(1), true));
        let entries = self.lines.iter().map(|l| (l.name.clone(), l.style(), l.dashed)).chain(limit);
        for (y, (name, style, dashed)) in (20..).step_by(22).zip(entries) {
            let dashes: &[(i32, i32)] = if dashed { &[(0, 7), (12, 19)] } else { &[(0, 22)] };
            for (from, to) in dashes {
                area.draw(&PathElement::new(vec![(*from, y), (*to, y)], style))?;
            }
            area.draw_text(&name, &text, (30, y - 8))?;
        }
        Ok(())
    }

    /// Time and value ranges, the latter with some air.
    fn ranges(&self) -> ((f64, f64), (f64, f64)) {
        let points = || self.lines.iter().flat_map(|l| &l.points);
        let within = |values: &mut dyn Iterator<Item = f64>| {
            values
                .filter(|v| v.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let time = within(&mut points().map(|p| p.0));
        let value = within(&mut points().map(|p| p.1).chain(self.limits.iter().copied()));
        let (low, high) = if value.0 < value.1 { value } else { (value.0 - 1.0, value.0 + 1.0) };
        let air = 0.06 * (high - low);
        let time = if time.0 < time.1 { time } else { (0.0, 1.0) };
        if low.is_finite() { (time, (low - air, high + air)) } else { (time, (0.0, 1.0)) }
    }
}

/// With as many decimals as the range needs.
fn number(value: f64, range: f64) -> String {
    let decimals = if range >= 20.0 {
        0
    } else if range >= 2.0 {
        1
    } else if range >= 0.2 {
        2
    } else {
        3
    };
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
        format!("{:.decimals$}", 0.0)
    } else {
        text
    }
}

type Axis = plotters::coord::types::RangedCoordf64;

impl Line {
    fn style(&self) -> ShapeStyle {
        COLOURS[self.colour % COLOURS.len()].stroke_width(2)
    }

    fn draw<'a, B: DrawingBackend + 'a>(
        &self,
        chart: &mut ChartContext<'a, B, Cartesian2d<Axis, Axis>>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let points = self.thinned();
        if self.dashed {
            chart.draw_series(DashedLineSeries::new(points, 7, 5, self.style()))?;
        } else {
            chart.draw_series(LineSeries::new(points, self.style()))?;
        }
        Ok(())
    }

    /// Of each stretch the least and the most, so that a spike of one tick is still seen.
    fn thinned(&self) -> Vec<(f64, f64)> {
        let finite = self.points.iter().copied().filter(|p| p.1.is_finite());
        if self.points.len() <= MOST_POINTS {
            return finite.collect();
        }
        let all: Vec<(f64, f64)> = finite.collect();
        let stretch = all.len().div_ceil(MOST_POINTS / 2);
        let mut thin: Vec<(f64, f64)> = all
            .chunks(stretch)
            .flat_map(|part| {
                let extreme = |by: fn(&f64, &f64) -> bool| {
                    part.iter().copied().reduce(|a, b| if by(&b.1, &a.1) { b } else { a })
                };
                let (low, high) = (extreme(|a, b| a < b), extreme(|a, b| a > b));
                let mut pair: Vec<_> = low.into_iter().chain(high).collect();
                pair.sort_by(|a, b| a.0.total_cmp(&b.0));
                pair.dedup();
                pair
            })
            .collect();
        thin.extend(all.last());
        thin
    }
}
