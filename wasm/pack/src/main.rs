//! Makes the JavaScript package of the built modules: `narx-wasm-pack DIRECTORY BENCH_WASM CORE_WASM LAB_WASM
//! FULL_WASM TRANSCRIPT_WASM` fills `DIRECTORY/web`, for browsers and bundlers, and `DIRECTORY/node`, for
//! Node, which reads the modules of `web`.
//!
//! | import | files | content |
//! |---|---|---|
//! | `narx` | `narx.js`, `narx_bg.wasm` | the bench |
//! | `narx/core` | `core.js`, `core_bg.wasm` | masters, messages, the dictionary, slcan |
//! | `narx/lab` | `lab.js`, `lab_bg.wasm` | replay of recordings, logs |
//! | `narx/full` | `full.js`, `full_bg.wasm` | the bench with log memory, description and bootloader |
//! | `narx/transcript` | `transcript.js`, `transcript_bg.wasm` | replay of a node's transcript |
//! | `narx/drive`, `narx/script` | from `wasm/ts` | TypeScript over the modules |
//!
//! It is a package of its own and not a part of xtask, because its dependencies take longer to compile than
//! all of narx, and `cargo xtask demo` needs none of them.

mod names;
mod panics;

use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use std::{env, fs};
use wasm_bindgen_cli_support::Bindgen;

/// The default export and `initSync` of the modules for Node, which are loaded by their import: a program
/// that awaits the default export runs in both.
const LOADED: &str = "\nexport const initSync = () => wasm;\nexport default async () => wasm;\n";

/// Types of the full bench: those of the bench.
const FULL: &str = "export * from \"./narx.js\";\nexport { default } from \"./narx.js\";\n";

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [directory, bench, core, lab, full, transcript] = arguments.as_slice() else {
        bail!("usage: narx-wasm-pack DIRECTORY BENCH_WASM CORE_WASM LAB_WASM FULL_WASM TRANSCRIPT_WASM")
    };
    let (web, node) = (directory.join("web"), directory.join("node"));
    // Removes all files of an earlier version.
    if directory.exists() {
        fs::remove_dir_all(directory).with_context(|| directory.display().to_string())?;
    }
    let modules = [("narx", bench), ("core", core), ("lab", lab), ("full", full), ("transcript", transcript)];
    for (name, wasm) in modules {
        bindgen(wasm, name)?.web(true)?.generate(&web)?;
        bindgen(wasm, name)?.nodejs_module(true)?.typescript(false).generate(&node)?;
        one_copy(&node, name)?;
    }
    append(&web.join("narx.d.ts"), &names::bench()?)?;
    append(&web.join("core.d.ts"), &names::core()?)?;
    append(&web.join("lab.d.ts"), &names::lab()?)?;
    fs::write(web.join("full.d.ts"), FULL)?;
    Ok(())
}

/// Lets a module for Node read the WebAssembly of the one for browsers, which is the same.
fn one_copy(node: &Path, name: &str) -> anyhow::Result<()> {
    let (script, module) = (node.join(format!("{name}.js")), format!("{name}_bg.wasm"));
    let text = fs::read_to_string(&script)?;
    let shared = text.replace(&module, &format!("../web/{module}"));
    if shared == text || !text.contains("const wasm = ") && !text.contains("let wasm = ") {
        bail!("{}: wasm-bindgen loads its module in another way than before", script.display());
    }
    fs::write(&script, shared + LOADED)?;
    Ok(fs::remove_file(node.join(module))?)
}

fn bindgen(wasm: &Path, name: &str) -> anyhow::Result<Bindgen> {
    let mut bindgen = Bindgen::new();
    bindgen.input_module(name, panics::silenced(wasm)?).out_name(name).typescript(true);
    bindgen.omit_default_module_path(false).remove_producers_section(true);
    Ok(bindgen)
}

fn append(declarations: &Path, names: &str) -> anyhow::Result<()> {
    let text = fs::read_to_string(declarations)?;
    // wasm-bindgen declares `Symbol.dispose`, which the library of ES2023 does not have.
    fs::write(declarations, format!("/// <reference lib=\"esnext.disposable\" />\n{text}{names}"))?;
    Ok(())
}
