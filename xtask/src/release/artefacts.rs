//! The artefacts, each made by the command that makes it for developers, too.

use super::{Maker, VERSION};
use crate::cross::Processor;
use crate::files::{self, copy};
use crate::{board, image::Image, install};
use narx_report::steps::{self, Outcome, output};
use serde_json::Value;
use std::fs;

/// Linux on both processors, with the oldest C library that Rust supports.
const LINUX: [&str; 2] = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu"];
const GLIBC: &str = "2.17";

impl Maker<'_> {
    /// Every package of the workspace that may be published, as cargo would send it, compiled from there.
    pub(super) fn crates(&self) -> Outcome {
        let metadata = self.metadata()?;
        let packages = metadata["packages"].as_array().into_iter().flatten();
        let names = packages.filter(|package| package["publish"].is_null() && package["source"].is_null());
        let names: Vec<&str> = names.filter_map(|package| package["name"].as_str()).collect();
        let mut cargo = self.call("cargo", &["package", "--quiet", "--locked"]);
        cargo.args(names.iter().flat_map(|name| ["-p", name]));
        steps::run(&mut cargo)?;
        let folder = self.folder("crates")?;
        names.iter().try_for_each(|name| {
            let file = format!("{name}-{VERSION}.crate");
            copy(&self.built().join("package").join(&file), &folder.join(&file))
        })?;
        Ok(vec![names.join(", ")])
    }

    /// Returns what cargo knows of the workspace and its dependencies.
    pub(super) fn metadata(&self) -> Result<Value, String> {
        let text = output(&mut self.call("cargo", &["metadata", "--locked", "--format-version", "1"]))?;
        serde_json::from_str(&text).map_err(|error| format!("cargo metadata: {error}"))
    }

    /// The C library for every target.
    pub(super) fn archive(&self) -> Outcome {
        self.xtask(&["archive"])?;
        let name = format!("narx-{VERSION}.tar.gz");
        copy(&self.built().join(&name), &self.folder("c")?.join(format!("narx-c-{VERSION}.tar.gz")))?;
        Ok(Vec::new())
    }

    /// The package of npm, and the page as a folder for any web server.
    pub(super) fn javascript(&self) -> Outcome {
        self.xtask(&["web"])?;
        let folder = self.folder("npm")?;
        let mut npm = self.call("npm", &["pack", "--silent", "--pack-destination"]);
        steps::run(npm.arg(&folder).current_dir(self.root.join("wasm/pkg")))?;
        let page = self.built().join(format!("narx-page-{VERSION}"));
        // Files of an earlier version must not stay.
        let _ = fs::remove_dir_all(&page);
        copy(&self.root.join("wasm/web/dist"), &page)?;
        files::pack(&page, &self.folder("page")?.join(format!("narx-page-{VERSION}.tar.gz")))
    }

    /// Images of the emulated board and of the B-G431B-ESC1, without debug information. Bootloaders believe
    /// the published test key.
    pub(super) fn firmware(&self) -> Outcome {
        self.xtask(&["firmware", "--board", "qemu"])?;
        self.xtask(&["firmware", "--board", "b-g431b-esc1"])?;
        let folder = self.folder("firmware")?;
        let built = self.built();
        let emulated = built.join(crate::image::EMBEDDED).join("release");
        let board = built.join(crate::image::EMBEDDED).join(board::PROFILE);
        for (from, to) in [
            (emulated.join(Image::Drive.name()), "qemu-drive.elf"),
            (emulated.join(Image::Bootloader.name()), "qemu-bootloader-test-key.elf"),
            (emulated.join(Image::Application.name()), "qemu-application.elf"),
            (board.join("drive"), "b-g431b-esc1-drive.elf"),
            (board.join("boot"), "b-g431b-esc1-bootloader-test-key.elf"),
        ] {
            copy(&from, &folder.join(to))?;
            let mut strip = self.call(Processor::CortexM4F.tool("strip"), &["--strip-debug"]);
            steps::run(strip.arg(folder.join(to)))?;
        }
        Ok(Vec::new())
    }

    /// The programs for a terminal, for Linux.
    pub(super) fn command_line(&self) -> Outcome {
        for target in LINUX {
            self.build_for_linux("narx-terminal", target)?;
            let processor = target.split('-').next().unwrap_or(target);
            let content = self.built().join(format!("narx-terminal-{VERSION}-linux-{processor}"));
            copy(&self.built().join(target).join("release/narx-terminal"), &content.join("narx-terminal"))?;
            for text in ["LICENSE-MIT", "LICENSE-APACHE"] {
                copy(&self.root.join(text), &content.join(text))?;
            }
            let name = format!("{}.tar.gz", content.file_name().unwrap_or_default().to_string_lossy());
            files::pack(&content, &self.folder("command-line")?.join(name))?;
        }
        Ok(Vec::new())
    }

    /// Wheels for Linux, and the sources.
    pub(super) fn python(&self) -> Outcome {
        let folder = self.folder("python")?.display().to_string();
        let package = self.root.join("python");
        let binaries = package.join("narx/binaries");
        let _ = fs::remove_dir_all(&binaries);
        let maturin = |arguments: &[&str]| {
            let mut maturin = self.call("maturin", arguments);
            steps::run(maturin.args(["--out", &folder]).current_dir(&package))
        };
        for target in LINUX {
            install::rust_target(target)?;
            // The library of the FMUs is for x86-64 alone.
            if target.starts_with("x86_64") {
                self.build_for_linux("narx-fmu", target)?;
                let library = "libnarx_fmu.so";
                copy(&self.built().join(target).join("release").join(library), &binaries.join(library))?;
            }
            let compatible = format!("manylinux_{}", GLIBC.replace('.', "_"));
            let wheel = ["build", "--locked", "--release", "--strip", "--zig", "--target", target];
            maturin(&[&wheel[..], &["--compatibility", &compatible]].concat())?;
            let _ = fs::remove_dir_all(&binaries);
        }
        maturin(&["sdist"])
    }

    /// Builds a package for the oldest C library of Linux, without symbols.
    fn build_for_linux(&self, package: &str, target: &str) -> Outcome {
        install::rust_target(target)?;
        let mut cargo = self.call("cargo-zigbuild", &["zigbuild", "--locked", "--release", "-p", package]);
        cargo.args(["--target", &format!("{target}.{GLIBC}")]);
        steps::run(cargo.env("CARGO_PROFILE_RELEASE_STRIP", "symbols"))
    }
}
