//! Figures: panels over a common horizontal axis, as SVG or PNG by the file's extension.

pub mod flight;
mod labels;
mod line;
pub mod map;
pub mod moving;
#[cfg(feature = "png")]
pub mod pixels;

use labels::{number, power};
pub use line::{Line, SERIES, Stroke, series};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::sync::Once;
use twinrotor_sim::{Error, Outcome};

/// Lines over a common horizontal axis.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    /// Above everything.
    pub title: String,
    /// Of the horizontal axis, with its unit; empty for time \[s\].
    pub x_label: String,
    /// One under the other.
    pub panels: Vec<Panel>,
}

/// One pair of axes.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// Of the vertical axis, with its unit.
    pub y_label: String,
    /// Between two curves, under everything.
    pub bands: Vec<Band>,
    /// What is drawn, first at the bottom.
    pub lines: Vec<Line>,
    /// Words beside points of the axes, above everything.
    pub labels: Vec<(f64, f64, String)>,
    /// Horizontal lines, such as limits.
    pub limits: Vec<f64>,
    /// Powers of ten on the vertical axis; what is not above zero is left out.
    pub logarithmic: bool,
}

/// The area between two curves.
#[derive(Debug, Clone)]
pub struct Band {
    /// Horizontal, lower and upper.
    pub points: Vec<(f64, f64, f64)>,
    /// Which of [`COLOURS`].
    pub colour: usize,
}

/// For which page a figure is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// The legend beside the axes.
    Wide,
    /// For a telephone: the legend beneath.
    Narrow,
}

/// A colour: red, green, blue.
pub use plotters::style::RGBColor as Colour;

/// Blue, vermilion, green, mauve, wine, olive and, for what is no series, grey. Okabe and Ito's first two,
/// and others found for them, so that any two of the six are apart in Lab by 20 and more to everyone: as
/// they are and with red, green or blue cones missing (Machado, Oliveira, Fernandes 2009); all stand out
/// from white.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 177, 100),
    RGBColor(178, 123, 160),
    RGBColor(102, 26, 51),
    RGBColor(60, 73, 0),
    RGBColor(110, 110, 110),
];

/// Of limits and axes.
pub const SOFT: RGBColor = RGBColor(90, 90, 90);
/// Of the lines behind.
pub const GRID: RGBColor = RGBColor(225, 225, 225);
const LEGEND_WIDTH: u32 = 170;
const PANEL_HEIGHT: u32 = 270;
const TITLE_HEIGHT: u32 = 44;
const LEGEND_LINE: u32 = 22;
/// Part of the colour that a band keeps.
const FAINT: f64 = 0.18;

impl Layout {
    fn width(self) -> u32 {
        match self {
            Self::Wide => 1_000,
            Self::Narrow => 420,
        }
    }
}

static FONT: Once = Once::new();
/// DejaVu Sans, subset to Latin, Greek and a few signs.
const FONT_DATA: &[u8] = include_bytes!("../assets/DejaVuSans.ttf");

impl Figure {
    fn size(&self, layout: Layout) -> (u32, u32) {
        let heights = self.panels.iter().map(|p| p.height(layout));
        (layout.width(), TITLE_HEIGHT + heights.sum::<u32>())
    }

