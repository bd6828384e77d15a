//! Images of the board B-G431B-ESC1: built, measured against the memory that they have, and searched for
//! places that can panic.

use crate::cross;
use crate::image::EMBEDDED;
use crate::image::{Size, size};
use crate::install;
use narx_report::steps::{self, Outcome, output};
use narx_report::target_directory;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

/// Package of the board's images.
pub(crate) const PACKAGE: &str = "narx-b-g431b-esc1";
/// Profile with which they are built.
pub(crate) const PROFILE: &str = "small";
const GOLDEN: &str = "tests/golden/b-g431b-esc1.toml";
const HEAD: &str = "\
# The images of the board B-G431B-ESC1 (profile `small`), bytes: flash with constants and initial values, and RAM without the stack. `drive` is the application in its slot, with
# all that the board has use for; its flash counts the header of 512 bytes that signing puts before it. `boot` is the bootloader, which receives over CAN.
# `bare` is what the board takes beside the core: start-up, vector table, drivers, both ends of the flash, around a core that answers every tick with Coast. `room` is what there
# is: narx_boot::Map::B_G431B_ESC1, and 24 KiB of RAM, of which the stack needs what is left. `fits` is false as long as an image does not.
#
# panics: places from which a panic can be reached in `drive` or `boot`, by the function that they were written in: bounds that the compiler could not see
# are kept. On this board a panic turns the gates off and resets.
#
# Made anew by `cargo xtask firmware --board b-g431b-esc1 --golden`, compared within 1 % (panics exactly) by `cargo xtask test firmware`.
";
/// Largest difference from the golden figure, as a share of it: compilers of other hosts and other keys give
/// slightly different sizes.
const TOLERANCE: f64 = 0.01;
/// Header of a signed image, bytes (`narx_boot::HEADER_LENGTH`).
const HEADER: u32 = 512;
/// Largest part of the RAM for variables. The stack shares the 32 KiB with them, and would have too little
/// beside more.
const RAM_ROOM: u32 = 24 << 10;

/// An image and the flash that it has.
struct Image {
    name: &'static str,
    before: u32,
    room: u32,
}

const IMAGES: [Image; 3] = [
    Image { name: "drive", before: HEADER, room: 96 << 10 },
    Image { name: "boot", before: 0, room: 22 << 10 },
    // Goal for everything outside the core.
    Image { name: "bare", before: 0, room: 10 << 10 },
];

/// Measured figures of an image.
struct Measured {
    flash: u32,
    ram: u32,
    room: u32,
}

impl Measured {
    const fn fits(&self) -> bool {
        self.flash <= self.room && self.ram <= RAM_ROOM
    }
}

/// Path of a built image.
pub(crate) fn path(root: &Path, image: &str) -> PathBuf {
    target_directory(root).join(EMBEDDED).join(PROFILE).join(image)
}

/// Builds and measures the images. With `golden` it writes the golden file; else it fails if one does not
/// fit.
pub(crate) fn command(root: &Path, golden: bool) -> ExitCode {
    let done = build(root).and_then(|_| measure(root)).and_then(|measured| {
        measured.iter().for_each(|(name, figures)| steps::say(line(name, figures)));
        match measured.iter().find(|(_, figures)| !figures.fits()) {
            _ if golden => regenerate(root, false),
            None => Ok(Vec::new()),
            Some((name, _)) => Err(format!("{name} does not fit the board")),
        }
    });
    steps::finish(done)
}

/// Builds all images. The bootloader accepts images of the key that the environment names, else those of the
/// test key.
///
/// # Errors
/// Fails with the message of rustup or cargo.
pub(crate) fn build(root: &Path) -> Outcome {
    install::rust_target(EMBEDDED)?;
    let key = if env::var_os("NARX_UPDATE_KEY").is_none() {
        steps::say(
            "the bootloader takes images of the test key, which everybody has: NARX_UPDATE_KEY names another",
        );
        "test-key"
    } else {
        ""
    };
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--profile", PROFILE, "-p", PACKAGE, "--bins", "--target", EMBEDDED]);
    steps::run(cargo.args(["--features", key]).current_dir(root))
}

