//! The digest of a drive's outputs, defined byte for byte so that every language can repeat it.

use super::outputs::fields;
use crate::motor::PwmCommand;
use crate::motor::machine::event::Status;
use core::fmt;
use crc::{CRC_64_XZ, Crc};

/// A table of 2 KiB that does not compress is more than a web page's module can afford.
#[cfg(target_arch = "wasm32")]
type Way = crc::NoTable;
#[cfg(not(target_arch = "wasm32"))]
type Way = crc::Table<1>;

static CRC64: Crc<u64, Way> = Crc::<u64, Way>::new(&CRC_64_XZ);

/// CRC-64/XZ of bytes as they come.
pub(super) type Check = crc::Digest<'static, u64, Way>;

/// CRC-64/XZ before the first byte.
pub(super) const fn check() -> Check {
    CRC64.digest()
}

/// CRC-64/XZ over the outputs of all ticks in order: every PWM command, and after it the status if that tick
/// reported one. Each begins with a letter (`P`, `S`), then its fields in the order of their declaration,
/// little endian, nothing between them: `bool` and enumerations one byte (numbered from 0 in the order of
/// declaration where the declaration gives no number), quantities their raw bits, an enumeration's contents
/// right after it. A command's commutations are their count, then instant and step of each.
#[derive(Clone)]
pub struct Digest {
    crc: Check,
}

impl Default for Digest {
    fn default() -> Self {
        Self { crc: check() }
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Digest({:016x})", self.value())
    }
}

impl Digest {
    /// Adds the answer of one tick.
    pub fn update(&mut self, command: &PwmCommand, status: Option<&Status>) {
        fields(command, status, &mut |_, bits| {
            let bytes = bits.value.to_le_bytes();
            self.crc.update(bytes.get(..bits.bytes as usize).unwrap_or(&bytes));
        });
    }

    /// The digest so far.
    pub fn value(&self) -> u64 {
        self.crc.clone().finalize()
    }
}
