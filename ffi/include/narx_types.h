/**
 * @file
 * Types of narx.h, which includes this file. Made by `cargo xtask header`: do not edit.
 */

#ifndef NARX_TYPES_H
#define NARX_TYPES_H

#include "narx_tables.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Size of the name and the unit of a setting in narx_setting_error_t, the closing 0 included.
#define NARX_NAME_SIZE 24

/// Number of parameters that narx_commission writes.
#define NARX_COMMISSIONED 31

/// Number of parameters that narx_speed_loop writes.
#define NARX_SPEED_LOOP_PARAMETERS 6

/// 64-bit words of a drive on any processor.
#define NARX_DRIVE_WORDS 800

/// Bytes of a drive on any processor; narx_drive_size returns the bytes that it needs on this one.
#define NARX_DRIVE_SIZE (NARX_DRIVE_WORDS * 8)

/// Values that a TX-Driver keeps over a restart: those of the entries NARX_TX_ENTRY_NODE_ID to
/// _ENCODER_RESOLUTION, in their order.
#define NARX_TX_VALUES 12

/// 64-bit words of a TX-Driver on any processor.
#define NARX_TX_DRIVER_WORDS 56

/// 64-bit words of a TX-Driver's master on any processor.
#define NARX_TX_MASTER_WORDS 60

/// 1 in Q16 (I16F16), the library's volts, amperes, degrees Celsius and revolutions per second: -32 768 to
/// 32 767.99998.
#define NARX_Q16_ONE (1 << 16)

/// 1 in IQ24 (I8F24), as DSP libraries have it: -128 to 127.99999994.
#define NARX_IQ24_ONE (1 << 24)

/// 1 in Q15 (I1F15), which is one more than its largest value, 32 767: -1 to 0.99997.
#define NARX_Q15_ONE (1 << 15)

/// 1 in Q12 (I4F12), the virtual scope's samples: -8 to 7.9998.
#define NARX_Q12_ONE (1 << 12)

/// 1 in U1F15, a duty: 0 to 1.
#define NARX_DUTY_ONE (1 << 15)

/// 1 turn of an electrical angle, a wrapping uint16_t.
#define NARX_TURN (1 << 16)

/// 64-bit words of an identification on any processor.
#define NARX_IDENTIFICATION_WORDS 1512

/// 64-bit words of a master on any processor.
#define NARX_MASTER_WORDS 552

/// Rises whenever coefficients of an earlier library would be wrong for this one: what `narx coefficients`
/// prints compares it.
#define NARX_COEFFICIENTS_VERSION 15

/// Largest number of pattern changes in one period.
#define NARX_COMMUTATIONS_MAX 2

/// Size of the longest line that narx_replay_until writes, the closing 0 included.
#define NARX_OUTPUTS_TEXT_SIZE 1024

/// Largest number of edges in one period; more are counted in narx_samples_t.edges_lost.
#define NARX_EDGES_MAX 4

/// Bit of narx_samples_t.lines: the gate driver reports a fault.
#define NARX_LINE_DRIVER_FAULT 1

/// Bit of narx_samples_t.lines: the hardware break input has tripped.
#define NARX_LINE_EMERGENCY 2

/// Bit of narx_samples_t.lines: DSIO1 as an input.
#define NARX_LINE_DSI1 4

/// Bit of narx_samples_t.lines: DSIO2 as an input.
#define NARX_LINE_DSI2 8

/// 64-bit words of a scope's memory on any processor.
#define NARX_SCOPE_WORDS 1446

/// 64-bit words of a narx_storage_t on any processor.
#define NARX_STORAGE_WORDS 320

/// Largest number of bytes of one program call: a page, within which it stays.
#define NARX_FLASH_PAGE 256

/// Bytes of the smallest erase.
#define NARX_FLASH_SUBSECTOR 4096

/// Result of every call: 0 or more if the call did its work, negative if it did nothing.
enum narx_status_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
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
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_status_t narx_status_t;
#else
/// A value of the enumeration.
typedef int32_t narx_status_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A switch pattern: first letter switched (PWM), second held low, third phase floating.
enum narx_step_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// All six switches off.
    NARX_STEP_COAST,
    /// A switched, B low.
    NARX_STEP_AB,
    /// A switched, C low.
    NARX_STEP_AC,
    /// B switched, C low.
    NARX_STEP_BC,
    /// B switched, A low.
    NARX_STEP_BA,
    /// C switched, A low.
    NARX_STEP_CA,
    /// C switched, B low.
    NARX_STEP_CB,
    /// Three-phase lock: A switched, B and C low. Pulls the rotor to 180 degrees.
    NARX_STEP_LOCK_A,
    /// Three-phase lock: A and B switched, C low. Pulls to 240 degrees.
    NARX_STEP_LOCK_AB,
    /// Three-phase lock: B switched, C and A low. Pulls to 300 degrees.
    NARX_STEP_LOCK_B,
    /// Three-phase lock: B and C switched, A low. Pulls to 0 degrees.
    NARX_STEP_LOCK_BC,
    /// Three-phase lock: C switched, A and B low. Pulls to 60 degrees.
    NARX_STEP_LOCK_C,
    /// Three-phase lock: C and A switched, B low. Pulls to 120 degrees.
    NARX_STEP_LOCK_CA,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_step_t narx_step_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_step_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Which part of the PWM cycle the phase voltages show.
enum narx_sample_mode_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// In the off-time: referred to ground or to the mean of the three phases.
    NARX_SAMPLE_MODE_OFF_TIME,
    /// In the middle of the on-time: referred to half the bus voltage.
    NARX_SAMPLE_MODE_ON_TIME,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_sample_mode_t narx_sample_mode_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_sample_mode_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Freewheeling of a switched leg's current while its high side is off.
enum narx_rectification_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Through the low side's body diode. Current cannot reverse, so the motor cannot feed the bus.
    NARX_RECTIFICATION_DIODE,
    /// Through the low-side switch (complementary PWM with dead time): less loss, current may reverse.
    NARX_RECTIFICATION_SYNCHRONOUS,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_rectification_t narx_rectification_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_rectification_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// System states, numbered as the specification numbers them.
enum narx_state_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// 0: boot and self-tests, PWM off.
    NARX_STATE_INITIALIZATION = 0,
    /// 1: PWM off.
    NARX_STATE_STANDBY = 1,
    /// 2: holds the rotor at a known position.
    NARX_STATE_ROTOR_LOCK = 2,
    /// 3: rotates the field at a commanded speed.
    NARX_STATE_OPEN_LOOP = 3,
    /// 4: commutates on back-EMF zero crossings.
    NARX_STATE_SENSORLESS_CLOSED_LOOP = 4,
    /// 5: commutates on hall sensors.
    NARX_STATE_HALL_CLOSED_LOOP = 5,
    /// 6: PWM off until acknowledged.
    NARX_STATE_FAULT = 6,
    /// 7: tries to catch or restart a sensorless motor that has stopped.
    NARX_STATE_SENSORLESS_AUTO_RESTART = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_state_t narx_state_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_state_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// The meaning of the bus current's reading. Recordings keep it, but the drive ignores it and takes every
/// reading for [`CurrentMode::Average`].
enum narx_current_mode_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Mean DC-link current over the last period.
    NARX_CURRENT_MODE_AVERAGE,
    /// Sampled in the middle of the on-time: the phase current.
    NARX_CURRENT_MODE_ON_TIME,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_current_mode_t narx_current_mode_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_current_mode_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Source of an edge.
enum narx_edge_source_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// A hall line.
    NARX_EDGE_SOURCE_HALL,
    /// A back-EMF comparator.
    NARX_EDGE_SOURCE_COMPARATOR,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_edge_source_t narx_edge_source_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_edge_source_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Control mode for which a drive is commissioned.
enum narx_commissioning_mode_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Hall closed loop.
    NARX_COMMISSIONING_MODE_HALL = 0,
    /// Sensorless closed loop, through open loop.
    NARX_COMMISSIONING_MODE_SENSORLESS = 1,
    /// Open loop only.
    NARX_COMMISSIONING_MODE_OPEN_LOOP = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_commissioning_mode_t narx_commissioning_mode_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_commissioning_mode_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Part of an identification that is under way.
enum narx_identification_stage_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Reads what the drive is.
    NARX_IDENTIFICATION_STAGE_ASKS = 0,
    /// Holds the rotor: resistance and inductance.
    NARX_IDENTIFICATION_STAGE_HOLDS = 1,
    /// Turns the rotor and lets it coast: back-EMF constant.
    NARX_IDENTIFICATION_STAGE_SPINS = 2,
    /// Accelerates it and lets it coast: inertia and friction.
    NARX_IDENTIFICATION_STAGE_ACCELERATES = 3,
    /// Turns the rotor one electrical revolution each way: hall sensors.
    NARX_IDENTIFICATION_STAGE_CALIBRATES = 4,
    /// Stops the motor and restores the parameters.
    NARX_IDENTIFICATION_STAGE_RESTORES = 5,
    /// Turns the rotor slowly, in steps, and waits for narx_identification_mark: pole pairs. It comes after
    /// Holds.
    NARX_IDENTIFICATION_STAGE_COUNTS = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_identification_stage_t narx_identification_stage_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_identification_stage_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Data that can be downloaded.
