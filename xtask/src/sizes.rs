//! Flash and RAM of the C library, fast and small, whole and of each part alone, and the cost of a step:
//! golden figures in `tests/golden/ffi_sizes.toml`.

use crate::cross::{self, Processor};
use crate::files::read;
use crate::install;
use crate::library::{Library, NARX, SMALL};
use crate::qemu::{self, Machine};
use narx_report::steps::Outcome;
use narx_report::steps::output;
use narx_report::target_directory;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Largest difference from the golden figure, as a share of it, or as a few instructions: compilers and
/// linkers round and pad differently.
pub(crate) const TOLERANCE: f64 = 0.01;
const FEW: f64 = 3.0;
const GOLDEN: &str = "tests/golden/ffi_sizes.toml";
const HEAD: &str = "\
# The C library on a microcontroller. Flash of a program that uses every call of one part and nothing else, bytes (code and constants, after the
# linker has left out what nobody calls; memcpy, memset and 64-bit division of the C library included), and RAM of one object. `ready` is the flash
# without the calls that check settings and compute coefficients: with ready-made ones. `whole` is every call of narx.h; it has no objects of its
# own. Instructions of one step as C calls it, mean and worst of the 2000 in tests/c/cost.c, without wait states; a drive is in Initialization and
# Standby there: tests/golden/instructions.toml has the others. Code for the Cortex-M0 (thumbv6m) is counted on a Cortex-M4, too. The first tables
# are of the fast library (opt-level 3), `small` of the small one (z). `alone` is a whole program that turns a motor by the control tick alone
# (tests/c/alone.c, its coefficients included) with a library of these control modes and nothing else.
# Made anew by `cargo xtask sizes`; the fast tables, and those of the Cortex-M4F at z, are compared within 1 % by `cargo xtask test ffi`.
";

/// Parts of the interface: name, prefixes of its calls, and its object.
const PARTS: [(&str, &[&str], Option<&str>); 18] = [
    ("formats", &["narx_q1", "narx_iq24", "narx_milli"], None),
    ("pi", &["narx_pi_"], Some("narx_pi_t")),
    ("ramp", &["narx_ramp_"], Some("narx_ramp_t")),
    ("hall", &["narx_hall_"], Some("narx_hall_t")),
    ("commutation", &["narx_commutation_"], Some("narx_commutator_t")),
    ("zero_crossing", &["narx_zero_crossing_"], Some("narx_zero_crossing_t")),
    ("fault", &["narx_fault_"], Some("narx_fault_t")),
    ("state", &["narx_state_"], Some("narx_state_machine_t")),
    ("message", &["narx_message_"], None),
    ("master", &["narx_master_"], Some("narx_master_t")),
    (
        "identification",
        &["narx_identification_", "narx_nameplate_", "narx_commission", "narx_speed_loop"],
        Some("narx_identification_t"),
    ),
    ("tx_driver", &["narx_tx_driver_"], Some("narx_tx_driver_t")),
    ("tx_master", &["narx_tx_master_"], Some("narx_tx_master_t")),
    ("motor", &["narx_motor_", "narx_coefficients_"], Some("narx_motor_t")),
    ("drive", &["narx_drive_", "narx_board_", "narx_scope_"], Some("narx_drive_t")),
    ("storage", &["narx_storage_"], Some("narx_storage_t")),
    ("replay", &["narx_replay"], None),
    ("whole", &["narx_"], None),
];

/// Control modes of a library for the control tick alone.
const MODES: [(&str, &[&str]); 3] = [
    ("hall", &["hall"]),
    ("sensorless", &["sensorless"]),
    ("every_mode", &["hall", "sensorless", "open-loop"]),
];

/// Builds the libraries, then measures them.
///
/// # Errors
/// Those of [`regenerate`], and the compiler's message.
pub(crate) fn generate(root: &Path, check: bool) -> Outcome {
    Processor::MEASURED.iter().try_for_each(|processor| NARX.build(root, Some(*processor)).map(drop))?;
    regenerate(root, check)
}

