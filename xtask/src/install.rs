//! Installation of tools that the tests need. A tool that cannot be installed is named with the command that
//! does it.

use narx_report::steps;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{env, fs};

/// Installations that change the whole machine go one after the other.
static INSTALLING: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    INSTALLING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A Debian package, and a program by which its presence is checked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Package {
    /// Name of the package.
    pub(crate) name: &'static str,
    /// A program or a file of the package.
    pub(crate) provides: &'static str,
}

impl Package {
    /// Returns whether the package is installed.
    pub(crate) fn is_there(&self) -> bool {
        is_there(self.provides)
    }
}

/// Packages that run JavaScript, and fetch JavaScript packages.
pub(crate) const NODE: [Package; 2] =
    [Package { name: "nodejs", provides: "node" }, Package { name: "npm", provides: "npm" }];

/// Installs the packages that are missing: as root or with sudo on Debian.
///
/// # Errors
/// Fails with the missing packages and the command that installs them, if they cannot be installed here.
pub(crate) fn debian(packages: &[Package]) -> steps::Outcome {
    let _alone = alone();
    let missing: Vec<&str> =
        packages.iter().filter(|package| !package.is_there()).map(|package| package.name).collect();
    if missing.is_empty() {
        return Ok(Vec::new());
    }
    let advice = format!("missing: {}\non Debian: sudo apt-get install -y {0}", missing.join(" "));
    if !Path::new("/etc/debian_version").exists() {
        return Err(advice);
    }
    let apt = |arguments: &[&str]| {
        let mut command = if is_root() { Command::new("apt-get") } else { Command::new("sudo") };
        if !is_root() {
            command.args(["-n", "apt-get"]);
        }
        command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments);
        steps::run(&mut command)
    };
    let install =
        || apt(&[&["install", "-y", "-qq", "--no-install-recommends"], missing.as_slice()].concat());
    // A fresh system has no package lists, and its first installation can fail on a rename; the second
    // does not.
    install()
        .or_else(|_| apt(&["update", "-qq"]).and_then(|_| install()))
        .or_else(|_| install())
        .map_err(|reason| format!("{reason}\n{advice}"))?;
    match packages.iter().find(|package| !package.is_there()) {
        Some(package) => Err(format!("{} is installed but brings no {}", package.name, package.provides)),
        None => Ok(Vec::new()),
    }
}

/// Adds a target to the Rust toolchain.
///
/// # Errors
/// Fails with rustup's message.
pub(crate) fn rust_target(name: &str) -> steps::Outcome {
    let _alone = alone();
    steps::run(Command::new("rustup").args(["target", "add", name]))
}

/// Adds components to the nightly Rust toolchain, or installs it with them.
///
/// # Errors
/// Fails with rustup's message.
pub(crate) fn nightly(components: &[&str]) -> steps::Outcome {
    let _alone = alone();
    let installed = Command::new("rustup").args(["+nightly", "component", "list", "--installed"]).output();
    let installed = installed.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    let is_there = |component: &&str| installed.as_ref().is_ok_and(|list| list.contains(*component));
    if components.iter().all(is_there) {
        return Ok(Vec::new());
    }
    let mut rustup = Command::new("rustup");
    rustup.args(["toolchain", "install", "nightly", "--profile", "minimal", "--no-self-update"]);
    steps::run(rustup.args(components.iter().flat_map(|component| ["--component", component])))
}

/// Installs a cargo command (`cargo-NAME`) from crates.io in this version, unless it is there; takes some
/// minutes.
///
/// # Errors
/// Fails with cargo's message.
pub(crate) fn cargo_program(name: &str, version: &str) -> steps::Outcome {
    // Called through cargo: not every command answers when it is called by its own name.
    let said = Command::new("cargo").args([name.trim_start_matches("cargo-"), "--version"]).output();
    if said.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).trim_end().ends_with(version)) {
        return Ok(Vec::new());
    }
    steps::run(Command::new("cargo").args(["install", name, "--locked", "--version", version]))
}

/// Returns the interpreter of a virtual environment with exactly these requirements; the environment is made
/// anew when they have changed.
///
/// # Errors
/// Fails with the message of Python or pip.
pub(crate) fn python_environment(directory: &Path, requirements: &Path) -> Result<PathBuf, String> {
    let (name, program) =
        if cfg!(windows) { ("python", "Scripts/python.exe") } else { ("python3", "bin/python") };
    let python = directory.join(program);
    let wanted =
        fs::read_to_string(requirements).map_err(|error| format!("{}: {error}", requirements.display()))?;
    let stamp = directory.join("installed.txt");
    if fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) && python.exists() {
        return Ok(python);
    }
    let create = || steps::run(Command::new(name).args(["-m", "venv", "--clear"]).arg(directory));
    // Debian ships Python without the module that makes environments.
    create().or_else(|reason| {
        let venv = Package { name: "python3-venv", provides: "a module that only trying shows" };
        match debian(&[venv]) {
            Err(advice) if !advice.contains("is installed but") => Err(format!("{reason}\n{advice}")),
            _ => create(),
        }
    })?;
    steps::run(Command::new(&python).args(["-m", "pip", "install", "--quiet", "-r"]).arg(requirements))?;
    fs::write(&stamp, wanted).map_err(|error| format!("{}: {error}", stamp.display()))?;
    Ok(python)
}

/// Installs the npm packages that `directory/package-lock.json` names, unless they are there.
///
/// # Errors
/// Fails with npm's message, or with the command that installs npm.
pub(crate) fn npm(directory: &Path) -> steps::Outcome {
    let lock = directory.join("package-lock.json");
    let wanted = fs::read_to_string(&lock).map_err(|error| format!("{}: {error}", lock.display()))?;
    let stamp = directory.join("node_modules/installed.json");
    if fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(Vec::new());
    }
    debian(&NODE)?;
    steps::run(
        Command::new("npm")
            .args(["ci", "--no-audit", "--no-fund", "--loglevel=error"])
            .current_dir(directory),
    )?;
    fs::write(&stamp, wanted).map_err(|error| format!("{}: {error}", stamp.display()))?;
    Ok(Vec::new())
}

/// Returns whether a program is on the path, or a file exists.
fn is_there(provides: &str) -> bool {
    if provides.starts_with('/') {
        return Path::new(provides).exists();
    }
    let paths = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&paths).any(|directory| directory.join(provides).is_file())
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").stderr(Stdio::null()).output();
    id.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}