enum narx_download_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The description of the drive, XML; the high byte of a word comes first.
    NARX_DOWNLOAD_KIND_DESCRIPTION = 0,
    /// The scope's record: `count` words, selected signals times samples, at most 65 536. Q3.12.
    NARX_DOWNLOAD_KIND_SCOPE = 1,
    /// `count` records of the log from index `first` on; each has half as many words as parameter 69 has
    /// bytes.
    NARX_DOWNLOAD_KIND_LOG = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_download_kind_t narx_download_kind_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_download_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A conversation of several messages.
enum narx_job_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Starts the motor as soon as the drive accepts a start; ends when it is in closed loop, or in open loop
    /// where no closed loop is enabled.
    NARX_JOB_KIND_START = 0,
    /// Calibrates the hall sensors: the motor turns one electrical revolution each way. Ends when it is at
    /// rest again.
    NARX_JOB_KIND_CALIBRATE_HALL = 1,
    /// Restarts a stopped drive; ends when it is in Standby or Fault again.
    NARX_JOB_KIND_REBOOT = 2,
    /// Sets the scope up and arms it.
    NARX_JOB_KIND_ARM_SCOPE = 3,
    /// Triggers the armed scope now.
    NARX_JOB_KIND_FORCE_SCOPE = 4,
    /// Waits until the scope's record is complete.
    NARX_JOB_KIND_AWAIT_SCOPE = 5,
    /// Arms the scope and waits for its record; without a trigger it forces the scope as soon as the samples
    /// before the trigger were taken.
    NARX_JOB_KIND_CAPTURE_SCOPE = 6,
    /// Erases the log; ends when that is done, after minutes for a full memory.
    NARX_JOB_KIND_ERASE_LOG = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_job_kind_t narx_job_kind_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_job_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Kind of a request to a drive.
enum narx_request_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Read parameter `number`.
    NARX_REQUEST_KIND_READ = 0,
    /// Write `value` to parameter `number`.
    NARX_REQUEST_KIND_WRITE = 1,
    /// Run the command parameter `number`: NARX_PARAMETER_STORE and others of its kind.
    NARX_REQUEST_KIND_RUN = 2,
    /// Read BUILD_INFO; its content is in the frame that answers: narx_message_decode.
    NARX_REQUEST_KIND_BUILD_INFO = 3,
    /// Read DEVICE_INFO; its content is in the frame that answers: narx_message_decode.
    NARX_REQUEST_KIND_DEVICE_INFO = 4,
    /// Restart the drive.
    NARX_REQUEST_KIND_REBOOT = 5,
    /// Restore factory values; `value` is the serial number of the addressed board.
    NARX_REQUEST_KIND_RESTORE_FACTORY = 6,
    /// Set the digital lines: `value` bit 0 enables DSIO1, bit 1 is its level, bits 2 and 3 are the same for
    /// DSIO2.
    NARX_REQUEST_KIND_DIGITAL_OUTPUTS = 7,
    /// Switch the hall supply off (`value` 1), or leave it to parameter 97 (0).
    NARX_REQUEST_KIND_DISABLE_HALL_SUPPLY = 8,
    /// Arm the scope; if it is armed, force its trigger.
    NARX_REQUEST_KIND_TRIGGER_SCOPE = 9,
    /// Read length and CRC-32 of the description; they are in the frame that answers: narx_message_decode.
    NARX_REQUEST_KIND_DESCRIPTION_INFO = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_request_kind_t narx_request_kind_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_request_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Kind of a message.
enum narx_tx_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Master: NMT command `command` to node `node`, or to all for 0: 1 start, 2 stop, 128 pre-operational,
    /// 129 reset.
    NARX_TX_KIND_NMT = 0,
    /// Master: SYNC; all nodes sample now and send PDO2.
    NARX_TX_KIND_SYNC = 1,
    /// Master: request to `node` for PDO3, of `size` bytes.
    NARX_TX_KIND_REQUEST_PDO = 2,
    /// Master: read request for entry `index`, `subindex` of `node`.
    NARX_TX_KIND_READ = 3,
    /// Master: request to write `value` to the entry `index`, `subindex` of `node`; `size` is 1 to 4 bytes,
    /// or 0 if only the node knows it.
    NARX_TX_KIND_WRITE = 4,
    /// Node: boot-up or heartbeat; `command` is its state: 0 boot-up, 4 Stopped, 5 Operational, 127
    /// Pre-Operational.
    NARX_TX_KIND_HEARTBEAT = 5,
    /// Node: an error; `value` is its code.
    NARX_TX_KIND_ERROR = 6,
    /// Node: PDO with `positions` and `encoder`, as far as the layout has them; `command` is the number of
    /// the PDO, 1 to 3.
    NARX_TX_KIND_PDO = 7,
    /// Node: the entry was written.
    NARX_TX_KIND_WRITTEN = 8,
    /// Node: the entry holds `value`, of `size` bytes.
    NARX_TX_KIND_VALUE = 9,
    /// Master or node: the request was refused or is aborted; `value` is the abort code (Table 10).
    NARX_TX_KIND_ABORT = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
/// A value of the enumeration.
typedef enum narx_tx_kind_t narx_tx_kind_t;
#else
/// A value of the enumeration.
typedef uint8_t narx_tx_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A commutation: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_commutator_t {
    /// Private.
    uint64_t words[4];
} narx_commutator_t;

/// Settings for narx_commutation_init.
typedef struct narx_commutation_settings_t {
    /// Timing advance, electrical, 0 to 3000 in 0.01 degree (parameter 273).
    uint16_t advance_cdeg;
    /// First instant of a period at which a new step can act, 1/65 536 of it: when the caller has its answer.
    uint16_t earliest;
} narx_commutation_settings_t;

/// A setting from which no block can be built.
typedef struct narx_setting_error_t {
    /// The rejected value.
    int64_t value;
    /// Smallest value that builds, with the other settings as they are.
    int64_t min;
    /// Largest value that builds.
    int64_t max;
    /// Fraction bits of the three values: 16 for a Q16, 0 for a count.
    uint8_t fraction_bits;
    /// Name of the setting: the name of its field.
    char setting[NARX_NAME_SIZE];
    /// Its unit, empty without one.
    char unit[NARX_NAME_SIZE];
} narx_setting_error_t;

/// Coefficients of the commutator.
typedef struct narx_commutator_coefficients_t {
    /// First instant of a period at which a pattern can change, in 1/65 536.
    uint16_t earliest;
    /// Timing advance, u32 turn (parameter 273).
    uint32_t advance;
} narx_commutator_coefficients_t;

/// One pattern change.
typedef struct narx_commutation_t {
    /// Instant of the change, in 1/65 536 of the period.
    uint16_t instant;
    /// Pattern from then on.
    narx_step_t step;
} narx_commutation_t;

/// The steps of one period.
typedef struct narx_steps_t {
    /// The step at the earliest instant.
    narx_step_t step;
    /// Number of valid entries of `commutations`.
    uint8_t commutation_count;
    /// Changes later in the period, in order of time.
    struct narx_commutation_t commutations[NARX_COMMUTATIONS_MAX];
} narx_steps_t;

/// Settings for narx_fault_init. The time for which each condition must hold is listed with its cause in
/// PROTOCOL.md.
typedef struct narx_fault_settings_t {
    /// Ticks a second, 1 000 to 100 000 Hz.
    uint32_t tick_rate;
    /// Largest bus voltage, 0 to 1 000 V; cleared 0.5 V below. Q16.
    int32_t over_voltage;
    /// Least bus voltage, 0 V to 1 V below the largest; cleared 0.5 V above. Q16.
    int32_t under_voltage;
    /// Largest magnitude of the mean DC-link current, 0 to 1 000 A; cleared 1/16 below. Q16.
    int32_t over_current;
    /// Temperature of the shutdown, -100 to 1 000 degrees C; cleared 2 below. Q16.
    int32_t over_temperature;
    /// Temperature of the warning, no more than that of the shutdown. Q16.
    int32_t warning;
    /// Largest pressure reading, -1 000 to 1 000 V; cleared 1/16 below. Q16.
    int32_t over_pressure;
    /// Largest electrical speed that is requested, 0 to 10 000 rev/s: 30 % above is overspeed. Q16.
    int32_t speed_max;
    /// Critical fault mask (parameter 115, 1 = critical); faults that protect the power stage are critical
    /// while driving in any case.
    uint32_t critical_mask;
    /// Torque without a hall edge for this long is a stall, 1 to 65 535 ms (parameter 265).
    uint32_t hall_stall_ms;
    /// Digital inputs that shut down. Sum of NARX_LINE_*.
    uint8_t shutdown_lines;
} narx_fault_settings_t;

/// Fault logic: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_fault_t {
    /// Private.
    uint64_t words[29];
} narx_fault_t;

/// A limit with hysteresis, raw I16F16. `clear` lies on the safe side of `trip`.
typedef struct narx_limit_t {
    /// Beyond this the fault qualifies.
    int32_t trip;
    /// Back beyond this its cause is gone.
    int32_t clear;
    /// Ticks in a row that the condition must hold, at least 1.
    uint16_t ticks;
} narx_limit_t;

