//! Each artefact used as its user gets it: in a folder outside the working copy, with an environment that has
//! neither Rust nor anything of ours, and what the registries of the language offer.

use super::VERSION;
use crate::cross::Processor;
use crate::files;
use crate::image::EMBEDDED;
use crate::install::{self, Package};
use narx_report::steps::{self, Outcome, Step, output};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// Debian packages that the tests need beside those of the archive.
const PACKAGES: [Package; 6] = [
    Package { name: "gcc", provides: "gcc" },
    Package { name: "cmake", provides: "cmake" },
    Package { name: "make", provides: "make" },
    Package { name: "pkg-config", provides: "pkg-config" },
    install::NODE[0],
    install::NODE[1],
];

/// Steps in their order.
pub(super) fn steps<'a>(root: &'a Path, out: &'a Path) -> Vec<Step<'a>> {
    let step = |name, run: fn(&User) -> Outcome| {
        Step::new(name, move || User::new(root, out, name).and_then(|user| run(&user)))
    };
    vec![
        Step::new("checksums", move || {
            steps::run(
                Command::new("sha256sum")
                    .args(["--quiet", "--check", super::materials::SUMS])
                    .current_dir(out),
            )
        }),
        Step::new("tools", || install::debian(&PACKAGES)),
        step("wheel", wheel),
        step("source of Python", source),
        step("npm package", npm),
        step("C archive", archive),
        step("PlatformIO", platformio),
        step("Zephyr", zephyr),
        step("crate", library),
        step("command line", command_line),
    ]
}

/// Somebody with an artefact and an empty folder.
struct User {
    root: PathBuf,
    out: PathBuf,
    home: PathBuf,
}

impl User {
    /// Makes the folder, in the system's folder for temporary files.
    fn new(root: &Path, out: &Path, name: &str) -> Result<Self, String> {
        let home = env::temp_dir().join(format!("narx-{VERSION}-{}", name.replace(' ', "-")));
        let _ = fs::remove_dir_all(&home);
        fs::create_dir_all(&home).map_err(|error| format!("{}: {error}", home.display()))?;
        Ok(Self { root: root.into(), out: out.into(), home })
    }

    /// A program of the system in the user's folder, in an environment without ours.
    fn call(&self, program: impl AsRef<std::ffi::OsStr>, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(&self.home).env_clear();
        command.env("PATH", "/usr/local/bin:/usr/bin:/bin").env("HOME", &self.home).env("LANG", "C.UTF-8");
        command
    }

    fn run(&self, program: impl AsRef<std::ffi::OsStr>, arguments: &[&str]) -> Outcome {
        steps::run(&mut self.call(program, arguments))
    }

    /// Runs a program that must print this somewhere.
    fn prints(&self, program: impl AsRef<std::ffi::OsStr>, arguments: &[&str], expected: &str) -> Outcome {
        let text = output(&mut self.call(program, arguments))?;
        match text.lines().find(|line| line.contains(expected)) {
            Some(line) => Ok(vec![line.trim().to_owned()]),
            None => Err(format!("{arguments:?} prints no {expected:?}:\n{text}")),
        }
    }

    /// Path of an artefact.
    fn artefact(&self, name: &str) -> String {
        self.out.join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) -> Result<(), String> {
        files::write(&self.home.join(name), text)
    }

    /// Copies a file of the working copy.
    fn copy(&self, from: &str, to: &str) -> Result<(), String> {
        files::copy(&self.root.join(from), &self.home.join(to))
    }

    /// Makes a virtual environment; returns its interpreter.
    fn environment(&self) -> Result<PathBuf, String> {
        let python = output(Command::new("python3").args(["-c", "import sys; print(sys.executable)"]))?;
        self.run(python.trim(), &["-m", "venv", "environment"])?;
        Ok(self.home.join("environment/bin/python"))
    }
}

