//! Proofs about linked programs: entry points from which no panic, no text and no floating point can be
//! reached, and a sufficient size of the stack. The remaining texts, and async functions that are polled
//! after their end, are a golden list in `tests/golden/proof.toml`.

mod code;
mod depth;
mod stack;
mod unsafe_files;

use crate::cross::{self, Processor};
use crate::firmware;
use crate::image::Image;
use crate::install;
use crate::library::NARX;
use crate::sizes;
use code::{Code, Function};
use narx_report::steps::{self, Outcome};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

/// File with the proven properties, and the remaining exceptions.
pub(crate) const GOLDEN: &str = "tests/golden/proof.toml";
const HEAD: &str = "\
# What is left where a proof ends, by `cargo xtask proof`; compared by `cargo xtask test firmware`. A name stands for all functions of that name.
#
# tick    the control interrupt of the image qemu. Proven: neither a panic nor core::fmt can be reached, nothing is called by a pointer, and no
#         instruction and no call of the compiler's library is one of floating point. stack: bytes on the longest path, with the registers that the
#         processor saves for the interrupt; functions: how many there are on all paths.
# stack   bytes on the longest path of calls, in the image qemu of the background loop with flash, motor and texts (loop) and of all from reset on with
#         every interrupt at once (program); in the image stack of the calls that tests/golden/instructions.toml measures (stack_NAME_bytes), which are
#         never more. Where calls by a pointer go, and what is on a path more than once, xtask/src/proof/stack.rs names.
# core    every call of narx.h but narx_storage_*, linked for the Cortex-M4F. Proven: the program has no panic in it. With narx_storage_*, too, it has none but
#         `resumed`, in storage_resumed.
# qemu    what runs in the image qemu after boot, its simulated motor included. Proven: no panic can be reached but `resumed`. texts: what asks for texts.
#         resumed   The compiler writes into every async function a panic for who polls it once more after its end. `.await` never does. Who polls by
#                   hand: the loop (`Background::run_with`), a task that has no end (`Mailbox::serve` returns `!`); `finish` and narx_storage_*, which
#                   poll a future of their own until it is ready and drop it.
# unsafe  files that contain the word.
";
/// Bytes that the processor saves for an interrupt: 8 words, and 18 of floating point where that was in use
/// (ARMv7-M Architecture Reference Manual, B1.5.6).
const EXCEPTION_FRAME: u32 = 4 * (8 + 18);

/// Runs `cargo xtask proof [--check]`.
pub(crate) fn command(root: &Path, check: bool) -> ExitCode {
    let built = firmware::build(root).and_then(|_| regenerate(root, check));
    steps::finish(built)
}

/// Proves the properties of the images and the library that [`firmware::build`] has made, and writes the
/// golden file or, with `check`, compares it.
///
/// # Errors
/// Fails with a property that does not hold, or that differs from the golden file.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    install::debian(&cross::PACKAGES)?;
    NARX.build(root, Some(Processor::CortexM4F))?;
    let image = Code::read(&Image::Drive.path(root))?;
    let tick = Tick::prove(&image)?;
    prove_core(root)?;
    let storage = Code::read(&sizes::link(root, Processor::CortexM4F, |_| true)?)?;
    let mut text = String::from(HEAD);
    let _ = writeln!(text, "\n[tick]\nfunctions = {}\nstack = {}", tick.functions, tick.stack);
    let _ = writeln!(text, "\n[stack]");
    let bounds = stack::bounds(root, &image, &Code::read(&Image::Stack.path(root))?)?;
    for (name, bytes) in &bounds {
        let _ = writeln!(text, "{name} = {bytes}");
    }
    let _ = writeln!(text, "\n[core]");
    let calls = storage.named(|name| name.starts_with("narx_"));
    list(&mut text, "storage_resumed", &callers(&storage, &calls, is_resumed));
    refuse_panics("the library with its storage", &callers(&storage, &calls, is_other_panic))?;
    let _ = writeln!(text, "\n[qemu]");
    let roots = image.named(|name| AFTER_BOOT.iter().any(|root| name.contains(root)));
    list(&mut text, "resumed", &callers(&image, &roots, is_resumed));
    refuse_panics("the image qemu after boot", &callers(&image, &roots, is_other_panic))?;
    list(&mut text, "texts", &callers(&image, &roots, is_text));
    let _ = writeln!(text, "\n[unsafe]");
    list(&mut text, "files", &unsafe_files::find(root)?);
    let path = root.join(GOLDEN);
    let closing = vec![
        format!(
            "the control interrupt: {} functions, {} bytes of stack at most, no panic, no float, no text",
            tick.functions, tick.stack
        ),
        bounds
            .iter()
            .map(|(name, bytes)| format!("{name} {bytes}"))
            .fold("bytes of stack:".into(), |line, row| line + " " + &row),
    ];
    if !check {
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        return Ok(closing);
    }
    let golden = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let differences = differences(&golden, &text);
    if differences.is_empty() {
        Ok(closing)
    } else {
        Err(differences + "if that is meant: cargo xtask proof")
    }
}