/// Coefficients of the fault logic.
typedef struct narx_protection_coefficients_t {
    /// Bus over-voltage.
    struct narx_limit_t over_voltage;
    /// Bus voltage above which that qualifies at once.
    int32_t over_voltage_at_once;
    /// Bus under-voltage.
    struct narx_limit_t under_voltage;
    /// Mean DC-link current, magnitude.
    struct narx_limit_t over_current;
    /// Temperature, shutdown.
    struct narx_limit_t over_temperature;
    /// Temperature, warning.
    struct narx_limit_t warning;
    /// Pressure reading, volts.
    struct narx_limit_t over_pressure;
    /// Speed above 130 % of the mode's maximum, electrical rev/s: hall.
    struct narx_limit_t overspeed_hall;
    /// Speed above 130 % of the maximum of sensorless and open loop.
    struct narx_limit_t overspeed_sensorless;
    /// Which digital inputs shut down.
    uint8_t shutdown_lines;
    /// Ticks a shutdown line must hold.
    uint16_t shutdown_ticks;
    /// Bits that are critical (parameter 115).
    uint32_t critical_mask;
    /// Ticks under torque at speed 0, which is itself parameter 113 without a hall edge (parameter 265).
    uint32_t hall_stall_ticks;
    /// Below this bus voltage a diagnostic is shown, raw I16F16.
    int32_t supply_low;
    /// Ticks in a millisecond, 1/256: the leak of the plausibility counts.
    uint16_t ticks_per_ms;
} narx_protection_coefficients_t;

/// Inputs of the fault logic in one tick. Quantities are Q16; a flag is set if it is not 0. All zeros
/// describe a board at rest without a supply.
typedef struct narx_evidence_t {
    /// Bus voltage.
    int32_t bus_voltage;
    /// Mean DC-link current of this tick.
    int32_t bus_current;
    /// Mean DC-link current after a first-order filter of 64 ticks.
    int32_t bus_current_filtered;
    /// Temperature of the power stage.
    int32_t temperature;
    /// Pressure reading, V.
    int32_t pressure;
    /// Electrical speed, magnitude, rev/s.
    int32_t speed;
    /// Faults of a parameter store: NARX_FAULT_STORE_*.
    uint32_t store_faults;
    /// Failure of sensorless control: NARX_CAUSE_SENSORLESS_STALL, _DESYNCHRONISATION or _WRONG_LOCK; 0
    /// without one.
    uint16_t sensorless;
    /// Digital inputs: sum of NARX_LINE_*.
    uint8_t lines;
    /// The master's request: 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown.
    uint8_t request;
    /// A self-test has failed.
    uint8_t self_test_failed;
    /// The hall code is 000 or 111.
    uint8_t hall_invalid;
    /// The hall sensors have jumped over a sector.
    uint8_t hall_jump;
    /// Sectors that the hall sensors have turned in this tick, signed.
    int8_t hall_sectors;
    /// No hall edge came for the hall time-out.
    uint8_t hall_stopped;
    /// The hall closed loop is running: its sensors are checked for plausibility.
    uint8_t hall_driving;
    /// The bridge is on, or a start is about to turn it on.
    uint8_t driving;
    /// Sign of the torque that was applied in the last tick: 1 forward, -1 reverse, 0 none.
    int8_t torque;
    /// A phase is open.
    uint8_t open_phase;
} narx_evidence_t;

/// Outputs of the fault logic.
typedef struct narx_faults_t {
    /// Faults that are present or latched: sum of NARX_FAULT_*.
    uint32_t word;
    /// Latched faults.
    uint32_t critical;
    /// Extended code of the first critical fault, a NARX_CAUSE_*; 0 without one.
    uint16_t cause;
    /// Not 0: a critical fault is present; the bridge must be switched off.
    uint8_t present;
    /// Not 0: none of the latched causes is present any more.
    uint8_t causes_gone;
} narx_faults_t;

/// A change of state.
typedef struct narx_change_t {
    /// State before: a narx_state_t.
    uint8_t from;
    /// State after.
    uint8_t to;
    /// Not 0: the change fired because of the command time-out.
    uint8_t timed_out;
} narx_change_t;

/// Settings for narx_hall_init.
typedef struct narx_hall_settings_t {
    /// Ticks a second, 1 000 to 100 000 Hz.
    uint32_t tick_rate;
    /// Offset of the edges beyond their place, -18 000 to 18 000 in 0.01 electrical degree (parameter 80).
    int32_t offset_cdeg;
    /// No edge for this long means standstill, 1 to 65 535 ms (parameter 113), and no more than 65 535 ticks.
    uint32_t timeout_ms;
    /// Slowest electrical speed that is interpolated between edges, rev/s; below, the middle of the sector
    /// stands for all of it. Q16.
    int32_t interpolation_min;
    /// Permutation of the lines, 0 to 5 (parameter 262); 0 is A, B, C.
    uint8_t order;
    /// Lines to invert before the permutation, 0 to 7: bit 0 = A, bit 1 = B, bit 2 = C.
    uint8_t polarity;
    /// Not 0: edges are time-stamped; else only the level is read, once a tick.
    uint8_t captured;
} narx_hall_settings_t;

/// A hall station: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_hall_t {
    /// Private.
    uint64_t words[15];
} narx_hall_t;

/// Coefficients of the hall station.
typedef struct narx_hall_coefficients_t {
    /// Sector by raw code, 0xFF = invalid; built from the wiring.
    uint8_t sectors[8];
    /// Angle by which the edges lie beyond 30 + 60 k degrees.
    uint16_t offset;
    /// No edge for this long, in 1/65 536 tick, means standstill (parameter 113).
    uint32_t timeout;
    /// Slowest speed that is interpolated between edges, in 2^-32 turn a tick.
    uint32_t interpolation_min;
    /// Edges come time-stamped; the level alone is a late witness.
    bool captured;
    /// Ticks of an invalid level after which the position is lost.
    uint8_t lost_after;
} narx_hall_coefficients_t;

/// A factor: `mantissa` x 2^-`shift`. A gain in IQ24 is {gain, 24}, one in Q15 {gain, 15}.
typedef struct narx_gain_t {
    /// 0 to 2^30 - 1, so that the product with any 32-bit value fits 64 bits.
    int32_t mantissa;
    /// Fraction bits, 0 to 62.
    uint32_t shift;
} narx_gain_t;

/// Ready-made coefficients of a hall station: those that its settings build.
typedef struct narx_hall_ready_t {
    /// The station's own.
    struct narx_hall_coefficients_t station;
    /// Rev/s (raw I16F16) of 2^-32 turn a tick.
    struct narx_gain_t speed_of_turns;
} narx_hall_ready_t;

/// One time-stamped edge.
typedef struct narx_edge_t {
    /// Instant, in 1/65 536 of the period that has just ended.
    uint16_t instant;
    /// Source of the edge: a narx_edge_source_t.
    uint8_t source;
    /// The three lines after the edge: bit 0 = A, bit 1 = B, bit 2 = C.
    uint8_t code;
} narx_edge_t;

/// Reading of the sensors after a tick.
typedef struct narx_hall_reading_t {
    /// Electrical angle at the present period's boundary, 2^32 a turn; for narx_commutation_step.
    uint32_t angle;
    /// Speed, 2^-32 turn a tick, signed; for narx_commutation_step.
    int32_t turn_speed;
    /// Electrical speed, Q16 rev/s, signed, limited by the time for which the next edge has not come.
    int32_t speed;
    /// Sector, 0 to 5: sector s spans 30 + 60 s to 90 + 60 s degrees; 255 until the first valid code.
    uint8_t sector;
    /// Sectors turned in this tick, signed.
    int8_t sectors;
    /// Not 0: the present code is 000 or 111.
    uint8_t invalid;
    /// Not 0: a sector was jumped over in this tick.
    uint8_t jump;
    /// Not 0: no edge came for the time-out: standstill.
    uint8_t stopped;
    /// Not 0: the position is doubtful; torque by this position could act in any direction.
    uint8_t doubtful;
} narx_hall_reading_t;

/// A PI controller: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_pi_t {
    /// Private.
    uint64_t words[5];
} narx_pi_t;

/// Settings for narx_pi_init. Errors and outputs are Q16 in units of the caller's choice.
typedef struct narx_pi_settings_t {
    /// Kp: output per error.
    struct narx_gain_t proportional;
    /// Ki: output per error and second.
    struct narx_gain_t integral;
    /// Steps a second, 1 to 1 000 000 Hz.
    uint32_t step_rate;
    /// Least output, Q16.
    int32_t minimum;
    /// Largest output, Q16, not below the least.
    int32_t maximum;
} narx_pi_settings_t;

/// Gains of a PI controller, built for one step rate.
typedef struct narx_pi_gains_t {
    /// Output per error.
    struct narx_gain_t proportional;
    /// Output per error and step: Ki x step time.
    struct narx_gain_t integral;
} narx_pi_gains_t;

/// Ready-made coefficients of a PI controller: those that its settings build.
typedef struct narx_pi_ready_t {
    /// Gains of one step: Kp, and Ki x step time.
    struct narx_pi_gains_t gains;
    /// Least output, raw I16F16.
    int32_t minimum;
    /// Largest output, raw I16F16, not below the least.
    int32_t maximum;
} narx_pi_ready_t;

