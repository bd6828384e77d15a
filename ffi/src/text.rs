//! Text in the caller's buffer.

use crate::pointer;
use crate::status::narx_status_t;
use core::ffi::c_char;
use core::fmt::{self, Write};

/// Writes `value` and a closing 0, cut to the size of the buffer. Nothing is written if the size is 0; `text`
/// may then be NULL.
///
/// # Safety
/// `text` is NULL or `size` writable bytes.
pub(crate) unsafe fn write(
    text: *mut c_char,
    size: usize,
    value: impl fmt::Display,
) -> Result<(), narx_status_t> {
    let Some(room) = size.checked_sub(1) else { return Ok(()) };
    pointer::check(text)?;
    let mut writer = Writer { text, room, used: 0 };
    // A text that is cut is not an error: the caller chose the size.
    let _ = write!(writer, "{value}");
    // SAFETY: `used` <= `room` < `size`.
    unsafe { text.add(writer.used).write(0) };
    Ok(())
}

struct Writer {
    text: *mut c_char,
    room: usize,
    used: usize,
}

impl Write for Writer {
    fn write_str(&mut self, piece: &str) -> fmt::Result {
        for byte in piece.bytes() {
            if self.used == self.room {
                return Err(fmt::Error);
            }
            // SAFETY: `used` < `room` < the size of the caller's buffer.
            unsafe { self.text.add(self.used).write(byte as c_char) };
            self.used += 1;
        }
        Ok(())
    }
}
