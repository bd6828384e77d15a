//! The WebAssembly build: module, packages for the web and for Node, and the page.

use crate::files;
use crate::install;
use narx_report::steps::{self, Outcome, Step, run_all};
use narx_report::target_directory;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

/// Target of browsers.
const TARGET: &str = "wasm32-unknown-unknown";

/// Packages, their profiles and the modules that `narx-wasm-pack` makes of them, in the order in which it
/// takes them.
const MODULES: [(&str, &str, &str); 5] = [
    ("narx-wasm", "wasm", "narx"),
    ("narx-wasm-core", SMALL, "core"),
    ("narx-wasm-lab", SMALL, "lab"),
    ("narx-wasm-full", "wasm", "full"),
    ("narx-wasm-transcript", SMALL, "transcript"),
];
const SMALL: &str = "wasm-small";

/// Features that rustc and wasm-bindgen use, and that Node 20 and browsers of 2022 support; `--all-features`
/// makes modules that only the newest engines load.
const FEATURES: [&str; 8] = [
    "--enable-bulk-memory",
    "--enable-bulk-memory-opt",
    "--enable-call-indirect-overlong",
    "--enable-multivalue",
    "--enable-mutable-globals",
    "--enable-nontrapping-float-to-int",
    "--enable-reference-types",
    "--enable-sign-ext",
];

/// Arguments of `web`.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(crate) struct Arguments {
    /// Serve the page on this computer after the build
    #[arg(long)]
    serve: bool,
    /// Port to serve on
    #[arg(long, default_value_t = 8080)]
    port: u16,
}

/// Builds the page, and serves it on request.
pub(crate) fn command(root: &Path, arguments: Arguments) -> ExitCode {
    let built = run_all(build(root));
    if arguments.serve && built == ExitCode::SUCCESS {
        let mut serve = Command::new("node");
        serve.arg(root.join("wasm/web/serve.mjs")).arg(arguments.port.to_string());
        return if serve.status().is_ok_and(|status| status.success()) {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        };
    }
    built
}

/// Steps that build everything: packages in `wasm/pkg`, the page in `wasm/web/dist`.
pub(crate) fn build(root: &Path) -> Vec<Step<'_>> {
    vec![
        Step::new("wasm tools", move || {
            install::rust_target(TARGET)?;
            install::npm(&root.join("wasm/web"))
        }),
        Step::new("wasm modules", move || modules(root)),
        Step::new("wasm packages", move || packages(root)),
        Step::new("web page", move || {
            steps::run(
                Command::new("npm").args(["run", "--silent", "build"]).current_dir(root.join("wasm/web")),
            )
        }),
    ]
}

/// Writes the type declarations, which are committed so that they are reviewed; with `check` compares them
/// with those that the code gives.
///
/// # Errors
/// Fails with a file that is out of date, or that cannot be read.
pub(crate) fn declarations(root: &Path, check: bool) -> Outcome {
    for name in ["narx.d.ts", "core.d.ts", "lab.d.ts"] {
        let (made, kept) = (root.join("wasm/pkg/web").join(name), root.join("wasm").join(name));
        let text = fs::read_to_string(&made).map_err(|error| format!("{}: {error}", made.display()))?;
        if !check {
            fs::write(&kept, text).map_err(|error| format!("{}: {error}", kept.display()))?;
        } else if !fs::read_to_string(&kept).is_ok_and(|kept| kept == text) {
            return Err(format!("wasm/{name} is out of date: cargo xtask generate writes it anew"));
        }
    }
    Ok(Vec::new())
}

/// Writes the generated and committed files, type declarations and golden sizes, from a fresh build.
///
/// # Errors
/// Fails with a part that cannot be built.
pub(crate) fn generate(root: &Path) -> Outcome {
    package(root)?;
    declarations(root, false)?;
    steps::run(
        Command::new("node")
            .args(["--test", "tests/wasm/size.test.mjs"])
            .current_dir(root)
            .env("UPDATE", "1"),
    )
}