/// A ramp: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_ramp_t {
    /// Private.
    uint64_t words[3];
} narx_ramp_t;

/// Settings for narx_ramp_init.
typedef struct narx_ramp_settings_t {
    /// Steepest change, Q16 a second, more than 0.
    int32_t rate;
    /// Steps a second, 1 to 1 000 000 Hz.
    uint32_t step_rate;
} narx_ramp_settings_t;

/// Ready-made coefficients of a ramp: those that its settings build.
typedef struct narx_ramp_ready_t {
    /// Largest change of one step, raw I16F16 with 16 extra bits.
    int64_t rate;
} narx_ramp_ready_t;

/// Settings for narx_state_init. Durations are 0 to 3 600 000 ms.
typedef struct narx_state_settings_t {
    /// Ticks a second, 1 000 to 100 000 Hz.
    uint32_t tick_rate;
    /// Boot time (T01).
    uint32_t boot_ms;
    /// Rotor lock (T23).
    uint32_t lock_ms;
    /// Open loop before sensorless (T34).
    uint32_t open_loop_ms;
    /// Auto-restart (T71, T74).
    uint32_t auto_restart_ms;
    /// Wait before a fault can be acknowledged (T61).
    uint32_t fault_wait_ms;
    /// Longest time without a command while driving; more is a fault.
    uint32_t command_timeout_ms;
    /// Not 0: open loop may run the motor (Table 6).
    uint8_t open_loop;
    /// Not 0: the sensorless loop may run the motor (Table 6).
    uint8_t sensorless;
    /// Not 0: the hall loop may run the motor (Table 6), before the others.
    uint8_t hall;
} narx_state_settings_t;

/// A state machine: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_state_machine_t {
    /// Private.
    uint64_t words[12];
} narx_state_machine_t;

/// Coefficients of the state machine. Durations are in ticks.
typedef struct narx_machine_coefficients_t {
    /// Open loop may run the motor (Table 6).
    bool open_loop_enable;
    /// The sensorless loop may run the motor (Table 6).
    bool sensorless_enable;
    /// The hall loop may run the motor (Table 6), before the others.
    bool hall_enable;
    /// Boot-up time (T01): 0.5 s.
    uint32_t boot;
    /// Rotor lock (T23).
    uint32_t lock;
    /// Rotor lock level (parameter 89).
    int32_t lock_level;
    /// Its rise a millisecond with 16 extra bits: a quarter of the lock.
    int64_t lock_rate;
    /// Open loop before sensorless (T34).
    uint32_t open_loop;
    /// Auto-restart time (T71, T74): 2 s.
    uint32_t auto_restart;
    /// Wait before a fault can be acknowledged (T61).
    uint32_t fault_wait;
    /// Command time-out.
    uint32_t command_timeout;
    /// A closed loop goes on by the other one's source where its own fails (parameter 308); both are enabled.
    bool other_source;
} narx_machine_coefficients_t;

/// Inputs of the state machine in one tick; a flag is set if it is not 0.
typedef struct narx_state_inputs_t {
    /// A critical fault is present.
    uint8_t critical;
    /// Self-tests or parameter store failed.
    uint8_t unhealthy;
    /// None of the latched faults' causes is present.
    uint8_t causes_gone;
    /// Estimated speed is 0, as the running mode judges it.
    uint8_t stopped;
    /// A hall calibration has a result.
    uint8_t calibrated;
    /// A working controller can be built from the present parameters.
    uint8_t parameters_fit;
} narx_state_inputs_t;

/// Present state of the machine.
typedef struct narx_state_report_t {
    /// Ticks in the present state, saturating.
    uint32_t age;
    /// A narx_state_t.
    uint8_t state;
    /// Direction of this start: 0 forward, 1 reverse.
    uint8_t direction;
    /// Reason why the last start was refused: 0 it was not, 1 no mode is enabled, 2 parameters, 4 Standby was
    /// not requested since the last stop.
    uint8_t refusal;
    /// Not 0: this tick turns the bridge on unless a condition prevents the start.
    uint8_t starting;
} narx_state_report_t;

/// One channel of the converter: value = (code - zero) * micro_per_code / 1 000 000.
typedef struct narx_channel_t {
    /// Nominal code at 0 V or 0 A, 0 to 4095.
    uint16_t zero;
    /// Micro-units (uV or uA) of one code; positive.
    int32_t micro_per_code;
} narx_channel_t;

/// Settings for narx_zero_crossing_init.
typedef struct narx_zero_crossing_settings_t {
    /// Ticks a second, 1 000 to 100 000 Hz.
    uint32_t tick_rate;
    /// Scale of the three phase terminals.
    struct narx_channel_t terminal;
    /// Scale of the bus voltage.
    struct narx_channel_t bus_voltage;
    /// Least blanking after a commutation, 0 to 100 000 us (parameter 86).
    uint32_t blanking_us;
    /// Delay of a rising crossing, -10 000 to 10 000 us (parameter 100).
    int32_t delay_rising_us;
    /// Delay of a falling crossing, -10 000 to 10 000 us.
    int32_t delay_falling_us;
    /// Line-to-line back-EMF, 0 to 1 000 000 uV a mechanical rpm (parameter 267); 0 unknown, then off-time
    /// crossings are not corrected for their threshold.
    uint32_t back_emf_uv_per_rpm;
    /// Instant of the period at which a new step acts, 1/65 536 of it, and the advance of the next
    /// commutation.
    struct narx_commutation_settings_t commutation;
    /// Pole pairs, 1 to 100.
    uint16_t pole_pairs;
    /// No crossing for this long is standstill, 1 to 32 767 ticks (parameter 85).
    uint16_t timeout_ticks;
    /// Smallest signal that stands out of the noise, 1 to 255 codes of a terminal.
    uint8_t noise_codes;
    /// Not 0: comparators with captured edges take the place of samples.
    uint8_t comparator;
} narx_zero_crossing_settings_t;

/// A zero crossing detector with its estimator: memory that the caller owns. It may be copied and moved
/// between calls.
typedef struct narx_zero_crossing_t {
    /// Private.
    uint64_t words[38];
} narx_zero_crossing_t;

/// One converter channel: `value = (code - zero) x gain + offset`, as one multiplication and one sum.
typedef struct narx_channel_scale_t {
    /// Raw I16F16 per code, with 16 extra bits.
    uint32_t gain;
    /// Offset that is added to every value, raw I16F16; `bias` contains it.
    int32_t offset;
    /// Value of code 0, raw I16F16 with 32 extra bits.
    int64_t bias;
} narx_channel_scale_t;

/// Coefficients of the back-EMF station.
typedef struct narx_back_emf_coefficients_t {
    /// Scale of the phase terminals.
    struct narx_channel_scale_t terminal;
    /// Smallest signal of one sample that stands out of the noise, converter codes.
    int32_t noise;
    /// Terminals below this code show no back-EMF: less than the noise.
    uint16_t silence;
    /// Ticks without voltage after which the windings carry no more current.
    uint16_t settle;
    /// Least blanking after a commutation, 1/65 536 tick (parameter 86).
    uint32_t discard;
    /// First instant of a period at which a pattern changes, 1/65 536.
    uint16_t earliest;
    /// Back-EMF comparators with capture take the converter's place.
    bool comparator;
    /// Delay of a rising crossing, 1/65 536 tick (parameter 100).
    int32_t delay_rising;
    /// Delay of a falling crossing, 1/65 536 tick (parameters 100 and 286).
    int32_t delay_falling;
    /// Volts of back-EMF per electrical rev/s (parameter 267), 0 unknown.
    struct narx_gain_t back_emf;
    /// Back-EMF per 2^-32 turn a tick.
    struct narx_gain_t emf_of_turns;
} narx_back_emf_coefficients_t;

/// Ready-made coefficients of a detector: those that its settings build.
typedef struct narx_zero_crossing_ready_t {
    /// The station's own.
    struct narx_back_emf_coefficients_t back_emf;
    /// Of the commutation that follows a crossing.
    struct narx_commutator_coefficients_t commutator;
    /// Scale of the bus voltage.
    struct narx_channel_scale_t bus_voltage;
    /// Rev/s (raw I16F16) of 2^-32 turn a tick.
    struct narx_gain_t speed_of_turns;
    /// No crossing for this long is standstill, 1/65 536 tick.
    uint32_t timeout;
} narx_zero_crossing_ready_t;

/// All inputs of the tick `tick`, measured in period `tick` at the instant that the previous command
/// requested.
typedef struct narx_samples_t {
    /// Number of this PWM period since power-up.
    uint64_t tick;
    /// Terminal voltages of phases A, B, C against ground, converter codes.
    uint16_t phase_voltage[3];
    /// Bus voltage, converter code.
    uint16_t bus_voltage;
    /// Bus current, converter code; see current_mode.
    uint16_t bus_current;
    /// Time from the bus voltage's conversion to phase C's, in 1/65 536 of a period (A and B lie evenly
    /// between).
    uint16_t skew;
    /// Part of the period in which the phase voltages were sampled: a narx_sample_mode_t.
    uint8_t sample_mode;
    /// Kind of bus_current: a narx_current_mode_t. The drive ignores it and takes every reading for
    /// NARX_CURRENT_MODE_AVERAGE.
    uint8_t current_mode;
    /// Hall lines at the sampling instant: bit 0 = A, bit 1 = B, bit 2 = C.
    uint8_t hall;
    /// Digital inputs at the sampling instant: sum of NARX_LINE_*, a bit is set while the input is asserted.
    uint8_t lines;
    /// Number of valid `edges`.
    uint8_t edge_count;
    /// Number of edges of period `tick` - 1 beyond NARX_EDGES_MAX.
    uint8_t edges_lost;
    /// Edges captured during the whole of period `tick` - 1, oldest first.
    struct narx_edge_t edges[NARX_EDGES_MAX];
} narx_samples_t;

