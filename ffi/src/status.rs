//! Results of the calls.

use core::ffi::{CStr, c_char};
use narx_core::bus::narmotion::ParameterStatus;
use narx_core::recording::{ReadError, ReplayError};

/// Result of every call: 0 or more if the call did its work, negative if it did nothing.
/// cbindgen:rename-all=None
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum narx_status_t {
    /// Done.
    NARX_OK = 0,
    /// Done; there is nothing to hand out.
    NARX_NOTHING = 1,
    /// A required pointer is NULL.
    NARX_ERROR_NULL = -1,
    /// A pointer is not aligned as its type requires.
    NARX_ERROR_ALIGNMENT = -2,
    /// The storage is too small: see the size function of its type.
    NARX_ERROR_SIZE = -3,
    /// The storage holds no object of its type: it was not initialised, or a drive was moved since.
    NARX_ERROR_UNINITIALISED = -4,
    /// No working controller can be built from the board's constants.
    NARX_ERROR_BOARD = -5,
    /// A field of the samples has an undefined value.
    NARX_ERROR_SAMPLES = -6,
    /// Not a CAN frame: identifier or length out of range.
    NARX_ERROR_FRAME = -7,
    /// No parameter has this number.
    NARX_ERROR_UNKNOWN_PARAMETER = -8,
    /// Only the drive writes this parameter.
    NARX_ERROR_READ_ONLY = -9,
    /// The value is outside the parameter's range (PROTOCOL.md).
    NARX_ERROR_OUT_OF_RANGE = -10,
    /// The parameter cannot be written in this state.
    NARX_ERROR_WRONG_STATE = -11,
    /// The parameter store is missing, busy or failed.
    NARX_ERROR_STORAGE = -12,
    /// The bytes do not begin like a recording.
    NARX_ERROR_NOT_A_RECORDING = -13,
    /// The recording's container has another version.
    NARX_ERROR_CONTAINER_VERSION = -14,
    /// The recording holds a drive with another layout of its state.
    NARX_ERROR_LAYOUT_VERSION = -15,
    /// The recording is not one of a drive.
    NARX_ERROR_KIND = -16,
    /// The recording ends too early.
    NARX_ERROR_TRUNCATED = -17,
    /// Bytes of the recording were changed, lost or moved.
    NARX_ERROR_CHECKSUM = -18,
    /// The recording has a field that no recorder writes.
    NARX_ERROR_MALFORMED = -19,
    /// The recording's initial state is not one of this drive.
    NARX_ERROR_STATE = -20,
    /// Not a message of this protocol: identifier, type or length do not fit.
    NARX_ERROR_NOT_A_MESSAGE = -21,
    /// A field of the message has an undefined value.
    NARX_ERROR_FIELD = -22,
    /// An undefined request, or an undefined value for it.
    NARX_ERROR_REQUEST = -23,
    /// The master is silent: it transmits nothing.
    NARX_ERROR_SILENT = -24,
    /// Earlier answers were not taken yet, or earlier messages wait for the bus.
    NARX_ERROR_FULL = -25,
    /// No answer after all attempts.
    NARX_ERROR_NO_ANSWER = -26,
    /// The drive has refused a message to which the protocol has no answer.
    NARX_ERROR_NOT_OBEYED = -27,
    /// The drive has no log memory.
    NARX_ERROR_NO_LOG = -28,
    /// A record of the log was received whole, but its content is damaged.
    NARX_ERROR_SPOILED = -29,
    /// The download was aborted, or the job was ended by another command.
    NARX_ERROR_ABORTED = -30,
    /// The node-id is not 1 to 127.
    NARX_ERROR_NODE = -31,
    /// No TX-Driver has these channels, sample rate or measuring range.
    NARX_ERROR_VARIANT = -32,
    /// No entry has this number.
    NARX_ERROR_UNKNOWN_ENTRY = -33,
    /// The node refuses to read or write the entry.
    NARX_ERROR_ENTRY = -34,
    /// The node refused to read or write the entry.
    NARX_ERROR_BUS_STATE = -35,
    /// A block cannot be built from its settings; narx_setting_error_t names the setting.
    NARX_ERROR_SETTING = -36,
    /// An argument has an undefined value.
    NARX_ERROR_ARGUMENT = -37,
    /// The drive would clamp this set-point: narx_master_speed_limits.
    NARX_ERROR_SPEED = -38,
    /// The board lacks equipment that the value needs (narx_board_t, equipment).
    NARX_ERROR_NOT_EQUIPPED = -39,
    /// The drive is in Fault.
    NARX_ERROR_FAULT = -40,
    /// The drive refuses the start.
    NARX_ERROR_START_REFUSED = -41,
    /// The job has taken too long.
    NARX_ERROR_TIMED_OUT = -42,
    /// The hall calibration has not found the sensors.
    NARX_ERROR_NOT_CALIBRATED = -43,
    /// The scope is not armed or forced: it is in another state, or the drive refuses it.
    NARX_ERROR_SCOPE_REFUSED = -44,
    /// No working controller can be built from the parameters; narx_parameter_error_t names one.
    NARX_ERROR_PARAMETERS = -45,
    /// No current flows: no motor is connected, or one of its phases is open.
    NARX_ERROR_NO_MOTOR = -46,
    /// Two phases of the motor are shorted, or the bridge has less resistance than was said.
    NARX_ERROR_SHORT = -47,
    /// The supply cannot hold its voltage under load.
    NARX_ERROR_SAGS = -48,
    /// The record fits no motor: something moves the shaft, or holds it.
    NARX_ERROR_UNSTEADY = -49,
    /// The terminals show no back-EMF: the rotor does not turn.
    NARX_ERROR_NO_BACK_EMF = -50,
    /// The motor does not reach the speed of the identification.
    NARX_ERROR_NOT_REACHED = -51,
    /// The supply leaves the motor no room to accelerate.
    NARX_ERROR_NO_ROOM = -52,
    /// The drive cannot run this motor on this supply.
    NARX_ERROR_COMMISSIONING = -53,
}

