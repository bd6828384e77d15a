//! Objects in the caller's memory that hold no pointers: they may be moved and copied between calls.

use crate::frame::narx_frame_t;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use core::mem::{align_of, size_of};
use narx_core::bus::Frame;

/// An opaque type of C, and the object in its memory once it is initialised.
pub(crate) trait Handle {
    /// Type of the core that the memory holds.
    type Object;
    /// First bytes of the memory of an initialised object; no other type has the same.
    const MARK: u32;
}

/// Content of a handle's memory.
#[repr(C)]
pub(crate) struct Marked<T> {
    mark: u32,
    object: T,
}

/// Fails to compile if a handle has no room for its object.
pub(crate) const fn assert_fits<H: Handle>() {
    assert_room::<Marked<H::Object>, H>();
}

/// Fails to compile if an opaque type of C has no room for its content.
pub(crate) const fn assert_room<Content, Opaque>() {
    assert!(
        size_of::<Content>() <= size_of::<Opaque>() && align_of::<Content>() <= align_of::<Opaque>(),
        "the content has outgrown its opaque type: raise the number of words in `words` of that type (a \
         NARX_*_WORDS or a plain number), then run `cargo xtask header` and `cargo xtask sizes`"
    );
}

/// Returns the bytes that the object needs on this processor.
pub(crate) const fn size<H: Handle>() -> usize {
    size_of::<Marked<H::Object>>()
}

/// Puts an object into `size` bytes of memory.
///
/// # Safety
/// `memory` is NULL, misaligned, or points to `size` writable bytes that nothing else uses.
pub(crate) unsafe fn init<H: Handle>(
    memory: *mut H,
    size: usize,
    object: impl FnOnce() -> Result<H::Object, narx_status_t>,
) -> Result<(), narx_status_t> {
    // SAFETY: the caller's promise.
    let place = unsafe { place(memory, size)? };
    let object = object()?;
    // SAFETY: aligned and large enough, as just checked.
    unsafe { place.write(Marked { mark: H::MARK, object }) };
    Ok(())
}

/// Returns where the object goes, if `size` bytes of memory have room for it.
///
/// # Safety
/// As [`init`].
#[inline(always)]
pub(crate) unsafe fn place<H: Handle>(
    memory: *mut H,
    size: usize,
) -> Result<*mut Marked<H::Object>, narx_status_t> {
    let place: *mut Marked<H::Object> = memory.cast();
    pointer::check(place)?;
    if size < size_of::<Marked<H::Object>>() { Err(NARX_ERROR_SIZE) } else { Ok(place) }
}

/// Puts an object into `size` bytes of memory that is made of the value that `from` points to.
///
/// # Safety
/// As [`init`] and [`pointer::read`].
pub(crate) unsafe fn init_from<H: Handle, From>(
    memory: *mut H,
    size: usize,
    from: *const From,
    object: impl FnOnce(&From) -> H::Object,
) -> Result<(), narx_status_t> {
    // SAFETY: the caller's promise.
    unsafe {
        let place = place(memory, size)?;
        let from = pointer::read(from)?;
        // One by one: both at once are copied by the C library's memcpy, a fourth of a small program.
        (&raw mut (*place).mark).write(H::MARK);
        (&raw mut (*place).object).write(object(from));
    }
    Ok(())
}

/// Returns the object.
///
/// # Safety
/// `memory` is NULL, misaligned, or readable and writable, and no other reference to the object lives.
pub(crate) unsafe fn object<'a, H: Handle>(memory: *mut H) -> Result<&'a mut H::Object, narx_status_t> {
    let marked: *mut Marked<H::Object> = memory.cast();
    pointer::check(marked)?;
    // SAFETY: neither NULL nor misaligned, so readable as the caller promises.
    if unsafe { (&raw const (*marked).mark).read() } != H::MARK {
        return Err(NARX_ERROR_UNINITIALISED);
    }
    // SAFETY: the mark shows that the object was written.
    Ok(unsafe { &mut (*marked).object })
}

/// Calls `call` with the object.
///
/// # Safety
/// As [`object`].
pub(crate) unsafe fn call<H: Handle>(
    memory: *mut H,
    call: impl FnOnce(&mut H::Object) -> Result<(), narx_status_t>,
) -> narx_status_t {
    // SAFETY: the caller's promise.
    pointer::status(unsafe { object(memory) }.and_then(call))
}

/// Gives the object a received frame.
///
/// # Safety
/// As [`object`] and [`pointer::read`].
pub(crate) unsafe fn handle_frame<H: Handle>(
    memory: *mut H,
    frame: *const narx_frame_t,
    handle: impl FnOnce(&mut H::Object, &Frame),
) -> narx_status_t {
    // SAFETY: the caller's promise.
    let run = || unsafe {
        handle(object(memory)?, &pointer::read(frame)?.try_into()?);
        Ok(())
    };
    pointer::status(run())
}

/// Writes the next value of the object to `to`, or returns NARX_NOTHING. It asks the object only if `to` can
/// be written, so that no value is lost.
///
/// # Safety
/// As [`object`] and [`pointer::write`].
pub(crate) unsafe fn poll<H: Handle, T: Copy>(
    memory: *mut H,
    to: *mut T,
    next: impl FnOnce(&mut H::Object) -> Option<T>,
) -> narx_status_t {
    // SAFETY: the caller's promise.
    let run = || unsafe {
        let object = object(memory)?;
        pointer::check(to)?;
        pointer::write(to, next(object).ok_or(NARX_NOTHING)?)
    };
    pointer::status(run())
}
