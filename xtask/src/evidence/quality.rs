//! Control quality on every motor of the market and on random ones: `cargo xtask quality`.

use super::missed::Missed;
use super::{FIGURES, Section};
use crate::quality::{Quality, Row};
use std::fmt::Write as _;
use std::path::Path;

const HEAD: &str = "\
The same promises as percentiles, in both closed loops, without load and at rated torque. *Presets* are the motors of the market at their nominal supply and at 2000, 4000, 8000 and 16 000 electrical rpm. *Random motors* are no motors of the market with errors but any \
that a data sheet could print: 5 to 250 W, 1000 to 12 000 rpm, 18 to 60 V, 1 to 14 pole pairs, 5 to 35 % of loss in the winding, time constants of 0.15 to 2 ms (electrical) and 2 to 60 ms (mechanical), friction, cogging, sine or flat top (`xtask/src/quality/motor.rs` has \
the ranges and what follows from them). Each runs at one set-point of the promised speeds, commissioned from its data; what the drive's limits forbid is counted and not run. Steady is what comes three seconds after the set-point was reached.

*Unseen* are points at which a drive without sensors has nothing to see, by the motor's data (`xtask/src/quality/physics.rs`): the floating phase still conducts when its back-EMF crosses, or the load step takes more than half of the speed before the speed loop can answer. They \
are judged apart, not left out.

";

/// Section with the table.
pub(super) fn section(root: &Path) -> Result<Section, String> {
    let path = root.join(FIGURES).join("quality.json");
    let quality = Quality::read(&path).map_err(|error| format!("{error}: cargo xtask quality"))?;
    let mut text = String::from(HEAD);
    let mut missed = Missed::default();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "`{}`: {} random motors.\n", quality.command, quality.motors);
    let _ = writeln!(
        text,
        "| motors | mode | metric | runs | median | 95 % | 99 % | worst | goal | beyond |\n|---|---|---|---:|---:|---:|---:|---:|---|---:|"
    );
    for row in quality.rows.iter().filter(|row| row.runs > 0) {
        let Row { of, mode, metric, unit, runs, median, p95, p99, worst, most, outside } = row;
        if unit.is_empty() {
            let _ = writeln!(text, "| {of} | {mode} | {metric} | {runs} | | | | | | {outside} |");
        } else {
            let _ = writeln!(
                text,
                "| {of} | {mode} | {metric}, {unit} | {runs} | {median:.2} | {p95:.2} | {p99:.2} | {worst:.2} | <= {most} | {outside} |"
            );
        }
        // Points that physics does not allow, or that limits forbid, are not promised.
        let promised = !of.ends_with("unseen") && row.is_promise();
        if promised && *outside > 0 {
            missed.add(&name(row));
        }
    }
    let names: Vec<String> = quality.rows.iter().map(name).collect();
    text += &missed.explain(root, |missed| names.iter().any(|name| name == missed))?;
    if let Some(first) = quality.failures.first() {
        let _ = writeln!(
            text,
            "\nEach of the {} is in `docs/evidence/quality.json` with the command that repeats it, such as `{}` ({}).",
            quality.failures.len(),
            first.command,
            first.what
        );
    }
    Ok(Section { title: "Control quality", text })
}

fn name(row: &Row) -> String {
    format!("{}, {}: {}", row.of, row.mode, row.metric)
}
