//! A drive in the caller's memory: the tick half and the background half side by side, joined by their
//! queues.
//!
//! The caller has one pointer to the whole drive, and one call may interrupt another. Therefore no reference
//! to the whole is ever made: [`tick`] and [`background`] make one to their own part only. Both read the
//! mark, which is an atomic.

use crate::board::narx_board_t;
use crate::frame::narx_frame_t;
use crate::handle;
use crate::pointer;
use crate::pwm::{self, narx_pwm_command_t};
use crate::samples::narx_samples_t;
use crate::status::narx_status_t::{self, *};
use core::mem::{align_of, size_of};
use core::sync::atomic::{AtomicU32, Ordering};
use narx_core::bus::Frame;
use narx_core::device::{Background, ControlTick, Queues};
use narx_core::dictionary::{ParameterError, Parameters};
use narx_core::motor::{Board, Coefficients};
use narx_core::node::{Identity, Node};

/// 64-bit words of a drive on any processor.
pub const NARX_DRIVE_WORDS: usize = 800;

/// Bytes of a drive on any processor; narx_drive_size returns the bytes that it needs on this one.
pub const NARX_DRIVE_SIZE: usize = NARX_DRIVE_WORDS * 8;

/// A drive: memory that the caller owns, static, on a stack or from a pool. Its content is private to the
/// library. It must neither move nor be copied after narx_drive_init. To end a drive, stop calling it.
#[repr(C)]
pub struct narx_drive_t {
    /// Private.
    words: [u64; NARX_DRIVE_WORDS],
}

/// A parameter that was stored.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_stored_t {
    /// Number of the parameter: a NARX_PARAMETER_*.
    pub number: u16,
    /// Raw value.
    pub value: i32,
}

/// Identity of firmware and board (BUILD_INFO, DEVICE_INFO, parameters 4 to 7).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_identity_t {
    /// Date of the build, YYYYMMDD in decimal.
    pub build_date: u32,
    /// Build number of the firmware.
    pub build_number: u16,
    /// Release of the board.
    pub hardware_release: u16,
    /// Release of the firmware: major in the high byte, minor in the low byte.
    pub software_release: u16,
    /// Not 0: built from sources that were not committed.
    pub source_modified: u8,
}

/// Content of a `narx_drive_t`.
#[repr(C)]
struct Device {
    /// Value of [`mark_of`] once the other fields are initialised at this address.
    mark: AtomicU32,
    queues: Queues<'static>,
    tick: ControlTick<'static, 'static>,
    background: Background<'static, 'static>,
}

const _: () = handle::assert_room::<Device, narx_drive_t>();

/// Returns the bytes that a drive needs on this processor: at most NARX_DRIVE_SIZE. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_drive_size() -> usize {
    size_of::<Device>()
}

/// Returns the alignment that a drive needs on this processor: at most that of narx_drive_t. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_drive_align() -> usize {
    align_of::<Device>()
}

/// Makes a drive at power-up, with factory parameters, in `size` bytes of memory (sizeof(narx_drive_t), or
/// narx_drive_size() in memory of your own). `board` is NULL for the default board. The previous content of
/// the memory is lost. If it was a drive, this reboots it.
///
/// Call it before any other use, not during another call for the same drive. A narx_drive_step that
/// interrupts it returns NARX_ERROR_UNINITIALISED and writes a coast command.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_init(
    drive: *mut narx_drive_t,
    size: usize,
    board: *const narx_board_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { init(drive, size, board, Identity::default(), Parameters::new()) })
}

/// Makes a drive as narx_drive_init does, with stored parameters and an identity. `stored` has `count`
/// parameters and may be NULL if `count` is 0; `identity` may be NULL. A set is accepted or rejected as a
/// whole: with NARX_ERROR_UNKNOWN_PARAMETER or NARX_ERROR_OUT_OF_RANGE the memory is unchanged. If no working
/// controller can be built from an accepted set, the drive refuses to start;
/// NARX_PARAMETER_REJECTED_PARAMETER holds the number of the parameter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_init_stored(
    drive: *mut narx_drive_t,
    size: usize,
    board: *const narx_board_t,
    identity: *const narx_identity_t,
    stored: *const narx_stored_t,
    count: usize,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let identity = if identity.is_null() { Identity::default() } else { pointer::read(identity)?.into() };
        let parameters = parameters(stored, count)?;
        init(drive, size, board, identity, parameters)
    };
    pointer::status(run())
}

