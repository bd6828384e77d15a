//! The other end of the bus: a master for one drive.

mod download;
mod requests;

pub use download::{
    narx_chunk_t, narx_download_kind_t, narx_master_abort_download, narx_master_download,
    narx_master_poll_chunk, narx_master_poll_download,
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
use narx_core::master::{Config, Heard, Master, SpeedLimit, SpeedLimits};

/// 64-bit words of a master on any processor.
pub const NARX_MASTER_WORDS: usize = 528;

/// The master of one drive: memory that the caller owns. Its content is the library's own; it may be copied and moved between calls.
/// Calls for one master must not interrupt each other; different masters have nothing in common.
#[repr(C)]
pub struct narx_master_t {
    /// Private.
    words: [u64; NARX_MASTER_WORDS],
}

const _: () = assert!(handle::fits::<narx_master_t>());

impl Handle for narx_master_t {
    type Object = Master;
    const MARK: u32 = u32::from_be_bytes(*b"nxMa");
}

/// How a master talks. Times in microseconds.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_master_config_t {
    /// Between two set-points, at least 1 000; 50 000.
    pub setpoint_period: u64,
    /// How long an answer may take, at least 1 000; 100 000.
    pub timeout: u64,
    /// A drive that has said nothing for so long is lost; 500 000.
    pub lost_after: u64,
    /// CAN address of the drive; 170.
    pub drive: u8,
    /// CAN address of the master; 85.
    pub master: u8,
    /// Not 0: transmits nothing and hears everything.
    pub silent: u8,
    /// Not 0: reads every parameter when the drive is first heard, and after it was lost; 1.
    pub read_parameters: u8,
    /// How often a message is sent before it counts as not answered; 3.
    pub attempts: u8,
}

/// What a master knows of its drive.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_drive_report_t {
    /// Not 0: the drive was heard lately.
    pub connected: u8,
    /// A narx_state_t, or 255 while it is not known.
    pub state: u8,
    /// Motor mode of the last STATUS_WORD: a narx_motor_mode_t, or 255 before the first.
    pub motor_mode: u8,
    /// Control mode of the last STATUS_WORD: a narx_control_mode_t, or 255 before the first.
    pub control_mode: u8,
    /// The set-point that the drive uses, rpm; 0 before it said one.
    pub accepted_speed: u16,
    /// Estimated mechanical speed, rpm, negative in reverse; 0 before the first.
    pub speed: i16,
    /// Live and latched faults: sum of NARX_FAULT_*.
    pub faults: u32,
    /// Critical faults of the last CRITICAL_FAULT.
    pub critical: u32,
    /// Its extended fault code: NARX_CAUSE_*.
    pub cause: u16,
}

/// A master at power-up as Figure 9 of the specification has it, to change what differs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_config_default(config: *mut narx_master_config_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { pointer::write(config, Config::default().into()) })
}

/// Bytes that a master needs on this processor: at most sizeof(narx_master_t). Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_master_size() -> usize {
    handle::size::<narx_master_t>()
}

/// Makes a master that has asked for nothing yet in `size` bytes of memory: sizeof(narx_master_t), or narx_master_size() of your own.
/// `config` may be NULL for the default. It sends set-points of 0, which keep measurements coming, and neither stops a motor nor
/// acknowledges a fault.
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

/// Takes a frame that arrived at `now`, microseconds. Frames of others are not heard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_handle_frame(
    master: *mut narx_master_t,
    frame: *const narx_frame_t,
    now: u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        handle::object(master)?.handle_frame(&pointer::read(frame)?.try_into()?, now);
        Ok(())
    };
    pointer::status(run())
}

/// The next frame that is due at `now`, microseconds, or NARX_NOTHING. Call it until there is nothing, at the latest when
/// narx_master_next_poll says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_poll_frame(
    master: *mut narx_master_t,
    now: u64,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        pointer::check(frame)?;
        pointer::write(frame, master.poll_frame(now).ok_or(NARX_NOTHING)?.into())
    };
    pointer::status(run())
}

/// When to poll again at the latest if no frame arrives and nothing is asked for until then, microseconds; UINT64_MAX for never.
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

