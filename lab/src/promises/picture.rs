//! Success of sensorless starts: three maps of one series of random plants, drawn as a picture for a report.

use super::start::Start;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Area to draw on.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Error of the drawing library.
pub(crate) type DrawError = DrawingAreaErrorKind<<SVGBackend<'static> as DrawingBackend>::ErrorType>;

const WIDTH: u32 = 1_200;
const HEIGHT: u32 = 470;
/// Units of the library per pixel: it places points on whole units.
pub(crate) const SCALE: u32 = 4;
/// Number of tiles along each axis.
const TILES: usize = 10;
/// Share of first tries at which the shade is darkest; smaller shares are as dark.
const DARKEST: f64 = 0.8;
/// Colour of lines and letters.
pub(crate) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Okabe and Ito's blue; the colour-blind can distinguish it from their vermilion.
const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xb2);
/// Their vermilion, for failures.
pub(crate) const VERMILION: RGBColor = RGBColor(0xd5, 0x5e, 0x00);

/// An axis: a figure of the start between bounds, on a logarithmic or linear scale.
struct Axis {
    title: &'static str,
    of: fn(&Start) -> f64,
    range: (f64, f64),
    logarithmic: bool,
    marks: &'static [f64],
}

const INERTIA: Axis = Axis {
    title: "inertia, times the data sheet's",
    of: |start| start.drawn.inertia,
    range: (0.2, 5.0),
    logarithmic: true,
    marks: &[0.2, 0.5, 1.0, 2.0, 5.0],
};
const LOAD: Axis = Axis {
    title: "load, % of rated torque",
    of: |start| 100.0 * start.drawn.load,
    range: (0.0, 30.0),
    logarithmic: false,
    marks: &[0.0, 10.0, 20.0, 30.0],
};
const FRICTION: Axis = Axis {
    title: "Coulomb friction, times nominal",
    of: |start| start.drawn.friction,
    range: (0.0, 3.0),
    logarithmic: false,
    marks: &[0.0, 1.0, 2.0, 3.0],
};
const SUPPLY: Axis = Axis {
    title: "supply, V",
    of: |start| start.drawn.plant.supply.voltage,
    range: (18.0, 60.0),
    logarithmic: false,
    marks: &[18.0, 24.0, 36.0, 48.0, 60.0],
};
const TEMPERATURE: Axis = Axis {
    title: "winding temperature, \u{b0}C (from R)",
    of: |start| start.drawn.winding_temperature(),
    // 0.9 and 1.65 of the resistance at 25 degrees.
    range: (-0.445, 190.4),
    logarithmic: false,
    marks: &[0.0, 50.0, 100.0, 150.0, 190.0],
};

impl Axis {
    /// Position along the axis, 0 to 1.
    fn place(&self, value: f64) -> f64 {
        let scale = |x: f64| if self.logarithmic { x.ln() } else { x };
        let (low, high) = (scale(self.range.0), scale(self.range.1));
        ((scale(value) - low) / (high - low)).clamp(0.0, 1.0)
    }
    fn tile(&self, start: &Start) -> usize {
        ((self.place((self.of)(start)) * TILES as f64) as usize).min(TILES - 1)
    }
}

/// Converts pixels to the library's units.
pub(crate) const fn px(pixels: u32) -> i32 {
    (pixels * SCALE) as i32
}

/// Draws the picture of a series.
pub(super) fn svg(starts: &[Start]) -> Result<String, String> {
    let mut text = String::new();
    {
        let size = (WIDTH * SCALE, HEIGHT * SCALE);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&root, starts).map_err(|error| error.to_string())?;
    }
    let large = format!("width=\"{}\" height=\"{}\"", WIDTH * SCALE, HEIGHT * SCALE);
    Ok(text.replacen(&large, &format!("width=\"{WIDTH}\" height=\"{HEIGHT}\""), 1))
}

fn draw(root: &Area<'_>, starts: &[Start]) -> Result<(), DrawError> {
    root.fill(&WHITE)?;
    let share = |holds: fn(&Start) -> bool| {
        100.0 * starts.iter().filter(|start| holds(start)).count() as f64 / starts.len().max(1) as f64
    };
    let title = format!(
        "Sensorless starts of {} random plants: {:.2} % at the first try, {:.2} % within Auto-restart",
        starts.len(),
        share(Start::started_at_once),
        share(Start::started)
    );
    write(root, &title, (px(24), px(26)), 19, HPos::Left, true)?;
    legend(root)?;
    let (_, panels) = root.split_vertically(px(76));
    for (panel, (x, y)) in panels.split_evenly((1, 3)).iter().zip([
        (&INERTIA, &LOAD),
        (&INERTIA, &FRICTION),
        (&SUPPLY, &TEMPERATURE),
    ]) {
        draw_map(panel, starts, x, y)?;
    }
    root.present()
}