/// Runs one control tick: takes the samples of this period and writes the command to apply. Tick half: call
/// it from the control interrupt, once a PWM period. It may interrupt every other call for the same drive
/// except narx_drive_init and itself.
///
/// On an error the command, if `command` is a valid pointer, is coast at duty 0: a caller that ignores the
/// status still turns the bridge off.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_step(
    drive: *mut narx_drive_t,
    samples: *const narx_samples_t,
    command: *mut narx_pwm_command_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { pwm::step(samples, command, || tick(drive), ControlTick::step) }
}

/// Takes a frame that has arrived. Frames that are not for this drive, or not well formed, are counted or
/// ignored (PROTOCOL.md). Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_handle_frame(
    drive: *mut narx_drive_t,
    frame: *const narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let background = background(drive)?;
        background.node().handle_frame(&pointer::read(frame)?.try_into()?);
        Ok(())
    };
    pointer::status(run())
}

/// Advances the drive's background to the control tick `now` and exchanges data with the tick half. Call it
/// once a period or less often, after narx_drive_handle_frame and before narx_drive_poll_frame. Background
/// half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_run(drive: *mut narx_drive_t, now: u64) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { background(drive) }.map(|background| background.run(now)))
}

/// Writes the next frame to send, or returns NARX_NOTHING. Call it until it returns NARX_NOTHING. Background
/// half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_poll_frame(
    drive: *mut narx_drive_t,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { poll(drive, frame, Node::poll_frame) }
}

/// Writes the next frame of a download that the master has requested, or returns NARX_NOTHING, as it does
/// while narx_drive_poll_frame has frames. Call it when no more than one frame is in the controller, the one
/// that is on the bus: more would delay the drive's other messages. A program that never calls it serves no
/// downloads. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_poll_bulk_frame(
    drive: *mut narx_drive_t,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { poll(drive, frame, Node::poll_bulk_frame) }
}

/// Writes a parameter as the master does: number, access, range and state are checked, then it takes effect
/// as described in PROTOCOL.md. `value` is the raw value, with the unit and scale of PROTOCOL.md; a 32-bit
/// unsigned value is passed as its bits. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_set_parameter(
    drive: *mut narx_drive_t,
    number: u16,
    value: i32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    match unsafe { background(drive) } {
        Ok(background) => background.node().write_parameter(number, value).into(),
        Err(error) => error,
    }
}

/// Reads a parameter, raw as in narx_drive_set_parameter, measured values included. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_get_parameter(
    drive: *mut narx_drive_t,
    number: u16,
    value: *mut i32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let read = background(drive)?.node().read_parameter(number);
        pointer::write(value, read.ok_or(NARX_ERROR_UNKNOWN_PARAMETER)?)
    };
    pointer::status(run())
}

/// # Safety
/// The conditions of the function that calls it.
unsafe fn poll(
    drive: *mut narx_drive_t,
    frame: *mut narx_frame_t,
    next: fn(&mut Node) -> Option<Frame>,
) -> narx_status_t {
    // SAFETY: the caller's promise.
    let run = || unsafe {
        let background = background(drive)?;
        // Checked first, so that a frame which cannot be written to the caller is not lost.
        pointer::check(frame)?;
        let sent = next(background.node()).ok_or(NARX_NOTHING)?;
        pointer::write(frame, sent.into())
    };
    pointer::status(run())
}

/// Returns the factory's parameters with `count` stored ones in their place.
///
/// # Safety
/// `stored` is NULL, misaligned, or points to `count` parameters.
pub(crate) unsafe fn parameters(
    stored: *const narx_stored_t,
    count: usize,
) -> Result<Parameters, narx_status_t> {
    let mut parameters = Parameters::new();
    if count > 0 {
        // SAFETY: the caller's promise.
        for narx_stored_t { number, value } in unsafe { pointer::slice(stored, count)? } {
            parameters.set(*number, *value)?;
        }
    }
    Ok(parameters)
}

