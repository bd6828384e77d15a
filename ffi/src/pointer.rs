//! The caller's pointers, checked as far as the library can check them.

use crate::status::narx_status_t::{self, *};

/// Returns a reference to the value that `pointer` points to.
///
/// # Safety
/// NULL, misaligned, or readable as a `T` while the result lives.
pub(crate) unsafe fn read<'a, T>(pointer: *const T) -> Result<&'a T, narx_status_t> {
    check(pointer)?;
    // SAFETY: neither NULL nor misaligned, so readable as the caller promises.
    Ok(unsafe { &*pointer })
}

/// Writes a value to `pointer`; the previous content need not have been a `T`.
///
/// # Safety
/// NULL, misaligned, or writable as a `T`.
pub(crate) unsafe fn write<T: Copy>(pointer: *mut T, value: T) -> Result<(), narx_status_t> {
    check(pointer)?;
    // SAFETY: neither NULL nor misaligned, so writable as the caller promises.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Writes a value to `pointer`, unless it is NULL: the caller does not need the value.
///
/// # Safety
/// As [`write`].
pub(crate) unsafe fn write_unless_null<T: Copy>(pointer: *mut T, value: T) -> Result<(), narx_status_t> {
    // SAFETY: the caller's promise.
    if pointer.is_null() { Ok(()) } else { unsafe { write(pointer, value) } }
}

/// Returns the `length` bytes that `pointer` points to.
///
/// # Safety
/// NULL, or `length` readable bytes while the result lives.
pub(crate) unsafe fn bytes<'a>(pointer: *const u8, length: usize) -> Result<&'a [u8], narx_status_t> {
    check(pointer)?;
    if isize::try_from(length).is_err() {
        return Err(NARX_ERROR_SIZE);
    }
    // SAFETY: not NULL, no longer than an object can be, readable as the caller promises.
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}

/// Returns the `count` values that `pointer` points to.
///
/// # Safety
/// NULL, misaligned, or readable as `count` times `T` while the result lives.
pub(crate) unsafe fn slice<'a, T>(pointer: *const T, count: usize) -> Result<&'a [T], narx_status_t> {
    check(pointer)?;
    // SAFETY: neither NULL nor misaligned, so readable as the caller promises.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

/// Checks that `pointer` is neither NULL nor misaligned.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), narx_status_t> {
    if pointer.is_null() {
        Err(NARX_ERROR_NULL)
    } else if !pointer.is_aligned() {
        Err(NARX_ERROR_ALIGNMENT)
    } else {
        Ok(())
    }
}

/// Returns the status of a call whose only result is its status.
pub(crate) fn status(result: Result<(), narx_status_t>) -> narx_status_t {
    result.err().unwrap_or(NARX_OK)
}