    /// As an SVG document.
    ///
    /// # Errors
    ///
    /// If it cannot be drawn.
    pub fn to_svg(&self, layout: Layout) -> Outcome<String> {
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, self.size(layout)).into_drawing_area();
        self.draw(area, layout)?;
        // XML has no place for most control characters, not even an escaped one.
        Ok(text.replace(is_no_xml, "\u{fffd}"))
    }

    /// What is drawn, as CSV: panel, line, horizontal, vertical.
    pub fn to_csv(&self) -> String {
        use std::fmt::Write;
        let mut text = String::from("panel,line,x,y\n");
        for panel in &self.panels {
            for line in &panel.lines {
                for (x, y) in &line.points {
                    let _ = writeln!(text, "\"{}\",\"{}\",{x},{y}", panel.y_label, line.name);
                }
            }
        }
        text
    }

    /// As a PNG picture: the SVG document in pixels, [`pixels::SCALE`] for each of its units.
    ///
    /// # Errors
    ///
    /// If it cannot be drawn.
    #[cfg(feature = "png")]
    pub fn to_png(&self) -> Outcome<Vec<u8>> {
        pixels::png(&self.to_svg(Layout::Wide)?)
    }

    fn draw<B: DrawingBackend>(
        &self,
        area: DrawingArea<B, plotters::coord::Shift>,
        layout: Layout,
    ) -> Outcome<()> {
        FONT.call_once(|| {
            // It is the one font there is, and a static one: registering it cannot fail.
            let _ = register_font("sans-serif", FontStyle::Normal, FONT_DATA);
        });
        self.try_draw(&area, layout).map_err(|e| Error::Failed(format!("the figure cannot be drawn: {e}")))
    }

    fn try_draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
        layout: Layout,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        area.fill(&WHITE)?;
        let (title, mut body) = area.split_vertically(TITLE_HEIGHT);
        let size = if layout == Layout::Wide { 20 } else { 15 };
        let style = ("sans-serif", size).into_text_style(&title).color(&BLACK);
        title.draw_text(&self.title, &style, (if layout == Layout::Wide { 16 } else { 6 }, 14))?;
        let x_label = if self.x_label.is_empty() { "time [s]" } else { &self.x_label };
        let count = self.panels.len();
        for (k, panel) in self.panels.iter().enumerate() {
            let (area, rest) = body.split_vertically(panel.height(layout));
            panel.draw(&area, if k + 1 == count { x_label } else { "" }, layout)?;
            body = rest;
        }
        area.present()
    }
}

impl Panel {
    fn height(&self, layout: Layout) -> u32 {
        let entries = u32::try_from(self.entries().count()).unwrap_or(0);
        match layout {
            Layout::Wide => PANEL_HEIGHT.max(40 + LEGEND_LINE * entries),
            Layout::Narrow => PANEL_HEIGHT + LEGEND_LINE * entries.div_ceil(2),
        }
    }

    /// Names, and how what they name is drawn.
    fn entries(&self) -> impl Iterator<Item = (&str, ShapeStyle, Stroke)> {
        let limit = (!self.limits.is_empty()).then(|| ("limit", SOFT.stroke_width(1), Stroke::Dashed));
        let named = self.lines.iter().filter(|l| !l.name.is_empty());
        named.map(|l| (l.name.as_str(), l.style(), l.stroke)).chain(limit)
    }

    /// A value as it is drawn.
    fn drawn(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    fn draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
        x_label: &str,
        layout: Layout,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let (area, legend) = match layout {
            Layout::Wide => area.split_horizontally(layout.width() - LEGEND_WIDTH),
            Layout::Narrow => area.split_vertically(PANEL_HEIGHT),
        };
        let (across, up) = self.ranges();
        let mut chart = ChartBuilder::on(&area)
            .margin_left(if layout == Layout::Wide { 12 } else { 2 })
            .margin_right(14)
            .margin_top(8)
            .x_label_area_size(if x_label.is_empty() { 26 } else { 44 })
            .y_label_area_size(if layout == Layout::Wide { 72 } else { 60 })
            .build_cartesian_2d(across.0..across.1, up.0..up.1)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(GRID)
            .axis_style(SOFT)
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_desc(x_label)
            .y_desc(self.y_label.as_str())
            .x_labels(if layout == Layout::Wide { 11 } else { 6 })
            .y_labels(7)
            .x_label_formatter(&|x| number(*x, across.1 - across.0))
            .y_label_formatter(&|y| if self.logarithmic { power(*y) } else { number(*y, up.1 - up.0) })
            .draw()?;
        for band in &self.bands {
            let shown =
                band.points.iter().filter(|p| self.drawn(p.1).is_finite() && self.drawn(p.2).is_finite());
            let there = shown.clone().map(|p| (p.0, self.drawn(p.1)));
            let back = shown.rev().map(|p| (p.0, self.drawn(p.2)));
            let fill = COLOURS[band.colour % COLOURS.len()].mix(FAINT).filled();
            chart.draw_series([Polygon::new(there.chain(back).collect::<Vec<_>>(), fill)])?;
        }
        for limit in &self.limits {
            let ends = vec![(across.0, self.drawn(*limit)), (across.1, self.drawn(*limit))];
            chart.draw_series(DashedLineSeries::new(ends, 4, 4, SOFT.stroke_width(1)))?;
        }
        for line in &self.lines {
            line.draw(&mut chart, |y| self.drawn(y))?;
        }
        let small = ("sans-serif", 12).into_text_style(&area).color(&SOFT);
        for (x, y, text) in &self.labels {
            let beside =
                EmptyElement::at((*x, self.drawn(*y))) + Text::new(text.clone(), (6, -13), small.clone());
            chart.draw_series(std::iter::once(beside))?;
        }
        self.draw_legend(&legend, layout)
    }

