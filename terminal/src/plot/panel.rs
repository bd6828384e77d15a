//! One panel: axes, curves and their legend.

use super::colour;
use plotters::chart::DualCoordChartContext;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Part of the picture.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Error of the drawing library.
pub(super) type DrawError = DrawingAreaErrorKind<<SVGBackend<'static> as DrawingBackend>::ErrorType>;

type Coordinates = Cartesian2d<RangedCoordf64, RangedCoordf64>;
type Chart<'a> = DualCoordChartContext<'a, SVGBackend<'a>, Coordinates, Coordinates>;

/// Margins left and right of every panel, so that all have the same time axis.
pub(super) const LEFT: u32 = 64;
pub(super) const RIGHT: u32 = 50;
/// Height of a panel's head, for its title and legend.
const HEAD: u32 = 26;
const TIME_AXIS: u32 = 40;
/// Units of the library per pixel: it places points on whole units.
const SCALE: u32 = 4;

/// Converts pixels to drawing units.
pub(super) const fn px(pixels: u32) -> u32 {
    pixels * SCALE
}

/// Shape of a curve.
pub(super) enum Shape {
    /// Points joined by a line.
    Line(Vec<(f64, f64)>),
    /// Area between two lines: x, lower, upper.
    Band(Vec<(f64, f64, f64)>),
}

/// A curve.
pub(super) struct Curve {
    pub(super) legend: &'static str,
    pub(super) colour: RGBColor,
    /// Width of the line, pixels.
    pub(super) width: f64,
    pub(super) shape: Shape,
}

/// A vertical axis.
pub(super) struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    /// Builds an axis from `low` to `high`.
    pub(super) const fn fixed(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// Builds an axis that contains all curves and zero, with a margin.
    pub(super) fn around(curves: &[Curve]) -> Self {
        let mut extremes = Vec::new();
        for curve in curves {
            match &curve.shape {
                Shape::Line(points) => extremes.extend(points.iter().map(|(_, y)| *y)),
                Shape::Band(band) => extremes.extend(band.iter().flat_map(|(_, low, high)| [*low, *high])),
            }
        }
        let low = extremes.iter().copied().filter(|y| y.is_finite()).fold(0.0, f64::min);
        let high = extremes.iter().copied().filter(|y| y.is_finite()).fold(0.0, f64::max);
        let air = ((high - low) * 0.06).max(1e-3);
        Self { low: if low < 0.0 { low - air } else { 0.0 }, high: high + air }
    }
}

/// Curves over a stretch of time.
pub(super) struct Panel {
    /// Title with the unit of the axis.
    title: &'static str,
    time: (f64, f64),
    axis: Axis,
    curves: Vec<Curve>,
    /// Curves with an axis of their own, on the right.
    pub(super) secondary: Option<(Axis, Vec<Curve>)>,
}

impl Panel {
    pub(super) fn new(title: &'static str, time: (f64, f64), axis: Axis, curves: Vec<Curve>) -> Self {
        Self { title, time, axis, curves, secondary: None }
    }

    /// Draws the panel, with a time axis if that has a name, and a faint line at each of `marks`.
    pub(super) fn draw(
        &self,
        area: &Area<'_>,
        time_axis: Option<&str>,
        marks: &[f64],
    ) -> Result<(), DrawError> {
        let (head, body) = area.split_vertically(px(HEAD));
        self.draw_head(&head)?;
        let second = self.secondary.as_ref().map_or(&self.axis, |(axis, _)| axis);
        // The right margin is equal with an axis in it and without.
        let (margin, labels) = if self.secondary.is_some() { (0, px(RIGHT)) } else { (px(RIGHT), 0) };
        let mut chart = ChartBuilder::on(&body)
            .margin_top(px(3))
            .margin_bottom(px(5))
            .margin_right(margin)
            .set_label_area_size(LabelAreaPosition::Left, px(LEFT))
            .set_label_area_size(LabelAreaPosition::Right, labels)
            .set_label_area_size(LabelAreaPosition::Bottom, time_axis.map_or(0, |_| px(TIME_AXIS)))
            .build_cartesian_2d(self.time.0..self.time.1, self.axis.low..self.axis.high)?
            .set_secondary_coord(self.time.0..self.time.1, second.low..second.high);
        self.draw_axes(&mut chart, time_axis.unwrap_or(""))?;
        for mark in marks {
            let line = [(*mark, self.axis.low), (*mark, self.axis.high)];
            chart.draw_series([PathElement::new(line, colour::GREY.mix(0.7).stroke_width(SCALE))])?;
        }
        for curve in &self.curves {
            match &curve.shape {
                Shape::Line(points) => chart.draw_series([curve.path(points)])?,
                Shape::Band(band) => chart.draw_series([curve.polygon(band)])?,
            };
        }
        for curve in self.secondary.iter().flat_map(|(_, curves)| curves) {
            if let Shape::Line(points) = &curve.shape {
                chart.draw_secondary_series([curve.path(points)])?;
            }
        }
        Ok(())
    }

