//! Memory of the virtual scope, which the caller owns.

use crate::device::{background, narx_drive_t};
use crate::handle;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use core::mem::{align_of, size_of};
use narx_core::scope::{Memory, WORDS};

/// 64-bit words of a scope's memory on any processor.
pub const NARX_SCOPE_WORDS: usize = 1446;

/// Memory of a virtual scope. It has room for the largest number of samples of one signal that parameter 23
/// can request (4096), or for 68 ms of inputs at 10 kHz. Its content is private to the library. It must stay
/// at its address as long as the drive lives.
#[repr(C)]
pub struct narx_scope_t {
    /// Private.
    words: [u64; NARX_SCOPE_WORDS],
}

const _: () = handle::assert_room::<Memory<[u16; WORDS]>, narx_scope_t>();

/// Returns the bytes that a scope with room for `samples` needs on this processor. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_scope_size(samples: u16) -> usize {
    (size_of::<Memory<[u16; 0]>>() + 2 * usize::from(samples))
        .next_multiple_of(align_of::<Memory<[u16; 0]>>())
}

/// Gives the drive's virtual scope its memory of `size` bytes: sizeof(narx_scope_t), or narx_scope_size() of
/// memory of your own that is aligned like a narx_scope_t. Returns NARX_ERROR_SIZE if it has no room for one
/// sample. Without memory the scope cannot be armed. Call it after narx_drive_init and before the first
/// narx_drive_step; narx_drive_init detaches the memory again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_attach_scope(
    drive: *mut narx_drive_t,
    memory: *mut narx_scope_t,
    size: usize,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h, and the memory is the caller's promise.
    let run = || unsafe {
        let memory = make(memory, size)?;
        background(drive)?.attach_scope(memory);
        Ok(())
    };
    pointer::status(run())
}

/// Makes an empty scope in `size` bytes of memory.
///
/// # Safety
/// `memory` is NULL, misaligned, or points to `size` bytes that nothing else uses from now on.
unsafe fn make(memory: *mut narx_scope_t, size: usize) -> Result<&'static mut Memory, narx_status_t> {
    let head: *mut Memory<[u16; 0]> = memory.cast();
    pointer::check(head)?;
    let room = size - size % align_of::<Memory<[u16; 0]>>();
    let words = room.checked_sub(size_of::<Memory<[u16; 0]>>()).ok_or(NARX_ERROR_SIZE)? / size_of::<u16>();
    if words == 0 {
        return Err(NARX_ERROR_SIZE);
    }
    let words = words.min(u16::MAX.into());
    let whole = core::ptr::slice_from_raw_parts_mut(memory.cast::<u16>(), words) as *mut Memory;
    // SAFETY: neither NULL nor misaligned. The layout is C's, so the words begin at the end of a `Memory`
    // without words; they end within `size`.
    unsafe {
        head.cast::<u8>().write_bytes(0, size_of::<Memory<[u16; 0]>>() + words * size_of::<u16>());
        head.write(Memory::new());
        Ok(&mut *whole)
    }
}
