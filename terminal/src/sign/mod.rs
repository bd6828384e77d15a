//! Images for the bootloader: a program with a header that its owner has signed (docs/UPDATE.md).

mod program;
#[cfg(test)]
mod tests;

use narx_boot::sign::SecretKey;
use narx_boot::{BODY_ALIGNMENT, Header, Version, hardware};
use narx_report::steps::{self, Outcome};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Program to sign, and its header and key.
#[derive(clap::Args)]
pub struct Arguments {
    /// Program to sign: an ELF file, or the bytes of the flash
    #[arg(required_unless_present = "new_key")]
    image: Option<PathBuf>,
    /// File of the secret key
    #[arg(long, value_name = "FILE", required_unless_present = "new_key")]
    key: Option<PathBuf>,
    /// Board: bench, qemu, b-g431b-esc1, or its hardware id in hexadecimal
    #[arg(long, value_name = "ID", value_parser = hardware_id, required_unless_present = "new_key")]
    hardware: Option<u32>,
    /// Version of the program: MAJOR.MINOR.PATCH or MAJOR.MINOR.PATCH+BUILD
    #[arg(long, value_name = "VERSION", required_unless_present = "new_key")]
    version: Option<Version>,
    /// File for the image, .narximg
    #[arg(long, value_name = "FILE", required_unless_present = "new_key")]
    out: Option<PathBuf>,
    /// Make a new secret key instead, in this file, and its public half beside it (.pub)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["image", "key", "hardware", "version", "out"])]
    new_key: Option<PathBuf>,
}

/// Runs `cargo xtask sign`.
pub fn command(arguments: &Arguments) -> ExitCode {
    steps::finish(run(arguments))
}

/// Signs, or makes a key; returns the closing line.
///
/// # Errors
/// Fails with a file that cannot be read or written, or that has another content.
pub fn run(arguments: &Arguments) -> Outcome {
    match arguments {
        Arguments { new_key: Some(file), .. } => new_key(file),
        Arguments {
            image: Some(image),
            key: Some(key),
            hardware: Some(hardware),
            version: Some(version),
            out: Some(out),
            ..
        } => sign(image, &read_key(key)?, *hardware, *version, out),
        // clap has checked that these arguments are present.
        _ => Err("nothing to sign".into()),
    }
}

/// Signs a program; returns the closing line.
///
/// # Errors
/// Fails if the program cannot be read or is none, or if the image cannot be written.
pub fn sign(program: &Path, key: &SecretKey, hardware: u32, version: Version, out: &Path) -> Outcome {
    let bytes = fs::read(program).map_err(|error| at(program, &error))?;
    let mut body = program::flat(&bytes).map_err(|error| at(program, &error))?;
    if body.is_empty() {
        return Err(at(program, &"no program in it"));
    }
    body.resize(body.len().next_multiple_of(BODY_ALIGNMENT as usize), 0xFF);
    let header = Header { hardware, version, length: body.len() as u32 };
    let image = [key.sign(header, &body).as_slice(), &body].concat();
    fs::write(out, &image).map_err(|error| at(out, &error))?;
    Ok(vec![format!(
        "{}: version {version} for {hardware:08X}h, {} bytes, key {}",
        out.display(),
        image.len(),
        hexadecimal(&key.public().0)
    )])
}

fn new_key(file: &Path) -> Outcome {
    let mut secret = [0; 32];
    getrandom::fill(&mut secret).map_err(|error| format!("no random numbers: {error}"))?;
    let public = hexadecimal(&SecretKey(secret).public().0);
    // Never overwrites a key, which boards may already use.
    let mut options = fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut secret_file = options.open(file).map_err(|error| at(file, &error))?;
    writeln!(secret_file, "{}", hexadecimal(&secret)).map_err(|error| at(file, &error))?;
    let public_file = file.with_extension("pub");
    fs::write(&public_file, format!("{public}\n")).map_err(|error| at(&public_file, &error))?;
    Ok(vec![format!(
        "{}: keep it secret; {}: what boards are built with",
        file.display(),
        public_file.display()
    )])
}

/// Reads a line of 64 hexadecimal digits.
fn read_key(file: &Path) -> Result<SecretKey, String> {
    let text = fs::read_to_string(file).map_err(|error| at(file, &error))?;
    let digits = text.trim();
    if digits.len() != 64 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err(at(file, &"not a secret key: 64 hexadecimal digits"));
    }
    let mut key = [0; 32];
    for (place, pair) in key.iter_mut().zip(digits.as_bytes().chunks(2)) {
        let pair = std::str::from_utf8(pair).map_err(|error| at(file, &error))?;
        *place = u8::from_str_radix(pair, 16).map_err(|error| at(file, &error))?;
    }
    Ok(SecretKey(key))
}

fn hardware_id(text: &str) -> Result<u32, String> {
    if let Some((_, id)) = hardware::BOARDS.into_iter().find(|(name, _)| *name == text) {
        return Ok(id);
    }
    let digits = text.trim_start_matches("0x").trim_end_matches('h');
    u32::from_str_radix(digits, 16).map_err(|_| {
        let names = hardware::BOARDS.map(|(name, _)| name).join(", ");
        format!("neither one of {names} nor eight hexadecimal digits")
    })
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn at(file: &Path, error: &dyn std::fmt::Display) -> String {
    format!("{}: {error}", file.display())
}
