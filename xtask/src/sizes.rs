//! Flash and RAM of the C library, whole and of each part alone, and the cost of a step: golden figures in
//! `tests/golden/ffi_sizes.toml`.

use crate::cross::{self, Processor};
use crate::install;
use crate::library::NARX;
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
# linker has left out what nobody calls; memcpy and 64-bit division included), and RAM of one object. `whole` is every call of narx.h; it has
# no objects of its own. Instructions of one step as C calls it, mean and worst of the 2000 in tests/c/cost.c, without wait states; a drive is in
# Initialization and Standby there: tests/golden/instructions.toml has the others. Code for the Cortex-M0 (thumbv6m) is counted on a Cortex-M4, too.
# Made anew by `cargo xtask sizes`, compared within 1 % by `cargo xtask test ffi`.
";

/// Parts of the interface: name, prefixes of its calls, and its object.
const PARTS: [(&str, &[&str], Option<&str>); 16] = [
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
    ("tx_driver", &["narx_tx_driver_"], Some("narx_tx_driver_t")),
    ("tx_master", &["narx_tx_master_"], Some("narx_tx_master_t")),
    ("drive", &["narx_drive_", "narx_board_", "narx_scope_"], Some("narx_drive_t")),
    ("storage", &["narx_storage_"], Some("narx_storage_t")),
    ("replay", &["narx_replay"], None),
    ("whole", &["narx_"], None),
];

/// Builds the libraries, then measures them.
///
/// # Errors
/// Those of [`regenerate`], and the compiler's message.
pub(crate) fn generate(root: &Path, check: bool) -> Outcome {
    Processor::ALL.iter().try_for_each(|processor| NARX.build(root, Some(*processor)).map(drop))?;
    regenerate(root, check)
}

/// Measures libraries that are built, and writes the golden file or, with `check`, compares it.
///
/// # Errors
/// Fails if a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    install::debian(&cross::PACKAGES)?;
    let mut text = String::from(HEAD);
    let mut closing = Vec::new();
    for processor in Processor::ALL {
        let (table, line) = table(root, processor)?;
        let _ = write!(text, "\n[{}]\n{table}", processor.target());
        closing.push(line);
    }
    let path = root.join(GOLDEN);
    if !check {
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        return Ok(closing);
    }
    let wrong = misses(&read(&path)?, &text);
    if wrong.is_empty() { Ok(closing) } else { Err(wrong.join("\n")) }
}

/// Builds the library and measures its parts; returns a table of each.
///
/// # Errors
/// Fails with the compiler's message.
pub(crate) fn measured(root: &Path, processor: Processor) -> Result<toml::Table, String> {
    NARX.build(root, Some(processor))?;
    let (text, _) = table(root, processor)?;
    text.parse().map_err(|error| format!("{GOLDEN}: {error}"))
}

