//! A line of a panel, drawn with as many points as a page shows.

use crate::COLOURS;
use plotters::prelude::*;

/// More points than this on a line cannot be seen.
pub(crate) const MOST_POINTS: usize = 1_200;
/// \[pixels\] A line longer than this is not drawn in dashes, each of which is an element of its own.
const MOST_DASHED: f64 = 12_000.0;

/// A line with a name.
#[derive(Debug, Clone)]
pub struct Line {
    /// In the legend; none if empty.
    pub name: String,
    /// Horizontal and vertical.
    pub points: Vec<(f64, f64)>,
    /// Which of [`COLOURS`].
    pub colour: usize,
    /// How it is drawn.
    pub stroke: Stroke,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// Through.
    Solid,
    /// In dashes.
    Dashed,
    /// In short dashes, further apart.
    Dotted,
    /// Through, and thin: one of many.
    Thin,
    /// A dot at each point and nothing between.
    Dots,
    /// A ring at each point and nothing between.
    Rings,
}

/// How many lines of a figure differ in colour alone: all of [`COLOURS`] but the grey, which references have.
pub const SERIES: usize = COLOURS.len() - 1;

/// Colour and stroke of the `k`th of many lines: through, then in dashes, then in dots, each time in all
/// colours.
pub fn series(k: usize) -> (usize, Stroke) {
    let strokes = [Stroke::Solid, Stroke::Dashed, Stroke::Dotted];
    (k % SERIES, strokes[k / SERIES % strokes.len()])
}

type Axis = plotters::coord::types::RangedCoordf64;

impl Line {
    pub(crate) fn style(&self) -> ShapeStyle {
        let width = if self.stroke == Stroke::Thin { 1 } else { 2 };
        COLOURS[self.colour % COLOURS.len()].stroke_width(width)
    }

    pub(crate) fn draw<'a, B: DrawingBackend + 'a>(
        &self,
        chart: &mut ChartContext<'a, B, Cartesian2d<Axis, Axis>>,
        drawn: impl Fn(f64) -> f64,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let points = self.thinned().into_iter().map(|(x, y)| (x, drawn(y))).filter(|p| p.1.is_finite());
        let points: Vec<(f64, f64)> = points.collect();
        let pixels = points.windows(2).map(|w| {
            let ends = [w[0], w[1]].map(|p| chart.plotting_area().map_coordinate(&p));
            f64::hypot(f64::from(ends[0].0 - ends[1].0), f64::from(ends[0].1 - ends[1].1))
        });
        let broken = matches!(self.stroke, Stroke::Dashed | Stroke::Dotted);
        let crowded = broken && pixels.sum::<f64>() > MOST_DASHED;
        let points = points.into_iter();
        let style = self.style();
        match self.stroke {
            // Dashes that fill the area cannot be told apart either.
            _ if crowded => {
                chart.draw_series(LineSeries::new(points, style))?;
            }
            Stroke::Solid | Stroke::Thin => {
                chart.draw_series(LineSeries::new(points, style))?;
            }
            Stroke::Dashed => {
                chart.draw_series(DashedLineSeries::new(points.collect::<Vec<_>>(), 7, 5, style))?;
            }
            Stroke::Dotted => {
                chart.draw_series(DashedLineSeries::new(points.collect::<Vec<_>>(), 2, 4, style))?;
            }
            Stroke::Dots => {
                chart.draw_series(points.map(|p| Circle::new(p, 3, style.filled())))?;
            }
            Stroke::Rings => {
                chart.draw_series(points.map(|p| Circle::new(p, 7, style)))?;
            }
        }
        Ok(())
    }

    /// Of each stretch the least and the most, so that a spike of one tick is still seen.
    pub(crate) fn thinned(&self) -> Vec<(f64, f64)> {
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
        let ends = [all.first(), all.last()].map(|end| end.copied());
        if let [Some(first), Some(last)] = ends {
            if thin.first() != Some(&first) {
                thin.insert(0, first);
            }
            if thin.last() != Some(&last) {
                thin.push(last);
            }
        }
        thin
    }
}