/// Returns the caller's board, or the default one for NULL.
///
/// # Safety
/// `board` is NULL, misaligned, or readable.
pub(crate) unsafe fn board(board: *const narx_board_t) -> Result<Board, narx_status_t> {
    // SAFETY: the caller's promise.
    let board = if board.is_null() { Board::BENCH } else { unsafe { pointer::read(board)? }.into() };
    if board.is_plausible() { Ok(board) } else { Err(NARX_ERROR_BOARD) }
}

/// # Safety
/// `drive` and `board` are NULL or valid, and nothing else uses the drive.
pub(crate) unsafe fn init(
    drive: *mut narx_drive_t,
    size: usize,
    board: *const narx_board_t,
    identity: Identity,
    parameters: Parameters,
) -> Result<(), narx_status_t> {
    let device: *mut Device = drive.cast();
    pointer::check(device)?;
    if size < size_of::<Device>() {
        return Err(NARX_ERROR_SIZE);
    }
    // SAFETY: the caller's promise.
    let board = unsafe { self::board(board)? };
    // A plausible board must give a controller with the factory parameters.
    if Coefficients::build(&Parameters::new(), &board).is_err() {
        return Err(NARX_ERROR_BOARD);
    }
    // SAFETY: aligned and large enough, as just checked. Each part is written before a reference to it is
    // made. The two halves hold the reference to the queues for as long as the mark is valid.
    unsafe {
        mark(device).store(0, Ordering::SeqCst);
        let queues = &raw mut (*device).queues;
        queues.write(Queues::new());
        let (tick, background) = (*queues).power_up(identity, board, parameters);
        (&raw mut (*device).tick).write(tick);
        (&raw mut (*device).background).write(background);
        mark(device).store(mark_of(device), Ordering::SeqCst);
    }
    Ok(())
}

/// Returns the tick half.
///
/// # Safety
/// `drive` is NULL or valid, and no other reference to the tick half lives.
unsafe fn tick<'a>(drive: *mut narx_drive_t) -> Result<&'a mut ControlTick<'static, 'static>, narx_status_t> {
    let device = initialised(drive)?;
    // SAFETY: the mark shows that it was written; a reference to this part only.
    Ok(unsafe { &mut (*device).tick })
}

/// Returns the background half.
///
/// # Safety
/// `drive` is NULL or valid, and no other reference to the background half lives.
pub(crate) unsafe fn background<'a>(
    drive: *mut narx_drive_t,
) -> Result<&'a mut Background<'static, 'static>, narx_status_t> {
    let device = initialised(drive)?;
    // SAFETY: the mark shows that it was written; a reference to this part only.
    Ok(unsafe { &mut (*device).background })
}

fn initialised(drive: *mut narx_drive_t) -> Result<*mut Device, narx_status_t> {
    let device: *mut Device = drive.cast();
    pointer::check(device)?;
    // SAFETY: neither NULL nor misaligned, and the caller promises readable memory.
    let found = unsafe { mark(device) }.load(Ordering::SeqCst);
    if found == mark_of(device) { Ok(device) } else { Err(NARX_ERROR_UNINITIALISED) }
}

/// # Safety
/// `device` is aligned and its first bytes are readable and writable.
unsafe fn mark<'a>(device: *mut Device) -> &'a AtomicU32 {
    // SAFETY: the caller's promise; an atomic may be shared.
    unsafe { AtomicU32::from_ptr((&raw mut (*device).mark).cast()) }
}

/// Returns the mark of a drive at this address. The halves hold the address of the queues, so a drive that
/// was moved or copied is invalid: its mark does not fit its address.
fn mark_of(device: *mut Device) -> u32 {
    const DRIVE: u32 = u32::from_be_bytes(*b"narx");
    DRIVE ^ (device.addr() as u32)
}

impl From<&narx_identity_t> for Identity {
    fn from(identity: &narx_identity_t) -> Self {
        Self {
            build_number: identity.build_number,
            source_modified: identity.source_modified != 0,
            build_date: identity.build_date,
            hardware_release: identity.hardware_release,
            software_release: identity.software_release,
        }
    }
}

impl From<ParameterError> for narx_status_t {
    fn from(error: ParameterError) -> Self {
        match error {
            ParameterError::Unknown { .. } => NARX_ERROR_UNKNOWN_PARAMETER,
            ParameterError::OutOfRange { .. } | ParameterError::Layout => NARX_ERROR_OUT_OF_RANGE,
        }
    }
}