/// Returns a line for each part of a library that is built, and a closing line.
fn table(root: &Path, processor: Processor) -> Result<(String, String), String> {
    let directory = target_directory(root).join("c");
    fs::create_dir_all(&directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    let calls = calls(&read(&root.join("ffi/include/narx.h"))?);
    let (mut text, mut line) = (String::new(), format!("{}: flash", processor.target()));
    let costs = costs(root, processor)?;
    for (name, prefixes, object) in PARTS {
        let flash = flash(root, processor, calls.iter().filter(|call| begins(call, prefixes)))?;
        let ram = object.map_or(Ok(0), |object| ram(root, processor, object))?;
        let _ = write!(text, "{name} = {{ flash = {flash}, ram = {ram}");
        if let Some((_, mean, worst)) = costs.iter().find(|(part, ..)| part == name) {
            let _ = write!(text, ", mean = {mean}, worst = {worst}");
        }
        let _ = writeln!(text, " }}");
        if ["pi", "hall", "zero_crossing", "drive", "whole"].contains(&name) {
            let _ = write!(line, ", {name} {flash}");
        }
    }
    Ok((text, line.replacen("flash,", "flash:", 1)))
}

/// Differences from the golden file.
fn misses(golden: &str, now: &str) -> Vec<String> {
    let parse = |text: &str| text.parse::<toml::Table>().unwrap_or_default();
    let (golden, now) = (parse(golden), parse(now));
    let figure = |table: &toml::Table, target: &str, part: &str, kind: &str| {
        let figure = table.get(target)?.get(part)?.get(kind)?.as_integer()?;
        Some(figure as f64)
    };
    let mut wrong = Vec::new();
    for target in Processor::ALL.map(Processor::target) {
        for (part, ..) in PARTS {
            for (kind, few) in [("flash", 0.0), ("ram", 0.0), ("mean", FEW), ("worst", FEW)] {
                let before = figure(&golden, target, part, kind).unwrap_or(-1.0);
                let after = figure(&now, target, part, kind).unwrap_or(-1.0);
                if (after - before).abs() > few.max(TOLERANCE * before.abs()) {
                    wrong.push(format!(
                        "{target} {part} {kind}: golden {before}, now {after}: cargo xtask sizes"
                    ));
                }
            }
        }
    }
    wrong
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
    program(root, processor, calls.iter().filter(|call| uses(call)))
}

fn program<'a>(
    root: &Path,
    processor: Processor,
    calls: impl Iterator<Item = &'a String> + Clone,
) -> Result<PathBuf, String> {
    let directory = target_directory(root).join("c");
    fs::create_dir_all(&directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    let program = directory.join("size.elf");
    let mut linker = Command::new(cross::COMPILER);
    linker.args(processor.options()).args(["-nostdlib", "-Wl,--gc-sections,-z,noexecstack"]);
    linker.args(calls.clone().map(|call| format!("-Wl,--undefined={call}")));
    linker.args(calls.take(1).map(|call| format!("-Wl,--entry={call}")));
    // The compiler's own functions, on a processor that cannot divide.
    linker.arg(NARX.path(root, Some(processor))).arg("-lgcc").arg("-o").arg(&program);
    output(&mut linker)?;
    Ok(program)
}

/// Code and constants of a program with these calls, bytes.
fn flash<'a>(
    root: &Path,
    processor: Processor,
    calls: impl Iterator<Item = &'a String> + Clone,
) -> Result<u64, String> {
    let program = program(root, processor, calls)?;
    let text = output(Command::new("arm-none-eabi-size").arg(&program))?;
    let figures = text.lines().nth(1).unwrap_or_default().split_whitespace();
    let figures: Vec<u64> = figures.map_while(|figure| figure.parse().ok()).collect();
    match figures[..] {
        // The library has no variables, as the head of narx.h says of it.
        [text, 0, 0, ..] => Ok(text),
        [_, data, bss, ..] => Err(format!("the library has variables: {data} + {bss} bytes")),
        _ => Err(format!("arm-none-eabi-size: {text}")),
    }
}

/// Size of an object, bytes.
fn ram(root: &Path, processor: Processor, object: &str) -> Result<u64, String> {
    let directory = target_directory(root).join("c");
    let (source, compiled) = (directory.join("size.c"), directory.join("size.o"));
    let text = format!("#include \"narx.h\"\n{object} object;\n");
    fs::write(&source, text).map_err(|error| format!("{}: {error}", source.display()))?;
    let mut compiler = Command::new(cross::COMPILER);
    compiler.args(processor.options()).args(["-c", "-fno-common", "-I"]).arg(root.join("ffi/include"));
    output(compiler.arg(&source).arg("-o").arg(&compiled))?;
    let symbols = output(Command::new("arm-none-eabi-nm").arg("--print-size").arg(&compiled))?;
    let bytes = symbols.split_whitespace().nth(1).and_then(|bytes| u64::from_str_radix(bytes, 16).ok());
    bytes.ok_or_else(|| format!("arm-none-eabi-nm: {symbols}"))
}

/// Mean and worst number of instructions of each step, counted by `tests/c/cost.c`.
fn costs(root: &Path, processor: Processor) -> Result<Vec<(String, u64, u64)>, String> {
    install::debian(&[qemu::PACKAGE])?;
    let program = target_directory(root).join("c/cost.elf");
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

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}