    /// Beside the axes or beneath, where it hides nothing.
    fn draw_legend<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
        layout: Layout,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let text = ("sans-serif", 14).into_text_style(area).color(&BLACK);
        let columns = if layout == Layout::Wide { 1 } else { 2 };
        for (k, (name, style, stroke)) in (0_i32..).zip(self.entries()) {
            let (x, y) = (12 * (columns - 1) + k % columns * 200, 20 + k / columns * 22 - 12 * (columns - 1));
            match stroke {
                Stroke::Dots => area.draw(&Circle::new((x + 11, y), 4, style.filled()))?,
                Stroke::Rings => area.draw(&Circle::new((x + 11, y), 6, style))?,
                Stroke::Dashed => {
                    area.draw(&PathElement::new(vec![(x, y), (x + 7, y)], style))?;
                    area.draw(&PathElement::new(vec![(x + 12, y), (x + 19, y)], style))?;
                }
                Stroke::Dotted => {
                    for dot in 0..4 {
                        area.draw(&PathElement::new(vec![(x + 6 * dot, y), (x + 6 * dot + 2, y)], style))?;
                    }
                }
                Stroke::Solid | Stroke::Thin => {
                    area.draw(&PathElement::new(vec![(x, y), (x + 22, y)], style))?;
                }
            }
            area.draw_text(name, &text, (x + 30, y - 8))?;
        }
        Ok(())
    }

    /// What the axes cover: the horizontal just, the vertical with some air.
    fn ranges(&self) -> ((f64, f64), (f64, f64)) {
        let points = || self.lines.iter().flat_map(|l| &l.points);
        let within = |values: &mut dyn Iterator<Item = f64>| {
            values
                .filter(|v| v.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let edges = self.bands.iter().flat_map(|b| &b.points).flat_map(|p| [p.1, p.2]);
        let values = points().map(|p| p.1).chain(self.limits.iter().copied()).chain(edges);
        let across = within(&mut points().map(|p| p.0));
        let up = within(&mut values.map(|v| self.drawn(v)));
        let (low, high) = if up.0 < up.1 { up } else { (up.0 - 1.0, up.0 + 1.0) };
        let air = 0.06 * (high - low);
        let across = if across.0 < across.1 { across } else { (0.0, 1.0) };
        if low.is_finite() { (across, (low - air, high + air)) } else { (across, (0.0, 1.0)) }
    }
}

/// Is it a character that XML 1.0 does not allow (section 2.2)?
fn is_no_xml(c: char) -> bool {
    (c < ' ' && !matches!(c, '\t' | '\n' | '\r')) || matches!(c, '\u{fffe}' | '\u{ffff}')
}

#[cfg(test)]
mod tests;