use narx_status_t::*;

/// Returns the version of the library, "major.minor.patch": a constant string.
#[unsafe(no_mangle)]
pub extern "C" fn narx_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => c"",
        };
    VERSION.as_ptr()
}

/// Returns a status in words, for a log: a constant string, never NULL, whatever the number.
#[unsafe(no_mangle)]
pub extern "C" fn narx_status_text(status: i32) -> *const c_char {
    let known = ALL.iter().find(|known| **known as i32 == status);
    known.map_or(c"unknown status", |known| text(*known)).as_ptr()
}

const ALL: [narx_status_t; 55] = [
    NARX_OK,
    NARX_NOTHING,
    NARX_ERROR_NULL,
    NARX_ERROR_ALIGNMENT,
    NARX_ERROR_SIZE,
    NARX_ERROR_UNINITIALISED,
    NARX_ERROR_BOARD,
    NARX_ERROR_SAMPLES,
    NARX_ERROR_FRAME,
    NARX_ERROR_UNKNOWN_PARAMETER,
    NARX_ERROR_READ_ONLY,
    NARX_ERROR_OUT_OF_RANGE,
    NARX_ERROR_WRONG_STATE,
    NARX_ERROR_STORAGE,
    NARX_ERROR_NOT_A_RECORDING,
    NARX_ERROR_CONTAINER_VERSION,
    NARX_ERROR_LAYOUT_VERSION,
    NARX_ERROR_KIND,
    NARX_ERROR_TRUNCATED,
    NARX_ERROR_CHECKSUM,
    NARX_ERROR_MALFORMED,
    NARX_ERROR_STATE,
    NARX_ERROR_NOT_A_MESSAGE,
    NARX_ERROR_FIELD,
    NARX_ERROR_REQUEST,
    NARX_ERROR_SILENT,
    NARX_ERROR_FULL,
    NARX_ERROR_NO_ANSWER,
    NARX_ERROR_NOT_OBEYED,
    NARX_ERROR_NO_LOG,
    NARX_ERROR_SPOILED,
    NARX_ERROR_ABORTED,
    NARX_ERROR_NODE,
    NARX_ERROR_VARIANT,
    NARX_ERROR_UNKNOWN_ENTRY,
    NARX_ERROR_ENTRY,
    NARX_ERROR_BUS_STATE,
    NARX_ERROR_SETTING,
    NARX_ERROR_ARGUMENT,
    NARX_ERROR_SPEED,
    NARX_ERROR_NOT_EQUIPPED,
    NARX_ERROR_FAULT,
    NARX_ERROR_START_REFUSED,
    NARX_ERROR_TIMED_OUT,
    NARX_ERROR_NOT_CALIBRATED,
    NARX_ERROR_SCOPE_REFUSED,
    NARX_ERROR_PARAMETERS,
    NARX_ERROR_NO_MOTOR,
    NARX_ERROR_SHORT,
    NARX_ERROR_SAGS,
    NARX_ERROR_UNSTEADY,
    NARX_ERROR_NO_BACK_EMF,
    NARX_ERROR_NOT_REACHED,
    NARX_ERROR_NO_ROOM,
    NARX_ERROR_COMMISSIONING,
];

