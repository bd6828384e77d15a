//! Makes JavaScript packages of the built modules: `narx-wasm-pack DIRECTORY BENCH_WASM CORE_WASM LAB_WASM
//! FULL_WASM TRANSCRIPT_WASM` fills `DIRECTORY/web` and `DIRECTORY/node`.
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

/// The package.json of a package, with its imports.
const MANIFEST: &str = r#"{
  "name": "narx",
  "type": "module",
  "exports": {
    ".": { "types": "./narx.d.ts", "default": "./narx.js" },
    "./core": { "types": "./core.d.ts", "default": "./core.js" },
    "./lab": { "types": "./lab.d.ts", "default": "./lab.js" },
    "./full": { "types": "./full.d.ts", "default": "./full.js" },
    "./transcript": { "types": "./transcript.d.ts", "default": "./transcript.js" },
    "./drive": { "types": "./drive.d.ts", "default": "./drive.js" },
    "./script": { "types": "./script.d.ts", "default": "./script.js" },
    "./*.wasm": "./*.wasm"
  }
}
"#;

/// Types of the full bench: those of the bench.
const FULL: &str = "export * from \"./narx.js\";\nexport { default } from \"./narx.js\";\n";

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [directory, bench, core, lab, full, transcript] = arguments.as_slice() else {
        bail!("usage: narx-wasm-pack DIRECTORY BENCH_WASM CORE_WASM LAB_WASM FULL_WASM TRANSCRIPT_WASM")
    };
    let (web, node) = (directory.join("web"), directory.join("node"));
    for package in [&web, &node] {
        // Removes all files of an earlier version.
        if package.exists() {
            fs::remove_dir_all(package).with_context(|| package.display().to_string())?;
        }
    }
    let modules = [("narx", bench), ("core", core), ("lab", lab), ("full", full), ("transcript", transcript)];
    for (name, wasm) in modules {
        bindgen(wasm, name)?.web(true)?.generate(&web)?;
        bindgen(wasm, name)?.nodejs_module(true)?.generate(&node)?;
    }
    for package in [&web, &node] {
        append(&package.join("narx.d.ts"), &names::bench()?)?;
        append(&package.join("core.d.ts"), &names::core()?)?;
        append(&package.join("lab.d.ts"), &names::lab()?)?;
        fs::write(package.join("full.d.ts"), FULL)?;
        fs::write(package.join("package.json"), MANIFEST)?;
    }
    Ok(())
}

fn bindgen(wasm: &Path, name: &str) -> anyhow::Result<Bindgen> {
    let mut bindgen = Bindgen::new();
    bindgen.input_module(name, panics::silenced(wasm)?).out_name(name).typescript(true);
    bindgen.omit_default_module_path(false).remove_producers_section(true);
    Ok(bindgen)
}

fn append(declarations: &Path, names: &str) -> anyhow::Result<()> {
    let text = fs::read_to_string(declarations)?;
    fs::write(declarations, text + names)?;
    Ok(())
}
