//! A map: what something costs over two coordinates, in bands of parts of the least.

use crate::labels::number;
use crate::{Colour, FONT, FONT_DATA, SOFT, is_no_xml};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::fmt::Write as _;
use twinrotor_sim::{Error, Outcome};

/// One coordinate of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// What it is, with its unit.
    pub label: String,
    /// Its first value.
    pub from: f64,
    /// Its last.
    pub to: f64,
    /// Equal factors and not equal differences are equally far apart.
    pub logarithmic: bool,
    /// Cells along it.
    pub cells: usize,
}

impl Scale {
    /// The value at a part of the whole.
    fn value(&self, part: f64) -> f64 {
        if self.logarithmic {
            self.from * (self.to / self.from).powf(part)
        } else {
            self.from + (self.to - self.from) * part
        }
    }

    /// At which part of the whole a value is.
    fn part(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }

    /// The cell of a part.
    fn cell(&self, part: f64) -> usize {
        let most = self.cells.saturating_sub(1);
        (0..most).take_while(|k| (*k + 1) as f64 <= part * self.cells as f64).count()
    }

    fn told(&self, part: f64) -> String {
        let value = self.value(part);
        number(value, if self.logarithmic { value } else { (self.to - self.from) / 4.0 })
    }
}

/// A map.
#[derive(Debug, Clone)]
pub struct Map {
    /// Above everything.
    pub title: String,
    /// Across.
    pub x: Scale,
    /// Up.
    pub y: Scale,
    /// What is mapped.
    pub what: String,
    /// Row by row, the lowest first.
    pub values: Vec<f64>,
    /// Points with words beside them.
    pub marks: Vec<(f64, f64, String)>,
}

/// Up to which part of the least a band reaches, and its colour: viridis, the least darkest, which
/// the colour-blind and a printer without colour keep in order.
const BANDS: [(f64, Colour); 8] = [
    (1.01, RGBColor(68, 1, 84)),
    (1.03, RGBColor(70, 50, 127)),
    (1.1, RGBColor(54, 92, 141)),
    (1.25, RGBColor(39, 127, 142)),
    (1.5, RGBColor(31, 161, 135)),
    (2.0, RGBColor(74, 194, 109)),
    (4.0, RGBColor(159, 218, 58)),
    (10.0, RGBColor(253, 231, 37)),
];
/// Beyond them, and where there is no number.
const BEYOND: Colour = RGBColor(225, 225, 225);
const SIZE: (u32, u32) = (900, 700);
const LEGEND: u32 = 190;

type Drawn<T, B> = Result<T, DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

impl Map {
    /// As an SVG document.
    ///
    /// # Errors
    ///
    /// If it cannot be drawn.
    pub fn to_svg(&self) -> Outcome<String> {
        FONT.call_once(|| {
            // It is the one font there is, and a static one: registering it cannot fail.
            let _ = register_font("sans-serif", FontStyle::Normal, FONT_DATA);
        });
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let drawn = self.draw(&area);
        drawn.map_err(|e| Error::Failed(format!("the map cannot be drawn: {e}")))?;
        drop(area);
        Ok(text.replace(is_no_xml, "\u{fffd}"))
    }

