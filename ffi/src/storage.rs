//! The drive's flash, if the caller has one: parameters that survive a power cut, and the log.

use crate::board::narx_board_t;
use crate::device::{background, init, narx_drive_t, narx_identity_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use core::ffi::c_void;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use narx_core::storage::{FlashReply, FlashTask, Opened, Storage};

/// 64-bit words of a narx_storage_t on any processor.
pub const NARX_STORAGE_WORDS: usize = 320;

/// Storage of a drive's parameters and its log: memory that the caller owns. Its content is private to the
/// library.
#[repr(C)]
pub struct narx_storage_t {
    /// Private.
    words: [u64; NARX_STORAGE_WORDS],
}

/// Largest number of bytes of one program call: a page, within which it stays.
pub const NARX_FLASH_PAGE: usize = 256;
/// Bytes of the smallest erase.
pub const NARX_FLASH_SUBSECTOR: usize = 4096;

/// A serial NOR flash, as the board drives it. The functions wait until the flash is done and return 0, or
/// another number if it is absent or has failed. The drive then reports fault bit 30 on the bus.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_flash_t {
    /// Bytes of the flash: whole subsectors, 512 KiB or more. The log uses the space that the parameters
    /// leave.
    pub size: u32,
    /// Pointer that is passed to the functions.
    pub context: *mut c_void,
    /// Reads `length` bytes from `address` on.
    pub read: Option<
        unsafe extern "C" fn(context: *mut c_void, address: u32, bytes: *mut u8, length: usize) -> i32,
    >,
    /// Programs `length` bytes from `address` on, within one page of NARX_FLASH_PAGE: bits change from 1 to
    /// 0.
    pub program: Option<
        unsafe extern "C" fn(context: *mut c_void, address: u32, bytes: *const u8, length: usize) -> i32,
    >,
    /// Erases from `from` to before `to`, whole subsectors of NARX_FLASH_SUBSECTOR: all bits become 1. The
    /// function may erase larger sectors in between at once.
    pub erase: Option<unsafe extern "C" fn(context: *mut c_void, from: u32, to: u32) -> i32>,
}

/// The flash as a `NorFlash` of the core's storage.
#[derive(Debug)]
pub(crate) struct Chip(narx_flash_t);

/// The flash has failed, or an address lies beyond its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChipError(NorFlashErrorKind);

impl NorFlashError for ChipError {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl Chip {
    fn check(&self, from: u32, length: usize) -> Result<(), ChipError> {
        let end = u64::from(from) + length as u64;
        if end <= u64::from(self.0.size) { Ok(()) } else { Err(ChipError(NorFlashErrorKind::OutOfBounds)) }
    }
}

/// Converts the result of a function of the board. It is never `None`: narx_storage_init rejects a missing
/// function.
fn done(answer: Option<i32>) -> Result<(), ChipError> {
    if answer == Some(0) { Ok(()) } else { Err(ChipError(NorFlashErrorKind::Other)) }
}

impl ErrorType for Chip {
    type Error = ChipError;
}

impl ReadNorFlash for Chip {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), ChipError> {
        self.check(offset, bytes.len())?;
        // SAFETY: the caller's function with the caller's context, and memory of that length.
        done(self.0.read.map(|read| unsafe { read(self.0.context, offset, bytes.as_mut_ptr(), bytes.len()) }))
    }

    fn capacity(&self) -> usize {
        self.0.size as usize
    }
}

impl NorFlash for Chip {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = NARX_FLASH_SUBSECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), ChipError> {
        self.check(from, to.saturating_sub(from) as usize)?;
        // SAFETY: as above.
        done(self.0.erase.map(|erase| unsafe { erase(self.0.context, from, to) }))
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), ChipError> {
        self.check(offset, bytes.len())?;
        let (mut at, mut left) = (offset, bytes);
        while !left.is_empty() {
            let room = NARX_FLASH_PAGE - at as usize % NARX_FLASH_PAGE;
            let (page, rest) = left.split_at(room.min(left.len()));
            // SAFETY: as above.
            done(
                self.0
                    .program
                    .map(|program| unsafe { program(self.0.context, at, page.as_ptr(), page.len()) }),
            )?;
            // No overflow: the check above has shown that it is within the flash.
            (at, left) = (at.wrapping_add(page.len() as u32), rest);
        }
        Ok(())
    }
}

impl Handle for narx_storage_t {
    type Object = Storage<Chip>;
    const MARK: u32 = u32::from_be_bytes(*b"nstr");
}

const _: () = handle::assert_fits::<narx_storage_t>();

/// Returns the bytes that a storage needs on this processor: at most sizeof(narx_storage_t). Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_storage_size() -> usize {
    handle::size::<narx_storage_t>()
}

/// Makes a storage in `size` bytes of memory. `flash` is copied. Its functions, none of which may be NULL,
/// are called only within narx_storage_init_drive and narx_storage_serve.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_storage_init(
    storage: *mut narx_storage_t,
    size: usize,
    flash: *const narx_flash_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let make = || unsafe {
        let flash = *pointer::read(flash)?;
        if flash.read.is_none() || flash.program.is_none() || flash.erase.is_none() {
            return Err(NARX_ERROR_NULL);
        }
        Ok(Storage::new(Chip(flash)))
    };
    // SAFETY: as above.
    pointer::status(unsafe { handle::init(storage, size, make) })
}

/// Makes a drive as narx_drive_init does, with the parameters that the flash holds, or factory values for
/// those that it does not hold. The drive then keeps its parameters and its log on this flash. The drive
/// reports the state of the flash on the bus, including fault bits 26, 30 and 31. `identity` may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_storage_init_drive(
    storage: *mut narx_storage_t,
    drive: *mut narx_drive_t,
    size: usize,
    board: *const narx_board_t,
    identity: *const narx_identity_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let identity = if identity.is_null() { Default::default() } else { pointer::read(identity)?.into() };
        let FlashReply::Opened(opened) = finish(handle::object(storage)?.execute(FlashTask::Open)) else {
            return Err(NARX_ERROR_UNINITIALISED);
        };
        let Opened { parameters, .. } = opened.clone();
        init(drive, size, board, identity, parameters)?;
        background(drive)?.node().attach_storage(&opened);
        Ok(())
    };
    pointer::status(run())
}

/// Runs one bounded step of the drive's work on its flash: a store, a record of the log, a piece of an erase.
/// Returns NARX_NOTHING if there is none. Call it in every pass of the main loop. It takes as long as your
/// flash does, and some 6 KiB of stack. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_storage_serve(
    storage: *mut narx_storage_t,
    drive: *mut narx_drive_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let node = background(drive)?.node();
        let storage = handle::object(storage)?;
        let request = node.poll_storage().ok_or(NARX_NOTHING)?;
        node.handle_storage(finish(storage.execute(request)));
        Ok(())
    };
    pointer::status(run())
}

/// Returns the result of a future. It is ready at the first poll, because the board's functions block.
fn finish<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    loop {
        if let Poll::Ready(answer) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return answer;
        }
    }
}
