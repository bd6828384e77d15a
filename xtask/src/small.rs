//! Flash of the core on a small board, and the bytes that each feature adds to it: golden figures in
//! `tests/golden/small_board.toml`.

use crate::image::EMBEDDED;
use crate::install;
use crate::{cross, sizes};
use narx_report::steps::Outcome;
use narx_report::steps::output;
use narx_report::target_directory;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

const GOLDEN: &str = "tests/golden/small_board.toml";
const HEAD: &str = "\
# Flash of everything in the core that a small board links (firmware/small: control tick, background, parameters, broadcasts; no peripherals, no
# store), bytes of code and constants on a Cortex-M4F at opt-level z, the processor's vector table not counted. `least` is the core without
# features, `every` with all of them, and under `adds` what a feature alone adds to the least.
# Made anew by `cargo xtask sizes`; `least` and `every` are compared within 1 % by `cargo xtask test firmware`.

";

/// The core's features, in the order in which its manifest lists them.
const FEATURES: [&str; 7] =
    ["names", "description", "log", "scope", "recorder", "hall-calibration", "accelerometer"];

/// Measures, and writes the golden file or, with `check`, compares the two main figures.
///
/// # Errors
/// Fails with the compiler's message, or if a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    let (least, every) = least_and_every(root)?;
    let path = root.join(GOLDEN);
    if check {
        let golden = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let golden: toml::Table = golden.parse().map_err(|error| format!("{}: {error}", path.display()))?;
        for (name, now) in [("least", least), ("every", every)] {
            let before = golden.get(name).and_then(toml::Value::as_integer).unwrap_or(-1);
            if (now - before).abs() as f64 > sizes::TOLERANCE * before.abs() as f64 {
                return Err(format!("small board, {name}: golden {before}, now {now}: cargo xtask sizes"));
            }
        }
    } else {
        let mut text = format!("{HEAD}least = {least}\nevery = {every}\n\n[adds]\n");
        for feature in FEATURES {
            let _ = writeln!(text, "{feature} = {}", flash(root, &[feature])? - least);
        }
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(vec![format!("flash of the core on a small board: {least}, with every feature {every}")])
}

/// Flash without features, and with all of them, bytes.
///
/// # Errors
/// Fails with the compiler's message.
pub(crate) fn least_and_every(root: &Path) -> Result<(i64, i64), String> {
    install::rust_target(EMBEDDED)?;
    install::debian(&cross::PACKAGES)?;
    Ok((flash(root, &[])?, flash(root, &FEATURES)?))
}

/// Code and constants with these features of the core, bytes.
fn flash(root: &Path, features: &[&str]) -> Result<i64, String> {
    let features: Vec<_> = features.iter().map(|feature| format!("narx-core/{feature}")).collect();
    let mut build = Command::new("cargo");
    build.current_dir(root).args(["build", "--quiet", "--profile", "small", "-p", "narx-small"]);
    output(build.args(["--target", EMBEDDED, "--features", &features.join(",")]))?;
    let image = target_directory(root).join(EMBEDDED).join("small/small");
    let sections = output(Command::new("arm-none-eabi-size").arg("-A").arg(&image))?;
    let of = |name: &str| {
        let line = sections.lines().find(|line| line.split_whitespace().next() == Some(name))?;
        line.split_whitespace().nth(1)?.parse::<i64>().ok()
    };
    match (of(".text"), of(".rodata"), of(".data")) {
        (Some(text), Some(rodata), Some(data)) => Ok(text + rodata + data),
        _ => Err(format!("arm-none-eabi-size: {sections}")),
    }
}