/// Measures fast libraries that are built, and small ones; writes the golden file or, with `check`, compares
/// it and measures less.
///
/// # Errors
/// Fails if a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    install::debian(&cross::PACKAGES)?;
    let mut text = String::from(HEAD);
    let mut closing = Vec::new();
    for processor in Processor::MEASURED {
        let target = processor.target();
        let costs = costs(root, processor)?;
        let (table, line) = table(root, NARX, processor, &costs)?;
        let _ = write!(text, "\n[{target}]\n{table}");
        closing.push(format!("{target}: flash{line}"));
    }
    for processor in Processor::MEASURED {
        let target = processor.target();
        if check && processor != Processor::CortexM4F {
            continue;
        }
        SMALL.build(root, Some(processor))?;
        let (table, line) = table(root, SMALL, processor, &[])?;
        let _ = write!(text, "\n[{target}.small]\n{table}\n[{target}.alone]\n");
        for (name, modes) in MODES {
            let z = alone(root, SMALL, processor, modes)?;
            let three = if check { None } else { Some(alone(root, NARX, processor, modes)?) };
            let three = three.map_or(String::new(), |bytes| format!(", 3 = {bytes}"));
            let _ = writeln!(text, "{name} = {{ z = {z}{three} }}");
        }
        // Libraries of some modes have taken the place of the whole ones.
        SMALL.build(root, Some(processor))?;
        if !check {
            NARX.build(root, Some(processor))?;
        }
        closing.push(format!("{target}, small: flash{line}"));
    }
    let path = root.join(GOLDEN);
    if !check {
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        return Ok(closing);
    }
    let golden = read(&path)?.parse().map_err(|error| format!("{GOLDEN}: {error}"))?;
    let now = text.parse().map_err(|error| format!("{GOLDEN}: {error}"))?;
    let mut wrong = Vec::new();
    misses("", &golden, &now, &mut wrong);
    if wrong.is_empty() { Ok(closing) } else { Err(wrong.join("\n")) }
}

/// Builds the fast library and measures its parts; returns a table of each.
///
/// # Errors
/// Fails with the compiler's message.
pub(crate) fn measured(root: &Path, processor: Processor) -> Result<toml::Table, String> {
    NARX.build(root, Some(processor))?;
    let (text, _) = table(root, NARX, processor, &costs(root, processor)?)?;
    text.parse().map_err(|error| format!("{GOLDEN}: {error}"))
}

/// Returns a line for each part of a library that is built, and the end of a closing line.
fn table(
    root: &Path,
    library: Library,
    processor: Processor,
    costs: &[(String, u64, u64)],
) -> Result<(String, String), String> {
    let calls = calls(&read(&root.join("ffi/include/narx.h"))?);
    let (mut text, mut line) = (String::new(), String::new());
    for (name, prefixes, object) in PARTS {
        let part: Vec<_> = calls.iter().filter(|call| begins(call, prefixes)).collect();
        let flash = flash(root, library, processor, &part)?;
        let ram = object.map_or(Ok(0), |object| ram(root, processor, object))?;
        let _ = write!(text, "{name} = {{ flash = {flash}, ");
        let needs_settings = |call: &str| call.ends_with("_init") || call.ends_with("_settings_default");
        if part.iter().any(|call| call.ends_with("_init_ready")) && name != "whole" {
            let ready: Vec<_> = part.iter().copied().filter(|call| !needs_settings(call)).collect();
            let _ = write!(text, "ready = {}, ", self::flash(root, library, processor, &ready)?);
        }
        let _ = write!(text, "ram = {ram}");
        if let Some((_, mean, worst)) = costs.iter().find(|(part, ..)| part == name) {
            let _ = write!(text, ", mean = {mean}, worst = {worst}");
        }
        let _ = writeln!(text, " }}");
        if ["pi", "hall", "zero_crossing", "motor", "drive", "whole"].contains(&name) {
            let _ = write!(line, ", {name} {flash}");
        }
    }
    Ok((text, line.replacen(',', ":", 1)))
}

/// Flash of the program of the control tick alone, with a library of these control modes, bytes.
fn alone(root: &Path, library: Library, processor: Processor, modes: &[&str]) -> Result<u64, String> {
    library.build_part(root, processor, modes)?;
    let program = file(root, "alone.elf")?;
    let mut compiler = Command::new(processor.tool("gcc"));
    compiler.args(processor.options()).args(["-std=c99", "-Os"]).args(cross::STRICT).args(BARE);
    compiler.arg("-Wl,--entry=main").arg("-I").arg(root.join("ffi/include"));
    compiler.arg(root.join("tests/c/alone.c")).arg(library.path(root, Some(processor)));
    output(compiler.arg("-o").arg(&program))?;
    let (text, data, _) = sizes(&program)?;
    Ok(text + data)
}

/// Differences of the figures in `now` from the golden ones.
fn misses(place: &str, golden: &toml::Table, now: &toml::Table, wrong: &mut Vec<String>) {
    for (name, value) in now {
        let (place, before) = (format!("{place} {name}"), golden.get(name));
        if let Some(table) = value.as_table() {
            misses(
                &place,
                before.and_then(toml::Value::as_table).unwrap_or(&toml::Table::new()),
                table,
                wrong,
            );
            continue;
        }
        let few = if name == "mean" || name == "worst" { FEW } else { 0.0 };
        let after = value.as_integer().unwrap_or(-1);
        let before = before.and_then(toml::Value::as_integer).unwrap_or(-1);
        if (after - before).abs() as f64 > few.max(TOLERANCE * before.abs() as f64) {
            wrong.push(format!("{}: golden {before}, now {after}: cargo xtask sizes", place.trim_start()));
        }
    }
}

fn begins(call: &str, prefixes: &[&str]) -> bool {
    prefixes.iter().any(|prefix| call.starts_with(prefix))
}

