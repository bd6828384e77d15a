//! Results of fuzzing: `cargo xtask fuzz`.

use super::{FIGURES, Section, cell};
use crate::fuzz::report::{Report, Row, Sweep};
use std::fmt::Write as _;
use std::path::Path;

const HEAD: &str = "\
libFuzzer looks for bytes that break a promise of what reads bytes; the table in CONTRIBUTING.md (*Fuzzing*) says what each target is given and what must hold. A finding is mended and its input kept in `tests/fuzz/corpus`, which the tests run. Executions are few where each is a drive's life of up to two seconds, or a flash \
that is powered up again and again. Seconds are the clock's: how many executions fit into them is a matter of what else the machine does.

";

/// Section with the table, and the run with every identifier.
pub(super) fn section(root: &Path) -> Result<Section, String> {
    let report = Report::read(&root.join(FIGURES).join("fuzz.json"))?.unwrap_or_default();
    let names = crate::fuzz::targets(root).unwrap_or_default();
    let text = format!("{HEAD}{}{}", targets(&report, &names), sweeps(&report));
    Ok(Section { title: "Bytes from anywhere", text })
}

fn targets(report: &Report, names: &[String]) -> String {
    let command = format!("`cargo xtask fuzz --out {FIGURES}`");
    if report.targets.is_empty() {
        return format!("{command}: not measured.\n");
    }
    let mut text = format!(
        "{command}, on: {}. New inputs reached what none had reached before, in this run or in the corpora of earlier ones.\n\n",
        report.machine
    );
    text += "| target | seconds | executions | new inputs | findings | code of commit |\n|---|---:|---:|---:|---:|---|\n";
    for row in report.targets.iter().chain([&report.total()]) {
        let Row { target, seconds, executions, new_inputs, findings, commit, .. } = row;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {target} | {seconds} | {executions} | {new_inputs} | {} | {commit} |",
            findings.len()
        );
    }
    for name in names.iter().filter(|name| !report.targets.iter().any(|row| row.target == **name)) {
        let _ = writeln!(text, "| {name} | not measured | | | | |");
    }
    for row in &report.targets {
        for finding in &row.findings {
            let _ = writeln!(text, "\nOpen, {}: {}", row.target, cell(finding));
        }
    }
    text
}

fn sweeps(report: &Report) -> String {
    let mut text = String::from(
        "\nEvery identifier with every data length code, as data and as remote frame: what a node does with it is what PROTOCOL.md says, and everything else is silent and changes nothing but a counter. ",
    );
    let command = format!("`cargo xtask fuzz --identifiers --out {FIGURES}`");
    if report.sweeps.is_empty() {
        return text + &format!("{command}: not measured.\n");
    }
    let _ = writeln!(
        text,
        "{command}:\n\n| node | identifiers | lengths | data, remote | frames | seconds | code of commit |\n|---|---|---:|---:|---:|---:|---|"
    );
    for Sweep { node, bits, frames, seconds, commit } in &report.sweeps {
        let _ = writeln!(text, "| {node} | all of {bits} bits | 9 | 2 | {frames} | {seconds} | {commit} |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_figures_it_is_not_measured() {
        let Section { text, .. } = section(Path::new("/nowhere")).unwrap();
        assert_eq!(text.matches(": not measured.").count(), 2, "{text}");
    }

    #[test]
    fn what_was_found_is_not_hidden() {
        let row = Row {
            target: "bus".into(),
            findings: vec!["a | b".into()],
            commit: "c".into(),
            ..Row::default()
        };
        let report = Report { targets: vec![row], ..Report::default() };
        let text = targets(&report, &["boot".into(), "bus".into()]);
        let rows =
            "| bus | 0 | 0 | 0 | 1 | c |\n| all | 0 | 0 | 0 | 1 |  |\n| boot | not measured | | | | |\n";
        assert!(text.contains(rows), "{text}");
        assert!(text.ends_with("\nOpen, bus: a \\| b\n"), "{text}");
    }
}
