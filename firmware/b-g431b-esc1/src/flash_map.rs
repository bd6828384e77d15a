//! The flash: who stands where.
//!
//! ```text
//!  0        24 K           70 K              118 K   120 K      128 K
//!  | boot   | active       | dfu             | state | parameters |
//!  | loader | application  | its successor   |       | map, map   |
//! ```
//!
//! The successor's slot is a page larger than the active one: a swap that can be cut off and undone moves pages by one.

use core::ops::Range;

/// Where the flash stands in the address space (DS12589, section 4).
pub const START: u32 = 0x0800_0000;
/// Its size, bytes.
pub const SIZE: u32 = 128 << 10;
/// The smallest unit of erasing, bytes (RM0440, section 3.3.1: category 2 devices).
pub const PAGE: u32 = 2 << 10;
/// What is programmed at once, bytes: with eight bits of ECC, once between two erases.
pub const WORD: u32 = 8;

/// The bootloader.
pub const BOOT: Range<u32> = 0..24 << 10;
/// The application that runs.
pub const ACTIVE: Range<u32> = BOOT.end..BOOT.end + (46 << 10);
/// The application that was received, or the one before.
pub const DFU: Range<u32> = ACTIVE.end..ACTIVE.end + (48 << 10);
/// How far a swap has come.
pub const STATE: Range<u32> = DFU.end..DFU.end + PAGE;
/// Parameters and their mirror.
pub const PARAMETERS: Range<u32> = STATE.end..STATE.end + (8 << 10);

const _: () = assert!(PARAMETERS.end == SIZE && DFU.end - DFU.start >= ACTIVE.end - ACTIVE.start + PAGE);
