//! Puts the public key that was chosen into the library.

use std::path::{Path, PathBuf};
use std::{env, fs};

const VARIABLE: &str = "NARX_UPDATE_KEY";
const TEST_KEY: &str = "../keys/TEST-ONLY.pub";

fn main() {
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    println!("cargo::rerun-if-changed=build.rs");
    let test_key =
        env::var_os("CARGO_FEATURE_TEST_KEY").map(|_| Path::new(env!("CARGO_MANIFEST_DIR")).join(TEST_KEY));
    let file = env::var_os(VARIABLE).map(PathBuf::from).or(test_key);
    let key = file.map(|file| {
        println!("cargo::rerun-if-changed={}", file.display());
        read(&file).unwrap_or_else(|problem| panic!("{}: {problem}", file.display()))
    });
    let text = format!(
        "const CHOSEN: Option<Key> = {};\n",
        key.map_or("None".into(), |key| format!("Some(Key({key:?}))"))
    );
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join("key.rs");
    fs::write(out, text).expect("cargo has made the folder");
}

/// A line of 64 hexadecimal digits.
fn read(file: &Path) -> Result<[u8; 32], String> {
    let text = fs::read_to_string(file).map_err(|error| error.to_string())?;
    let digits = text.trim();
    let mut key = [0; 32];
    if digits.len() != 64 || !digits.is_ascii() {
        return Err("not 64 hexadecimal digits".into());
    }
    for (place, at) in key.iter_mut().zip((0..).step_by(2)) {
        *place = u8::from_str_radix(&digits[at..at + 2], 16).map_err(|_| "not 64 hexadecimal digits")?;
    }
    Ok(key)
}
