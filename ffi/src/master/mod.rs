//! Master of one drive.

mod download;
mod job;
mod requests;

pub use download::{
    narx_chunk_t, narx_download_kind_t, narx_master_abort_download, narx_master_download,
    narx_master_poll_chunk, narx_master_poll_download,
};
pub use job::{
    narx_job_failure_t, narx_job_kind_t, narx_master_abort_record, narx_master_begin,
    narx_master_begin_record, narx_master_poll_job, narx_master_poll_record, narx_scope_setup_t,
};
pub use requests::{
    narx_answer_t, narx_master_poll_answer, narx_master_request, narx_request_kind_t, narx_request_t,
};

use crate::frame::narx_frame_t;
use crate::handle::{self, Handle};
use crate::message::{self, narx_message_t};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::bus::narmotion::{Addresses, FromDrive, Opcode};
use narx_core::master::{Config, Master, Received, SpeedLimit, SpeedLimits};

/// 64-bit words of a master on any processor.
pub const NARX_MASTER_WORDS: usize = 552;

/// The master of one drive: memory that the caller owns. Its content is private to the library; it may be
/// copied and moved between calls. Calls for one master must not interrupt each other; different masters
/// share nothing.
#[repr(C)]
pub struct narx_master_t {
    /// Private.
    words: [u64; NARX_MASTER_WORDS],
}

const _: () = handle::assert_fits::<narx_master_t>();

impl Handle for narx_master_t {
    type Object = Master;
    const MARK: u32 = u32::from_be_bytes(*b"nxMa");
}

/// Configuration of a master. Times in microseconds.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_master_config_t {
    /// Period of the set-points, at least 1 000; default 50 000.
    pub setpoint_period: u64,
    /// Longest time until an answer, at least 1 000; default 100 000.
    pub timeout: u64,
    /// Silence after which the drive counts as lost; default 500 000.
    pub lost_after: u64,
    /// CAN address of the drive; default 170.
    pub drive: u8,
    /// CAN address of the master; default 85.
    pub master: u8,
    /// Not 0: listens only and transmits nothing; default 0.
    pub silent: u8,
    /// Not 0: reads every parameter when the first frame of the drive is received, and after it was lost;
    /// default 1.
    pub read_parameters: u8,
    /// Number of times that a message is sent before it counts as not answered; default 3.
    pub attempts: u8,
}

/// State of a drive, from its last messages.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_drive_report_t {
    /// Not 0: a frame of the drive was received within `lost_after` of narx_master_config_t, or within three
    /// of its broadcast periods if that is longer.
    pub connected: u8,
    /// State: a narx_state_t, or 255 while unknown.
    pub state: u8,
    /// Motor mode of the last STATUS_WORD: a narx_motor_mode_t, or 255 before the first.
    pub motor_mode: u8,
    /// Control mode of the last STATUS_WORD: a narx_control_mode_t, or 255 before the first.
    pub control_mode: u8,
    /// Set-point that the drive uses, rpm; 0 before the drive sent one.
    pub accepted_speed: u16,
    /// Estimated mechanical speed, rpm, negative in reverse; 0 before the first.
    pub speed: i16,
    /// Live and latched faults: sum of NARX_FAULT_*.
    pub faults: u32,
    /// Critical faults of the last CRITICAL_FAULT.
    pub critical: u32,
    /// Extended fault code of that CRITICAL_FAULT: NARX_CAUSE_*.
    pub cause: u16,
}

/// Writes the default configuration, with the values of Figure 9 of the specification, as a start for your
/// own.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_config_default(config: *mut narx_master_config_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { pointer::write(config, Config::default().into()) })
}

/// Returns the bytes that a master needs on this processor: at most sizeof(narx_master_t). Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_master_size() -> usize {
    handle::size::<narx_master_t>()
}