/// First block of code of a page of Markdown that is indented by four spaces and contains this.
fn block(page: &str, contains: &str) -> Option<String> {
    let mut blocks = page.split("\n\n").filter(|block| block.lines().all(|line| line.starts_with("    ")));
    let block = blocks.find(|block| block.contains(contains))?;
    Some(block.lines().map(|line| line.get(4..).unwrap_or_default()).collect::<Vec<_>>().join("\n"))
}

/// pip installs the wheel; the first lines of its readme, the command and a notebook run.
fn wheel(user: &User) -> Outcome {
    let python = user.environment()?;
    let folder = user.artefact("python");
    let of_narx = format!("narx[can,plot,pandas]=={VERSION}");
    let pip = ["-m", "pip", "install", "--quiet", "--only-binary", ":all:", "--find-links", &folder];
    user.run(&python, &[&pip[..], &[&of_narx, "nbclient", "ipykernel"]].concat())?;
    let text = ["-c", "import importlib.metadata as m; print(m.metadata('narx').get_payload())"];
    let readme = output(&mut user.call(&python, &text))?;
    user.write("readme.py", &block(&readme, "import narx").ok_or("the readme begins without code")?)?;
    user.run(&python, &["readme.py"])?;
    let mut lines = user.prints(&python, &["-c", "import narx; print('narx', narx.__version__)"], VERSION)?;
    lines.extend(user.prints(user.home.join("environment/bin/narx"), &["--help"], "bench")?);
    let notebook = "01-first-spin.ipynb";
    user.copy(&format!("python/notebooks/{notebook}"), notebook)?;
    user.run(user.home.join("environment/bin/jupyter"), &["execute", notebook])?;
    lines.push(format!("{notebook} run"));
    Ok(lines)
}

/// pip compiles the sources: this user has Rust.
fn source(user: &User) -> Outcome {
    let python = user.environment()?;
    let file = user.artefact(&format!("python/narx-{VERSION}.tar.gz"));
    let mut pip = user.call(&python, &["-m", "pip", "install", "--quiet", &file]);
    steps::run(with_rust(&mut pip))?;
    user.prints(&python, &["-c", "import narx; print(len(narx.Motor.presets()), 'motors')"], "motors")
}

/// npm installs the package; a program runs in Node, its types are checked, and Vite bundles it.
fn npm(user: &User) -> Outcome {
    user.write("package.json", "{ \"name\": \"user\", \"private\": true, \"type\": \"module\" }\n")?;
    let package = user.artefact(&format!("npm/narx-{VERSION}.tgz"));
    let install = ["install", "--no-audit", "--no-fund", "--loglevel=error"];
    user.run("npm", &[&install[..], &[&package, "vite@8.3.8", "typescript@6.0.3"]].concat())?;
    user.write(
        "main.ts",
        "import init, { Bench, Motor } from \"narx\";\n\
         import loadCore, { parameters } from \"narx/core\";\n\
         import { Drive } from \"narx/drive\";\n\n\
         await init();\n\
         await loadCore();\n\
         const bench = new Bench(Motor.preset(\"bly172s-24v\"), { supplyVoltage: 24 });\n\
         bench.start(2000);\n\
         const speed = bench.run(2).column(\"speed\");\n\
         console.log(`${Math.abs((speed.at(-1) ?? 0) - 2000) < 20}, ${parameters().length > 100}, ${typeof Drive}`);\n",
    )?;
    user.write("index.html", "<script type=\"module\" src=\"/main.ts\"></script>\n")?;
    let options = ["--target", "ES2023", "--module", "ES2022", "--moduleResolution", "bundler", "--strict"];
    let tsc = [&["main.ts", "--lib", "ES2023,DOM"][..], &options].concat();
    let bin = user.home.join("node_modules/.bin");
    user.run(bin.join("tsc"), &tsc)?;
    let mut lines = user.prints("node", &["main.js"], "true, true, function")?;
    user.run(bin.join("vite"), &["build", "--logLevel", "error", "--target", "es2022"])?;
    let assets = user.home.join("dist/assets");
    let entries = fs::read_dir(&assets).map_err(|error| format!("{}: {error}", assets.display()))?;
    let names: Vec<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    if !names.iter().any(|name| name.starts_with("narx_bg") && name.ends_with(".wasm")) {
        return Err(format!("Vite has bundled no WebAssembly: {names:?}"));
    }
    lines.push(format!("{} files bundled", names.len()));
    Ok(lines)
}

