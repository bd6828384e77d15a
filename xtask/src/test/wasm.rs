//! Tests of the WebAssembly build, in Node and in Chromium.

use crate::install::{self, Package};
use crate::replayer::{ARGUMENTS, Replayer};
use crate::web;
use narx_report::steps::{self, Step};
use std::path::Path;

/// Steps in their order.
pub(crate) fn steps(root: &Path) -> Vec<Step<'_>> {
    let mut steps = web::build(root);
    steps.push(Step::new("type declarations", move || web::declarations(root, true)));
    steps.push(Step::new("wasm in Node", move || {
        node(
            root,
            &[
                "recording",
                "bench",
                "changes",
                "drive",
                "described",
                "core",
                "example",
                "identification",
                "full",
                "size",
                "budget",
            ],
        )
    }));
    steps.push(Step::new("page in Chromium", move || {
        // The variable CHROMIUM names another browser.
        if std::env::var_os("CHROMIUM").is_none() {
            install::debian(&[CHROMIUM])?;
        }
        node(
            root,
            &[
                "page",
                "learn",
                "model",
                "operate",
                "identify",
                "workspace",
                "passing",
                "instruments",
                "adapter",
                "bridge",
            ],
        )
    }));
    steps
}

/// Programs that replay recordings, once [`steps`] has built them.
pub(crate) fn replayers(root: &Path) -> Vec<Replayer> {
    let program = |name, script| {
        Replayer::new(name, web::node().arg(root.join("tests/wasm").join(script)).arg(ARGUMENTS))
    };
    vec![program("Node", "replay.mjs"), program("Chromium", "chromium.mjs")]
}

/// Package of Chromium without windows, which no test needs: a third of the size of the whole browser.
const CHROMIUM: Package = Package { name: "chromium-headless-shell", provides: "chromium-headless-shell" };

/// Runs test files of `tests/wasm`.
fn node(root: &Path, names: &[&str]) -> steps::Outcome {
    let mut command = web::node();
    command.args(["--test", "--test-reporter=tap"]).current_dir(root);
    steps::run(command.args(names.iter().map(|name| format!("tests/wasm/{name}.test.mjs"))))
}
