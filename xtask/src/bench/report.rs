//! The table of goals, for the eye and for programs.

use super::Arguments;
use std::fmt::Write as _;

/// One goal.
pub(super) struct Row {
    /// What is promised.
    pub(super) promise: &'static str,
    /// The bound.
    pub(super) goal: &'static str,
    /// What was measured.
    pub(super) measured: String,
    /// The bound is kept.
    pub(super) met: bool,
    /// The figures by name, for programs.
    pub(super) figures: Vec<(&'static str, f64)>,
    /// What did not keep it, and how to see it again.
    pub(super) failures: Vec<String>,
}

/// Failures printed of each row; all of them are in `bench.json`.
const PRINTED: usize = 20;

/// Prints the failures of every row, then the table.
pub(super) fn print(rows: &[Row]) {
    for row in rows.iter().filter(|row| !row.failures.is_empty()) {
        println!("{}:", row.promise);
        row.failures.iter().take(PRINTED).for_each(|failure| println!("  {failure}"));
        if row.failures.len() > PRINTED {
            println!("  and {} more in bench.json", row.failures.len() - PRINTED);
        }
        println!();
    }
    let width = |of: fn(&Row) -> usize| rows.iter().map(of).max().unwrap_or(0);
    let (promise, goal) = (width(|row| row.promise.len()), width(|row| row.goal.len()));
    println!("{:<promise$}  {:<goal$}  verdict  measured", "promise", "goal");
    for row in rows {
        let verdict = if row.met { "ok" } else { "FAIL" };
        println!("{:<promise$}  {:<goal$}  {verdict:<7}  {}", row.promise, row.goal, row.measured);
    }
}

/// `bench.json`.
pub(super) fn json(rows: &[Row], arguments: &Arguments, runs: usize) -> String {
    let mut text = String::new();
    let _ = write!(text, "{{\n  \"seed\": {}, \"runs\": {runs},\n  \"promises\": [", arguments.seed);
    for (index, row) in rows.iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        let figures: Vec<String> =
            row.figures.iter().map(|(name, value)| format!("{}: {}", string(name), number(*value))).collect();
        let failures: Vec<String> = row.failures.iter().map(|failure| string(failure)).collect();
        let _ = write!(
            text,
            "{comma}\n    {{\n      \"promise\": {},\n      \"goal\": {},\n      \"measured\": {},\n      \"met\": {},\n      \"figures\": {{{}}},\n      \"failures\": [{}]\n    }}",
            string(row.promise),
            string(row.goal),
            string(&row.measured),
            row.met,
            figures.join(", "),
            failures.join(", "),
        );
    }
    text.push_str("\n  ]\n}\n");
    text
}

/// JSON knows no infinity.
fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { "null".into() }
}

fn string(text: &str) -> String {
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => out.extend(['\\', letter]),
            '\n' => out.push_str("\\n"),
            letter if letter < ' ' => {}
            letter => out.push(letter),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_and_numbers_of_json() {
        assert_eq!(string("a \"b\" \\ c\n"), "\"a \\\"b\\\" \\\\ c\\n\"");
        assert_eq!(number(f64::INFINITY), "null");
        assert_eq!(number(0.25), "0.25");
    }
}
