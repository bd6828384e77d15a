//! A run as a picture for a report: speed, currents, duty and supply over time, the states above them, and
//! the phase currents of the last revolutions below.

mod decimate;
mod panel;
mod states;

use decimate::{extents, line, means};
use narx_sim::trace::{Column, Trace};
use panel::{Area, Axis, Curve, Panel, Shape, px};
use plotters::prelude::*;
use std::fmt;

/// Colours that the colour-blind can distinguish (Okabe and Ito, "Color Universal Design", 2008).
mod colour {
    use plotters::style::RGBColor;
    pub(super) const BLACK: RGBColor = RGBColor(0x22, 0x22, 0x22);
    pub(super) const GREY: RGBColor = RGBColor(0x99, 0x99, 0x99);
    pub(super) const ORANGE: RGBColor = RGBColor(0xe6, 0x9f, 0x00);
    pub(super) const SKY: RGBColor = RGBColor(0x56, 0xb4, 0xe9);
    pub(super) const GREEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
    pub(super) const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xb2);
    pub(super) const VERMILION: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
    pub(super) const PURPLE: RGBColor = RGBColor(0xcc, 0x79, 0xa7);
}

/// Number of stretches of time with which a curve is drawn: one for each 1.5 pixels of an ordinary screen.
const STRETCHES: usize = 600;
const WIDTH: u32 = 1_100;
const TITLE_HEIGHT: u32 = 58;
const STATES_HEIGHT: u32 = 30;
const PANEL_HEIGHT: u32 = 220;
/// Height of the panel with the time axis, which also serves the panels above.
const LAST_PANEL_HEIGHT: u32 = 252;

/// Text above the picture.
pub struct Caption<'a> {
    /// The motor.
    pub title: &'a str,
    /// Mode, speed, supply, load and PWM rate.
    pub subtitle: &'a str,
}

/// Reason why there is no picture.
#[derive(Debug, PartialEq)]
pub enum PlotError {
    /// The trace lacks a signal.
    Missing(&'static str),
    /// The trace has fewer than two rows.
    TooShort,
    /// Error of the drawing library.
    Drawing(String),
}

impl fmt::Display for PlotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(name) => write!(f, "the trace has no signal \"{name}\""),
            Self::TooShort => write!(f, "the trace has fewer than two rows"),
            Self::Drawing(reason) => write!(f, "the picture could not be drawn: {reason}"),
        }
    }
}

impl std::error::Error for PlotError {}

/// Draws a trace that has at least the signals of `run.csv`, and in a panel of their own the displacements
/// (mm) of the same rows.
pub fn svg(trace: &Trace, displacements: Option<&Trace>, caption: &Caption<'_>) -> Result<String, PlotError> {
    let run = Run::new(trace)?;
    let mut panels = vec![run.speed(), run.currents(), run.duty()?];
    panels.extend(displacements.map(|trace| run.displacements(trace)));
    let zoom = run.last_revolutions();
    let above = panels.len() as u32 - 1;
    let height = TITLE_HEIGHT + STATES_HEIGHT + above * PANEL_HEIGHT + 2 * LAST_PANEL_HEIGHT;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (px(WIDTH), px(height))).into_drawing_area();
        let draw = || -> Result<(), panel::DrawError> {
            root.fill(&WHITE)?;
            let (title, rest) = root.split_vertically(px(TITLE_HEIGHT));
            draw_title(&title, caption)?;
            let (band, mut rest) = rest.split_vertically(px(STATES_HEIGHT));
            let changes = states::draw(&band, &run.time, &run.state)?;
            for (index, panel) in panels.iter().enumerate() {
                let last = index + 1 == panels.len();
                let height = if last { LAST_PANEL_HEIGHT } else { PANEL_HEIGHT };
                let (area, below) = rest.split_vertically(px(height));
                panel.draw(&area, last.then_some("time, s"), &changes)?;
                rest = below;
            }
            zoom.draw(&rest, Some("time, s"), &[])?;
            root.present()
        };
        draw().map_err(|error| PlotError::Drawing(error.to_string()))?;
    }
    // The drawing is large, because the library places points on whole units; it is shown at its proper size.
    let large = format!("width=\"{}\" height=\"{}\"", px(WIDTH), px(height));
    Ok(text.replacen(&large, &format!("width=\"{WIDTH}\" height=\"{height}\""), 1))
}