/// The pattern that was applied in the period that has ended.
typedef struct narx_applied_t {
    /// Instant at which the phases were sampled, in 1/65 536 of the period.
    uint16_t sample_at;
    /// Step at the period's earliest instant: a narx_step_t.
    uint8_t step;
    /// Number of changes that followed.
    uint8_t commutation_count;
    /// Instants of the changes, in 1/65 536 of the period.
    uint16_t instants[NARX_COMMUTATIONS_MAX];
    /// Steps after the changes.
    uint8_t steps[NARX_COMMUTATIONS_MAX];
} narx_applied_t;

/// Reading of the terminals after a tick.
typedef struct narx_zero_crossing_reading_t {
    /// Age of a crossing that was seen in this tick: time from it to the present boundary, 1/65 536 tick,
    /// negative after the boundary; INT32_MIN without one.
    int32_t crossing;
    /// Time from the present boundary to the next commutation, 1/65 536 tick: 0 is now, UINT32_MAX is
    /// unknown.
    uint32_t commutation;
    /// Electrical angle at the present boundary, 2^32 a turn; for narx_commutation_step.
    uint32_t angle;
    /// Speed, 2^-32 turn a tick, signed; for narx_commutation_step.
    int32_t turn_speed;
    /// Electrical speed, Q16 rev/s, signed; 0 while unknown.
    int32_t speed;
    /// Crossings accepted since narx_zero_crossing_init, wrapping.
    uint32_t accepted;
    /// Lag of the last accepted crossing behind its prediction, 65 536 a turn.
    int16_t margin;
    /// Outcome of the last step's crossing: 0 none yet, 1 accepted, 2 too early, 3 not seen, 4 hidden by
    /// demagnetisation, 5 seen on a coasting motor.
    uint8_t why;
    /// Not 0: six consistent crossings of both polarities; the position may close a loop.
    uint8_t running;
    /// Not 0: the bridge must be switched off: 1 stalled, 2 out of step.
    uint8_t lost;
} narx_zero_crossing_reading_t;

/// Constants of a board.
typedef struct narx_board_t {
    /// Control ticks, and PWM periods, per second (Hz): 1 000 to 100 000.
    uint32_t tick_rate;
    /// First instant of a period at which a new step can act, in 1/65 536 of the period: the sample is taken
    /// and narx_drive_step has returned.
    uint16_t earliest;
    /// Time for which both switches of a leg stay off between one and the other, ns.
    uint16_t dead_time_ns;
    /// Resistance of the two switches that conduct in a step, milliohm; the drive computes its losses from it
    /// (output power, Table 1).
    uint16_t bridge_milliohm;
    /// Not 0: the hall lines have time-stamping input captures.
    uint8_t hall_capture;
    /// Not 0: back-EMF comparators with time-stamping input captures watch the floating phase.
    uint8_t comparator_capture;
    /// Parts that the board has; the drive refuses a parameter value that needs another one. Sum of 1
    /// external temperature sensor, 2 switch for the supply of the hall sensors, 4 DSIO1 and DSIO2 as inputs,
    /// 8 as outputs, 16 accelerometer, 32 pressure input, 64 memory of the log.
    uint8_t equipment;
    /// Bus voltage, uV per code.
    struct narx_channel_t bus_voltage;
    /// Terminal voltages of the three phases against ground, uV per code.
    struct narx_channel_t phase_voltage;
    /// DC-link current, uA per code; positive from the supply into the bridge.
    struct narx_channel_t bus_current;
} narx_board_t;

/// A motor, its supply and its mode. Resistance, inductance and torque constant are line to line, in the DC
/// (six-step) convention: V = R I + k w, T = k I.
typedef struct narx_nameplate_t {
    /// Ohm.
    double resistance;
    /// H.
    double inductance;
    /// N m/A, which is the back-EMF constant, V s/rad.
    double torque_constant;
    /// Of the rotor and what is coupled to it, kg m2.
    double inertia;
    /// Coulomb friction, N m; 0 if it is not known.
    double static_friction;
    /// Viscous friction, N m s/rad; 0 if it is not known.
    double viscous_friction;
    /// Rated DC current, A; 0 for the current that heats the winding by 6 W, at most 6 A.
    double rated_current;
    /// Supply voltage, 18 to 60 V.
    double supply;
    /// Largest set-point, mechanical rpm; 0 for the largest that motor and drive allow.
    double speed_max;
    /// PWM frequency of the board, 8 000 to 50 000 Hz; 0 for 10 000.
    uint32_t pwm_rate;
    /// Pole pairs, 1 or more.
    uint8_t pole_pairs;
    /// A narx_commissioning_mode_t.
    uint8_t mode;
} narx_nameplate_t;

/// A measured figure.
typedef struct narx_figure_t {
    /// The value.
    double value;
    /// The truth is within this of the value for about 95 of 100 motors.
    double uncertainty;
} narx_figure_t;

/// Figures of a motor as its drive has measured them, at the temperature that the motor had.
typedef struct narx_identified_t {
    /// Ambient temperature at the drive when the measurement began, degrees Celsius: that of a motor that has
    /// rested in the same room. NAN if the drive does not broadcast it.
    double temperature;
    /// Bus voltage without load, V.
    double supply;
    /// Largest phase current of the identification: the given one, or what the heat allows, A.
    double current;
    /// Line to line, ohm.
    struct narx_figure_t resistance;
    /// Line to line, H.
    struct narx_figure_t inductance;
    /// N m/A, which is the back-EMF constant, V s/rad. This and what follows is 0 for a rotor that was held.
    struct narx_figure_t torque_constant;
    /// Of the rotor and what is coupled to it, kg m2.
    struct narx_figure_t inertia;
    /// Friction at `speed`, N m.
    struct narx_figure_t friction;
    /// Its constant part, N m.
    double static_friction;
    /// Its part that grows with the speed, N m s/rad.
    double viscous_friction;
    /// Speed to which `friction` belongs, the largest that was used, rad/s.
    double speed;
    /// Pole pairs, as given or as counted.
    uint8_t pole_pairs;
    /// Not 0: the rotor has turned.
    uint8_t turned;
    /// Not 0: the hall sensors were calibrated, and the drive keeps what follows.
    uint8_t calibrated;
    /// Permutation of the hall lines, 0 to 5 (parameter 262).
    uint8_t hall_order;
    /// Hall lines that are inverted, a bit each (parameter 263).
    uint8_t hall_polarity;
    /// Offset of the hall edges, electrical degrees (parameter 80).
    double hall_offset;
} narx_identified_t;

/// A parameter that was stored.
typedef struct narx_stored_t {
    /// Number of the parameter: a NARX_PARAMETER_*.
    uint16_t number;
    /// Raw value.
    int32_t value;
} narx_stored_t;

/// Parameters for a motor: write each with NARX_REQUEST_KIND_WRITE, or give them to narx_drive_init_stored.
typedef struct narx_commissioned_t {
    /// The parameters, raw.
    struct narx_stored_t parameters[NARX_COMMISSIONED];
    /// Smallest set-point, mechanical rpm.
    double speed_min;
    /// Largest set-point, mechanical rpm.
    double speed_max;
    /// Mean phase current that the limits leave, A.
    double phase_current;
    /// Rated DC current, given or estimated, A.
    double rated_current;
} narx_commissioned_t;

/// A speed loop.
typedef struct narx_speed_loop_t {
    /// Its gains and slowest set-point, raw.
    struct narx_stored_t parameters[NARX_SPEED_LOOP_PARAMETERS];
    /// Frequency at which the open loop has a gain of 1, Hz.
    double bandwidth;
    /// Phase margin at the slowest set-point, degrees; it is larger at every other.
    double phase_margin;
    /// Proportional gain, V s/rad.
    double kp;
    /// Integral gain, V/rad.
    double ki;
} narx_speed_loop_t;

/// A drive: memory that the caller owns, static, on a stack or from a pool. Its content is private to the
/// library. It must neither move nor be copied after narx_drive_init. To end a drive, stop calling it.
typedef struct narx_drive_t {
    /// Private.
    uint64_t words[NARX_DRIVE_WORDS];
} narx_drive_t;

/// Identity of firmware and board (BUILD_INFO, DEVICE_INFO, parameters 4 to 7).
typedef struct narx_identity_t {
    /// Date of the build, YYYYMMDD in decimal.
    uint32_t build_date;
    /// Build number of the firmware.
    uint16_t build_number;
    /// Release of the board.
    uint16_t hardware_release;
    /// Release of the firmware: major in the high byte, minor in the low byte.
    uint16_t software_release;
    /// Not 0: built from sources that were not committed.
    uint8_t source_modified;
} narx_identity_t;

