//! Cost of a control tick on a Cortex-M4F: instructions counted by the emulator, beside a bare tick by hand
//! in C and other people's control, and memory.

use super::{Context, tools};
use crate::instructions::Counted;
use crate::{cross, firmware, others, qemu};
use narx_report::figures::{Figure, Part};

/// Goals for a motor in steady running: the mean with hall sensors, and mean and maximum without.
const HALL: f64 = 250.0;
const SENSORLESS: f64 = 300.0;
const SENSORLESS_WORST: f64 = 450.0;

/// Builds the images and counts.
pub(super) fn part(context: &Context<'_>) -> Part {
    let [compiler, library] = cross::PACKAGES;
    if let Err(reason) = tools::debian(context, &[compiler, library, qemu::PACKAGE]) {
        return Part::skipped(reason);
    }
    match firmware::build(context.root).and_then(|_| Counted::new(context.root)) {
        Ok(counted) => {
            let mut part = Part::new(figures(&counted), Vec::new());
            part.join(compared(context));
            part
        }
        Err(reason) => {
            Part::new(vec![Figure::new("instructions a tick", f64::NAN, "").at_most(HALL)], vec![reason])
        }
    }
}

fn figures(counted: &Counted) -> Vec<Figure> {
    let average = |name: &str| counted.row(name).map_or(f64::NAN, |row| row.average());
    let worst = |name: &str| counted.row(name).map_or(f64::NAN, |row| row.worst as f64);
    let mut figures = Vec::new();
    for (mode, goal, worst_goal) in [("hall", HALL, None), ("sensorless", SENSORLESS, Some(SENSORLESS_WORST))]
    {
        let (ours, floor) = (average(&format!("running.{mode}")), average(&format!("floor.{mode}")));
        let most =
            Figure::new(format!("control tick, {mode}, worst"), worst(&format!("running.{mode}")), UNIT);
        figures.extend([
            Figure::new(format!("control tick, {mode}, average"), ours, UNIT)
                .at_most(goal)
                .note("a motor that just runs"),
            worst_goal.map_or_else(|| most.clone(), |goal| most.clone().at_most(goal)),
            Figure::new(format!("the floor by hand in C, {mode}, average"), floor, UNIT)
                .note(format!("lab/floor/tick.c, {}", counted.compiler)),
            Figure::new(format!("control tick, {mode}, times the floor"), ours / floor, ""),
        ]);
    }
    let most = counted.rows.iter().filter(|row| row.name.starts_with("vector.")).map(|row| row.worst).max();
    figures.push(Figure::new(
        "control tick, worst in any state",
        most.map_or(f64::NAN, |most| most as f64),
        UNIT,
    ));
    for (key, name) in MEMORY {
        let bytes =
            counted.memory.iter().find(|(name, _)| name == key).map_or(f64::NAN, |(_, bytes)| *bytes as f64);
        figures.push(Figure::new(name, bytes, "bytes"));
    }
    figures
}

/// Counts other crates.
fn compared(context: &Context<'_>) -> Part {
    let mut part = Part::default();
    match others::count(context.root) {
        Ok(rows) => part.figures.extend(rows.into_iter().map(|row| {
            Figure::new(format!("one call of {}, average", row.name), row.average, UNIT)
                .note(format!("worst {}", row.worst))
        })),
        Err(reason) => part.failures.push(reason),
    }
    part
}

const UNIT: &str = "instructions";

/// Memory figures of the counting images, and their meaning.
const MEMORY: [(&str, &str); 7] = [
    ("state_bytes", "RAM of the drive's state"),
    ("coefficients_bytes", "RAM of its coefficients"),
    ("device_bytes", "RAM of a device: drive, node and queues"),
    ("whole_bytes", "RAM of all that, with storing and logging"),
    ("stack_drive_bytes", "stack of the control tick"),
    ("stack_tick_bytes", "stack of the tick's half of a device"),
    ("stack_background_bytes", "stack of its background"),
];
