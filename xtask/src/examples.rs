//! The examples for boards, which people copy: each is a workspace of its own. Their arithmetic is tested
//! here, and their images are built for the real target and measured.

use crate::image::{EMBEDDED, Size, size};
use crate::install;
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{fs, iter};

/// Folders in `examples/`, each with its images.
const EXAMPLES: [(&str, &[&str]); 2] = [("embassy-stm32", &["drive", "check"]), ("rtic", &["drive"])];

const GOLDEN: &str = "tests/golden/examples.toml";
const HEAD: &str = "\
# The images of the examples for boards, bytes: flash with constants and initial values, and RAM without the stack.
# Made anew by `cargo xtask examples`, compared within 1 % by `cargo xtask test firmware`.
";
/// Largest difference from the golden figure, as a share of it.
const TOLERANCE: f64 = 0.01;

/// Builds, tests and measures the examples; writes the golden file or, with `check`, compares it.
pub(crate) fn command(root: &Path, check: bool) -> ExitCode {
    steps::finish(regenerate(root, check))
}

/// As [`command`].
///
/// # Errors
/// Fails with cargo's message, or if a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    install::rust_target(EMBEDDED)?;
    let (mut text, mut closing) = (String::from(HEAD), Vec::new());
    for (example, images) in EXAMPLES {
        cargo(root, example, &["fmt", "--check"])?;
        closing.extend(cargo(root, example, &["test", "--quiet"])?);
        cargo(root, example, &["clippy", "--quiet", "--target", EMBEDDED, "--bins", "--", "-D", "warnings"])?;
        cargo(root, example, &["build", "--quiet", "--release", "--target", EMBEDDED])?;
        for image in images {
            let path = directory(root).join(format!("{example}-{image}"));
            // The images of two examples have one name.
            fs::copy(directory(root).join(EMBEDDED).join("release").join(image), &path)
                .map_err(|error| format!("{}: {error}", path.display()))?;
            let Size { flash, ram } = size(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            let _ = write!(text, "\n[{example}.{image}]\nflash = {flash}\nram = {ram}\n");
            closing.push(format!("{example}, {image}: {flash} bytes of flash, {ram} of RAM"));
        }
    }
    let path = root.join(GOLDEN);
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    if check {
        compare(&fs::read_to_string(&path).map_err(failed)?, &text)?;
    } else {
        fs::write(&path, text).map_err(failed)?;
    }
    Ok(closing)
}

/// Compares each figure with the golden one.
fn compare(golden: &str, now: &str) -> Result<(), String> {
    let figures = |text: &str| -> Result<Vec<(String, i64)>, String> {
        let table: toml::Table = text.parse().map_err(|error| format!("{GOLDEN}: {error}"))?;
        let mut figures = Vec::new();
        for (example, images) in &table {
            for (image, sizes) in images.as_table().into_iter().flatten() {
                for (name, bytes) in sizes.as_table().into_iter().flatten() {
                    figures.push((format!("{example}, {image}, {name}"), bytes.as_integer().unwrap_or(-1)));
                }
            }
        }
        Ok(figures)
    };
    let (golden, now) = (figures(golden)?, figures(now)?);
    if golden.len() != now.len() {
        return Err(format!("{GOLDEN}: other images: cargo xtask examples"));
    }
    for ((place, before), (_, after)) in iter::zip(golden, now) {
        if (after - before).abs() as f64 > TOLERANCE * before as f64 {
            return Err(format!("{place}: golden {before}, now {after}: cargo xtask examples"));
        }
    }
    Ok(())
}

/// Build directory of the examples: what they have in common is built once. [`regenerate`] leaves the images
/// in it, as `EXAMPLE-IMAGE`.
pub(crate) fn directory(root: &Path) -> PathBuf {
    target_directory(root).join("examples")
}

/// Runs cargo in the folder of an example.
fn cargo(root: &Path, example: &str, arguments: &[&str]) -> Outcome {
    let mut cargo = Command::new("cargo");
    cargo.args(arguments).current_dir(root.join("examples").join(example));
    steps::run(cargo.env("CARGO_TARGET_DIR", directory(root)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_may_differ_by_a_hundredth() {
        let text = |flash| format!("[embassy-stm32.drive]\nflash = {flash}\nram = 40\n");
        assert_eq!(compare(&text(10_000), &text(10_100)), Ok(()));
        assert!(compare(&text(10_000), &text(10_101)).unwrap_err().contains("golden 10000, now 10101"));
        assert!(compare(&text(10_000), "").is_err());
    }
}
