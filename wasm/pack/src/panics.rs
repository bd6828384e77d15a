//! Removal of the messages of panics. There is no console for the standard library's output, and a program
//! sees only a trap of a panic, with or without its message.

use anyhow::{Context, ensure};
use std::fs;
use std::path::Path;
use walrus::Module;

/// Parts of the mangled paths of functions that only a panic calls: those of `core::panicking` and
/// `std::panicking`, and those that raise one for common reasons.
const PANICS: [&str; 5] =
    ["4core9panicking", "3std9panicking", "16slice_index_fail", "13expect_failed", "13unwrap_failed"];

/// Returns the module in a file, with a trap in place of each of [`PANICS`]. `wasm-opt` then removes
/// functions and data that only they used.
pub(crate) fn silenced(wasm: &Path) -> anyhow::Result<Module> {
    let bytes = fs::read(wasm).with_context(|| wasm.display().to_string())?;
    let mut module = walrus::ModuleConfig::new()
        // Not strict, as wasm-bindgen parses it.
        .strict_validate(false)
        .generate_producers_section(false)
        .parse(&bytes)
        .with_context(|| wasm.display().to_string())?;
    let is_panic = |name: &str| PANICS.iter().any(|panic| name.contains(panic));
    let panics: Vec<_> = module
        .funcs
        .iter()
        .filter(|function| function.name.as_deref().is_some_and(is_panic))
        .map(|function| function.id())
        .collect();
    ensure!(!panics.is_empty(), "{}: no panic found by its name", wasm.display());
    for id in panics {
        let function = module.funcs.get_mut(id).kind.unwrap_local_mut();
        let entry = function.entry_block();
        function.block_mut(entry).instrs.clear();
        function.builder_mut().func_body().unreachable();
    }
    Ok(module)
}