/// Names of all calls of the header.
fn calls(header: &str) -> Vec<String> {
    let name = |line: &str| {
        let (before, _) = line.split_once('(')?;
        let name = before.rsplit([' ', '*']).next()?;
        (name.starts_with("narx_") && !line.starts_with("//")).then(|| name.to_owned())
    };
    header.lines().filter(|line| !line.starts_with([' ', '#', '/'])).filter_map(name).collect()
}

/// Links a program of the calls of narx.h that `uses` selects with the library that is built; returns its
/// path.
///
/// # Errors
/// Fails with the linker's message.
pub(crate) fn link(
    root: &Path,
    processor: Processor,
    uses: impl Fn(&str) -> bool,
) -> Result<PathBuf, String> {
    let calls = calls(&read(&root.join("ffi/include/narx.h"))?);
    let calls: Vec<_> = calls.iter().filter(|call| uses(call)).collect();
    program(root, NARX, processor, &calls)
}

/// Returns the path of a file in the folder of C programs, which it creates.
fn file(root: &Path, name: &str) -> Result<PathBuf, String> {
    let directory = target_directory(root).join("c");
    fs::create_dir_all(&directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    Ok(directory.join(name))
}

/// Options for a program without a start-up, with the small C library.
const BARE: [&str; 3] = ["-nostartfiles", "--specs=nano.specs", "-Wl,--gc-sections,-z,noexecstack"];

fn program(
    root: &Path,
    library: Library,
    processor: Processor,
    calls: &[&String],
) -> Result<PathBuf, String> {
    let program = file(root, "size.elf")?;
    let mut linker = Command::new(processor.tool("gcc"));
    linker.args(processor.options()).args(BARE);
    linker.args(calls.iter().map(|call| format!("-Wl,--undefined={call}")));
    linker.args(calls.iter().take(1).map(|call| format!("-Wl,--entry={call}")));
    linker.arg(library.path(root, Some(processor))).arg("-o").arg(&program);
    output(&mut linker)?;
    Ok(program)
}

/// Code and constants of a program with these calls, bytes.
fn flash(root: &Path, library: Library, processor: Processor, calls: &[&String]) -> Result<u64, String> {
    match sizes(&program(root, library, processor, calls)?)? {
        // The library has no variables, as the head of narx.h says of it.
        (text, 0, 0) => Ok(text),
        (_, data, bss) => Err(format!("the library has variables: {data} + {bss} bytes")),
    }
}

/// Sizes of a program: code with constants, initialised variables, and other variables, bytes.
fn sizes(program: &Path) -> Result<(u64, u64, u64), String> {
    let text = output(Command::new("arm-none-eabi-size").arg(program))?;
    let figures = text.lines().nth(1).unwrap_or_default().split_whitespace();
    let figures: Vec<u64> = figures.map_while(|figure| figure.parse().ok()).collect();
    match figures[..] {
        [text, data, bss, ..] => Ok((text, data, bss)),
        _ => Err(format!("arm-none-eabi-size: {text}")),
    }
}

/// Size of an object, bytes.
fn ram(root: &Path, processor: Processor, object: &str) -> Result<u64, String> {
    let (source, compiled) = (file(root, "size.c")?, file(root, "size.o")?);
    let text = format!("#include \"narx.h\"\n{object} object;\n");
    fs::write(&source, text).map_err(|error| format!("{}: {error}", source.display()))?;
    let mut compiler = Command::new(processor.tool("gcc"));
    compiler.args(processor.options()).args(["-c", "-fno-common", "-I"]).arg(root.join("ffi/include"));
    output(compiler.arg(&source).arg("-o").arg(&compiled))?;
    let symbols = output(Command::new("arm-none-eabi-nm").arg("--print-size").arg(&compiled))?;
    let bytes = symbols.split_whitespace().nth(1).and_then(|bytes| u64::from_str_radix(bytes, 16).ok());
    bytes.ok_or_else(|| format!("arm-none-eabi-nm: {symbols}"))
}

/// Mean and worst number of instructions of each step, counted by `tests/c/cost.c`.
fn costs(root: &Path, processor: Processor) -> Result<Vec<(String, u64, u64)>, String> {
    install::debian(&[qemu::PACKAGE])?;
    let program = file(root, "cost.elf")?;
    let mut compiler = cross::compiler_for(root, processor, Machine::Mps2M4);
    compiler.args(["-std=c99", "-O2", "-I"]).arg(root.join("ffi/include")).args(cross::STRICT);
    compiler.arg(root.join("tests/c/cost.c")).arg(NARX.path(root, Some(processor)));
    output(compiler.arg("-o").arg(&program))?;
    let arguments: [&str; 0] = [];
    let text = output(&mut qemu::counting(&program, &arguments))?;
    let row = |line: &str| {
        let mut words = line.split_whitespace();
        Some((words.next()?.to_owned(), words.next()?.parse().ok()?, words.next()?.parse().ok()?))
    };
    Ok(text.lines().filter_map(row).collect())
}
