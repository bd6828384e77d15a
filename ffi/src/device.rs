//! A drive in the caller's memory: the tick half and the background half side by side, joined by their queues.
//!
//! Whoever calls holds one pointer to all of it, and one call may interrupt another. So no reference to the whole is
//! ever made: [`tick`] and [`background`] make one to their own part only, and the mark, which both read, is an atomic.

use crate::board::narx_board_t;
use crate::frame::narx_frame_t;
use crate::pointer;
use crate::pwm::narx_pwm_command_t;
use crate::samples::narx_samples_t;
use crate::status::narx_status_t::{self, *};
use core::mem::{align_of, size_of};
use core::sync::atomic::{AtomicU32, Ordering};
use narx_core::bus::Frame;
use narx_core::device::{Background, ControlTick, Queues};
use narx_core::dictionary::{ParameterError, Parameters};
use narx_core::motor::{Board, Coefficients, PwmCommand, Samples};
use narx_core::node::{Identity, Node};

/// 64-bit words of a drive on any processor.
pub const NARX_DRIVE_WORDS: usize = 800;

/// Bytes of a drive on any processor; narx_drive_size tells what it needs on this one.
pub const NARX_DRIVE_SIZE: usize = NARX_DRIVE_WORDS * 8;

/// A drive: memory that the caller owns, static, on a stack or from a pool. Its content is the library's own. It must
/// neither move nor be copied after narx_drive_init; to end a drive, stop calling it.
#[repr(C)]
pub struct narx_drive_t {
    /// Private.
    words: [u64; NARX_DRIVE_WORDS],
}

/// A parameter that was stored.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_stored_t {
    /// Its number: a NARX_PARAMETER_*.
    pub number: u16,
    /// Its raw value.
    pub value: i32,
}

/// What firmware and board say of themselves (BUILD_INFO, DEVICE_INFO, parameters 4 to 7).
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

/// What stands in a `narx_drive_t`.
#[repr(C)]
struct Device {
    /// Says that the rest is there, and that it was made here.
    mark: AtomicU32,
    queues: Queues<'static>,
    tick: ControlTick<'static, 'static>,
    background: Background<'static, 'static>,
}

const _: () = assert!(size_of::<Device>() <= size_of::<narx_drive_t>());
const _: () = assert!(align_of::<Device>() <= align_of::<narx_drive_t>());

/// Bytes that a drive needs on this processor: at most NARX_DRIVE_SIZE. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_drive_size() -> usize {
    size_of::<Device>()
}

/// Alignment that a drive needs on this processor: at most that of narx_drive_t. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_drive_align() -> usize {
    align_of::<Device>()
}

/// Makes a drive at power-up, with factory parameters, in `size` bytes of memory (sizeof(narx_drive_t), or
/// narx_drive_size() in memory of your own). `board` is NULL for the default board. What stood in the memory before is lost, a drive
/// included: this is its reboot.
///
/// Call it before any other use, not during another call for the same drive. A narx_drive_step that interrupts it
/// answers NARX_ERROR_UNINITIALISED and coast.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_init(
    drive: *mut narx_drive_t,
    size: usize,
    board: *const narx_board_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { init(drive, size, board, Identity::default(), Parameters::new()) })
}

/// The same with what you have stored and who you are: `count` parameters, which may be NULL for none, and `identity`, which may be NULL.
/// A set as a whole is taken or, for NARX_ERROR_UNKNOWN_PARAMETER and NARX_ERROR_OUT_OF_RANGE, refused: the memory is as it was. A set that is taken and
/// does not build leaves a drive that refuses to start: NARX_PARAMETER_REJECTED_PARAMETER says for which parameter.
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
        let mut parameters = Parameters::new();
        if count > 0 {
            for narx_stored_t { number, value } in pointer::slice(stored, count)? {
                parameters.set(*number, *value)?;
            }
        }
        init(drive, size, board, identity, parameters)
    };
    pointer::status(run())
}