const fn text(status: narx_status_t) -> &'static CStr {
    match status {
        NARX_OK => c"done",
        NARX_NOTHING => c"nothing to hand out",
        NARX_ERROR_NULL => c"a pointer is NULL",
        NARX_ERROR_ALIGNMENT => c"a pointer is misaligned",
        NARX_ERROR_SIZE => c"the storage is too small",
        NARX_ERROR_UNINITIALISED => c"the storage holds nothing of its type, or a drive that was moved",
        NARX_ERROR_BOARD => c"no working controller can be built from the board's constants",
        NARX_ERROR_SAMPLES => c"a field of the samples has an undefined value",
        NARX_ERROR_FRAME => c"not a CAN frame: identifier or length out of range",
        NARX_ERROR_UNKNOWN_PARAMETER => c"no parameter has this number",
        NARX_ERROR_READ_ONLY => c"only the drive writes this parameter",
        NARX_ERROR_OUT_OF_RANGE => c"the value is outside the parameter's range",
        NARX_ERROR_WRONG_STATE => c"the parameter cannot be written in this state",
        NARX_ERROR_STORAGE => c"the parameter store is missing, busy or failed",
        NARX_ERROR_NOT_A_RECORDING => c"not a narx recording",
        NARX_ERROR_CONTAINER_VERSION => c"a recording in a container of another version",
        NARX_ERROR_LAYOUT_VERSION => c"a recording of a drive with another layout",
        NARX_ERROR_KIND => c"not a recording of a drive",
        NARX_ERROR_TRUNCATED => c"the recording ends too early",
        NARX_ERROR_CHECKSUM => c"the recording is corrupt: a check value differs",
        NARX_ERROR_MALFORMED => c"the recording is corrupt: a field that no recorder writes",
        NARX_ERROR_STATE => c"the recording's initial state is not one of this drive",
        NARX_ERROR_NOT_A_MESSAGE => c"not a message of this protocol",
        NARX_ERROR_FIELD => c"a field of the message has an undefined value",
        NARX_ERROR_REQUEST => c"undefined request, or undefined value for it",
        NARX_ERROR_SILENT => c"the master is silent",
        NARX_ERROR_FULL => c"earlier answers were not taken yet",
        NARX_ERROR_NO_ANSWER => c"no answer",
        NARX_ERROR_NOT_OBEYED => c"the drive has refused the request",
        NARX_ERROR_NO_LOG => c"the drive has no log memory",
        NARX_ERROR_SPOILED => c"a record of the log is damaged",
        NARX_ERROR_ABORTED => c"aborted",
        NARX_ERROR_NODE => c"the node-id must be 1 to 127",
        NARX_ERROR_VARIANT => c"no such TX-Driver: channels, sample rate or measuring range",
        NARX_ERROR_UNKNOWN_ENTRY => c"no entry has this number",
        NARX_ERROR_ENTRY => c"the node refuses to read or write the entry",
        NARX_ERROR_BUS_STATE => c"no such state of a CAN controller",
        NARX_ERROR_SETTING => c"a setting is out of its range",
        NARX_ERROR_NOT_EQUIPPED => c"the board lacks equipment that the value needs",
        NARX_ERROR_ARGUMENT => c"an argument has an undefined value",
        NARX_ERROR_FAULT => c"the drive is in Fault",
        NARX_ERROR_START_REFUSED => c"the drive refuses the start",
        NARX_ERROR_TIMED_OUT => c"the job has taken too long",
        NARX_ERROR_NOT_CALIBRATED => c"the hall calibration has not found the sensors",
        NARX_ERROR_SCOPE_REFUSED => c"the scope is not armed or forced",
        NARX_ERROR_PARAMETERS => c"no working controller can be built from the parameters",
        NARX_ERROR_SPEED => c"the set-point is beyond the drive's limits",
        NARX_ERROR_NO_MOTOR => c"no current flows: no motor is connected, or one of its phases is open",
        NARX_ERROR_SHORT => c"two phases are shorted, or the bridge has less resistance than was said",
        NARX_ERROR_SAGS => c"the supply cannot hold its voltage under load",
        NARX_ERROR_UNSTEADY => c"what was recorded fits no motor: something moves the shaft, or holds it",
        NARX_ERROR_NO_BACK_EMF => c"the terminals show no back-EMF: the rotor does not turn",
        NARX_ERROR_NOT_REACHED => c"the motor does not reach the speed of the identification",
        NARX_ERROR_NO_ROOM => c"the supply leaves the motor no room to accelerate",
        NARX_ERROR_COMMISSIONING => c"the drive cannot run this motor on this supply",
    }
}

