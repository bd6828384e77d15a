//! Images of the emulated board: their names, files and sizes.

use narx_report::target_directory;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Target of a Cortex-M4 with floating point, as on the boards.
pub(crate) const EMBEDDED: &str = "thumbv7em-none-eabihf";

/// An image of the board `qemu`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Image {
    /// The virtual drive.
    Drive,
    /// Replays recordings.
    Replay,
    /// Counts the instructions of the control tick.
    Count,
    /// Counts the instructions of the simulated motor.
    Plant,
    /// Measures the stack that the calls of a shell take.
    Stack,
    /// Counts the instructions of a drive between two sleeps in Standby.
    Standby,
    /// Swaps and verifies images in the slots, and enters one.
    Bootloader,
    /// The virtual drive in a slot.
    Application,
}

impl Image {
    /// All images.
    pub(crate) const ALL: [Self; 8] = [
        Self::Drive,
        Self::Replay,
        Self::Count,
        Self::Plant,
        Self::Stack,
        Self::Standby,
        Self::Bootloader,
        Self::Application,
    ];

    /// Name of the image and of its file.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Drive => "qemu",
            Self::Replay => "replay",
            Self::Count => "count",
            Self::Plant => "plant",
            Self::Stack => "stack",
            Self::Standby => "standby",
            Self::Bootloader => "bootloader",
            Self::Application => "application",
        }
    }

    /// Path at which the build leaves it.
    pub(crate) fn path(self, root: &Path) -> PathBuf {
        target_directory(root).join(EMBEDDED).join("release").join(self.name())
    }
}

/// Memory that an image occupies, bytes.
pub(crate) struct Size {
    pub(crate) flash: u32,
    pub(crate) ram: u32,
}

/// Start of the RAM of a Cortex-M.
const RAM: u32 = 0x2000_0000;

/// Sums the segments of a 32-bit little-endian ELF file (System V ABI, chapter 5): bytes that the file holds
/// count as flash, wherever they run; segments in RAM count as RAM, too.
pub(crate) fn size(path: &Path) -> io::Result<Size> {
    let file = fs::read(path)?;
    let malformed = || io::Error::other("not a 32-bit ELF file");
    let bytes = |at: usize, length: usize| file.get(at..at + length).ok_or_else(malformed);
    let word = |at| bytes(at, 4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    let half = |at| bytes(at, 2).map(|half| usize::from(u16::from_le_bytes([half[0], half[1]])));
    if bytes(0, 5)? != b"\x7fELF\x01" {
        return Err(malformed());
    }
    let (table, entry, count) = (word(28)? as usize, half(42)?, half(44)?);
    let mut size = Size { flash: 0, ram: 0 };
    for header in (0..count).map(|index| table + index * entry) {
        const LOAD: u32 = 1;
        if word(header)? == LOAD {
            size.flash += word(header + 16)?;
            if word(header + 8)? >= RAM {
                size.ram += word(header + 20)?;
            }
        }
    }
    Ok(size)
}
