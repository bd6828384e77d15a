//! Fuzz targets: a function for each part of narx that reads frames, files or the content of a flash, to be
//! given any bytes. A function returns nothing and panics where a promise is broken; the least of the
//! promises is that the part does not panic.
//!
//! `cargo xtask fuzz` lets libFuzzer search for such bytes; `tests/` runs the same functions over the corpus
//! and over random inputs.

mod board;
pub mod boot;
pub mod bus;
pub mod candump;
pub mod description;
pub mod drive;
pub mod log;
pub mod master;
pub mod program;
mod real;
pub mod recording;
pub mod scope;
pub mod slcan;
mod sound;
pub mod storage;
pub mod transcript;
pub mod tx_driver;
pub mod tx_master;
pub mod update;

/// A part that reads bytes.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the target, of its folder in `corpus`, and of its program in `fuzz_targets`.
    pub name: &'static str,
    /// Function that runs an input.
    pub run: fn(&[u8]),
}

/// All targets.
pub const TARGETS: [Target; 15] = [
    Target { name: "boot", run: boot::run },
    Target { name: "bus", run: bus::run },
    Target { name: "candump", run: candump::run },
    Target { name: "description", run: description::run },
    Target { name: "drive", run: drive::run },
    Target { name: "log", run: log::run },
    Target { name: "master", run: master::run },
    Target { name: "recording", run: recording::run },
    Target { name: "scope", run: scope::run },
    Target { name: "slcan", run: slcan::run },
    Target { name: "storage", run: storage::run },
    Target { name: "transcript", run: transcript::run },
    Target { name: "tx_driver", run: tx_driver::run },
    Target { name: "tx_master", run: tx_master::run },
    Target { name: "update", run: update::run },
];