/// The answer to the samples of period k. `step` and `commutations` act in period k, the rest from period k +
/// 1.
typedef struct narx_pwm_command_t {
    /// Duty of the switched legs in period k + 1: U1F15, at most 32 768 = 1. The on-time is centred on the
    /// period's boundary.
    uint16_t duty;
    /// Sampling instant in period k + 1, in 1/65 536 of it.
    uint16_t sample_at;
    /// Part of the period in which that sample is taken.
    narx_sample_mode_t sample_mode;
    /// Freewheeling in period k + 1.
    narx_rectification_t rectification;
    /// The pattern to apply at once, when the call that writes it returns. Coast turns all six switches off.
    narx_step_t step;
    /// Number of valid entries of `commutations`.
    uint8_t commutation_count;
    /// Pattern changes later in period k, in order of time, none before the board's `earliest`.
    struct narx_commutation_t commutations[NARX_COMMUTATIONS_MAX];
} narx_pwm_command_t;

/// A classic CAN frame.
typedef struct narx_frame_t {
    /// Identifier: 11 bits, or 29 if `extended`.
    uint32_t id;
    /// Not 0: the identifier has 29 bits.
    uint8_t extended;
    /// Not 0: a remote request, without data.
    uint8_t remote;
    /// Number of data bytes, or of those that a remote frame requests: 0 to 8.
    uint8_t length;
    /// Data bytes; the first `length` are valid.
    uint8_t data[8];
} narx_frame_t;

/// A TX-Driver: memory that the caller owns. Its content is private to the library; it may be copied and
/// moved between calls. Calls for one TX-Driver must not interrupt each other.
typedef struct narx_tx_driver_t {
    /// Private.
    uint64_t words[NARX_TX_DRIVER_WORDS];
} narx_tx_driver_t;

/// Hardware and firmware of a TX-Driver. Positions in 2^-27 mm.
typedef struct narx_tx_variant_t {
    /// Number of sensors: 1 or 2.
    uint8_t channels;
    /// Release of the firmware, major in the high byte (2100h).
    uint16_t firmware;
    /// Rate at which narx_tx_driver_handle_sample is called, Hz.
    uint32_t sample_rate;
    /// Start of each sensor's measuring range.
    int32_t range_start[2];
    /// End of each sensor's measuring range, beyond its start.
    int32_t range_end[2];
} narx_tx_variant_t;

/// Fault confinement of the CAN controller (ISO 11898-1).
typedef struct narx_bus_state_t {
    /// 0: error active, 1: error passive, 2: off the bus.
    uint8_t error;
    /// Transmit error counter.
    uint16_t transmit_errors;
    /// Receive error counter.
    uint16_t receive_errors;
} narx_bus_state_t;

/// Layout of a node's PDOs.
typedef struct narx_tx_layout_t {
    /// Number of sensors: 1 or 2.
    uint8_t channels;
    /// Not 0: the encoder's value follows.
    uint8_t encoder;
} narx_tx_layout_t;

/// State of a TX-Driver that its board needs.
typedef struct narx_tx_driver_report_t {
    /// Bit rate for the CAN controller, bit/s.
    uint32_t bits_per_second;
    /// The node-id in force.
    uint8_t node;
    /// NMT state: 4 Stopped, 5 Operational, 127 Pre-Operational.
    uint8_t state;
    /// Layout of its PDOs.
    struct narx_tx_layout_t layout;
    /// Levels of the two switching outputs.
    uint8_t outputs[2];
} narx_tx_driver_report_t;

/// The master of one TX-Driver: memory that the caller owns. Its content is private to the library; it may be
/// copied and moved between calls. Calls for one master must not interrupt each other.
typedef struct narx_tx_master_t {
    /// Private.
    uint64_t words[NARX_TX_MASTER_WORDS];
} narx_tx_master_t;

/// Answer to a request.
typedef struct narx_tx_answer_t {
    /// NARX_OK, NARX_ERROR_NO_ANSWER, or NARX_ERROR_ENTRY with the abort code of Table 10 in `value`.
    narx_status_t status;
    /// Value that was read or written.
    uint32_t value;
    /// Entry of the request: a NARX_TX_ENTRY_*.
    uint8_t entry;
    /// Not 0: the request was a write; else a read.
    uint8_t written;
} narx_tx_answer_t;

/// State of a node, from its last messages.
typedef struct narx_tx_node_report_t {
    /// Time of reception of the last positions, microseconds; UINT64_MAX before the first.
    uint64_t at;
    /// The last positions, 2^-27 mm; 0 before the first.
    int32_t positions[2];
    /// Number of boot-up messages.
    uint32_t boots;
    /// Number of error messages.
    uint32_t errors;
    /// Number of the node's frames that cannot be decoded: most likely PDOs of another layout.
    uint32_t malformed;
    /// Encoder, counts; 0 before the first.
    uint16_t encoder;
    /// Code of the last error message; 0 before the first.
    uint16_t last_error;
    /// Not 0: a frame of the node was received within the last 5 s.
    uint8_t present;
    /// State in the last heartbeat; 255 before the first.
    uint8_t state;
} narx_tx_node_report_t;

/// An eddyCAN message (PROTOCOL.md, section 10). Fields that are not named at its kind are ignored.
typedef struct narx_tx_message_t {
    /// Kind: a narx_tx_kind_t.
    uint8_t kind;
    /// Node-id, 1 to 127.
    uint8_t node;
    /// NMT command or state, or number of the PDO.
    uint8_t command;
    /// Subindex of the entry.
    uint8_t subindex;
    /// Index of the entry.
    uint16_t index;
    /// Counts of the encoder.
    uint16_t encoder;
    /// Number of bytes of a value.
    uint8_t size;
    /// Not 0: the node sends this NARX_TX_KIND_ABORT; else the master does.
    uint8_t from_node;
    /// Value, error code or abort code.
    uint32_t value;
    /// Position of each channel, 2^-27 mm.
    int32_t positions[2];
} narx_tx_message_t;

/// Facts that the user knows of the motor, and limits of its identification.
typedef struct narx_identification_config_t {
    /// Largest phase current, A, at most 6; 0, the default, for the current whose heat in the winding is 6 W,
    /// 6 A at most.
    double current;
    /// Resistance of two switches of the drive, ohm, below 1; default that of narx's own board, 0.04. It is
    /// taken off what is measured.
    double bridge;
    /// Pole pairs, 1 to 50; 0, the default: they are counted, with narx_identification_mark.
    uint8_t pole_pairs;
    /// Not 0: the rotor stays still, and resistance and inductance alone are measured; default 0.
    uint8_t hold;
    /// Not 0: the hall sensors are calibrated, too; not with `hold`; default 0.
    uint8_t halls;
} narx_identification_config_t;

/// The identification of one motor: memory that the caller owns. Its content is private to the library; it
/// may be copied and moved between calls. Calls for one identification, or for its master, must not interrupt
/// each other.
typedef struct narx_identification_t {
    /// Private.
    uint64_t words[NARX_IDENTIFICATION_WORDS];
} narx_identification_t;

/// The master of one drive: memory that the caller owns. Its content is private to the library; it may be
/// copied and moved between calls. Calls for one master must not interrupt each other; different masters
/// share nothing.
typedef struct narx_master_t {
    /// Private.
    uint64_t words[NARX_MASTER_WORDS];
} narx_master_t;

/// Readings of the board besides the tick's samples, before calibration. Volts and degrees Celsius in Q16:
/// 65 536 is 1 (narx_q16_from_milli).
typedef struct narx_slow_inputs_t {
    /// Sensor on the power board.
    int32_t ambient_temperature;
    /// External sensor, if there is one (parameter 8).
    int32_t external_temperature;
    /// Pressure input after its amplifier.
    int32_t pressure;
    /// Outputs of the accelerometer along X, Y, Z: 0.5 V a g about its zero-g level.
    int32_t accel[3];
    /// 1.8 V reference of the accelerometer.
    int32_t accel_reference;
    /// 0.383 VREF.
    int32_t reference;
    /// 6 V rail.
    int32_t rail_6v;
    /// 14 V rail of the gate drivers.
    int32_t rail_14v;
    /// Analog signal input.
    int32_t asi;
    /// Not 0: DSIO1 reads high.
    uint8_t dsi1;
    /// Not 0: DSIO2 reads high.
    uint8_t dsi2;
} narx_slow_inputs_t;

/// Levels to apply to the board: 0 or 1.
typedef struct narx_outputs_t {
    /// 1: DSIO1 is an output; 0: an input.
    uint8_t dsio1_enable;
    /// Level of DSIO1.
    uint8_t dsio1_level;
    /// 1: DSIO2 is an output; 0: an input.
    uint8_t dsio2_enable;
    /// Level of DSIO2.
    uint8_t dsio2_level;
    /// Switch for the supply of the hall sensors.
    uint8_t hall_supply;
} narx_outputs_t;

