//! Makes JavaScript packages of a built `narx_wasm.wasm`: `narx-wasm-pack WASM DIRECTORY` fills `DIRECTORY/web` and
//! `DIRECTORY/node`.
//!
//! A package of its own and not a part of xtask: what it depends on takes longer to compile than all of narx, and
//! `cargo xtask demo` needs none of it.

use anyhow::{Context, bail};
use narx_core::motor::FaultWord;
use narx_sim::bench::SIGNALS;
use narx_sim::commissioning::Mode;
use narx_sim::presets::PRESETS;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};
use wasm_bindgen_cli_support::Bindgen;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [wasm, directory] = arguments.as_slice() else { bail!("usage: narx-wasm-pack WASM DIRECTORY") };
    let (web, node) = (directory.join("web"), directory.join("node"));
    for package in [&web, &node] {
        // Nothing of an earlier version stays behind.
        if package.exists() {
            fs::remove_dir_all(package).with_context(|| package.display().to_string())?;
        }
    }
    bindgen(wasm).web(true)?.generate(&web)?;
    bindgen(wasm).nodejs_module(true)?.generate(&node)?;
    for package in [&web, &node] {
        append_names(&package.join("narx.d.ts"))?;
        fs::write(package.join("package.json"), "{ \"name\": \"narx\", \"type\": \"module\" }\n")?;
    }
    Ok(())
}

fn bindgen(wasm: &Path) -> Bindgen {
    let mut bindgen = Bindgen::new();
    bindgen.input_path(wasm).out_name("narx").typescript(true);
    bindgen.omit_default_module_path(false).remove_producers_section(true);
    bindgen
}

/// The names that TypeScript should know, from the tables that hold them.
fn append_names(declarations: &Path) -> anyhow::Result<()> {
    let mut text = fs::read_to_string(declarations)?;
    union(
        &mut text,
        "SignalName",
        "Signals of a trace.",
        SIGNALS.iter().map(|signal| signal.name.to_owned()),
    )?;
    union(&mut text, "MotorName", "Real motors.", PRESETS.iter().map(|preset| preset.name.to_owned()))?;
    union(&mut text, "Mode", "Control modes.", Mode::ALL.iter().map(|mode| mode.name().to_owned()))?;
    let faults = FaultWord::all();
    let names = faults.iter_names().map(|(name, _)| name.to_ascii_lowercase());
    union(&mut text, "FaultName", "Bits of the fault word.", names)?;
    fs::write(declarations, text)?;
    Ok(())
}

fn union(
    text: &mut String,
    name: &str,
    about: &str,
    members: impl Iterator<Item = String>,
) -> anyhow::Result<()> {
    write!(text, "\n/** {about} */\nexport type {name} =")?;
    for member in members {
        write!(text, "\n    | \"{member}\"")?;
    }
    text.push_str(";\n");
    Ok(())
}