impl From<ParameterStatus> for narx_status_t {
    fn from(status: ParameterStatus) -> Self {
        match status {
            ParameterStatus::Done => NARX_OK,
            ParameterStatus::UnknownNumber => NARX_ERROR_UNKNOWN_PARAMETER,
            ParameterStatus::ReadOnly => NARX_ERROR_READ_ONLY,
            ParameterStatus::OutOfRange => NARX_ERROR_OUT_OF_RANGE,
            ParameterStatus::WrongState => NARX_ERROR_WRONG_STATE,
            ParameterStatus::Storage => NARX_ERROR_STORAGE,
            ParameterStatus::NotEquipped => NARX_ERROR_NOT_EQUIPPED,
        }
    }
}

impl From<ReplayError> for narx_status_t {
    fn from(error: ReplayError) -> Self {
        match error {
            ReplayError::State | ReplayError::Features { .. } => NARX_ERROR_STATE,
            ReplayError::Read(error) => match error {
                ReadError::NotARecording => NARX_ERROR_NOT_A_RECORDING,
                ReadError::ContainerVersion { .. } => NARX_ERROR_CONTAINER_VERSION,
                ReadError::LayoutVersion { .. } => NARX_ERROR_LAYOUT_VERSION,
                ReadError::Kind { .. } => NARX_ERROR_KIND,
                ReadError::Truncated { .. } => NARX_ERROR_TRUNCATED,
                ReadError::Checksum { .. } => NARX_ERROR_CHECKSUM,
                ReadError::Malformed { .. }
                | ReadError::TickCount { .. }
                | ReadError::TrailingBytes { .. } => NARX_ERROR_MALFORMED,
            },
        }
    }
}