/// Configuration of a master. Times in microseconds.
typedef struct narx_master_config_t {
    /// Period of the set-points, at least 1 000; default 50 000.
    uint64_t setpoint_period;
    /// Longest time until an answer, at least 1 000; default 100 000.
    uint64_t timeout;
    /// Silence after which the drive counts as lost; default 500 000.
    uint64_t lost_after;
    /// CAN address of the drive; default 170.
    uint8_t drive;
    /// CAN address of the master; default 85.
    uint8_t master;
    /// Not 0: listens only and transmits nothing; default 0.
    uint8_t silent;
    /// Not 0: reads every parameter when the first frame of the drive is received, and after it was lost;
    /// default 1.
    uint8_t read_parameters;
    /// Number of times that a message is sent before it counts as not answered; default 3.
    uint8_t attempts;
} narx_master_config_t;

/// Set-points that the drive accepts unchanged, and the parameters that state them.
typedef struct narx_speed_limits_t {
    /// Smallest magnitude, rpm.
    uint16_t min;
    /// Largest magnitude, rpm.
    uint16_t max;
    /// Number of the parameter of `min`: 102, 104, or 88 in open loop; 65 535 while no mode is enabled.
    uint16_t min_parameter;
    /// Number of the parameter of `max`: 101, 103, or 88 in open loop; 65 535 while no mode is enabled.
    uint16_t max_parameter;
} narx_speed_limits_t;

/// State of a drive, from its last messages.
typedef struct narx_drive_report_t {
    /// Not 0: a frame of the drive was received within `lost_after` of narx_master_config_t, or within three
    /// of its broadcast periods if that is longer.
    uint8_t connected;
    /// State: a narx_state_t, or 255 while unknown.
    uint8_t state;
    /// Motor mode of the last STATUS_WORD: a narx_motor_mode_t, or 255 before the first.
    uint8_t motor_mode;
    /// Control mode of the last STATUS_WORD: a narx_control_mode_t, or 255 before the first.
    uint8_t control_mode;
    /// Set-point that the drive uses, rpm; 0 before the drive sent one.
    uint16_t accepted_speed;
    /// Estimated mechanical speed, rpm, negative in reverse; 0 before the first.
    int16_t speed;
    /// Live and latched faults: sum of NARX_FAULT_*.
    uint32_t faults;
    /// Critical faults of the last CRITICAL_FAULT.
    uint32_t critical;
    /// Extended fault code of that CRITICAL_FAULT: NARX_CAUSE_*.
    uint16_t cause;
} narx_drive_report_t;

/// A NarMotion-X message (PROTOCOL.md, section 2).
typedef struct narx_message_t {
    /// Kind: a narx_message_kind_t.
    uint16_t kind;
    /// CAN address of the drive; 170 as shipped.
    uint8_t drive;
    /// CAN address of the master; 85 as shipped.
    uint8_t master;
    /// Fields: raw numbers, with unit and scale beside each. The fields of other messages are ignored.
    narx_fields_t fields;
} narx_message_t;

/// Up to three words of a download.
typedef struct narx_chunk_t {
    /// Place of the first word in the download, words.
    uint32_t offset;
    /// Number of valid `words`.
    uint8_t length;
    /// The words.
    uint16_t words[3];
} narx_chunk_t;

/// Settings of a record of the scope: raw values of its parameters.
typedef struct narx_scope_setup_t {
    /// Recorded signals, a bit each (parameter 22); 0 records the inputs of every control tick instead.
    uint32_t channels;
    /// Level of the triggers 1 to 4, thousandths of the signal's base (parameter 292).
    int32_t level;
    /// Samples of each signal (parameter 23); of a record of inputs, control ticks.
    uint16_t samples;
    /// Control ticks from one sample to the next (parameter 24).
    uint16_t prescaler;
    /// Samples from before the trigger (parameter 26), fewer than all.
    uint16_t before;
    /// Kind of the trigger (parameter 290); 0 for none.
    uint8_t trigger;
    /// Signal of the triggers 1 to 4 (parameter 291).
    uint8_t signal;
} narx_scope_setup_t;

/// Details of a job that has failed; 0, or 255 for a state that is unknown or does not matter, where there
/// are none.
typedef struct narx_job_failure_t {
    /// Faults of a drive in Fault: sum of NARX_FAULT_*.
    uint32_t faults;
    /// Extended fault code: NARX_CAUSE_*.
    uint16_t cause;
    /// Parameter that does not fit the others, for refusal 2 of a start; setting of the scope that is out of
    /// range; parameter that the drive refuses.
    uint16_t parameter;
    /// Reason of a refused start: parameter 276; of a refused record: parameter 306.
    uint8_t refusal;
    /// State of the drive: a narx_state_t, or 255.
    uint8_t state;
    /// State of the scope: parameter 260, or 255.
    uint8_t scope;
} narx_job_failure_t;

/// A request to a drive.
typedef struct narx_request_t {
    /// Kind: a narx_request_kind_t.
    uint8_t kind;
    /// Number of the parameter, if the request is about one.
    uint16_t number;
    /// Raw value, if the request has one.
    int32_t value;
} narx_request_t;

/// Answer to a request.
typedef struct narx_answer_t {
    /// The request.
    struct narx_request_t request;
    /// NARX_OK, NARX_ERROR_NO_ANSWER, NARX_ERROR_NOT_OBEYED, or the reason why the drive refuses the
    /// parameter.
    narx_status_t status;
    /// The raw value that the parameter has now; 0 for a request without a parameter.
    int32_t value;
} narx_answer_t;

/// A motor's control: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_motor_t {
    /// Private.
    uint64_t words[190];
} narx_motor_t;

/// Scales of the fast channels.
typedef struct narx_measurement_scales_t {
    /// Bus voltage (parameter 14 is its offset).
    struct narx_channel_scale_t bus_voltage;
    /// DC-link current (parameter 13 is its offset).
    struct narx_channel_scale_t bus_current;
    /// Phase terminal voltages.
    struct narx_channel_scale_t phase_voltage;
    /// Periods of 100 us in a tick, 1/65 536: the filter of the bus current takes 1/64 of a difference in
    /// each.
    uint32_t filter;
} narx_measurement_scales_t;

/// Coefficients of the calibration.
typedef struct narx_hall_calibration_coefficients_t {
    /// Speed of the field, 2^-32 turn a tick: half a revolution a second.
    uint32_t speed;
    /// The rotor lock level (parameter 89).
    int32_t level;
} narx_hall_calibration_coefficients_t;

/// Coefficients of the open-loop generator.
typedef struct narx_open_loop_coefficients_t {
    /// Speed at the end of the ramp, electrical rev/s, raw I16F16 (parameter 88).
    int32_t speed;
    /// Rise a millisecond, raw I16F16 with 16 extra bits (parameters 88 and 109).
    int64_t rate;
    /// Level while the field stands still (rotor lock level, but no more than the open-loop level). Levels as
    /// `initial_level` of the control's coefficients.
    int32_t level_start;
    /// Level at the end of the ramp (parameter 87).
    int32_t level;
    /// `(level - level_start) / speed` as mantissa x 2^-shift.
    struct narx_gain_t slope;
    /// Turns of 2^-32 a tick per raw rev/s.
    struct narx_gain_t turns;
} narx_open_loop_coefficients_t;

/// Coefficients of the rails.
typedef struct narx_rail_coefficients_t {
    /// Volts per raw ampere (parameter 268), 0 unknown.
    struct narx_gain_t resistance;
    /// Volts that turning the current over in six commutations a revolution costs, per raw ampere and raw
    /// rev/s: 3 L (parameter 283) with 16 extra bits, 0 unknown.
    struct narx_gain_t commutation;
    /// Volts per electrical rev/s (parameter 267), 0 unknown.
    struct narx_gain_t back_emf;
    /// Milliseconds in which the bucket loses one episode.
    uint32_t leak;
} narx_rail_coefficients_t;

/// Coefficients of the sensorless station. Times are in ticks, levels as `initial_level` of the control's
/// coefficients.
typedef struct narx_sensorless_coefficients_t {
    /// The floating phase.
    struct narx_back_emf_coefficients_t back_emf;
    /// Desynchronisation and stall.
    struct narx_rail_coefficients_t rails;
    /// No crossing for this long is speed 0 (parameter 85), 1/65 536 tick.
    uint32_t timeout;
    /// Silent terminals for this long mean a rotor at rest.
    uint32_t rest;
    /// Two locks together.
    uint32_t align;
    /// Rise of the lock level a millisecond, 16 extra bits.
    int64_t align_rate;
    /// Level of the locks (parameter 89).
    int32_t align_level;
    /// Rise of the kick a millisecond, 16 extra bits.
    int64_t kick_rate;
    /// Level at which the kick ends (parameter 87).
    int32_t kick_level;
    /// Without any crossing at the full level the field steps on after this.
    uint32_t kick_patience;
    /// A kick that has not led to closed loop within this is given up.
    uint32_t kick_limit;
    /// Largest back-EMF that is braked by a short circuit, 2^-32 turn a tick: what the phase current limit
    /// allows.
    int32_t brake_max;
} narx_sensorless_coefficients_t;