/// Makes a master without a command yet in `size` bytes of memory: sizeof(narx_master_t), or
/// narx_master_size() of your own. `config` may be NULL for the default. The master sends set-points of 0,
/// which keep measurements coming, but neither stop a motor nor acknowledge a fault. A drive whose motor
/// another master has started gets none: they would keep the motor turning after that master is gone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_init(
    master: *mut narx_master_t,
    size: usize,
    config: *const narx_master_config_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let config = if config.is_null() { Config::default() } else { Config::from(pointer::read(config)?) };
        handle::init(master, size, || Ok(Master::new(config)))
    };
    pointer::status(run())
}

/// Takes a frame that arrived at `now`, microseconds. Frames of other nodes are ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_handle_frame(
    master: *mut narx_master_t,
    frame: *const narx_frame_t,
    now: u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::handle_frame(master, frame, |master, frame| master.handle_frame(frame, now)) }
}

/// Writes the next frame that is due at `now`, microseconds, or returns NARX_NOTHING. Call it until it
/// returns NARX_NOTHING, at the latest at the time of narx_master_next_poll.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_poll_frame(
    master: *mut narx_master_t,
    now: u64,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::poll(master, frame, |master| Some(master.poll_frame(now)?.into())) }
}

/// Writes the latest time of the next poll, microseconds, if no frame arrives and nothing is requested until
/// then; UINT64_MAX for never.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_next_poll(
    master: *mut narx_master_t,
    now: u64,
    at: *mut u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe {
        handle::object(master).and_then(|master| pointer::write(at, master.next_poll(now)))
    })
}

/// Requests a start at a speed, mechanical rpm, negative in reverse, and repeats the request every period. A
/// drive accepts a start only if it received Standby since it last stopped: call narx_master_stop first, or
/// use narx_master_begin, which does so and reports the result. Returns NARX_ERROR_SPEED for a speed outside
/// the limits of narx_master_speed_limits, or, before these were received, outside the range of MOTOR_CMD.
/// Open loop runs at parameter 88, whatever speed is requested. `accepted_speed` of narx_master_report is the
/// speed that the drive uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_start(master: *mut narx_master_t, rpm: i32) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = |master: &mut Master| {
        check_speed(master, rpm)?;
        master.start(rpm);
        Ok(())
    };
    unsafe { handle::call(master, run) }
}

/// Requests another speed in the same direction, rpm. Returns NARX_ERROR_SPEED as narx_master_start does.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_set_speed(master: *mut narx_master_t, rpm: u16) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = |master: &mut Master| {
        check_speed(master, rpm.into())?;
        master.set_speed(rpm);
        Ok(())
    };
    unsafe { handle::call(master, run) }
}

/// Set-points that the drive accepts unchanged, and the parameters that state them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_speed_limits_t {
    /// Smallest magnitude, rpm.
    pub min: u16,
    /// Largest magnitude, rpm.
    pub max: u16,
    /// Number of the parameter of `min`: 102, 104, or 88 in open loop; 65 535 while no mode is enabled.
    pub min_parameter: u16,
    /// Number of the parameter of `max`: 101, 103, or 88 in open loop; 65 535 while no mode is enabled.
    pub max_parameter: u16,
}

/// Writes the limits of the set-point in the mode that the drive's parameters enable. Returns NARX_NOTHING
/// before those parameters were received (78, 81 to 83, and those of narx_speed_limits_t); `read_parameters`
/// of narx_master_config_t makes the master read them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_speed_limits(
    master: *mut narx_master_t,
    limits: *mut narx_speed_limits_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::poll(master, limits, |master| Some(master.speed_limits()?.into())) }
}

impl From<SpeedLimits> for narx_speed_limits_t {
    fn from(SpeedLimits { min, max }: SpeedLimits) -> Self {
        let number = |limit: SpeedLimit| limit.parameter.unwrap_or(u16::MAX);
        Self { min: min.rpm, max: max.rpm, min_parameter: number(min), max_parameter: number(max) }
    }
}

