//! Hardware ids: "NX" and a number, which never changes once a board has left.

/// The bench's drive.
pub const BENCH: u32 = 0x4E58_0000;
/// The emulated board (mps2-an386).
pub const QEMU: u32 = 0x4E58_0001;
/// The B-G431B-ESC1.
pub const B_G431B_ESC1: u32 = 0x4E58_0002;

/// Every board by its name.
pub const BOARDS: [(&str, u32); 3] = [("bench", BENCH), ("qemu", QEMU), ("b-g431b-esc1", B_G431B_ESC1)];
