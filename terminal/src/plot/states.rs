//! The states as a band above the panels.

use super::panel::{Area, DrawError, LEFT, RIGHT, px};
use super::{STATES_HEIGHT, WIDTH, colour};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Name, short name and tint of states 0 to 7, as in the specification (section 7).
const STATES: [(&str, &str, RGBColor); 8] = [
    ("Initialization", "Init", colour::GREY),
    ("Standby", "Stby", colour::GREY),
    ("Rotor lock", "Lock", colour::ORANGE),
    ("Open-loop", "OL", colour::SKY),
    ("Sensorless closed-loop", "SL", colour::GREEN),
    ("Hall closed-loop", "Hall", colour::BLUE),
    ("Fault", "Fault", colour::VERMILION),
    ("Auto-restart", "AR", colour::PURPLE),
];

/// A stretch of time in one state.
struct Stretch {
    from: f64,
    to: f64,
    state: usize,
}

/// Draws the band; returns the times at which the state changed.
pub(super) fn draw(area: &Area<'_>, time: &[f64], state: &[f64]) -> Result<Vec<f64>, DrawError> {
    let stretches = stretches(time, state);
    let (Some(first), Some(last)) = (time.first(), time.last()) else { return Ok(Vec::new()) };
    let width = f64::from(px(WIDTH - LEFT - RIGHT));
    let place = |t: f64| px(LEFT) as i32 + ((t - first) / (last - first) * width).round() as i32;
    let (top, bottom) = (px(3) as i32, px(STATES_HEIGHT - 4) as i32);
    let text = ("sans-serif", px(14), &colour::BLACK).into_text_style(area);
    let text = text.pos(Pos::new(HPos::Center, VPos::Center));
    for stretch in &stretches {
        let (name, short, tint) = STATES[stretch.state.min(7)];
        let (left, right) = (place(stretch.from), place(stretch.to));
        area.draw(&Rectangle::new([(left, top), (right, bottom)], tint.mix(0.35).filled()))?;
        area.draw(&PathElement::new([(left, top), (left, bottom)], WHITE.stroke_width(px(1))))?;
        // A letter takes about 27 units; a margin is left on both sides.
        let fits = |text: &&str| right - left > 27 * text.len() as i32 + px(5) as i32;
        if let Some(label) = [name, short].iter().find(|text| fits(text)) {
            area.draw_text(label, &text, ((left + right) / 2, (top + bottom) / 2))?;
        }
    }
    Ok(stretches.iter().skip(1).map(|stretch| stretch.from).collect())
}

fn stretches(time: &[f64], state: &[f64]) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for (t, state) in time.iter().zip(state) {
        let state = *state as usize;
        match stretches.last_mut() {
            Some(last) => {
                last.to = *t;
                if last.state != state {
                    stretches.push(Stretch { from: *t, to: *t, state });
                }
            }
            None => stretches.push(Stretch { from: *t, to: *t, state }),
        }
    }
    stretches
}