/// Builds the drive's image for a PWM of 20 kHz, in a folder of its own; returns its path.
///
/// # Errors
/// Fails with cargo's message.
pub(crate) fn build_at_20_khz(root: &Path) -> Result<PathBuf, String> {
    let folder = target_directory(root).join("pwm-20-khz");
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--profile", PROFILE, "-p", PACKAGE, "--bin", "drive", "--target", EMBEDDED]);
    cargo.args(["--features", "pwm-20-khz", "--target-dir"]).arg(&folder);
    steps::run(cargo.current_dir(root))?;
    Ok(folder.join(EMBEDDED).join(PROFILE).join("drive"))
}

fn measure(root: &Path) -> Result<Vec<(&'static str, Measured)>, String> {
    let figures = |image: &Image| {
        let path = path(root, image.name);
        let Size { flash, ram } = size(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok((image.name, Measured { flash: flash + image.before, ram, room: image.room }))
    };
    IMAGES.iter().map(figures).collect()
}

fn line(name: &str, figures: &Measured) -> String {
    let Measured { flash, ram, room } = figures;
    let verdict = match flash.checked_sub(*room) {
        None | Some(0) => format!("{} left", room - flash),
        Some(over) => format!("{over} TOO MANY"),
    };
    let stack = (32_u32 << 10).saturating_sub(*ram);
    format!(
        "{name:<11} {flash:>7} bytes of flash of {room}, {verdict}; {ram:>6} of RAM, {stack} for the stack"
    )
}

/// Measures images that are built, and writes the golden file or, with `check`, compares it.
///
/// # Errors
/// Fails if a figure differs from the golden one.
pub(crate) fn regenerate(root: &Path, check: bool) -> Outcome {
    let measured = measure(root)?;
    let panics = panics(root)?;
    let mut text = String::from(HEAD);
    for (name, figures) in &measured {
        let Measured { flash, ram, room } = figures;
        let _ = writeln!(
            text,
            "\n[{name}]\nflash = {flash}\nroom = {room}\nram = {ram}\nfits = {}",
            figures.fits()
        );
    }
    let _ = writeln!(text, "\n[panics]");
    for (place, count) in &panics {
        let _ = writeln!(text, "\"{place}\" = {count}");
    }
    let closing = measured.iter().map(|(name, figures)| line(name, figures));
    let sites: usize = panics.values().sum();
    let closing = closing.chain([format!("{sites} places that can panic")]).collect();
    let file = root.join(GOLDEN);
    let shown = |error| format!("{}: {error}", file.display());
    if !check {
        fs::write(&file, text).map_err(shown)?;
        return Ok(closing);
    }
    let wrong = misses(&fs::read_to_string(&file).map_err(shown)?, &text);
    if wrong.is_empty() { Ok(closing) } else { Err(wrong.join("\n")) }
}

/// Differences from the golden file.
fn misses(golden: &str, now: &str) -> Vec<String> {
    let parse = |text: &str| text.parse::<toml::Table>().unwrap_or_default();
    let (golden, now) = (parse(golden), parse(now));
    let mut wrong = Vec::new();
    let empty = toml::Table::new();
    for (section, figures) in &now {
        let before = golden.get(section).and_then(toml::Value::as_table).unwrap_or(&empty);
        let after = figures.as_table().unwrap_or(&empty);
        for key in before.keys().chain(after.keys().filter(|key| !before.contains_key(*key))) {
            let (was, is) = (before.get(key), after.get(key));
            let near = match (was.and_then(toml::Value::as_integer), is.and_then(toml::Value::as_integer)) {
                (Some(was), Some(is)) if section != "panics" => {
                    (is - was).abs() as f64 <= TOLERANCE * was.abs() as f64
                }
                _ => was == is,
            };
            if !near {
                let shown = |value: Option<&toml::Value>| match value {
                    Some(toml::Value::Integer(figure)) => figure.to_string(),
                    Some(toml::Value::Boolean(fits)) => fits.to_string(),
                    _ => "none".into(),
                };
                wrong.push(format!("{section} {key}: golden {}, now {}", shown(was), shown(is)));
            }
        }
    }
    if !wrong.is_empty() {
        wrong.push("to accept: cargo xtask firmware --board b-g431b-esc1 --golden".into());
    }
    wrong
}

/// Counts the calls of functions that end in the panic handler, by the file and function of ours, or of a
/// library, in which they were written.
fn panics(root: &Path) -> Result<BTreeMap<String, usize>, String> {
    install::debian(&cross::PACKAGES)?;
    let mut all = BTreeMap::new();
    for image in ["drive", "boot"] {
        for (place, count) in panics_of(root, &path(root, image))? {
            let most = all.entry(place).or_insert(0);
            *most = count.max(*most);
        }
    }
    Ok(all)
}

fn panics_of(root: &Path, image: &Path) -> Result<BTreeMap<String, usize>, String> {
    let code =
        output(Command::new("arm-none-eabi-objdump").args(["-d", "-C", "--no-show-raw-insn"]).arg(image))?;
    let calls: Vec<&str> = code.lines().filter_map(call_of_panic).collect();
    let mut table = BTreeMap::new();
    if calls.is_empty() {
        return Ok(table);
    }
    let frames = output(
        Command::new("arm-none-eabi-addr2line").args(["-a", "-f", "-i", "-C", "-e"]).arg(image).args(calls),
    )?;
    // Each block is an address, and then function and place of each frame, innermost first.
    for frames in frames.split("0x").skip(1) {
        let lines: Vec<&str> = frames.lines().skip(1).collect();
        let ours = lines.chunks_exact(2).find(|frame| !is_of_the_language(frame[1]));
        let place = ours.map_or("the language's own".into(), |frame| named(root, frame[0], frame[1]));
        *table.entry(place).or_insert(0) += 1;
    }
    Ok(table)
}

/// Address of an instruction that calls a panicking function. Calls inside such functions do not count by
/// themselves.
fn call_of_panic(line: &str) -> Option<&str> {
    let (address, instruction) = line.trim_start().split_once(':')?;
    let mut words = instruction.split_whitespace();
    let is_call = words.next().is_some_and(|name| name == "bl" || name.starts_with("b."));
    let target = instruction.split_once('<')?.1;
    let panics = [
        "core::panicking::",
        "panic_already_borrowed",
        "slice_index_fail",
        "_mismatch_fail",
        "unwrap_failed",
    ];
    (is_call && !target.contains('+') && panics.iter().any(|name| target.contains(name))).then_some(address)
}

fn is_of_the_language(place: &str) -> bool {
    place.contains("/rustc/") || place.contains("/library/") || place.starts_with("??")
}

/// File and function. Line numbers are left out because they move, and the folders of this machine because
/// they differ.
fn named(root: &Path, function: &str, place: &str) -> String {
    let file = place.split(':').next().unwrap_or(place);
    let registry = file.split_once("/registry/src/").and_then(|(_, rest)| rest.split_once('/'));
    let ours = Path::new(file).strip_prefix(root).ok().and_then(Path::to_str);
    let file = match (registry, ours) {
        (Some((_, path)), _) => path,
        (None, path) => path.unwrap_or(file),
    };
    // Compilers write the types in names differently.
    let function = function.split('<').next().unwrap_or(function);
    // Functions that the compiler has outlined are numbered, and the numbers move.
    let function = if function.starts_with("OUTLINED_FUNCTION") { "outlined" } else { function };
    format!("{file} {function}").trim_end().to_owned()
}
