//! Stacks of the emulated board's images: bounds of everything that runs there, and of single calls, which
//! are compared with their measured stacks.

use super::code::Code;
use super::depth::{Goes, Known, depth};
use super::{EXCEPTION_FRAME, is_panic};
use std::fs;
use std::path::Path;

/// Sinks of texts: a semihosting host, a frame of the description, and a counter of its length.
const SINK: Goes = Goes::To("as core::fmt::Write>::write_str");
const CHARACTERS: Goes = Goes::To("core::fmt::Write::write_char");
/// A text with numbers in it, which goes through the sink's table of functions.
const PIECES: Goes = Goes::To("core::fmt::Write::write_fmt");

/// Callers of a pointer in the images, and the targets. There is no executor: the loop polls the only task by
/// its name.
const KNOWN: Known = Known {
    pointers: &[
        // Pieces of a text: the formatting of a value, or the sink itself.
        (
            "core::fmt::write",
            &[
                Goes::To("as core::fmt::Display>::fmt"),
                Goes::To("as core::fmt::Debug>::fmt"),
                Goes::To("as core::fmt::UpperHex>::fmt"),
                SINK,
                CHARACTERS,
            ],
        ),
        // Sections of the description, from a table of functions; these write.
        (
            "Document>::write_line",
            &[
                Goes::To("narx_core::description::sections::cause"),
                Goes::To("narx_core::description::sections::fault"),
                Goes::To("narx_core::description::sections::message"),
                Goes::To("core::ops::function::FnOnce::call_once"),
                SINK,
                CHARACTERS,
                PIECES,
            ],
        ),
        ("narx_core::description::sections::", &[SINK, CHARACTERS, PIECES]),
        ("core::ops::function::FnOnce::call_once", &[SINK, CHARACTERS, PIECES]),
        ("core::iter::traits::iterator::Iterator::try_for_each::call", &[SINK, CHARACTERS, PIECES]),
        ("core::fmt::", &[SINK, CHARACTERS]),
        ("narx_core::shown::fixed", &[SINK, CHARACTERS]),
        // A checkpoint of the drive, or a stored item: few functions, each called so often that its address
        // stays in a register.
        ("postcard::ser::", &[Goes::Own]),
        ("Drive>::write_state", &[Goes::Own]),
        ("store_item_inner", &[Goes::Own]),
    ],
    nested: &[
        // A text within a text: an error, its detail, and a number in that.
        ("core::fmt::write", 4),
        // Structures on lines of their own: no more than one within another is printed.
        ("PadAdapter as core::fmt::Write>::write_str", 2),
        // The motor's circuit begins its interval anew when the idle one of its three legs begins to conduct;
        // no other idle leg is left then.
        ("Stage>::interval", 2),
        ("Stage>::start_idle_leg", 1),
    ],
};

/// Interrupts of the image qemu beside its main program; each may interrupt the one before it.
const INTERRUPTS: [&str; 4] = ["SysTick", "DefaultHandler", "PendSV", "NonMaskableInt"];
/// Calls of a shell, measured by `firmware/gauges/stack.rs`: name, and the functions there by the ends of
/// their names.
const CALLS: [(&str, &[&str]); 5] = [
    ("tick", &["stack::image::step"]),
    ("background", &["narx_core::device::Background::run"]),
    (
        "node",
        &["Node::poll_frame", "::poll_bulk_frame", "::handle_frame", "::poll_storage", "::handle_storage"],
    ),
    ("storage", &["narx_core::storage::Storage<F>::execute::{{closure}}"]),
    ("master", &["Master::poll_frame", "Master::handle_frame"]),
];
const MEASURED: &str = "tests/golden/instructions.toml";

/// Returns names and bytes: the background loop of the image qemu, the whole program with all interrupts at
/// once, and single calls in the image stack.
///
/// # Errors
/// Fails if there is no bound, or if a measured stack exceeds its bound.
pub(super) fn bounds(root: &Path, drive: &Code, calls: &Code) -> Result<Vec<(&'static str, u32)>, String> {
    let background = deepest(drive, |name| name.contains("Background<B>::run_with"))?;
    let mut program = deepest(drive, |name| name == "Reset")?;
    for interrupt in INTERRUPTS {
        program += deepest(drive, |name| name == interrupt)? + EXCEPTION_FRAME;
    }
    let mut rows = vec![("loop", background), ("program", program)];
    let measured = fs::read_to_string(root.join(MEASURED)).map_err(|error| format!("{MEASURED}: {error}"))?;
    for (name, ends) in CALLS {
        let bound = deepest(calls, |function| ends.iter().any(|end| function.ends_with(end)))?;
        let key = format!("stack_{name}_bytes = ");
        let line = measured.lines().find_map(|line| line.strip_prefix(&key));
        let used: u32 =
            line.and_then(|line| line.parse().ok()).ok_or_else(|| format!("{MEASURED}: no {key}"))?;
        if used > bound {
            return Err(format!("{name} took {used} bytes of stack, more than the bound of {bound}"));
        }
        rows.push((name, bound));
    }
    Ok(rows)
}

/// Largest bound of all functions with such a name.
fn deepest(code: &Code, is: impl Fn(&str) -> bool) -> Result<u32, String> {
    let named = code.named(is);
    let bounds: Result<Vec<u32>, String> =
        named.iter().map(|root| depth(code, *root, &KNOWN, is_panic)).collect();
    bounds?.into_iter().max().ok_or_else(|| "an image has not the functions whose stack is bounded".into())
}