/// Draws the legend of shades and crosses.
fn legend(root: &Area<'_>) -> Result<(), DrawError> {
    let y = px(56);
    write(root, "first try:", (px(24), y), 14, HPos::Left, false)?;
    let mut x = px(92);
    for percent in [100_u32, 95, 90, 85, 80] {
        let box_ = [(x, y - px(8)), (x + px(18), y + px(8))];
        root.draw(&Rectangle::new(box_, shade(f64::from(percent) / 100.0).filled()))?;
        root.draw(&Rectangle::new(box_, INK.mix(0.4).stroke_width(SCALE / 2)))?;
        let text = if percent == 80 { "80 % or less".into() } else { format!("{percent} %") };
        write(root, &text, (x + px(24), y), 14, HPos::Left, false)?;
        x += px(74);
    }
    x += px(44);
    cross(root, (x, y))?;
    write(root, "did not start", (x + px(12), y), 14, HPos::Left, false)?;
    x += px(120);
    root.draw(&Rectangle::new([(x, y - px(8)), (x + px(18), y + px(8))], INK.mix(0.25).filled()))?;
    write(root, "none drawn here", (x + px(24), y), 14, HPos::Left, false)
}

/// Draws one map: shares in tiles, failures as crosses.
fn draw_map(area: &Area<'_>, starts: &[Start], x: &Axis, y: &Axis) -> Result<(), DrawError> {
    let (width, height) = area.dim_in_pixel();
    let (left, right, top, bottom) = (px(66), width as i32 - px(18), px(8), height as i32 - px(62));
    let at = |u: f64, v: f64| {
        let across = f64::from(left) + u * f64::from(right - left);
        (across.round() as i32, (f64::from(bottom) - v * f64::from(bottom - top)).round() as i32)
    };
    let mut tiles = [[(0_u32, 0_u32); TILES]; TILES];
    for start in starts {
        let (tried, first) = &mut tiles[x.tile(start)][y.tile(start)];
        *tried += 1;
        *first += u32::from(start.started_at_once());
    }
    let step = 1.0 / TILES as f64;
    for (column, tiles) in tiles.iter().enumerate() {
        for (row, (tried, first)) in tiles.iter().enumerate() {
            let (u, v) = (column as f64 * step, row as f64 * step);
            let colour = match tried {
                0 => INK.mix(0.25),
                tried => shade(f64::from(*first) / f64::from(*tried)).to_rgba(),
            };
            area.draw(&Rectangle::new([at(u, v), at(u + step, v + step)], colour.filled()))?;
        }
    }
    area.draw(&Rectangle::new([at(0.0, 0.0), at(1.0, 1.0)], INK.stroke_width(SCALE)))?;
    for start in starts.iter().filter(|start| !start.started()) {
        cross(area, at(x.place((x.of)(start)), y.place((y.of)(start))))?;
    }
    for mark in x.marks {
        let (across, _) = at(x.place(*mark), 0.0);
        write(area, &mark.to_string(), (across, bottom + px(14)), 14, HPos::Center, false)?;
    }
    for mark in y.marks {
        let (_, up) = at(0.0, y.place(*mark));
        write(area, &mark.to_string(), (left - px(7), up), 14, HPos::Right, false)?;
    }
    write(area, x.title, ((left + right) / 2, bottom + px(38)), 15, HPos::Center, false)?;
    let upright = ("sans-serif", 15 * SCALE as i32)
        .into_text_style(area)
        .color(&INK)
        .transform(FontTransform::Rotate270)
        .pos(Pos::new(HPos::Center, VPos::Center));
    area.draw_text(y.title, &upright, (px(18), (top + bottom) / 2))
}

/// Shade of a share, from pale (all starts succeed at the first try) to deep blue.
fn shade(share: f64) -> RGBColor {
    let depth = ((1.0 - share) / (1.0 - DARKEST)).clamp(0.0, 1.0);
    let mix = |from: u8, to: u8| (f64::from(from) + depth * (f64::from(to) - f64::from(from))).round() as u8;
    RGBColor(mix(0xe6, BLUE.0), mix(0xf1, BLUE.1), mix(0xf9, BLUE.2))
}

fn cross(area: &Area<'_>, (x, y): (i32, i32)) -> Result<(), DrawError> {
    let arm = px(4);
    let style = VERMILION.stroke_width(2 * SCALE);
    area.draw(&PathElement::new([(x - arm, y - arm), (x + arm, y + arm)], style))?;
    area.draw(&PathElement::new([(x - arm, y + arm), (x + arm, y - arm)], style))
}

/// Writes a word.
pub(crate) fn write(
    area: &Area<'_>,
    text: &str,
    at: (i32, i32),
    size: u32,
    side: HPos,
    bold: bool,
) -> Result<(), DrawError> {
    let weight = if bold { FontStyle::Bold } else { FontStyle::Normal };
    let style = ("sans-serif", px(size), weight, &INK).into_text_style(area);
    area.draw_text(text, &style.pos(Pos::new(side, VPos::Center)), at)
}
