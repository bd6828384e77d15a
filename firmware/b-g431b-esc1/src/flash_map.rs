//! The flash: who stands where is the bootloader's to say ([`MAP`]); where it is in the address space, and
//! how it is written, the chip's.
//!
//! ```text
//!  0             22 K                            118 K   120 K      128 K
//!  | bootloader  | the slot: header, application | state | parameters |
//!  | receives    |                               |       | four pages |
//! ```

use narx_boot::Map;

/// The slot, in bytes from [`START`].
pub const MAP: Map = Map::B_G431B_ESC1;
/// Hardware id of the images that are for this board.
pub const HARDWARE: u32 = narx_boot::hardware::B_G431B_ESC1;

/// Start of the flash in the address space (DS12589, section 4).
pub const START: u32 = 0x0800_0000;
/// Its size, bytes.
pub const SIZE: u32 = 128 << 10;
/// The smallest unit of erasing, bytes (RM0440, section 3.3.1: category 2 devices).
pub const PAGE: u32 = 2 << 10;
/// Unit of programming, bytes: it has eight bits of ECC and can be programmed once between two erases.
pub const WORD: u32 = 8;

const _: () = assert!(MAP.parameters.end == SIZE);