/// Returns the picture for a page with a dark background.
pub fn dark(svg: &str) -> String {
    // Background, text, grid and the one curve whose colour is too dark.
    let colours =
        [("#FFFFFF", "#0D1117"), ("#222222", "#E6EDF3"), ("#000000", "#E6EDF3"), ("#0072B2", "#58A6FF")];
    colours.iter().fold(svg.to_owned(), |text, (light, dark)| text.replace(light, dark))
}

fn draw_title(area: &Area<'_>, caption: &Caption<'_>) -> Result<(), panel::DrawError> {
    let left = px(panel::LEFT) as i32;
    let title = ("sans-serif", px(21), FontStyle::Bold, &colour::BLACK).into_text_style(area);
    area.draw_text(caption.title, &title, (left, px(9) as i32))?;
    let subtitle = ("sans-serif", px(15), &colour::BLACK).into_text_style(area);
    area.draw_text(caption.subtitle, &subtitle, (left, px(34) as i32))
}

/// Signals to draw.
struct Run<'a> {
    trace: &'a Trace,
    time: Vec<f64>,
    state: Vec<f64>,
    sector: Vec<f64>,
    phases: [Vec<f64>; 3],
}

impl<'a> Run<'a> {
    fn new(trace: &'a Trace) -> Result<Self, PlotError> {
        let column = |name| column(trace, name);
        for name in ["speed", "speed_estimated", "setpoint", "bus_current"] {
            column(name)?;
        }
        let run = Self {
            trace,
            time: column("time")?,
            state: column("state")?,
            sector: column("sector")?,
            phases: [column("current_a")?, column("current_b")?, column("current_c")?],
        };
        if run.time.len() < 2 { Err(PlotError::TooShort) } else { Ok(run) }
    }

    fn points(&self, name: &'static str) -> Vec<(f64, f64)> {
        let values = column(self.trace, name).unwrap_or_default();
        self.time.iter().copied().zip(values).collect()
    }

    fn curve(&self, name: &'static str, legend: &'static str, colour: RGBColor) -> Curve {
        Curve { legend, colour, width: 1.5, shape: Shape::Line(line(&self.points(name), STRETCHES)) }
    }

    fn time_range(&self) -> (f64, f64) {
        // Up to the end of the last row's period.
        match self.time.as_slice() {
            // Slightly more, so that a round end has its number on the axis.
            [first, .., before, last] => (*first, last + (last - before) * 1.000_1),
            [first, last] => (*first, *last),
            _ => (0.0, 1.0),
        }
    }

    fn speed(&self) -> Panel {
        let curves = vec![
            self.curve("speed_estimated", "estimated", colour::ORANGE),
            self.curve("speed", "true", colour::BLUE),
            Curve { width: 1.2, ..self.curve("setpoint", "set-point", colour::BLACK) },
        ];
        Panel::new("Speed, rpm", self.time_range(), Axis::around(&curves), curves)
    }

    fn currents(&self) -> Panel {
        // The phase currents are one band: the conducting phase changes far faster than a pixel.
        let any_phase = |pick: fn(f64, f64) -> f64| -> Vec<f64> {
            let [a, b, c] = &self.phases;
            a.iter().zip(b).zip(c).map(|((a, b), c)| pick(pick(*a, *b), *c)).collect()
        };
        let [low, high] = [any_phase(f64::min), any_phase(f64::max)].map(|values| {
            let points: Vec<(f64, f64)> = self.time.iter().copied().zip(values).collect();
            extents(&points, STRETCHES)
        });
        let phases = low.iter().zip(&high).map(|(low, high)| (low.min.0, low.min.1, high.max.1)).collect();
        // The bus current falls with every commutation: its range and its mean are drawn.
        let bus = self.points("bus_current");
        let bus_range = extents(&bus, STRETCHES).iter().map(|e| (e.min.0, e.min.1, e.max.1)).collect();
        let band = |legend, colour, band| Curve { legend, colour, width: 0.0, shape: Shape::Band(band) };
        let curves = vec![
            band("phases A, B, C (range)", colour::SKY, phases),
            band("bus (range)", colour::ORANGE, bus_range),
            Curve {
                legend: "bus (mean)",
                colour: colour::VERMILION,
                width: 1.5,
                shape: Shape::Line(means(&bus, STRETCHES)),
            },
        ];
        Panel::new("Currents, A", self.time_range(), Axis::around(&curves), curves)
    }

