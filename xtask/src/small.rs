//! Flash of the core on a small board, the bytes that each feature adds to it, and the control tick alone:
//! golden figures in `tests/golden/small_board.toml`.

use crate::cross::{self, Processor};
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
# store), bytes of code and constants on a Cortex-M4F at opt-level z, the processor's vector table not counted. `least` is the core without
# features but the control modes, `every` with all of them, and under `adds` what a feature alone adds to the least. Under `alone` is the control tick
# without parameters and bus (firmware/small/src/motor.rs), by control modes, processor and opt-level.
# Made anew by `cargo xtask sizes`; `least`, `every` and `alone` on a Cortex-M4F at opt-level z are compared within 1 % by `cargo xtask test firmware`.

";

/// The core's features, in the order in which its manifest lists them.
const FEATURES: [&str; 7] =
    ["names", "description", "log", "scope", "recorder", "hall-calibration", "accelerometer"];

/// Control modes of a control tick alone.
const MODES: [(&str, &[&str]); 3] = [
    ("hall", &["hall"]),
    ("sensorless", &["sensorless"]),
    ("every_mode", &["hall", "sensorless", "open-loop"]),
];

/// Measures, and writes the golden file or, with `check`, compares some of its figures.
///
/// # Errors
/// Fails with the compiler's message, or if a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    let (least, every) = least_and_every(root)?;
    let path = root.join(GOLDEN);
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    if check {
        compare(root, &fs::read_to_string(&path).map_err(failed)?, least, every)?;
    } else {
        fs::write(&path, table(root, least, every)?).map_err(failed)?;
    }
    Ok(vec![format!("flash of the core on a small board: {least}, with every feature {every}")])
}

/// Compares `least`, `every` and, on a Cortex-M4F at opt-level z, `alone` with the golden figures.
fn compare(root: &Path, golden: &str, least: i64, every: i64) -> Result<(), String> {
    let golden: toml::Table = golden.parse().map_err(|error| format!("{GOLDEN}: {error}"))?;
    let alone_before = golden.get("alone").and_then(|alone| alone.get(EMBEDDED));
    let mut figures = vec![("least", golden.get("least"), least), ("every", golden.get("every"), every)];
    for (name, modes) in MODES {
        let before = alone_before.and_then(|table| table.get(name)?.get("z"));
        figures.push((name, before, alone(root, EMBEDDED, "small", modes)?));
    }
    for (name, before, now) in figures {
        let before = before.and_then(toml::Value::as_integer).unwrap_or(-1);
        if (now - before).abs() as f64 > sizes::TOLERANCE * before.abs() as f64 {
            return Err(format!("small board, {name}: golden {before}, now {now}: cargo xtask sizes"));
        }
    }
    Ok(())
}

/// Measures the rest, and returns the text of the golden file.
fn table(root: &Path, least: i64, every: i64) -> Result<String, String> {
    let mut text = format!("{HEAD}least = {least}\nevery = {every}\n\n[adds]\n");
    for feature in FEATURES {
        let _ = writeln!(text, "{feature} = {}", flash(root, &[feature])? - least);
    }
    for processor in Processor::ALL {
        let target = processor.target();
        install::rust_target(target)?;
        let _ = writeln!(text, "\n[alone.{target}]");
        for (name, modes) in MODES {
            let (z, three) = (alone(root, target, "small", modes)?, alone(root, target, "release", modes)?);
            let _ = writeln!(text, "{name} = {{ z = {z}, 3 = {three} }}");
        }
    }
    Ok(text)
}

/// Flash with the control modes alone, and with every feature, bytes.
///
/// # Errors
/// Fails with the compiler's message.
pub(crate) fn least_and_every(root: &Path) -> Result<(i64, i64), String> {
    install::rust_target(EMBEDDED)?;
    install::debian(&cross::PACKAGES)?;
    Ok((flash(root, &[])?, flash(root, &FEATURES)?))
}

/// Code and constants with these features of the core beside the control modes, bytes.
fn flash(root: &Path, features: &[&str]) -> Result<i64, String> {
    let features: Vec<_> = features.iter().map(|feature| format!("narx-core/{feature}")).collect();
    image(root, EMBEDDED, "small", &["--bin", "small", "--features", &features.join(",")])
}

/// Code and constants of the control tick alone with these control modes, bytes.
fn alone(root: &Path, target: &str, profile: &str, modes: &[&str]) -> Result<i64, String> {
    let arguments = ["--bin", "motor", "--no-default-features", "--features", &modes.join(",")];
    image(root, target, profile, &arguments)
}

/// Builds an image of narx-small, named by the second of `arguments`; returns its code and constants, bytes.
fn image(root: &Path, target: &str, profile: &str, arguments: &[&str]) -> Result<i64, String> {
    let mut build = Command::new("cargo");
    build.current_dir(root).args(["build", "--quiet", "--profile", profile, "-p", "narx-small"]);
    output(build.args(["--target", target]).args(arguments))?;
    let image = target_directory(root).join(target).join(profile).join(arguments[1]);
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
