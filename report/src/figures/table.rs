//! The table as text for a terminal.

use super::{Figure, Part};
use std::fmt::Write as _;

/// Number of failures shown of each part; all of them are in the file.
const SHOWN: usize = 20;

/// Formats the failures of every part, then a line for each figure.
pub fn table(parts: &[Part]) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for part in parts.iter().filter(|part| !part.failures.is_empty()) {
        let _ = writeln!(text, "{}:", part.part);
        for failure in part.failures.iter().take(SHOWN) {
            let _ = writeln!(text, "  {failure}");
        }
        if part.failures.len() > SHOWN {
            let _ = writeln!(text, "  and {} more in the file", part.failures.len() - SHOWN);
        }
        text.push('\n');
    }
    let figures = || parts.iter().flat_map(|part| &part.figures);
    let width =
        |of: fn(&Figure) -> String| figures().map(|figure| of(figure).chars().count()).max().unwrap_or(0);
    let (name, value, goal) = (width(|f| f.name.clone()), width(value), width(aim));
    let _ = writeln!(text, "{:<name$}  {:>value$}  {:<goal$}  verdict  of what", "figure", "", "goal");
    for part in parts {
        let _ = writeln!(text, "{}  # {}", part.part, part.command);
        if let Some(reason) = &part.skipped {
            let _ = writeln!(text, "  not measured: {reason}");
        }
        for figure in &part.figures {
            let verdict = match (figure.goal, figure.is_met()) {
                (None, _) => "",
                (_, true) => "ok",
                (_, false) => "FAIL",
            };
            let line = format!(
                "{:<name$}  {:>value$}  {:<goal$}  {verdict:<7}  {}",
                figure.name,
                self::value(figure),
                aim(figure),
                figure.note
            );
            let _ = writeln!(text, "{}", line.trim_end());
        }
    }
    text
}

/// Formats a figure with its unit.
pub fn value(figure: &Figure) -> String {
    let Some(value) = figure.figure else { return "none".into() };
    // Four digits suffice for figures that are not counts.
    let digits = (3.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    let number = if value.fract() == 0.0 { value.to_string() } else { format!("{value:.digits$}") };
    format!("{number} {}", figure.unit).trim_end().to_owned()
}

fn aim(figure: &Figure) -> String {
    figure.goal.map_or_else(String::new, |goal| goal.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_four_digits_and_counts_all_of_theirs() {
        for (figure, text) in [
            (99.94, "99.94 %"),
            (0.012_345, "0.01235 %"),
            (152_341.0, "152341 %"),
            (1234.56, "1235 %"),
            (-0.5, "-0.5000 %"),
            (0.0, "0 %"),
            (f64::NAN, "none"),
        ] {
            assert_eq!(value(&Figure::new("", figure, "%")), text);
        }
        assert_eq!(value(&Figure::new("", 3.25, "")), "3.250");
    }

    #[test]
    fn every_figure_has_its_line_under_the_command_that_measures_it() {
        let mut start = Part::new(
            vec![
                Figure::new("starts", 99.8, "%").at_least(99.9).note("998 of 1000"),
                Figure::new("slowest", 2.0, "s").at_most(3.0),
                Figure::new("rate", 210.5, "1/s"),
            ],
            (0..22).map(|seed| format!("seed {seed}")).collect(),
        );
        (start.part, start.command) = ("start".into(), "cargo xtask bench --only start".into());
        let mut logs = Part::skipped("no python3");
        (logs.part, logs.command) = ("logs".into(), "cargo xtask bench --only logs".into());
        let text = table(&[start, logs]);
        let tail = "\
  and 2 more in the file

figure              goal     verdict  of what
start  # cargo xtask bench --only start
starts     99.80 %  >= 99.9  FAIL     998 of 1000
slowest        2 s  <= 3     ok
rate     210.5 1/s
logs  # cargo xtask bench --only logs
  not measured: no python3
";
        assert!(text.starts_with("start:\n  seed 0\n"), "{text}");
        assert!(text.ends_with(tail), "{text}");
    }
}