/// One control tick: takes the samples of this period and answers what to apply. Tick half: call it from the control
/// interrupt, once a PWM period; it may interrupt every other call for the same drive but narx_drive_init and itself.
///
/// On an error the command, if there is one to write, is coast at duty 0: a caller who overlooks the status turns the
/// bridge off.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_step(
    drive: *mut narx_drive_t,
    samples: *const narx_samples_t,
    command: *mut narx_pwm_command_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(command)?;
        let samples = Samples::try_from(pointer::read(samples)?)?;
        Ok(tick(drive)?.step(&samples))
    };
    let (answer, status) = match run() {
        Ok(answer) => (answer, NARX_OK),
        Err(error) => (PwmCommand::default(), error),
    };
    // SAFETY: the rule for pointers at the head of narx.h.
    match unsafe { pointer::write(command, answer.into()) } {
        Ok(()) => status,
        Err(error) => error,
    }
}

/// Takes a frame that has arrived. Frames that are not for this drive, or not well formed, are counted or ignored as
/// PROTOCOL.md says. Background half.
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

/// Advances the drive's background to the control tick `now` and passes on what has come from the tick and what goes
/// there. Call it once a period or more seldom, after narx_drive_handle_frame and before narx_drive_poll_frame.
/// Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_run(drive: *mut narx_drive_t, now: u64) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { background(drive) }.map(|background| background.run(now)))
}

/// The next frame to send, or NARX_NOTHING. Call it until there is nothing. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_poll_frame(
    drive: *mut narx_drive_t,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { poll(drive, frame, Node::poll_frame) }
}

/// The next frame of a download that the master has asked for, or NARX_NOTHING; nothing while narx_drive_poll_frame has
/// frames. Call it when no more than one frame is in the controller, the one that is on the bus: more would delay what
/// the drive has to say next. A program that never calls it serves no downloads. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_poll_bulk_frame(
    drive: *mut narx_drive_t,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { poll(drive, frame, Node::poll_bulk_frame) }
}

/// Writes a parameter as the master does: number, access, range and state are checked, then it acts as PROTOCOL.md
/// says. `value` is the raw value: its unit and scale stand there, too; a 32-bit unsigned one is passed as its bits.
/// Background half.
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

/// Reads a parameter, raw as in narx_drive_set_parameter, live ones included. Background half.
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
/// As the calls that it is the body of.
unsafe fn poll(
    drive: *mut narx_drive_t,
    frame: *mut narx_frame_t,
    next: fn(&mut Node) -> Option<Frame>,
) -> narx_status_t {
    // SAFETY: the caller's promise.
    let run = || unsafe {
        let background = background(drive)?;
        // A frame that cannot be handed out stays.
        pointer::check(frame)?;
        let sent = next(background.node()).ok_or(NARX_NOTHING)?;
        pointer::write(frame, sent.into())
    };
    pointer::status(run())
}

/// # Safety
/// `drive` and `board` are NULL or valid, and nobody else uses the drive.
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
    let board = if board.is_null() { Board::BENCH } else { unsafe { pointer::read(board)? }.into() };
    // With the factory's parameters a controller can be built for any board that can be.
    if !board.is_plausible() || Coefficients::build(&Parameters::new(), &board).is_err() {
        return Err(NARX_ERROR_BOARD);
    }
    // SAFETY: aligned and large enough, as just checked; each part is written before a reference to it is made, and the
    // reference to the queues goes to the two halves for as long as the mark stands.
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

/// The tick half.
///
/// # Safety
/// `drive` is NULL or valid, and no other reference to the tick half lives.
unsafe fn tick<'a>(drive: *mut narx_drive_t) -> Result<&'a mut ControlTick<'static, 'static>, narx_status_t> {
    let device = initialised(drive)?;
    // SAFETY: the mark says that it was written; a reference to this part only.
    Ok(unsafe { &mut (*device).tick })
}

/// The background half.
///
/// # Safety
/// `drive` is NULL or valid, and no other reference to the background half lives.
pub(crate) unsafe fn background<'a>(
    drive: *mut narx_drive_t,
) -> Result<&'a mut Background<'static, 'static>, narx_status_t> {
    let device = initialised(drive)?;
    // SAFETY: the mark says that it was written; a reference to this part only.
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

/// The halves know where the queues are, so a drive that was moved or copied is none: the mark depends on the address.
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
