//! Properties of the linked programs that are shown without many runs: `cargo xtask proof`, and the tools
//! that watch memory.

use super::Section;
use serde::Deserialize;
use std::fs;
use std::path::Path;

/// Results of [`crate::proof`] that the page shows.
#[derive(Deserialize)]
struct Golden {
    tick: Tick,
    stack: Stack,
    core: Core,
    qemu: Qemu,
    r#unsafe: Files,
}

#[derive(Deserialize)]
struct Tick {
    functions: usize,
    stack: u32,
}

#[derive(Deserialize)]
struct Stack {
    background: u32,
    node: u32,
    storage: u32,
}

#[derive(Deserialize)]
struct Core {
    storage_resumed: Vec<String>,
}

#[derive(Deserialize)]
struct Qemu {
    resumed: Vec<String>,
}

#[derive(Deserialize)]
struct Files {
    files: Vec<String>,
}

/// Section with the table.
pub(super) fn section(root: &Path) -> Result<Section, String> {
    let path = root.join(crate::proof::GOLDEN);
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let golden: Golden = toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(Section { title: "What cannot happen", text: table(&golden) })
}

fn table(golden: &Golden) -> String {
    let Golden { tick, stack, core, qemu, r#unsafe } = golden;
    format!(
        "\
`cargo xtask proof` walks every path of calls in the linked programs for a Cortex-M4F: what is not on any cannot happen, however the program is fed. What is left is a list in `{}`, which `cargo xtask test` compares on every run.

| what | |
|---|---|
| in the control interrupt: a panic, a text, floating point, a call by a pointer | on none of its paths, {} functions |
| in any call of `narx.h` but those of storage: a panic | in none |
| in those of storage: a panic | {} async functions have one, for who polls them once more after their end, which no caller does |
| in all that runs in the emulated drive after boot, its simulated motor included: a panic | {} async functions, likewise |
| stack of the control interrupt, at most | {} bytes |
| stack of the background, of its node, of its storage, at most | {}, {}, {} bytes |
| `unsafe` in the core or in the simulation | in no file; of the firmware, in {} files that touch a chip |

`cargo xtask test ffi` runs the C interface, which takes pointers, under gcc's and clang's sanitizers and in valgrind, and both halves of a drive at once under ThreadSanitizer and in Miri: none has anything to say, and misuse on purpose is noticed. `cargo xtask audit` holds every dependency to its licence and source; [SECURITY.md](../SECURITY.md) says what all of \
this is to keep out.
",
        crate::proof::GOLDEN,
        tick.functions,
        core.storage_resumed.len(),
        qemu.resumed.len(),
        tick.stack,
        stack.background,
        stack.node,
        stack.storage,
        r#unsafe.files.len(),
    )
}
