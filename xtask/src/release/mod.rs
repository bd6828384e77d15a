//! A release: every artefact in one folder, with checksums, a bill of materials and the changelog's part.
//!
//! A commit gives the same bytes in any folder: the compiler replaces the names of folders, times are
//! that of the commit, and what is built comes from a target directory of its own.

mod artefacts;
mod materials;
mod used;

use crate::{files, install, web};
use narx_report::steps::{self, Outcome, Step, output};
use narx_report::target_directory;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Address that says that the owner has not filled in where the project lives.
const UNFILLED: &str = ".example";

/// Arguments of `release`.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct Arguments {
    /// Folder for the artefacts, a new one; without it target/release-VERSION
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Make the release a second time, from a clone in another folder, and compare every byte
    #[arg(long)]
    check: bool,
    /// Use each artefact of the folder as its user gets it, without Rust and without the working copy
    #[arg(long, conflicts_with = "check")]
    test: bool,
    /// Build the Python wheel of this machine alone, on Windows and macOS, for which Linux cannot build one
    #[arg(long, conflicts_with_all = ["check", "test"])]
    wheel: bool,
}

/// Runs `cargo xtask release`.
pub(crate) fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| target_directory(root).join(format!("release-{VERSION}")));
    let out = std::path::absolute(&out).unwrap_or(out);
    if arguments.test {
        return steps::run_all(used::steps(root, &out));
    }
    if arguments.check {
        return steps::finish(check(root, &out));
    }
    if arguments.wheel {
        return steps::finish(wheel(root, &out));
    }
    // The default folder has nothing but releases; another one may have anything.
    if arguments.out.is_some() && out.exists() {
        return steps::finish(Err(format!(
            "{}: is there already; a release takes a new folder",
            out.display()
        )));
    }
    let maker = match Maker::new(root, out) {
        Ok(maker) => maker,
        Err(reason) => return steps::finish(Err(reason)),
    };
    steps::run_all(maker.steps())
}

/// Builds the wheel of this machine.
fn wheel(root: &Path, out: &Path) -> Outcome {
    let mut maturin = Command::new(tools(root)?);
    maturin.args(["-m", "maturin", "build", "--locked", "--release", "--strip", "--out"]);
    steps::run(maturin.arg(out.join("python")).current_dir(root.join("python")))
}

/// Returns the interpreter of the environment with the tools that build for Python.
fn tools(root: &Path) -> Result<PathBuf, String> {
    install::python_environment(
        &target_directory(root).join("release-tools"),
        &root.join("xtask/src/release/requirements.txt"),
    )
}

/// Maker of the artefacts: its folders, and the environment of its programs.
struct Maker<'a> {
    root: &'a Path,
    out: PathBuf,
    /// Variables of every program that builds.
    environment: Vec<(&'static str, String)>,
}

impl<'a> Maker<'a> {
    /// Prepares a release of the commit that is checked out.
    ///
    /// # Errors
    /// Fails if the working copy differs from its commit.
    fn new(root: &'a Path, out: PathBuf) -> Result<Self, String> {
        let git = |arguments: &[&str]| output(Command::new("git").args(arguments).current_dir(root));
        let changed = git(&["status", "--porcelain", "--untracked-files=no"])?;
        if !changed.is_empty() {
            return Err(format!("a release is made of a commit, and these files differ from it:\n{changed}"));
        }
        let tools = tools(root)?;
        let built = target_directory(root).join("releasing");
        let paths = env::var_os("PATH").unwrap_or_default();
        let tools = tools.parent().map(Path::to_path_buf).unwrap_or_default();
        let path = env::join_paths([tools].into_iter().chain(env::split_paths(&paths)))
            .map_err(|error| format!("PATH: {error}"))?;
        let environment = vec![
            ("CARGO_ENCODED_RUSTFLAGS", web::folders_replaced(root, &built).join("\x1f")),
            ("CARGO_INCREMENTAL", "0".into()),
            ("CARGO_TARGET_DIR", built.display().to_string()),
            ("PATH", path.to_string_lossy().into_owned()),
            ("SOURCE_DATE_EPOCH", git(&["log", "-1", "--format=%ct"])?.trim().to_owned()),
        ];
        if out.exists() {
            fs::remove_dir_all(&out).map_err(|error| format!("{}: {error}", out.display()))?;
        }
        Ok(Self { root, out, environment })
    }

    fn steps(&self) -> Vec<Step<'_>> {
        vec![
            Step::new("crates", || self.crates()),
            Step::new("C archive", || self.archive()),
            Step::new("JavaScript", || self.javascript()),
            Step::new("firmware", || self.firmware()),
            Step::new("command line", || self.command_line()),
            Step::new("Python", || self.python()),
            Step::new("texts", || self.texts()),
        ]
    }

    /// Returns a call of a program in the environment of the release.
    fn call(&self, program: impl AsRef<std::ffi::OsStr>, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command.args(arguments).envs(self.environment.clone()).current_dir(self.root);
        command
    }

    /// Runs a command of `cargo xtask` in the environment of the release.
    fn xtask(&self, arguments: &[&str]) -> Outcome {
        let this = env::current_exe().map_err(|error| format!("cargo xtask: {error}"))?;
        steps::run(&mut self.call(this, arguments))
    }

    /// Folder of what is built.
    fn built(&self) -> PathBuf {
        target_directory(self.root).join("releasing")
    }

    /// A folder of the release, which is made.
    fn folder(&self, name: &str) -> Result<PathBuf, String> {
        let folder = self.out.join(name);
        fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok(folder)
    }
}

/// Makes the release again in a clone, and compares the checksums of all files.
fn check(root: &Path, out: &Path) -> Outcome {
    let sums = |folder: &Path| {
        files::read(&folder.join(materials::SUMS)).map_err(|reason| format!("{reason}; cargo xtask release"))
    };
    let first = sums(out)?;
    let folder = target_directory(root).join("release-again");
    // Clone and compiled packages stay, for the next time.
    let (clone, built, again) = (folder.join("clone"), folder.join("built"), folder.join("artefacts"));
    if again.exists() {
        fs::remove_dir_all(&again).map_err(|error| format!("{}: {error}", again.display()))?;
    }
    let git = |arguments: &[&str]| steps::run(Command::new("git").arg("-C").arg(&clone).args(arguments));
    steps::run(Command::new("git").args(["init", "--quiet"]).arg(&clone))?;
    git(&["fetch", "--quiet", &root.display().to_string(), "HEAD"])?;
    git(&["checkout", "--quiet", "--force", "--detach", "FETCH_HEAD"])?;
    let mut cargo = Command::new("cargo");
    cargo.args(["xtask", "release", "--out"]).arg(&again).current_dir(&clone);
    steps::run(cargo.env("CARGO_TARGET_DIR", built))?;
    let second = sums(&again)?;
    let differing: Vec<&str> =
        first.lines().filter(|line| !second.lines().any(|other| other == *line)).collect();
    if !differing.is_empty() || first.lines().count() != second.lines().count() {
        return Err(format!("not the same bytes in two folders:\n{}", differing.join("\n")));
    }
    Ok(vec![format!("{} files, the same bytes in two folders", first.lines().count())])
}