/// Asks for a speed, mechanical rpm, negative in reverse, and repeats that as long as it holds. A drive takes a start once it has seen Standby since it last
/// stopped: narx_master_stop first. NARX_ERROR_SPEED for what is beyond the limits of narx_master_speed_limits, as far as they were heard; open loop
/// turns at parameter 88 whatever is asked for. What the drive uses is `accepted_speed` of narx_master_report.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_start(master: *mut narx_master_t, rpm: i32) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        check_speed(master, rpm)?;
        master.start(rpm);
        Ok(())
    };
    pointer::status(run())
}

/// Asks for another speed in the direction that was asked for, rpm. NARX_ERROR_SPEED as narx_master_start.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_set_speed(master: *mut narx_master_t, rpm: u16) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        check_speed(master, rpm.into())?;
        master.set_speed(rpm);
        Ok(())
    };
    pointer::status(run())
}

/// The set-points that the drive takes as they are, and the parameters that say so.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_speed_limits_t {
    /// Smallest magnitude, rpm.
    pub min: u16,
    /// Largest magnitude, rpm.
    pub max: u16,
    /// Number of the parameter of `min`: 102, 104, or 88 in open loop; 65 535 while no mode is enabled.
    pub min_parameter: u16,
    /// Number of the parameter of `max`: 101, 103, or 88; 65 535 likewise.
    pub max_parameter: u16,
}

/// Limits of the set-point in the mode that the drive's parameters enable; NARX_NOTHING before they were heard (78, 81 to 83, and those of
/// narx_speed_limits_t): narx_master_config_t has `read_parameters` for that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_speed_limits(
    master: *mut narx_master_t,
    limits: *mut narx_speed_limits_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        pointer::check(limits)?;
        let SpeedLimits { min, max } = master.speed_limits().ok_or(NARX_NOTHING)?;
        let number = |limit: SpeedLimit| limit.parameter.unwrap_or(u16::MAX);
        let (min_parameter, max_parameter) = (number(min), number(max));
        let found = narx_speed_limits_t { min: min.rpm, max: max.rpm, min_parameter, max_parameter };
        pointer::write(limits, found)
    };
    pointer::status(run())
}

/// Open loop has a speed of its own, and is started by whatever is asked for.
fn check_speed(master: &Master, rpm: i32) -> Result<(), narx_status_t> {
    master.check_speed(rpm).or_else(|error| if error.is_fixed() { Ok(()) } else { Err(NARX_ERROR_SPEED) })
}

/// Asks for Standby, which also acknowledges a fault.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_stop(master: *mut narx_master_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(master) }.map(Master::stop))
}

/// Asks for a shutdown (motor mode 3): fault bit 28.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_shut_down(master: *mut narx_master_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(master) }.map(Master::shut_down))
}

/// What the drive has said of itself, as known at `now`, microseconds.
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

/// The last measurement frame of one kind, NARX_MESSAGE_MEASUREMENT_0 to _8, as a message, and when it came (microseconds; `at` may be NULL);
/// NARX_NOTHING before the first.
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
        let Heard { value, at: when } = master.measurements().frame(opcode).ok_or(NARX_NOTHING)?;
        let frame = FromDrive::Measurement(value).encode(master.config().addresses);
        pointer::write(message, message::decode(&frame)?)?;
        pointer::write_unless_null(at, when)
    };
    pointer::status(run())
}

/// A parameter as it was last heard, raw, and when (microseconds; `at` may be NULL); NARX_NOTHING while it was not. It asks nothing of the bus:
/// a NARX_REQUEST_KIND_READ does.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_parameter(
    master: *mut narx_master_t,
    number: u16,
    value: *mut i32,
    at: *mut u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let heard = handle::object(master)?.parameters().get(number).ok_or(NARX_NOTHING)?;
        pointer::write(value, heard.value)?;
        pointer::write_unless_null(at, heard.at)
    };
    pointer::status(run())
}

fn report(master: &Master, now: u64) -> narx_drive_report_t {
    const UNKNOWN: u8 = u8::MAX;
    let report = master.report();
    let status = report.status.map(|heard| heard.value);
    let critical = report.critical.map(|heard| heard.value);
    narx_drive_report_t {
        connected: master.is_connected(now).into(),
        state: master.state().map_or(UNKNOWN, |state| state as u8),
        motor_mode: status.map_or(UNKNOWN, |status| status.mode as u8),
        control_mode: status.map_or(UNKNOWN, |status| status.control as u8),
        accepted_speed: report.accepted_speed.map_or(0, |heard| heard.value),
        speed: master.speed().map_or(0, |heard| heard.value),
        faults: report.faults.map_or(0, |heard| heard.value.bits()),
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