    fn draw_axes<'a>(&self, chart: &mut Chart<'a>, time_axis: &str) -> Result<(), DrawError> {
        let text = ("sans-serif", px(14), &colour::BLACK).into_text_style(chart.plotting_area());
        let axis = BLACK.mix(0.55).stroke_width(SCALE);
        let number = |value: &f64| number(*value);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.13).stroke_width(SCALE))
            .axis_style(axis)
            .x_labels(11)
            .y_labels(6)
            .x_desc(time_axis)
            .x_label_formatter(&number)
            .y_label_formatter(&number)
            .label_style(text.clone())
            .axis_desc_style(text.clone())
            .set_all_tick_mark_size(px(4))
            .draw()?;
        if self.secondary.is_some() {
            chart
                .configure_secondary_axes()
                .y_labels(6)
                .y_label_formatter(&number)
                .axis_style(axis)
                .label_style(text)
                .set_all_tick_mark_size(px(4))
                .draw()?;
        }
        Ok(())
    }

    /// Draws the title on the left, and the legend from the right.
    fn draw_head(&self, area: &Area<'_>) -> Result<(), DrawError> {
        let middle = px(HEAD) as i32 / 2 + px(3) as i32;
        let left = Pos::new(HPos::Left, VPos::Center);
        let title = ("sans-serif", px(16), FontStyle::Bold, &colour::BLACK).into_text_style(area).pos(left);
        area.draw_text(self.title, &title, (px(LEFT) as i32, middle))?;

        let text = ("sans-serif", px(14), &colour::BLACK).into_text_style(area).pos(left);
        let curves: Vec<&Curve> =
            self.curves.iter().chain(self.secondary.iter().flat_map(|(_, curves)| curves)).collect();
        let mut x = area.dim_in_pixel().0 as i32 - px(RIGHT) as i32;
        for curve in curves.into_iter().rev() {
            // No font is available for measuring; sans-serif letters are about half as wide as high.
            x -= (curve.legend.len() as f64 * 6.6 * f64::from(SCALE)) as i32;
            area.draw_text(curve.legend, &text, (x, middle))?;
            x -= px(28) as i32;
            let half = if curve.width == 0.0 { px(5) } else { px(1) } as i32;
            let swatch = [(x, middle - half), (x + px(22) as i32, middle + half)];
            area.draw(&Rectangle::new(swatch, curve.style_filled()))?;
            x -= px(16) as i32;
        }
        Ok(())
    }
}

impl Curve {
    fn path(&self, points: &[(f64, f64)]) -> PathElement<(f64, f64)> {
        let width = (self.width * f64::from(SCALE)).round() as u32;
        PathElement::new(points.to_vec(), self.colour.stroke_width(width))
    }

    fn polygon(&self, band: &[(f64, f64, f64)]) -> Polygon<(f64, f64)> {
        let upper = band.iter().map(|(x, _, high)| (*x, *high));
        let lower = band.iter().rev().map(|(x, low, _)| (*x, *low));
        Polygon::new(upper.chain(lower).collect::<Vec<_>>(), self.style_filled())
    }

    fn style_filled(&self) -> ShapeStyle {
        let opacity = if self.width == 0.0 { 0.55 } else { 1.0 };
        self.colour.mix(opacity).filled()
    }
}

/// Formats a number of an axis, with no more digits than it needs.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    // A typographic minus sign, and no negative zero.
    if text == "-0" { "0".into() } else { text.replace('-', "\u{2212}") }
}