/// A program takes the archive by CMake, FetchContent, and Make with pkg-config, here and for every
/// processor.
fn archive(user: &User) -> Outcome {
    let file = user.artefact(&format!("c/narx-c-{VERSION}.tar.gz"));
    user.run("tar", &["xzf", &file])?;
    let folder = user.home.join(format!("narx-{VERSION}"));
    user.copy("tests/c/consumer/main.c", "main.c")?;
    let project = |narx: &str| {
        format!(
            "cmake_minimum_required(VERSION 3.20)\nproject(user C)\n{narx}\nadd_executable(user main.c)\n\
             target_link_libraries(user PRIVATE narx::narx)\n"
        )
    };
    let fetched = format!(
        "include(FetchContent)\nFetchContent_Declare(narx URL \"file://{file}\")\nFetchContent_MakeAvailable(narx)"
    );
    let mut lines = Vec::new();
    for (name, narx) in [("found", &format!("find_package(narx {VERSION} REQUIRED)")), ("fetched", &fetched)]
    {
        user.write(&format!("{name}/CMakeLists.txt"), &project(narx))?;
        user.copy("tests/c/consumer/main.c", &format!("{name}/main.c"))?;
        let prefix = format!("-DCMAKE_PREFIX_PATH={}", folder.display());
        output(&mut user.call("cmake", &["-S", name, "-B", &format!("{name}/build"), &prefix]))?;
        output(&mut user.call("cmake", &["--build", &format!("{name}/build")]))?;
        output(&mut user.call(user.home.join(name).join("build/user"), &[]))?;
        lines.push(format!("CMake, {name}: runs"));
    }
    user.write(
        "Makefile",
        "CFLAGS += $(shell pkg-config --cflags narx) -Wl,--gc-sections\nLDLIBS += $(shell pkg-config --libs narx)\n\nmain: main.c\n",
    )?;
    let processors = Processor::ALL.map(Some);
    for processor in std::iter::once(None).chain(processors) {
        let target = processor.map_or("x86_64-unknown-linux-gnu", Processor::target);
        let mut make = user.call("make", &["--silent", "--always-make"]);
        make.env("PKG_CONFIG_PATH", folder.join("lib").join(target).join("pkgconfig"));
        if let Some(processor) = processor {
            make.arg(format!("CC={}", processor.tool("gcc")));
            make.env("CFLAGS", format!("{} {}", processor.options().join(" "), processor.library()));
        }
        output(&mut make)?;
        lines.push(format!("make, {target}: links"));
    }
    Ok(lines)
}

/// PlatformIO installs the archive, and links a project for two boards and for this machine. Platform and
/// SCons are not those of PlatformIO's registry: compilers there are large.
fn platformio(user: &User) -> Outcome {
    let python = user.environment()?;
    user.run(&python, &["-m", "pip", "install", "--quiet", "platformio==6.2.0", "scons==4.11.1"])?;
    user.copy("tests/c/platformio/platformio.ini", "platformio.ini")?;
    user.copy("tests/c/platformio/platform", "platform")?;
    user.copy("tests/c/platformio/tool", ".platformio/packages/tool-scons")?;
    user.copy("examples/platformio/src", "src")?;
    let mut run = user.call(user.home.join("environment/bin/pio"), &["run"]);
    let said = output(run.env("ARCHIVE", user.artefact(&format!("c/narx-c-{VERSION}.tar.gz"))))?;
    let summary = said.lines().filter(|line| line.contains("SUCCESS   "));
    let mut lines: Vec<String> = summary.map(|line| line.trim().to_owned()).collect();
    lines.extend(user.prints(user.home.join(".pio/build/here/firmware"), &[], VERSION)?);
    Ok(lines)
}