/// Checks a set-point. In open loop every set-point passes: the drive runs at a fixed speed.
fn check_speed(master: &Master, rpm: i32) -> Result<(), narx_status_t> {
    master.check_speed(rpm).or_else(|error| if error.is_fixed() { Ok(()) } else { Err(NARX_ERROR_SPEED) })
}

/// Requests Standby, which also acknowledges a fault.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_stop(master: *mut narx_master_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(master) }.map(Master::stop))
}

/// Requests a shutdown (motor mode 3): fault bit 28.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_shut_down(master: *mut narx_master_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(master) }.map(Master::shut_down))
}

/// Writes the state of the drive as known at `now`, microseconds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_report(
    master: *mut narx_master_t,
    now: u64,
    report: *mut narx_drive_report_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe {
        handle::object(master).and_then(|master| pointer::write(report, self::report(master, now)))
    })
}

/// Writes the last measurement frame of one kind, NARX_MESSAGE_MEASUREMENT_0 to _8, as a message, and the
/// time of its reception (microseconds; `at` may be NULL). Returns NARX_NOTHING before the first.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_measurement(
    master: *mut narx_master_t,
    kind: u16,
    message: *mut narx_message_t,
    at: *mut u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        let opcode = Opcode::new(kind).ok_or(NARX_ERROR_NOT_A_MESSAGE)?;
        let Received { value, at: when } = master.measurements().frame(opcode).ok_or(NARX_NOTHING)?;
        let frame = FromDrive::Measurement(value).encode(master.config().addresses);
        pointer::write(message, message::decode(&frame)?)?;
        pointer::write_unless_null(at, when)
    };
    pointer::status(run())
}

/// Writes the value of a parameter as last received, raw, and the time of its reception (microseconds; `at`
/// may be NULL). Returns NARX_NOTHING while it was not received. It sends nothing on the bus; to read a
/// parameter anew use NARX_REQUEST_KIND_READ.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_parameter(
    master: *mut narx_master_t,
    number: u16,
    value: *mut i32,
    at: *mut u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let received = handle::object(master)?.parameters().get(number).ok_or(NARX_NOTHING)?;
        pointer::write(value, received.value)?;
        pointer::write_unless_null(at, received.at)
    };
    pointer::status(run())
}

fn report(master: &Master, now: u64) -> narx_drive_report_t {
    const UNKNOWN: u8 = u8::MAX;
    let report = master.report();
    let status = report.status.map(|received| received.value);
    let critical = report.critical.map(|received| received.value);
    narx_drive_report_t {
        connected: master.is_connected(now).into(),
        state: master.state().map_or(UNKNOWN, |state| state as u8),
        motor_mode: status.map_or(UNKNOWN, |status| status.mode as u8),
        control_mode: status.map_or(UNKNOWN, |status| status.control as u8),
        accepted_speed: report.accepted_speed.map_or(0, |received| received.value),
        speed: master.speed().map_or(0, |received| received.value),
        faults: report.faults.map_or(0, |received| received.value.bits()),
        critical: critical.map_or(0, |critical| critical.faults.bits()),
        cause: critical.map_or(0, |critical| critical.code),
    }
}

impl From<Config> for narx_master_config_t {
    fn from(config: Config) -> Self {
        let Config {
            addresses: Addresses { drive, master },
            setpoint_period,
            silent,
            read_parameters,
            timeout,
            attempts,
            lost_after,
        } = config;
        let (silent, read_parameters) = (silent.into(), read_parameters.into());
        Self { setpoint_period, timeout, lost_after, drive, master, silent, read_parameters, attempts }
    }
}

impl From<&narx_master_config_t> for Config {
    fn from(config: &narx_master_config_t) -> Self {
        Self {
            addresses: Addresses { drive: config.drive, master: config.master },
            setpoint_period: config.setpoint_period,
            silent: config.silent != 0,
            read_parameters: config.read_parameters != 0,
            timeout: config.timeout,
            attempts: config.attempts,
            lost_after: config.lost_after,
        }
    }
}