/// Builds the packages in `wasm/pkg`, without the page.
///
/// # Errors
/// Fails with a part that cannot be built.
pub(crate) fn package(root: &Path) -> Outcome {
    install::rust_target(TARGET)?;
    install::npm(&root.join("wasm/web"))?;
    modules(root)?;
    packages(root)
}

/// Builds the modules as the compiler leaves them. Names of folders outside the project are replaced, because
/// they would differ on every machine. Each module is built by itself, because each needs other features of
/// core.
fn modules(root: &Path) -> Outcome {
    let flags = folders_replaced(root, &target_directory(root));
    for (package, profile, _) in MODULES {
        steps::run(
            Command::new("cargo")
                .args(["build", "-p", package, "--profile", profile, "--target", TARGET])
                .env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"))
                .current_dir(root),
        )?;
    }
    Ok(Vec::new())
}

/// Returns options of the compiler that replace the names of folders: those of the sources, of what is built
/// (`target`) and of cargo.
pub(crate) fn folders_replaced(root: &Path, target: &Path) -> Vec<String> {
    // The last one that fits is taken.
    let mut flags = vec![
        format!("--remap-path-prefix={}=narx", root.display()),
        format!("--remap-path-prefix={}=built", target.display()),
    ];
    if let Some(cargo) = cargo_home() {
        flags.push(format!("--remap-path-prefix={}=cargo", cargo.display()));
        for registry in fs::read_dir(cargo.join("registry/src")).into_iter().flatten().flatten() {
            flags.push(format!("--remap-path-prefix={}=cargo", registry.path().display()));
        }
    }
    flags
}

/// Generates the JavaScript around the modules, shrinks the modules, and compiles the TypeScript over them.
fn packages(root: &Path) -> Outcome {
    let built = target_directory(root).join(TARGET);
    let directory = root.join("wasm/pkg");
    let mut pack = Command::new("cargo");
    pack.args(["run", "--quiet", "--profile", "tool", "-p", "narx-wasm-pack", "--"]).arg(&directory);
    for (package, profile, _) in MODULES {
        pack.arg(built.join(profile).join(package.replace('-', "_") + ".wasm"));
    }
    steps::run(pack.current_dir(root))?;
    let tools = root.join("wasm/web/node_modules/.bin");
    let (web, node) = (directory.join("web"), directory.join("node"));
    for (_, _, name) in MODULES {
        let file = web.join(format!("{name}_bg.wasm"));
        let mut optimise = Command::new(tools.join("wasm-opt"));
        // The stack lies first in memory, so no address of an object is a small number:
        // `low-memory-unused` may assume that. Functions that are called once stay functions of their own:
        // they look more alike, so that a module is larger but, compressed, smaller.
        optimise
            .args(["-Os", "--converge", "--low-memory-unused", "--strip-target-features"])
            .args(["--one-caller-inline-max-function-size", "20"])
            .args(FEATURES)
            .arg(&file)
            .arg("-o")
            .arg(&file);
        steps::run(&mut optimise)?;
    }
    for (folder, declared) in [(&web, "true"), (&node, "false")] {
        let mut compile = Command::new(tools.join("tsc"));
        compile.arg("-p").arg(root.join("wasm/ts")).arg("--outDir").arg(folder);
        steps::run(compile.args(["--declaration", declared]))?;
    }
    for text in ["wasm/README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
        let from = root.join(text);
        let name = from.file_name().unwrap_or_default();
        files::copy(&from, &directory.join(name))?;
    }
    let manifest = files::read(&root.join("wasm/pack/package.json"))?
        .replace("@VERSION@", env!("CARGO_PKG_VERSION"))
        .replace("@REPOSITORY@", env!("CARGO_PKG_REPOSITORY"));
    files::write(&directory.join("package.json"), &manifest)?;
    Ok(Vec::new())
}

/// Node, for programs that call our modules often: Node 20 ends with "unreachable code" now and then, where
/// it has inlined a call of WebAssembly that returns an object.
pub(crate) fn node() -> Command {
    let mut command = Command::new("node");
    command.arg("--no-turbo-inline-js-wasm-calls");
    command
}

fn cargo_home() -> Option<PathBuf> {
    env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(PathBuf::from(env::var_os("HOME")?).join(".cargo")))
}