/// The module of Zephyr links a program for a Cortex-M4F, with Zephyr's functions of CMake as far as it calls
/// them; Kconfig reads its options.
fn zephyr(user: &User) -> Outcome {
    user.run("tar", &["xzf", &user.artefact(&format!("c/narx-c-{VERSION}.tar.gz"))])?;
    let python = user.environment()?;
    user.run(&python, &["-m", "pip", "install", "--quiet", "kconfiglib==14.1.0"])?;
    let module = format!("narx-{VERSION}/zephyr");
    let options = format!("import kconfiglib; print(*kconfiglib.Kconfig('{module}/Kconfig').syms)");
    let mut lines = user.prints(&python, &["-c", &options], "NARX_SMALL")?;
    user.copy("examples/zephyr", "example")?;
    user.copy("tests/c/zephyr", ".")?;
    let processor = Processor::CortexM4F;
    let flags = format!("-DCMAKE_C_FLAGS={} {}", processor.options().join(" "), processor.library());
    let compiler = format!("-DCMAKE_C_COMPILER={}", processor.tool("gcc"));
    output(&mut user.call(
        "cmake",
        &["-B", "build", &format!("-DMODULE={module}"), "-DEXAMPLE=example", &flags, &compiler],
    ))?;
    output(&mut user.call("cmake", &["--build", "build"]))?;
    lines.push(format!("links for {}", processor.target()));
    Ok(lines)
}

/// A new crate that depends on the packaged narx-core alone compiles for a Cortex-M4F: this user has Rust.
fn library(user: &User) -> Outcome {
    let name = format!("narx-core-{VERSION}");
    user.run("tar", &["xzf", &user.artefact(&format!("crates/{name}.crate"))])?;
    user.write(
        "Cargo.toml",
        &format!(
            "[package]\nname = \"user\"\nedition = \"2024\"\n\n[dependencies]\nnarx-core = {{ path = \"{name}\" }}\n\n[workspace]\nexclude = [\"{name}\"]\n"
        ),
    )?;
    user.write(
        "src/lib.rs",
        "#![no_std]\nuse narx_core::motor::{Drive, PwmCommand, Samples};\n\n\
         pub fn interrupt(drive: &mut Drive, samples: &Samples) -> PwmCommand {\n    drive.step(samples)\n}\n",
    )?;
    let mut cargo = user.call("cargo", &["build", "--quiet", "--release", "--target", EMBEDDED]);
    steps::run(with_rust(&mut cargo))?;
    Ok(vec![format!("{name} compiles for {EMBEDDED}")])
}

/// The program for a terminal runs; that for the other processor is one for Linux of the same age.
fn command_line(user: &User) -> Outcome {
    for processor in ["x86_64", "aarch64"] {
        let name = format!("narx-terminal-{VERSION}-linux-{processor}");
        user.run("tar", &["xzf", &user.artefact(&format!("command-line/{name}.tar.gz"))])?;
        let program = user.home.join(name).join("narx-terminal");
        let symbols =
            output(&mut user.call("readelf", &["--wide", "--version-info", &program.display().to_string()]))?;
        let versions = symbols.split("GLIBC_2.").skip(1).filter_map(|rest| {
            rest.split(|letter: char| !letter.is_ascii_digit()).next()?.parse::<u32>().ok()
        });
        match versions.max() {
            Some(..=17) => {}
            newest => return Err(format!("{}: for a C library 2.{newest:?}, not 2.17", program.display())),
        }
    }
    let program = user.home.join(format!("narx-terminal-{VERSION}-linux-x86_64/narx-terminal"));
    user.prints(program, &["demo"], "identical")
}

/// Lets a program find Rust.
fn with_rust(command: &mut Command) -> &mut Command {
    for name in ["PATH", "HOME", "CARGO_HOME", "RUSTUP_HOME"] {
        if let Some(value) = env::var_os(name) {
            command.env(name, value);
        }
    }
    command
}
