//! Puts keys into the library: the published one, and the one that was chosen.

use std::path::{Path, PathBuf};
use std::{env, fs};

const VARIABLE: &str = "NARX_UPDATE_KEY";

fn main() {
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    println!("cargo::rerun-if-changed=build.rs");
    let published = |name| read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("keys").join(name));
    let (public, secret) = (published("TEST-ONLY.pub"), published("TEST-ONLY.key"));
    let chosen = match env::var_os(VARIABLE) {
        Some(file) => Some(read(&PathBuf::from(file))),
        None => env::var_os("CARGO_FEATURE_TEST_KEY").map(|_| public),
    };
    let chosen = chosen.map_or("None".into(), |key| format!("Some(Key({key:?}))"));
    write(
        "key.rs",
        &format!("const CHOSEN: Option<Key> = {chosen};\nconst PUBLISHED: [u8; 32] = {public:?};\n"),
    );
    write("secret.rs", &format!("const PUBLISHED: [u8; 32] = {secret:?};\n"));
}

/// A line of 64 hexadecimal digits.
fn read(file: &Path) -> [u8; 32] {
    println!("cargo::rerun-if-changed={}", file.display());
    let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let digits = text.trim();
    let is_key = digits.len() == 64 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    assert!(is_key, "{}: not 64 hexadecimal digits", file.display());
    std::array::from_fn(|at| u8::from_str_radix(&digits[2 * at..2 * at + 2], 16).expect("just seen"))
}

fn write(name: &str, text: &str) {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join(name);
    fs::write(out, text).expect("cargo has made the folder");
}