    fn duty(&self) -> Result<Panel, PlotError> {
        let voltage = column(self.trace, "bus_voltage")?;
        let top = voltage.into_iter().filter(|v| v.is_finite()).fold(1.0, f64::max) * 1.12;
        column(self.trace, "duty")?;
        let duty = vec![self.curve("duty", "duty (left)", colour::GREEN)];
        let supply = vec![self.curve("bus_voltage", "bus voltage, V (right)", colour::PURPLE)];
        let mut panel = Panel::new("Duty and bus voltage, V", self.time_range(), Axis::fixed(0.0, 1.0), duty);
        panel.secondary = Some((Axis::fixed(0.0, top), supply));
        Ok(panel)
    }

    /// Panel with the displacements of the first TX-Drivers, each from its first position.
    fn displacements(&self, trace: &Trace) -> Panel {
        const DRAWN: [(&str, RGBColor); 4] = [
            ("TX-Driver 1", colour::BLUE),
            ("TX-Driver 2", colour::VERMILION),
            ("TX-Driver 3", colour::GREEN),
            ("TX-Driver 4", colour::PURPLE),
        ];
        let curve = |(column, (legend, colour)): (&Column, (&'static str, RGBColor))| {
            let first = column.iter().find(|position| !position.is_nan()).unwrap_or(0.0);
            let moved = column.iter().map(|position| 1e3 * (position - first));
            let points: Vec<(f64, f64)> = self.time.iter().copied().zip(moved).collect();
            Curve { legend, colour, width: 1.2, shape: Shape::Line(line(&points, STRETCHES)) }
        };
        let curves: Vec<Curve> = trace.columns().iter().zip(DRAWN).map(curve).collect();
        let axis = Axis::around(&curves);
        Panel::new("Displacement, um from the first position", self.time_range(), axis, curves)
    }

    /// Panel with the phase currents in detail, at the end of the last stretch of rotation under control.
    fn last_revolutions(&self) -> Panel {
        let (from, to) = self.last_sectors();
        let colours = [colour::ORANGE, colour::BLUE, colour::GREEN];
        let curve = |(index, legend): (usize, &'static str)| {
            let points: Vec<(f64, f64)> = (from..to)
                .filter_map(|row| Some((*self.time.get(row)?, *self.phases[index].get(row)?)))
                .collect();
            let shape = Shape::Line(line(&points, STRETCHES));
            Curve { legend, colour: colours[index], width: 1.5, shape }
        };
        let mut curves: Vec<Curve> =
            ["phase A", "phase B", "phase C"].into_iter().enumerate().map(curve).collect();
        let bus: Vec<(f64, f64)> = self.points("bus_current").drain(from..to).collect();
        curves.push(Curve {
            legend: "bus",
            colour: colour::VERMILION,
            width: 1.2,
            shape: Shape::Line(line(&bus, STRETCHES)),
        });
        let range = (self.time[from], self.time[to - 1]);
        Panel::new("Currents in the last electrical revolutions, A", range, Axis::around(&curves), curves)
    }

    /// Range of rows of up to 18 sectors (three electrical revolutions) before control ended, at least 100.
    fn last_sectors(&self) -> (usize, usize) {
        const ROWS_MIN: usize = 100;
        const ROWS_MAX: usize = 5_000;
        let controlled = |state: &f64| (2.0..=5.0).contains(state) || *state == 7.0;
        let end = self.state.iter().rposition(controlled).map_or(self.time.len(), |row| row + 1).max(2);
        let mut changes = 0;
        let mut start = end - 1;
        while start > 0 && end - start < ROWS_MAX && (changes < 18 || end - start < ROWS_MIN) {
            changes += usize::from(self.sector[start] != self.sector[start - 1]);
            start -= 1;
        }
        (start, end)
    }
}

fn column(trace: &Trace, name: &'static str) -> Result<Vec<f64>, PlotError> {
    Ok(trace.column(name).ok_or(PlotError::Missing(name))?.iter().collect())
}

#[cfg(test)]
mod tests;