/// Coefficients of the current limits, raw I16F16.
typedef struct narx_limit_coefficients_t {
    /// Limit at the beginning of a start (parameter 105), A.
    int32_t soft_start;
    /// Limit afterwards (parameter 106), at most the 7 A input rating of Table 1, A.
    int32_t maximum;
    /// Slope from one to the other (parameter 96), A per millisecond with 16 extra bits.
    int64_t rate;
    /// Estimated mean phase current (parameter 269), A.
    int32_t phase_current_max;
    /// From this temperature the limits fall (parameter 121), degrees C.
    int32_t derating_start;
    /// Per degree above it: 1 / (shutdown - warning).
    struct narx_gain_t derating;
    /// Resistance of the two switches that conduct, raw I16F16 ohm.
    int32_t bridge;
} narx_limit_coefficients_t;

/// Coefficients of the control station. Volts, amperes and rev/s are raw I16F16, duties raw U1F15.
typedef struct narx_control_coefficients_t {
    /// Ticks in a millisecond, 1/256.
    uint16_t ticks_per_ms;
    /// Part of its distance that the speed loop goes in a tick while something else decides, 1/65 536.
    uint16_t track;
    /// Bus current limiter, per tick.
    struct narx_pi_gains_t current;
    /// Current ratings.
    struct narx_limit_coefficients_t limits;
    /// Speed set-point ramp, electrical rev/s per millisecond with 16 extra bits (parameter 99).
    int64_t speed_rate;
    /// Largest change of the duty in a tick (parameter 271).
    uint16_t slew;
    /// Shortest on-time (parameter 272).
    uint16_t duty_min;
    /// Duty that dead time takes away under synchronous rectification.
    uint16_t dead_time;
    /// Above this bus voltage nothing may flow back: the over-voltage threshold less a margin.
    int32_t bus_guard;
    /// First level in closed loop (parameter 84). A level is raw I16F16: volts, or a share of the bus voltage
    /// (`levels_of_bus`).
    int32_t initial_level;
    /// Levels are shares of the live bus voltage: there is no nominal supply (parameter 266 is 0).
    bool levels_of_bus;
    /// Back-EMF per electrical rev/s (parameter 267); 0 unknown.
    struct narx_gain_t back_emf;
} narx_control_coefficients_t;

/// Coefficients of one closed-loop mode. Speeds are raw I16F16 electrical rev/s.
typedef struct narx_mode_coefficients_t {
    /// Speed loop, volts per electrical rev/s, per millisecond.
    struct narx_pi_gains_t speed;
    /// Smallest set-point.
    int32_t speed_min;
    /// Largest set-point.
    int32_t speed_max;
    /// Largest duty, raw U1F15.
    uint16_t duty_max;
    /// The speed is known from crossings alone, once in a sector.
    bool sparse;
} narx_mode_coefficients_t;

/// Everything configurable that the tick needs, in its own units.
typedef struct narx_coefficients_t {
    /// Converter scales.
    struct narx_measurement_scales_t measurement;
    /// Hall sensors.
    struct narx_hall_coefficients_t hall;
    /// Hall calibration.
    struct narx_hall_calibration_coefficients_t hall_calibration;
    /// Open loop.
    struct narx_open_loop_coefficients_t open_loop;
    /// Back-EMF estimator and start sequence.
    struct narx_sensorless_coefficients_t sensorless;
    /// Fault logic.
    struct narx_protection_coefficients_t protection;
    /// State machine.
    struct narx_machine_coefficients_t machine;
    /// Loops and limits.
    struct narx_control_coefficients_t control;
    /// Commutation.
    struct narx_commutator_coefficients_t commutator;
    /// Hall closed loop.
    struct narx_mode_coefficients_t hall_mode;
    /// Sensorless closed loop.
    struct narx_mode_coefficients_t sensorless_mode;
    /// Rev/s (raw I16F16) of 2^-32 turn a tick.
    struct narx_gain_t speed_of_turns;
    /// Settling after the end of the on-time before an off-time sample, in 1/65 536 of a period.
    uint16_t sample_settle;
} narx_coefficients_t;

/// Parameter that does not fit the others.
typedef struct narx_parameter_error_t {
    /// Smallest raw value that fits the others.
    int64_t min;
    /// Largest raw value that fits the others.
    int64_t max;
    /// Its raw value.
    int32_t value;
    /// Its number: a NARX_PARAMETER_*.
    uint16_t number;
} narx_parameter_error_t;

/// Report of a motor's control as of the last step. Speeds are electrical, Q16 rev/s, positive forward.
typedef struct narx_motor_report_t {
    /// Tick of this report.
    uint64_t tick;
    /// Faults that are present or latched: FAULT_WORD of PROTOCOL.md.
    uint32_t faults;
    /// Latched critical faults.
    uint32_t critical;
    /// Set-point after its limits and its ramp.
    int32_t setpoint;
    /// Speed by the hall sensors.
    int32_t speed_hall;
    /// Speed by the back-EMF; in open loop that of the field.
    int32_t speed_sensorless;
    /// Sectors turned since power-up: 6 an electrical revolution.
    int32_t sectors;
    /// Bus voltage, Q16 V.
    int32_t bus_voltage;
    /// Mean bus current, Q16 A.
    int32_t bus_current;
    /// Electrical input power, Q16 W.
    int32_t power;
    /// Terminal voltages, Q16 V.
    int32_t phase_voltage[3];
    /// Zero crossings accepted since power-up, wrapping.
    uint32_t crossings;
    /// Extended code of the first critical fault (PROTOCOL.md), 0 without one.
    uint16_t extended_code;
    /// Electrical angle that the commutation uses, 65 536 a turn.
    uint16_t angle;
    /// Applied duty, U1F15.
    uint16_t duty;
    /// Times that the hall sensors lost their code, saturating.
    uint16_t hall_invalid;
    /// Hall changes between sectors that are not neighbours, saturating.
    uint16_t hall_jumps;
    /// Distance of the last accepted crossing behind its prediction, 65 536 an electrical turn.
    int16_t crossing_margin;
    /// Result of the hall calibration, if `calibration` is 2: angle by which the edges lie beyond their
    /// place, 65 536 a turn.
    int16_t hall_offset;
    /// Permutation of the lines (parameter 262), if `calibration` is 2.
    uint8_t hall_order;
    /// Lines to invert (parameter 263), if `calibration` is 2.
    uint8_t hall_polarity;
    /// Hall calibration: 0 none, 1 running, 2 done, 3 failed.
    uint8_t calibration;
    /// State.
    narx_state_t state;
    /// Commanded direction: 0 forward, 1 reverse.
    uint8_t direction;
    /// Reason why the last start was refused: 0 it was not, 1 no mode is enabled, 4 Standby was not requested
    /// since the last stop.
    uint8_t refusal;
    /// The limit that bounds the duty: the numbers of parameter 280.
    uint8_t limiter;
    /// Outcome of the last step's zero crossing: the numbers of parameter 287.
    uint8_t crossing;
    /// 1: no command for the time-out.
    uint8_t command_expired;
    /// 1: the bus is below 18 V, which is no fault.
    uint8_t supply_low;
    /// 1: the rotor is known to stand.
    uint8_t standstill;
    /// 1: nothing shows the rotor now; it may turn while `sectors` stands.
    uint8_t unseen;
} narx_motor_report_t;

/// Result of a replay.
typedef struct narx_outcome_t {
    /// Number of ticks that were run.
    uint64_t ticks;
    /// Digest of the outputs of this replay.
    uint64_t digest;
    /// Digest of the outputs when they were recorded; equal to `digest` if they were the same, bit for bit.
    uint64_t recorded_digest;
    /// A warning: the behaviour version of the recorder if it differs from this library's (the digests may
    /// then rightly differ); otherwise 0.
    uint16_t other_behaviour;
} narx_outcome_t;

/// Memory of a virtual scope. It has room for the largest number of samples of one signal that parameter 23
/// can request (4096), or for 68 ms of inputs at 10 kHz. Its content is private to the library. It must stay
/// at its address as long as the drive lives.
typedef struct narx_scope_t {
    /// Private.
    uint64_t words[NARX_SCOPE_WORDS];
} narx_scope_t;

/// Storage of a drive's parameters and its log: memory that the caller owns. Its content is private to the
/// library.
typedef struct narx_storage_t {
    /// Private.
    uint64_t words[NARX_STORAGE_WORDS];
} narx_storage_t;

/// A serial NOR flash, as the board drives it. The functions wait until the flash is done and return 0, or
/// another number if it is absent or has failed. The drive then reports fault bit 30 on the bus.
typedef struct narx_flash_t {
    /// Bytes of the flash: whole subsectors, 512 KiB or more. The log uses the space that the parameters
    /// leave.
    uint32_t size;
    /// Pointer that is passed to the functions.
    void *context;
    /// Reads `length` bytes from `address` on.
    int32_t (*read)(void *context, uint32_t address, uint8_t *bytes, size_t length);
    /// Programs `length` bytes from `address` on, within one page of NARX_FLASH_PAGE: bits change from 1 to
    /// 0.
    int32_t (*program)(void *context, uint32_t address, const uint8_t *bytes, size_t length);
    /// Erases from `from` to before `to`, whole subsectors of NARX_FLASH_SUBSECTOR: all bits become 1. The
    /// function may erase larger sectors in between at once.
    int32_t (*erase)(void *context, uint32_t from, uint32_t to);
} narx_flash_t;

#endif // NARX_TYPES_H
