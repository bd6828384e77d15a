//! The certificate as a picture: a map for each grid, with the share of starts that succeed in each cell, and
//! the line up to which they are promised.

use super::Tried;
use super::grid::{Axis, GRIDS, Grid};
use crate::promises::picture::{Area, DrawError, INK, SCALE, VERMILION, px, write};
use crate::pwm_rate;
use narx_core::motor::Board;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const WIDTH: u32 = 1_260;
const HEIGHT: u32 = 500;

/// Numbers of starts and successes of a cell.
type Count = (u32, u32);

/// Draws the picture of all starts.
pub(super) fn svg(board: &Board, tried: &[Tried]) -> Result<String, String> {
    let mut text = String::new();
    {
        let size = (WIDTH * SCALE, HEIGHT * SCALE);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&root, board, tried).map_err(|error| error.to_string())?;
    }
    let large = format!("width=\"{}\" height=\"{}\"", WIDTH * SCALE, HEIGHT * SCALE);
    Ok(text.replacen(&large, &format!("width=\"{WIDTH}\" height=\"{HEIGHT}\""), 1))
}

fn draw(root: &Area<'_>, board: &Board, tried: &[Tried]) -> Result<(), DrawError> {
    root.fill(&WHITE)?;
    let rate = if board.tick_rate == pwm_rate::default() {
        String::new()
    } else {
        format!(" at a PWM rate of {} kHz", pwm_rate::kilohertz(board))
    };
    let title = format!(
        "{} sensorless starts{rate}, commissioned from data sheets alone: how many of 100 succeed",
        tried.len()
    );
    write(root, &title, (px(24), px(26)), 19, HPos::Left, true)?;
    let legend =
        "framed: what is promised, as long as friction and load take no more than half of the lock's torque";
    write(root, legend, (px(24), px(54)), 14, HPos::Left, false)?;
    let (_, panels) = root.split_vertically(px(72));
    for (index, (panel, grid)) in panels.split_evenly((1, GRIDS.len())).iter().zip(&GRIDS).enumerate() {
        draw_map(panel, grid, &counts(grid, index, tried))?;
    }
    root.present()
}

/// Counts by column and row.
fn counts(grid: &Grid, index: usize, tried: &[Tried]) -> Vec<Vec<Count>> {
    let mut counts = vec![vec![(0, 0); grid.y.values.len()]; grid.x.values.len()];
    for one in tried.iter().filter(|one| one.grid == index) {
        if let Some((tried, started)) =
            counts.get_mut(one.cell.column).and_then(|column| column.get_mut(one.cell.row))
        {
            *tried += 1;
            *started += u32::from(one.start.started());
        }
    }
    counts
}

fn draw_map(area: &Area<'_>, grid: &Grid, counts: &[Vec<Count>]) -> Result<(), DrawError> {
    let (width, height) = area.dim_in_pixel();
    let (left, right, top, bottom) = (px(66), width as i32 - px(14), px(8), height as i32 - px(62));
    let across = |column: usize| left + (right - left) * column as i32 / grid.x.values.len() as i32;
    let up = |row: usize| bottom - (bottom - top) * row as i32 / grid.y.values.len() as i32;
    for (column, counts) in counts.iter().enumerate() {
        for (row, (tried, started)) in counts.iter().enumerate() {
            let tile = [(across(column), up(row + 1)), (across(column + 1), up(row))];
            let middle = ((tile[0].0 + tile[1].0) / 2, (tile[0].1 + tile[1].1) / 2);
            if *tried == 0 {
                area.draw(&Rectangle::new(tile, INK.mix(0.25).filled()))?;
                continue;
            }
            let share = f64::from(*started) / f64::from(*tried);
            area.draw(&Rectangle::new(tile, shade(share).filled()))?;
            // Rounded down, so that 100 means all of them.
            let text = ((100.0 * share).floor() as u32).to_string();
            write(area, &text, middle, 12, HPos::Center, false)?;
        }
    }
    let [columns, rows] = [grid.x, grid.y].map(promised);
    let frame = [(across(columns.0), up(rows.1)), (across(columns.1), up(rows.0))];
    area.draw(&Rectangle::new(frame, INK.stroke_width(2 * SCALE)))?;
    for (column, value) in grid.x.values.iter().enumerate() {
        let middle = (across(column) + across(column + 1)) / 2;
        write(area, &value.to_string(), (middle, bottom + px(14)), 13, HPos::Center, false)?;
    }
    for (row, value) in grid.y.values.iter().enumerate() {
        let middle = (up(row) + up(row + 1)) / 2;
        write(area, &value.to_string(), (left - px(7), middle), 13, HPos::Right, false)?;
    }
    write(area, grid.x.title, ((left + right) / 2, bottom + px(38)), 15, HPos::Center, false)?;
    let upright = ("sans-serif", 15 * SCALE as i32)
        .into_text_style(area)
        .color(&INK)
        .transform(FontTransform::Rotate270)
        .pos(Pos::new(HPos::Center, VPos::Center));
    area.draw_text(grid.y.title, &upright, (px(18), (top + bottom) / 2))
}

/// Index of the first promised value, and the index after the last.
fn promised(axis: &Axis) -> (usize, usize) {
    let within = |value: &f64| (axis.promised.0..=axis.promised.1).contains(value);
    let first = axis.values.iter().position(within).unwrap_or(0);
    (first, first + axis.values.iter().filter(|value| within(value)).count())
}

/// Shade of a share: pale where all starts succeed, vermilion where none does.
fn shade(share: f64) -> RGBColor {
    let mix = |from: u8, to: u8| {
        (f64::from(from) + (1.0 - share) * (f64::from(to) - f64::from(from))).round() as u8
    };
    RGBColor(mix(0xe6, VERMILION.0), mix(0xf1, VERMILION.1), mix(0xf9, VERMILION.2))
}
