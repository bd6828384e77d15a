//! Images for the slots of the emulated board, signed with the key that everybody knows.

use crate::driven::output;
use crate::firmware::Image;
use crate::install;
use crate::steps::Outcome;
use narx_boot::sign::SecretKey;
use narx_boot::{BODY_ALIGNMENT, Header, Version};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// mps2-an386, as its bootloader calls it (`firmware/src/boards/qemu/slots.rs`).
const HARDWARE: u32 = 0x4E58_0001;
const KEY: &str = "firmware/keys/TEST-ONLY.key";

/// Where [`make`] leaves the images.
pub fn directory(root: &Path) -> PathBuf {
    install::target_directory(root).join("slots")
}

/// Makes images of the virtual drive: `old` and `new`, `older` than both, `foreign` with another key.
///
/// # Errors
/// What the tools said.
pub fn make(root: &Path) -> Outcome {
    let directory = directory(root);
    fs::create_dir_all(&directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    let flat = directory.join("application.bin");
    let mut objcopy = Command::new("arm-none-eabi-objcopy");
    output(objcopy.args(["-O", "binary"]).arg(Image::Application.path(root)).arg(&flat))?;
    let mut body = fs::read(&flat).map_err(|error| format!("{}: {error}", flat.display()))?;
    body.resize(body.len().next_multiple_of(BODY_ALIGNMENT as usize), 0xFF);
    let (owner, foreign) = (key(root)?, SecretKey([7; 32]));
    for (name, key, minor) in
        [("older", owner, 0), ("old", owner, 1), ("new", owner, 2), ("foreign", foreign, 2)]
    {
        let version = Version { major: 1, minor, patch: 0, build: u16::from(minor) };
        let mut image = key.sign(Header { hardware: HARDWARE, version, length: 0 }, &body).to_vec();
        image.extend(&body);
        let path = directory.join(name).with_extension("narximg");
        fs::write(&path, image).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(vec![format!("the application in a slot: {} bytes", body.len())])
}

/// A line of 64 hexadecimal digits.
fn key(root: &Path) -> Result<SecretKey, String> {
    let path = root.join(KEY);
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let digit = |at: usize| text.get(at..at + 2).and_then(|pair| u8::from_str_radix(pair, 16).ok());
    let bytes: Option<Vec<u8>> = (0..64).step_by(2).map(digit).collect();
    let key = bytes.and_then(|bytes| bytes.try_into().ok()).map(SecretKey);
    key.ok_or_else(|| format!("{}: not 64 hexadecimal digits", path.display()))
}
