//! Runs every target over its corpus, and over inputs that a seed derives from it: what a fuzzer does,
//! without one. An input that breaks a promise is written to a file whose name is printed.

use narx_fuzz::{TARGETS, Target};
use narx_sim::random::Random;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Longest input, as with the fuzzer.
const LENGTH_MAX: usize = 4096;

fn home() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn names(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    files.sort();
    files
}

/// Inputs of the corpus: real ones, and those that a fuzzer has found useful.
fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let files = names(&home().join("corpus").join(name));
    assert!(!files.is_empty(), "{name} has no corpus");
    files.into_iter().map(|file| (file.clone(), fs::read(file).unwrap())).collect()
}

fn target(name: &str) -> Target {
    *TARGETS.iter().find(|target| target.name == name).unwrap()
}

/// Runs the corpus and `count` changed inputs.
fn inputs(name: &str, count: usize) {
    let target = target(name);
    let corpus = corpus(name);
    for (file, bytes) in &corpus {
        give(&target, bytes, file);
    }
    let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.input"));
    let mut random = Random::new(name.bytes().map(u64::from).sum());
    for _ in 0..count {
        let bytes = mutated(&corpus, &mut random);
        let run = catch_unwind(AssertUnwindSafe(|| (target.run)(&bytes)));
        if let Err(panic) = run {
            fs::write(&made, &bytes).unwrap();
            println!("{name} with the input in {}", made.display());
            resume_unwind(panic);
        }
    }
}

fn give(target: &Target, bytes: &[u8], file: &Path) {
    let run = catch_unwind(AssertUnwindSafe(|| (target.run)(bytes)));
    run.unwrap_or_else(|panic| {
        println!("{} with the input in {}", target.name, file.display());
        resume_unwind(panic)
    });
}

/// An input of the corpus with up to eight changes of the kinds that libFuzzer makes.
fn mutated(corpus: &[(PathBuf, Vec<u8>)], random: &mut Random) -> Vec<u8> {
    let mut below = |bound: usize| random.bits() as usize % bound.max(1);
    let mut bytes = corpus[below(corpus.len())].1.clone();
    for _ in 0..=below(8) {
        let at = below(bytes.len() + 1);
        let (length, what) = (below(16), below(256) as u8);
        let end = (at + length).min(bytes.len());
        match below(6) {
            0 if at < bytes.len() => bytes[at] ^= 1 << (what & 7),
            1 if at < bytes.len() => bytes[at] = what,
            2 => drop(bytes.drain(at..end)),
            3 => bytes.insert(at, what),
            // A piece of itself, or of another input.
            4 => {
                let piece = bytes[at..end].to_vec();
                let to = below(bytes.len() + 1);
                bytes.splice(to..to, piece);
            }
            _ => {
                let other = &corpus[below(corpus.len())].1;
                let from = below(other.len() + 1);
                let piece = &other[from..(from + 4 * length).min(other.len())];
                bytes.splice(at..at, piece.iter().copied());
            }
        }
    }
    bytes.truncate(LENGTH_MAX);
    bytes
}

/// Defines a test for each target, with as many changed inputs as take some tenths of a second.
macro_rules! targets {
    ($($name:ident $count:literal,)*) => {
        $(#[test]
        fn $name() {
            inputs(stringify!($name), $count);
        })*

        #[test]
        fn each_target_has_its_test_and_its_program() {
            let programs = names(&home().join("fuzz_targets"));
            let programs: Vec<&str> = programs.iter().map(|file| file.file_stem().unwrap().to_str().unwrap()).collect();
            assert_eq!(programs, TARGETS.map(|target| target.name));
            assert_eq!(programs, [$(stringify!($name)),*]);
        }
    };
}

targets! {
    boot 1_000,
    bus 4_000,
    candump 2_000,
    description 500,
    drive 60,
    log 20_000,
    master 5_000,
    recording 1_000,
    scope 1_000,
    slcan 10_000,
    storage 50,
    transcript 2_000,
    tx_driver 5_000,
    tx_master 10_000,
    update 500,
}
