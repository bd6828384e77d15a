//! Flash of the core on a small board, and the bytes that each feature adds to it: golden figures in
//! `tests/golden/small_board.toml`.

use crate::cross;
use crate::image::EMBEDDED;
use crate::install;
use crate::sizes;
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
# store) on a Cortex-M4F, bytes of code and constants, the processor's vector table not counted. `least` is the core without features but the
# control modes, `every` with all of them, and under `adds` what a feature alone adds to the least; at opt-level z and at 3.
# Made anew by `cargo xtask sizes`; `least` and `every` at z are compared within 1 % by `cargo xtask test firmware`.

";

/// The core's features, in the order in which its manifest lists them.
const FEATURES: [&str; 7] =
    ["names", "description", "log", "scope", "recorder", "hall-calibration", "accelerometer"];

/// Measures, and writes the golden file or, with `check`, compares some of its figures.
///
/// # Errors
/// Fails with the compiler's message, or if a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    let (least, every) = least_and_every(root)?;
    let path = root.join(GOLDEN);
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    if check {
        compare(&fs::read_to_string(&path).map_err(failed)?, least, every)?;
    } else {
        fs::write(&path, table(root, least, every)?).map_err(failed)?;
    }
    Ok(vec![format!("flash of the core on a small board: {least}, with every feature {every}")])
}

/// Compares `least` and `every` at opt-level z with the golden figures.
fn compare(golden: &str, least: i64, every: i64) -> Result<(), String> {
    let golden: toml::Table = golden.parse().map_err(|error| format!("{GOLDEN}: {error}"))?;
    for (name, now) in [("least", least), ("every", every)] {
        let before = golden.get(name).and_then(|figures| figures.get("z")?.as_integer()).unwrap_or(-1);
        if (now - before).abs() as f64 > sizes::TOLERANCE * before.abs() as f64 {
            return Err(format!("small board, {name}: golden {before}, now {now}: cargo xtask sizes"));
        }
    }
    Ok(())
}

/// Measures the rest, and returns the text of the golden file.
fn table(root: &Path, least: i64, every: i64) -> Result<String, String> {
    let (fast_least, fast_every) = (flash(root, FAST, &[])?, flash(root, FAST, &FEATURES)?);
    let mut text = format!(
        "{HEAD}least = {{ z = {least}, 3 = {fast_least} }}\nevery = {{ z = {every}, 3 = {fast_every} }}\n\n[adds]\n"
    );
    for feature in FEATURES {
        let (z, three) =
            (flash(root, SMALL, &[feature])? - least, flash(root, FAST, &[feature])? - fast_least);
        let _ = writeln!(text, "{feature} = {{ z = {z}, 3 = {three} }}");
    }
    Ok(text)
}

/// Profiles with opt-level z and 3.
const SMALL: &str = "small";
const FAST: &str = "release";

/// Flash with the control modes alone, and with every feature, at opt-level z, bytes.
///
/// # Errors
/// Fails with the compiler's message.
pub(crate) fn least_and_every(root: &Path) -> Result<(i64, i64), String> {
    install::rust_target(EMBEDDED)?;
    install::debian(&cross::PACKAGES)?;
    Ok((flash(root, SMALL, &[])?, flash(root, SMALL, &FEATURES)?))
}

/// Code and constants with these features of the core beside the control modes, bytes.
fn flash(root: &Path, profile: &str, features: &[&str]) -> Result<i64, String> {
    let features: Vec<_> = features.iter().map(|feature| format!("narx-core/{feature}")).collect();
    let mut build = Command::new("cargo");
    build.current_dir(root).args(["build", "--quiet", "--profile", profile, "-p", "narx-small"]);
    output(build.args(["--target", EMBEDDED, "--features", &features.join(",")]))?;
    let image = target_directory(root).join(EMBEDDED).join(profile).join("small");
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
