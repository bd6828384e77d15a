//! Builds and starts C programs.

use crate::cross::{self, Processor, STRICT};
use crate::library::{BENCH, Library, NARX, SMALL};
use crate::qemu::{self, Machine};
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A compiler and its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Build {
    /// gcc, for this machine.
    Gcc,
    /// clang, for this machine.
    Clang,
    /// gcc, with sanitizers: the first invalid access or undefined behaviour stops the program.
    Sanitized,
    /// gcc for an emulated microcontroller, with the host's files by semihosting.
    For(Processor),
    /// gcc for an emulated Cortex-M4F, with the small library.
    Small,
}

use Build::{Clang, For, Gcc, Sanitized, Small};

impl Build {
    /// The builds that run every program.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        [Gcc, Clang, Sanitized].into_iter().chain(Processor::ALL.map(For))
    }

    /// Path of the program of a source file.
    pub(super) fn program(self, root: &Path, source: &str) -> PathBuf {
        let kind = match self {
            Gcc => "gcc",
            Clang => "clang",
            Sanitized => "sanitized",
            For(processor) => processor.target(),
            Small => "small",
        };
        let stem = Path::new(source).file_stem().unwrap_or_default().to_string_lossy();
        directory(root).join(format!("{stem}-{kind}"))
    }

    /// Returns a call of the program.
    pub(super) fn start(self, root: &Path, source: &str, arguments: &[String]) -> Command {
        let program = self.program(root, source);
        if let Some(processor) = self.processor() {
            return qemu::semihosting_on(processor.machine(), &program, arguments);
        }
        let mut command = Command::new(program);
        command.args(arguments);
        command
    }

    /// Runs the program; fails if it fails.
    pub(super) fn run(self, root: &Path, source: &str) -> Outcome {
        steps::run(&mut self.start(root, source, &[]))
    }

    /// Compiles and links the program of a source file of the working copy.
    pub(super) fn compile(self, root: &Path, source: &str) -> Outcome {
        let library = if self == Small { SMALL } else { NARX };
        let mut compiler = self.compiler(root);
        compiler.arg(root.join(source)).args(self.libraries(root, library));
        compiler.arg("-o").arg(self.program(root, source));
        steps::run(&mut compiler)
    }

    /// Compiles a program against the shared library, and runs it.
    pub(super) fn run_shared(root: &Path, source: &str) -> Outcome {
        let program = directory(root).join("shared");
        let mut compiler = Gcc.compiler(root);
        compiler.arg(root.join(source)).arg(NARX.shared(root)).arg("-o").arg(&program);
        steps::run(&mut compiler)?;
        steps::run(&mut Command::new(program))
    }

    /// Compiles a program on the simulated board, from these source files.
    pub(super) fn compile_on_bench(self, root: &Path, sources: &[&str]) -> Outcome {
        let mut compiler = self.compiler(root);
        compiler.arg("-I").arg(root.join("ffi/examples")).arg("-I").arg(root.join("tests/c"));
        compiler.args(sources.iter().map(|source| root.join(source)));
        compiler.args(self.libraries(root, BENCH)).arg("-lm").arg("-o").arg(self.program(root, sources[0]));
        steps::run(&mut compiler)
    }

    /// Compiles a program for the Cortex-M0, for the memory of a machine that has one.
    pub(super) fn compile_for_microbit(root: &Path, source: &str, program: &Path) -> Outcome {
        let mut compiler = cross::compiler_for(root, Processor::CortexM0, Machine::Microbit);
        compiler
            .args(["-std=c99", "-Os", "-DLINE_SIZE=128"])
            .args(STRICT)
            .arg("-I")
            .arg(root.join("ffi/include"));
        compiler.arg(root.join(source)).arg(NARX.path(root, Some(Processor::CortexM0)));
        steps::run(compiler.arg("-o").arg(program))
    }

    /// Returns the compiler with its options.
    fn compiler(self, root: &Path) -> Command {
        let mut command = match self.processor() {
            Some(processor) => cross::compiler_for(root, processor, processor.machine()),
            None => Command::new(if self == Clang { "clang" } else { "gcc" }),
        };
        command.args(["-std=c99", "-O2", "-g"]).args(STRICT).arg("-I").arg(root.join("ffi/include"));
        if self == Sanitized {
            command.args(["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]);
        }
        command
    }

    /// Static library of ours and the libraries that it needs, after the program's sources.
    fn libraries(self, root: &Path, library: Library) -> Vec<PathBuf> {
        let file = library.path(root, self.processor());
        let system: &[&str] = if self.processor().is_some() { &[] } else { &["-lpthread", "-ldl", "-lm"] };
        std::iter::once(file).chain(system.iter().map(PathBuf::from)).collect()
    }

    const fn processor(self) -> Option<Processor> {
        match self {
            Gcc | Clang | Sanitized => None,
            For(processor) => Some(processor),
            Small => Some(Processor::CortexM4F),
        }
    }
}

/// Folder of the C programs.
pub(super) fn directory(root: &Path) -> PathBuf {
    target_directory(root).join("c")
}

/// Creates the folder if it does not exist; returns it.
pub(super) fn made_directory(root: &Path) -> Result<PathBuf, String> {
    let directory = directory(root);
    fs::create_dir_all(&directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    Ok(directory)
}
