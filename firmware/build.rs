//! Gives the linker the memory of the board and the layout of an image, when an image is what is built.

use std::path::Path;
use std::{env, fs};

/// The images, and the memory that each stands in.
const IMAGES: [(&str, &str); 8] = [
    ("qemu", "memory.x"),
    ("replay", "large.x"),
    ("count", "memory.x"),
    ("plant", "memory.x"),
    ("stack", "memory.x"),
    ("standby", "memory.x"),
    ("bootloader", "memory.x"),
    ("application", "slot.x"),
];

fn main() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=src/boards/qemu");
    println!("cargo::rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return Ok(());
    }
    let out = env::var("OUT_DIR").map_err(std::io::Error::other)?;
    for (image, memory) in IMAGES {
        // Whose layout includes memory.x by this name, wherever the linker is told to look.
        let folder = Path::new(&out).join(memory.trim_end_matches(".x"));
        fs::create_dir_all(&folder)?;
        fs::copy(Path::new("src/boards/qemu").join(memory), folder.join("memory.x"))?;
        // No interrupt has a name of its own.
        fs::write(folder.join("device.x"), "")?;
        // The layout of cortex-m-rt, without padding between its sections and the pages of a file that nobody
        // maps.
        for argument in [&format!("-L{}", folder.display()), "-Tlink.x", "--nmagic"] {
            println!("cargo::rustc-link-arg-bin={image}={argument}");
        }
    }
    Ok(())
}
