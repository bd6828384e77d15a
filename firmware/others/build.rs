//! Gives the linker the memory of the emulated board and the layout of an image, when an image is what is
//! built.

use std::path::Path;
use std::{env, fs};

fn main() -> std::io::Result<()> {
    let memory = "../src/boards/qemu/memory.x";
    println!("cargo::rerun-if-changed={memory}");
    println!("cargo::rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return Ok(());
    }
    let out = env::var("OUT_DIR").map_err(std::io::Error::other)?;
    fs::copy(memory, Path::new(&out).join("memory.x"))?;
    // No interrupt has a name of its own.
    fs::write(Path::new(&out).join("device.x"), "")?;
    for argument in [&format!("-L{out}"), "-Tlink.x", "--nmagic"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    Ok(())
}