/// Entry points of the image qemu after its boot: the background loop, and the interrupts.
const AFTER_BOOT: [&str; 6] =
    ["Background<B>::run", "PendSV", "SysTick", "DefaultHandler", "NonMaskableInt", "HardFault"];

/// Properties of the control interrupt.
struct Tick {
    functions: usize,
    stack: u32,
}

impl Tick {
    fn prove(image: &Code) -> Result<Self, String> {
        let &[root] = image.named(|name| name == "PendSV").as_slice() else {
            return Err("the image has no interrupt PendSV".into());
        };
        let reached = image.reachable(&[root], |_| false);
        let refuse = |what: &str, is: &dyn Fn(&Function) -> Option<String>| {
            let found: Vec<String> = reached.values().filter_map(|function| is(function)).collect();
            if found.is_empty() {
                return Ok(());
            }
            Err(format!("from the control interrupt {what} can be reached:\n  {}\n", found.join("\n  ")))
        };
        let named = |is: fn(&str) -> bool| {
            move |function: &Function| is(&function.name).then(|| function.name.clone())
        };
        refuse("a panic", &named(is_panic))?;
        refuse("a text", &named(is_text))?;
        refuse("floating point", &named(is_float))?;
        let float = |function: &Function| Some(format!("{}: {}", function.name, function.float.as_ref()?));
        refuse("floating point", &float)?;
        refuse("whatever a register points at", &|function| {
            function.calls_any.then(|| function.name.clone())
        })?;
        let stack = depth::depth(image, root, &depth::Known::NOTHING, |_| false)? + EXCEPTION_FRAME;
        Ok(Self { functions: reached.len(), stack })
    }
}

/// Links every call of the C interface but those of the storage, and checks that none can panic.
fn prove_core(root: &Path) -> Result<(), String> {
    let program = sizes::link(root, Processor::CortexM4F, |call| !call.starts_with("narx_storage_"))?;
    let code = Code::read(&program)?;
    let calls = code.named(|name| name.starts_with("narx_"));
    let callers = callers(&code, &calls, is_panic);
    if code.named(is_panic).is_empty() {
        return Ok(());
    }
    Err(format!("core can panic, linked without storage:\n  {}", callers.join("\n  ")))
}

fn refuse_panics(what: &str, callers: &[String]) -> Result<(), String> {
    if callers.is_empty() { Ok(()) } else { Err(format!("{what} can panic:\n  {}\n", callers.join("\n  "))) }
}

/// Names of the functions that may run once one of `roots` runs, and that call a function that satisfies `is`
/// without satisfying it themselves. Code after a panic does not count.
fn callers(code: &Code, roots: &[u32], is: fn(&str) -> bool) -> Vec<String> {
    let calls = |function: &Function| {
        function.calls.iter().any(|at| code.functions.get(at).is_some_and(|called| is(&called.name)))
    };
    let reached = code.reachable(roots, is_panic);
    let found = reached
        .values()
        .filter(|function| !is(&function.name) && !is_panic(&function.name) && calls(function));
    found.map(|function| function.name.clone()).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Returns whether a function is the panic handler, or ends in it.
fn is_panic(name: &str) -> bool {
    const PARTS: [&str; 8] = [
        "core::panicking::",
        "rust_begin_unwind",
        "core::cell::panic_",
        "core::option::",
        "core::result::unwrap_failed",
        "slice_index_fail",
        "len_mismatch_fail",
        "slice_error_fail",
    ];
    PARTS.iter().any(|part| name.contains(part)) && !name.starts_with('<')
}

/// Returns whether a function is the panic of an async function that is polled again after its end; the
/// compiler writes it into every async function.
fn is_resumed(name: &str) -> bool {
    name.contains("core::panicking::panic_const::panic_const_async_fn_resumed")
}

fn is_other_panic(name: &str) -> bool {
    is_panic(name) && !is_resumed(name)
}

/// Returns whether a function formats texts.
fn is_text(name: &str) -> bool {
    ["core::fmt::", "core::fmt::Formatter"].iter().any(|part| name.trim_start_matches('<').starts_with(part))
}

/// Returns whether a function is floating point in software (Arm, *Run-time ABI for the Arm Architecture*,
/// 5.1.2).
fn is_float(name: &str) -> bool {
    const HELPERS: [&str; 6] = ["f", "d", "i2", "ui2", "l2", "ul2"];
    name.contains("compiler_builtins::float")
        || name
            .strip_prefix("__aeabi_")
            .is_some_and(|rest| HELPERS.iter().any(|helper| rest.starts_with(helper)))
}

fn list(text: &mut String, name: &str, entries: &[String]) {
    let _ = writeln!(text, "{name} = [");
    for entry in entries {
        let _ = writeln!(text, "    {entry:?},");
    }
    let _ = writeln!(text, "]");
}

/// Lines that only one of two texts has.
fn differences(golden: &str, now: &str) -> String {
    let (golden, now): (BTreeSet<&str>, BTreeSet<&str>) = (golden.lines().collect(), now.lines().collect());
    let gone = golden.difference(&now).map(|line| format!("gone: {}\n", line.trim()));
    let new = now.difference(&golden).map(|line| format!("new:  {}\n", line.trim()));
    gone.chain(new).collect()
}
