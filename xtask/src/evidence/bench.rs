//! Figures of `cargo xtask bench`, in three sections: promises of control, cost of a tick, speed of the
//! tools.

use super::missed::Missed;
use super::{FIGURES, Section, cell};
use crate::figures::{Part, Report, value};
use std::fmt::Write as _;
use std::path::Path;

/// Parts of each section.
const CONTROL: [&str; 8] =
    ["start", "soon", "steady", "load-step", "top-speed", "range", "efficiency", "faults"];
const COST: [&str; 3] = ["instructions", "flash", "callgrind"];
const SPEED: [&str; 6] = ["simulation", "sweep", "python", "logs", "scope", "page"];

/// Section with the promises of control.
pub(super) fn control(root: &Path) -> Result<Section, String> {
    let head = "Sensorless starts of random plants around the motors of the market (inertia x 0.2 to 5, Coulomb friction x 0 to 3, resistance x 0.9 to 1.65, \
back-EMF x 0.8 to 1.05, 18 to 60 V, any load up to 30 % of rated torque, any angle, friction and load up to half of the lock's torque), and every motor at its operating points, commissioned from its data sheet alone. A start that fails is listed \
in `docs/evidence/bench.json` with the command that repeats it.\n\n";
    let tail = "\n![Where the starts of random plants succeed](evidence/starts.svg)\n";
    section(root, "Promises of control", head, &CONTROL, tail)
}

/// Section with instructions and memory.
pub(super) fn cost(root: &Path) -> Result<Section, String> {
    let head = "Instructions on an emulated Cortex-M4F are exact and the same on every run; wait states of a flash and stalls of a pipeline are not in them. *The floor* is a bare six-step tick by hand in C, of which nothing more can be left out without it \
ceasing to be a drive: samples in millivolts, hall code or zero crossing, speed over six sectors, a speed PI and a current limit, over- and under-voltage, over-current and stall, duty by the live bus with a slew limit. It lacks nearly everything else: both \
directions, a start, states and transitions, interpolation between edges, debounce and direction check of the sensors, demagnetisation that is told from a crossing, blanking by time, desynchronisation rails, restart, power and temperature limits, qualified \
faults with codes, parameters, status, scope, recording, and a queue for events. It cannot start without sensors. That it is a drive all the same is shown by the simulated motor that it turns. `foc` is a current loop of field-oriented control \
and nothing else: angle and currents come ready, no speed loop, no limits, no protection. `foc-rs` and `brushless` are names without code, and of other crates that control a motor we know none.\n\n";
    section(root, "What it costs", head, &COST, "")
}

/// Section with the rates.
pub(super) fn speed(root: &Path) -> Result<Section, String> {
    let report = read(root)?;
    let head = format!(
        "Measured on: {}. Contenders of one row ran in the same run, in turns, and the fastest of each counts. motulator and gym-electric-motor compute what they compute (the notes say what), not what narx does: no CAN, no parameters, no switching edges.\n\n",
        report.machine
    );
    section(root, "How fast the tools are", &head, &SPEED, "")
}

fn read(root: &Path) -> Result<Report, String> {
    Report::read(&root.join(FIGURES).join("bench.json"))
}

fn section(
    root: &Path,
    title: &'static str,
    head: &str,
    parts: &[&str],
    tail: &str,
) -> Result<Section, String> {
    let report = read(root)?;
    if report.parts.is_empty() {
        return Err(format!("{FIGURES}/bench.json has no figures: cargo xtask bench --all --out {FIGURES}"));
    }
    let mut text = String::from(head);
    let mut missed = Missed::default();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "| figure | | goal | | of what |\n|---|---:|---|---|---|");
    for name in parts {
        let Some(part) = report.part(name) else {
            let _ = writeln!(text, "| `cargo xtask bench --only {name}` | not measured | | | |");
            continue;
        };
        rows(&mut text, part, &mut missed);
    }
    let names: Vec<&str> = parts
        .iter()
        .filter_map(|name| report.part(name))
        .flat_map(|part| &part.figures)
        .map(|figure| figure.name.as_str())
        .collect();
    text += &missed.explain(root, |name| names.contains(&name))?;
    text += tail;
    Ok(Section { title, text })
}

fn rows(text: &mut String, part: &Part, missed: &mut Missed) {
    let _ = writeln!(text, "| `{}` | | | | |", part.command.replace(" --out docs/evidence", ""));
    if let Some(reason) = &part.skipped {
        let _ = writeln!(text, "| {} | not measured | | | {} |", part.part, cell(reason));
    }
    figures(text, part, missed);
}

/// Writes a row for each figure of a part.
pub(super) fn figures(text: &mut String, part: &Part, missed: &mut Missed) {
    for figure in &part.figures {
        let goal = figure.goal.map_or_else(String::new, |goal| goal.to_string());
        let verdict = match (figure.goal, figure.is_met()) {
            (None, _) => "",
            (_, true) => "met",
            (_, false) => {
                missed.add(&figure.name);
                "*missed*"
            }
        };
        let _ = writeln!(
            text,
            "| {} | {} | {goal} | {verdict} | {} |",
            cell(&figure.name),
            value(figure),
            cell(&figure.note)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every measured part is on the page exactly once.
    #[test]
    fn every_part_of_the_bench_has_its_section() {
        let on_page: Vec<&str> = [CONTROL.as_slice(), &COST, &SPEED].concat();
        assert_eq!(on_page, crate::bench::parts());
    }
}
