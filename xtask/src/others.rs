//! Control by other people's crates, counted on the emulated Cortex-M4F as ours is: the image of
//! `firmware/others`.

use crate::image::EMBEDDED;
use crate::{install, qemu};
use narx_report::steps::{self, Outcome};
use std::path::Path;
use std::process::Command;

/// A controller and the instructions that a call of it takes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Counted {
    /// Crate, and the part of it that is called.
    pub(crate) name: String,
    /// Mean number of instructions of a call.
    pub(crate) average: f64,
    /// Largest number of instructions of a call.
    pub(crate) worst: u32,
}

/// Builds the image and runs it.
///
/// # Errors
/// Fails with the message of compiler or emulator, or with a controller that does not do its work.
pub(crate) fn count(root: &Path) -> Result<Vec<Counted>, String> {
    install::rust_target(EMBEDDED)?;
    let build = ["build", "--quiet", "--release", "-p", "narx-others", "--target", EMBEDDED];
    steps::run(Command::new("cargo").args(build).current_dir(root))?;
    let image = narx_report::target_directory(root).join(EMBEDDED).join("release/others");
    let text = steps::output(&mut qemu::counting(&image, &[] as &[&str]))?;
    let rows: Vec<Counted> = text.lines().filter_map(parse).collect();
    if rows.is_empty() { Err(format!("no rows in: {text}")) } else { Ok(rows) }
}

/// Counts as a step of the tests: checks that the controllers still do the work for which they are compared.
///
/// # Errors
/// Those of [`count`].
pub(crate) fn check(root: &Path) -> Outcome {
    let line = |row: Counted| format!("{}: {:.0} instructions a call", row.name, row.average);
    count(root).map(|rows| rows.into_iter().map(line).collect())
}

/// Parses `other NAME TICKS TOTAL WORST`.
fn parse(line: &str) -> Option<Counted> {
    let mut words = line.strip_prefix("other ")?.split_whitespace();
    let name = words.next()?.to_owned();
    let mut number = || words.next()?.parse::<u32>().ok();
    let (ticks, total, worst) = (number()?, number()?, number()?);
    Some(Counted { name, average: f64::from(total) / f64::from(ticks), worst })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_a_name_and_three_numbers() {
        let row = parse("other foc-space-vector 20000 7506639 386").unwrap();
        assert_eq!((row.name.as_str(), row.worst), ("foc-space-vector", 386));
        assert!((row.average - 375.33).abs() < 0.01);
        for line in ["# foc: voltage", "other foc", "other foc 1 2 x", "error foc why"] {
            assert_eq!(parse(line), None);
        }
    }
}