    fn least(&self) -> f64 {
        self.values.iter().copied().filter(|v| v.is_finite()).fold(f64::INFINITY, f64::min)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<(), B> {
        area.fill(&WHITE)?;
        let title = ("sans-serif", 20).into_text_style(area).color(&BLACK);
        area.draw_text(&self.title, &title, (16, 14))?;
        let (_, body) = area.split_vertically(44);
        let (body, legend) = body.split_horizontally(SIZE.0 - LEGEND);
        let mut chart = ChartBuilder::on(&body)
            .margin_left(12)
            .margin_right(14)
            .margin_top(8)
            .margin_bottom(8)
            .x_label_area_size(44)
            .y_label_area_size(72)
            .build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
        self.fill(&chart.plotting_area().strip_coord_spec())?;
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(SOFT)
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_desc(self.x.label.as_str())
            .y_desc(self.y.label.as_str())
            .x_labels(6)
            .y_labels(6)
            .x_label_formatter(&|part| self.x.told(*part))
            .y_label_formatter(&|part| self.y.told(*part))
            .draw()?;
        let words = ("sans-serif", 14).into_text_style(area).color(&BLACK);
        for (x, y, text) in &self.marks {
            let (x, y) = (self.x.part(*x), self.y.part(*y));
            // Words stay inside, and can be read on any band.
            let left = if x > 0.7 { -10 - 7 * i32::try_from(text.chars().count()).unwrap_or(0) } else { 10 };
            let width = 7 * i32::try_from(text.chars().count()).unwrap_or(0) + 8;
            let paper = Rectangle::new([(left - 4, -10), (left - 4 + width, 8)], WHITE.mix(0.8).filled());
            let mark = EmptyElement::at((x, y))
                + paper
                + Circle::new((0, 0), 6, WHITE.filled())
                + Circle::new((0, 0), 4, BLACK.filled())
                + Text::new(text.clone(), (left, -8), words.clone());
            chart.draw_series(std::iter::once(mark))?;
        }
        self.legend(&legend)
    }

    /// Pixel by pixel, neighbours of one band together.
    fn fill<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<(), B> {
        let least = self.least();
        let colour = |value: f64| {
            BANDS.iter().find(|(most, _)| value <= least * most).map_or(BEYOND, |(_, colour)| *colour)
        };
        let (width, height) = area.dim_in_pixel();
        let middle = |pixel: u32, of: u32| (f64::from(pixel) + 0.5) / f64::from(of);
        let columns: Vec<usize> = (0..width).map(|x| self.x.cell(middle(x, width))).collect();
        let row = |y: u32| -> Vec<(u32, u32, Colour)> {
            let base = self.y.cell(1.0 - middle(y, height)) * self.x.cells;
            let mut runs: Vec<(u32, u32, Colour)> = Vec::new();
            for (x, column) in (0..).zip(&columns) {
                let here = colour(self.values.get(base + column).copied().unwrap_or(f64::NAN));
                match runs.last_mut() {
                    Some((_, to, colour)) if *colour == here => *to = x + 1,
                    _ => runs.push((x, x + 1, here)),
                }
            }
            runs
        };
        let mut begun = (0, row(0));
        for y in 1..=height {
            let here = if y < height { row(y) } else { Vec::new() };
            if here != begun.1 {
                for (from, to, colour) in &begun.1 {
                    let corner = |x: u32, y: u32| (x.cast_signed(), y.cast_signed());
                    let corners = [corner(*from, begun.0), corner(*to, y)];
                    area.draw(&Rectangle::new(corners, colour.filled()))?;
                }
                begun = (y, here);
            }
        }
        Ok(())
    }

    fn legend<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<(), B> {
        let text = ("sans-serif", 14).into_text_style(area).color(&BLACK);
        let least = self.least();
        area.draw_text(&self.what, &text, (6, 12))?;
        let bands = BANDS.iter().map(|(most, colour)| (format!("to {:.4}", least * most), *most, *colour));
        let beyond = ("beyond, or none".to_owned(), f64::INFINITY, BEYOND);
        for (k, (told, most, colour)) in (0_i32..).zip(bands.chain([beyond])) {
            let y = 44 + 26 * k;
            area.draw(&Rectangle::new([(6, y), (28, y + 18)], colour.filled()))?;
            let mut line = told;
            if most.is_finite() {
                let _ = write!(line, "  (x {most})");
            }
            area.draw_text(&line, &text, (36, y + 2))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(label: &str, logarithmic: bool) -> Scale {
        Scale { label: label.to_owned(), from: 1.0, to: 16.0, logarithmic, cells: 40 }
    }

    fn map() -> Map {
        let (x, y) = (scale("k1", true), scale("k2", false));
        let value = |cell: usize| {
            let at = |k: usize| (k as f64 + 0.5) / 40.0;
            1.0 + 30.0 * ((at(cell % 40) - 0.25).powi(2) + (at(cell / 40) - 0.5).powi(2))
        };
        let mut values: Vec<f64> = (0..1600).map(value).collect();
        values[1599] = f64::NAN;
        let marks = vec![(2.0, 8.5, "best".to_owned())];
        Map { title: "A bowl".to_owned(), x, y, what: "J".to_owned(), values, marks }
    }

    #[test]
    fn a_value_is_where_its_scale_says() {
        for logarithmic in [false, true] {
            let scale = scale("k", logarithmic);
            for part in [0.0, 0.2, 1.0] {
                assert!((scale.part(scale.value(part)) - part).abs() < 1e-12);
            }
            assert_eq!((scale.cell(0.0), scale.cell(0.5), scale.cell(1.0)), (0, 20, 39));
        }
        assert!((scale("k", true).value(0.5) - 4.0).abs() < 1e-12);
    }

    /// Every pixel of the axes lies in exactly one rectangle, of the colour of the band that it is in.
    #[test]
    fn the_bands_cover_the_axes_once_and_the_darkest_is_where_least_is() {
        let svg = map().to_svg().unwrap();
        let number = |tag: &str, name: &str| -> Option<i64> {
            let rest = &tag[tag.find(&format!(" {name}=\""))? + name.len() + 3..];
            rest[..rest.find('"')?].parse().ok()
        };
        let fills: Vec<(i64, &str)> = svg
            .lines()
            .filter(|line| line.starts_with("<rect") && line.contains("fill=\"#"))
            .filter_map(|tag| {
                let colour = tag.split("fill=\"").nth(1)?.get(..7)?;
                Some((number(tag, "width")? * number(tag, "height")?, colour))
            })
            .collect();
        let total = |colour: &str| -> i64 { fills.iter().filter(|f| f.1 == colour).map(|f| f.0).sum() };
        let bands: i64 =
            BANDS.iter().map(|(_, c)| total(&format!("#{:02X}{:02X}{:02X}", c.0, c.1, c.2))).sum();
        let axes = i64::from(SIZE.0 - LEGEND - 12 - 14 - 72) * i64::from(SIZE.1 - 44 - 8 - 8 - 44);
        let grey = total("#E1E1E1");
        let legend = 9 * 22 * 18;
        assert_eq!(bands + grey - legend, axes);
        // Within 1.5 of the least: a circle of radius sqrt(.5/30), in parts of the axes.
        let dark = ["#440154", "#46327F", "#365C8D", "#277F8E", "#1FA187"].map(total);
        let within = (dark.iter().sum::<i64>() - 5 * 22 * 18) as f64 / axes as f64;
        let circle = std::f64::consts::PI * 0.5 / 30.0;
        assert!((within / circle - 1.0).abs() < 0.1, "{within} {circle}");
    }
}
