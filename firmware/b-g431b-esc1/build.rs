//! Gives the linker the memory and the layout of each image, when images are what is built.

use std::path::Path;
use std::{env, fs};

/// Images, and for each the file of the memory that it may use. The linker looks for `memory.x` in folders,
/// so each image has a folder of its own.
const IMAGES: [(&str, &str); 3] = [("drive", "slot.x"), ("bare", "slot.x"), ("boot", "boot.x")];

fn main() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return Ok(());
    }
    let out = env::var("OUT_DIR").map_err(std::io::Error::other)?;
    for (image, memory) in IMAGES {
        println!("cargo::rerun-if-changed={memory}");
        let folder = Path::new(&out).join(image);
        fs::create_dir_all(&folder)?;
        fs::copy(memory, folder.join("memory.x"))?;
        // The layout of cortex-m-rt, without padding between its sections and the pages of a file that nobody
        // maps.
        println!("cargo::rustc-link-arg-bin={image}=-L{}", folder.display());
        println!("cargo::rustc-link-arg-bin={image}=-Tlink.x");
        println!("cargo::rustc-link-arg-bin={image}=--nmagic");
        // Functions of the same instructions are one: no address of a function is compared.
        println!("cargo::rustc-link-arg-bin={image}=--icf=all");
    }
    Ok(())
}
