/*
 * narx: the control core of a NarMotion-X drive for three-phase BLDC motors, in fixed point.
 *
 * Made from the library's sources by `cargo xtask header`: do not edit.
 *
 *
 * A drive
 *
 *     static narx_drive_t drive;
 *
 *     narx_drive_init(&drive, sizeof drive, NULL);        once
 *
 *     narx_drive_step(&drive, &samples, &command);        control interrupt, every PWM period
 *
 *     narx_drive_handle_frame(&drive, &frame);            main loop: for each received frame,
 *     narx_drive_run(&drive, tick);                       then once,
 *     while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) send(&frame);    then until it is empty
 *
 *
 * Other parts
 *
 *     narx_motor_*                                        the drive's control tick alone, without bus and
 *                                                         parameters, for little flash
 *     narx_storage_*                                      a drive's flash: stored parameters and the log
 *     narx_pi_*, _ramp_*, _hall_*, _zero_crossing_*,      the drive's blocks one by one, for a driver of
 *     _commutation_*, _fault_*, _state_*                  your own
 *     narx_q16_*, _iq24_*, _q15_*, _q12_*                 conversions between its number formats and yours
 *     narx_message_*, narx_tx_message_*                   decoding and encoding of frames
 *     narx_master_*                                       a drive's master, at the other end of the bus
 *     narx_tx_driver_*, narx_tx_master_*                  the TX-Driver, another device, and its master
 *     narx_replay*                                        recordings
 *
 *
 * Calls that may interrupt each other
 *
 *     A drive has two halves that share nothing but queues. The tick half is narx_drive_step; the
 *     background half is every other narx_drive_* call. Either half may interrupt the other at any
 *     instruction, or run on another thread or processor. Within a half, calls for one drive must
 *     not interrupt each other. narx_drive_init, _init_stored and _attach_scope, and
 *     narx_storage_init_drive, must return before either half is called. narx_storage_serve belongs
 *     to the background half.
 *
 *     Any other object has one half: calls for one of them must not interrupt each other. A block's
 *     step function is called where you need it, mostly in the control interrupt; its init function
 *     is called at power-up. "Any context" marks a function that has no object at all.
 *
 *     Different objects share nothing: the library has no variables.
 *
 *
 * Memory
 *
 *     All memory is the caller's; the library has no heap. The only pointers that it keeps are those
 *     to the memory of a drive and of its scope: every other object may be freed when the call
 *     returns. A pointer points to readable (const) or writable memory of its type. The result is
 *     NARX_ERROR_NULL for NULL, unless the function gives NULL a meaning, NARX_ERROR_ALIGNMENT for a
 *     misaligned pointer, and NARX_ERROR_UNINITIALISED for an object that was not initialised.
 *     Zero the memory of an object before its first use, as static memory is. A call that returns an
 *     error has changed nothing.
 *
 *
 * Numbers
 *
 *     Q16 is I16F16: 65 536 is 1 V, A, degree Celsius or rev/s. Duty is U1F15: 32 768 is 1. Angles
 *     are unsigned parts of a turn and wrap. Instants are 1/65 536 of a PWM period. Converter codes
 *     are the raw results of the converter; narx_board_t has their scales. Parameters are raw
 *     integers; PROTOCOL.md lists their units and decimal scales.
 *
 *
 * Cost
 *
 *     Flash, RAM and instructions of each part on a Cortex-M: tests/golden/ffi_sizes.toml. The drive
 *     itself costs some 310 instructions a tick with hall sensors, 480 without, 2 820 in the worst
 *     tick of all conformance vectors (tests/golden/instructions.toml); narx_drive_step adds the
 *     conversion of the caller's structures. Link with --gc-sections.
 */

#ifndef NARX_H
#define NARX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
// Memory Mapping Flag.
#define NARX_PARAMETER_MEMORY_MAPPING_FLAG 0

// Device Number.
#define NARX_PARAMETER_DEVICE_NUMBER 1

// Slave CAN address.
#define NARX_PARAMETER_SLAVE_CAN_ADDRESS 2

// Master CAN address.
#define NARX_PARAMETER_MASTER_CAN_ADDRESS 3

// Hardware Release.
#define NARX_PARAMETER_HARDWARE_RELEASE 4

// Build number.
#define NARX_PARAMETER_BUILD_NUMBER 5

// Software Release.
#define NARX_PARAMETER_SOFTWARE_RELEASE 6

// Source modified.
#define NARX_PARAMETER_SOURCE_MODIFIED 7

// Temperature measurement source selection.
#define NARX_PARAMETER_TEMPERATURE_SOURCE 8

// Accel use ref for scaling selection.
#define NARX_PARAMETER_ACCEL_USE_REFERENCE 9

// Accel X calib offset, 10^-3 g.
#define NARX_PARAMETER_ACCEL_X_OFFSET 10

// Accel Y calib offset, 10^-3 g.
#define NARX_PARAMETER_ACCEL_Y_OFFSET 11

// Accel Z calib offset, 10^-3 g.
#define NARX_PARAMETER_ACCEL_Z_OFFSET 12

// HV current calib offset, 10^-3 A.
#define NARX_PARAMETER_HV_CURRENT_OFFSET 13

// HV voltage calib offset, 10^-3 V.
#define NARX_PARAMETER_HV_VOLTAGE_OFFSET 14

// Temperature calib offset, 10^-1 °C.
#define NARX_PARAMETER_TEMPERATURE_OFFSET 15

// Mechanical position calibration value, 10^-2 deg.
#define NARX_PARAMETER_POSITION_CALIBRATION 16

// Set position calibration value (rising edge).
#define NARX_PARAMETER_SET_POSITION 17

// Pressure calib offset, 10^-3 V.
#define NARX_PARAMETER_PRESSURE_CALIB_OFFSET 18

// Pressure calib gain.
#define NARX_PARAMETER_PRESSURE_CALIB_GAIN 19

// Pressure meas offset, 10^-3 V.
#define NARX_PARAMETER_PRESSURE_MEAS_OFFSET 20

// Pressure meas gain.
#define NARX_PARAMETER_PRESSURE_MEAS_GAIN 21

// Virtual Scop Channels Selection.
#define NARX_PARAMETER_SCOPE_CHANNELS 22

// Virtual Scop Samples Number, samples.
#define NARX_PARAMETER_SCOPE_SAMPLES 23

// Virtual Scop Sampling Prescaler.
#define NARX_PARAMETER_SCOPE_PRESCALER 24

// Virtual Scop Sampling Time, 10^-6 s.
#define NARX_PARAMETER_SCOPE_SAMPLING_TIME 25

// Virtual Scop Trig phase, samples.
#define NARX_PARAMETER_SCOPE_TRIGGER_PHASE 26

// 01 - Logging start index.
#define NARX_PARAMETER_LOGGING_START 27

// 02 - Logging package index.
#define NARX_PARAMETER_LOGGING_PACKAGE 28

// First of the 37 logging slots.
#define NARX_PARAMETER_LOGGING_SLOT_FIRST 29

// Last of the 37 logging slots.
#define NARX_PARAMETER_LOGGING_SLOT_LAST 65

// 40 - Logging end index.
#define NARX_PARAMETER_LOGGING_END 66

// Logging read start index.
#define NARX_PARAMETER_LOG_READ_START 67

// Logging read number of indexes.
#define NARX_PARAMETER_LOG_READ_COUNT 68

// Logging data size bytes, bytes.
#define NARX_PARAMETER_LOG_RECORD_BYTES 69

// Logging data max index.
#define NARX_PARAMETER_LOG_INDEX_MAX 70

// Logging data write index.
#define NARX_PARAMETER_LOG_WRITE_INDEX 71

// Logging period, ms.
#define NARX_PARAMETER_LOG_PERIOD 72

// Logging data subsectors number.
#define NARX_PARAMETER_LOG_SUBSECTORS 73

// Logging data ongoing subsector erase index.
#define NARX_PARAMETER_LOG_ERASE_SUBSECTOR 74

// Logging read request.
#define NARX_PARAMETER_LOG_READ_REQUEST 75

// Logging erase request.
#define NARX_PARAMETER_LOG_ERASE_REQUEST 76

// Logging memory full flag.
#define NARX_PARAMETER_LOG_MEMORY_FULL 77

// Motor pair poles.
#define NARX_PARAMETER_MOTOR_POLE_PAIRS 78

// Select control sequence for standard motor.
#define NARX_PARAMETER_STANDARD_HALL_SEQUENCE 79

// Hall effect offset angle, 10^-2 deg.
#define NARX_PARAMETER_HALL_OFFSET_ANGLE 80

// Open-loop enable.
#define NARX_PARAMETER_OPEN_LOOP_ENABLE 81

// Closed-loop Sensorless enable.
#define NARX_PARAMETER_SENSORLESS_ENABLE 82

// Closed-loop Hall Effect Sensors enable.
#define NARX_PARAMETER_HALL_ENABLE 83

// Closed-Loop initial duty cycle, 10^-2 %.
#define NARX_PARAMETER_INITIAL_DUTY 84

// Max period between two ZC events, ticks.
#define NARX_PARAMETER_ZC_PERIOD_MAX 85

// N periods to discard after a sector change, ticks.
#define NARX_PARAMETER_ZC_DISCARD 86

// Open-Loop duty cycle, 10^-2 %.
#define NARX_PARAMETER_OPEN_LOOP_DUTY 87

// Open-loop speed setpoint, rpm.
#define NARX_PARAMETER_OPEN_LOOP_SPEED 88

// Rotor lock duty cycle, 10^-2 %.
#define NARX_PARAMETER_LOCK_DUTY 89

// Speed Ki coefficient SL, 10^-6 V/rad.
#define NARX_PARAMETER_SPEED_KI_SL 90

// Speed Kp coefficient SL, 10^-6 V.s/rad.
#define NARX_PARAMETER_SPEED_KP_SL 91

// Speed Ki coefficient HES, 10^-9 V/(rpm.s).
#define NARX_PARAMETER_SPEED_KI_HES 92

// Speed Kp coefficient HES, 10^-9 V/rpm.
#define NARX_PARAMETER_SPEED_KP_HES 93

// HV current Kp coefficient, 10^-6 V/A.
#define NARX_PARAMETER_HV_CURRENT_KP 94

// HV current Ki coefficient, 10^-3 V/(A.s).
#define NARX_PARAMETER_HV_CURRENT_KI 95

// Max HV current setpoint rate, 10^-3 A/s.
#define NARX_PARAMETER_HV_CURRENT_RATE 96

// Hall Effect Sensors PS enable.
#define NARX_PARAMETER_HALL_SUPPLY_ENABLE 97

// Max duty cycle SL, 10^-2 %.
#define NARX_PARAMETER_DUTY_MAX_SL 98

// Speed setpoint rate, rpm/s.
#define NARX_PARAMETER_SPEED_RATE 99

// ZC delay compensation, 10^-2 ticks.
#define NARX_PARAMETER_ZC_DELAY 100

// Speed setpoint max saturation SL, rpm.
#define NARX_PARAMETER_SPEED_MAX_SL 101

// Speed setpoint min saturation SL, rpm.
#define NARX_PARAMETER_SPEED_MIN_SL 102

// Speed setpoint max saturation HES, rpm.
#define NARX_PARAMETER_SPEED_MAX_HES 103

// Speed setpoint min saturation HES, rpm.
#define NARX_PARAMETER_SPEED_MIN_HES 104

// Max HV current limitation soft start, 10^-3 A.
#define NARX_PARAMETER_HV_CURRENT_SOFT_START 105

// Max HV current limitation, 10^-3 A.
#define NARX_PARAMETER_HV_CURRENT_MAX 106

// Max duty cycle, 10^-2 %.
#define NARX_PARAMETER_DUTY_MAX 107

// Open-Loop phase duration, 10^-3 s.
#define NARX_PARAMETER_OPEN_LOOP_DURATION 108

// Open-Loop ramp rising time, 10^-3 s.
#define NARX_PARAMETER_OPEN_LOOP_RAMP 109

// Rotor lock phase duration, 10^-3 s.
#define NARX_PARAMETER_LOCK_DURATION 110

// can_autosend_period, ms.
#define NARX_PARAMETER_AUTOSEND_PERIOD 111

// Fault state wait time before acknowledgement, ms.
#define NARX_PARAMETER_FAULT_WAIT 112

// Electrical period measurement time-out, 10^-3 s.
#define NARX_PARAMETER_HALL_PERIOD_TIMEOUT 113

// Can TimeOut period, ms.
#define NARX_PARAMETER_CAN_TIMEOUT 114

// Critical fault mask.
#define NARX_PARAMETER_CRITICAL_FAULT_MASK 115

// Over-current HV threshold, 10^-3 A.
#define NARX_PARAMETER_OVER_CURRENT 116

// Over-pressure threshold, 10^-3 V.
#define NARX_PARAMETER_OVER_PRESSURE 117

// Over-temperature shutdown threshold, 10^-1 °C.
#define NARX_PARAMETER_OVER_TEMPERATURE 118

// Over-voltage HV threshold, 10^-3 V.
#define NARX_PARAMETER_OVER_VOLTAGE 119

// Under-voltage HV threshold, 10^-3 V.
#define NARX_PARAMETER_UNDER_VOLTAGE 120

// Over-temperature warning threshold, 10^-1 °C.
#define NARX_PARAMETER_TEMPERATURE_WARNING 121

// Store parameters.
#define NARX_PARAMETER_STORE 256

// Store once parameters.
#define NARX_PARAMETER_STORE_ONCE 257

// Reset calibration parameters.
#define NARX_PARAMETER_RESET_CALIBRATION 258

// Auto-calibrate.
#define NARX_PARAMETER_AUTO_CALIBRATE 259

// Scope state.
#define NARX_PARAMETER_SCOPE_STATE 260

// Drive state.
#define NARX_PARAMETER_DRIVE_STATE 261

// Hall order.
#define NARX_PARAMETER_HALL_ORDER 262

// Hall polarity mask.
#define NARX_PARAMETER_HALL_POLARITY 263

// Hall calibration request.
#define NARX_PARAMETER_HALL_CALIBRATE 264

// Hall stall time, ms.
#define NARX_PARAMETER_HALL_STALL_TIME 265

// Nominal supply voltage, 10^-3 V.
#define NARX_PARAMETER_NOMINAL_SUPPLY 266

// Back-EMF constant, 10^-6 V/rpm.
#define NARX_PARAMETER_BACK_EMF_CONSTANT 267

// Winding resistance, 10^-3 ohm.
#define NARX_PARAMETER_WINDING_RESISTANCE 268

// Phase current limit, 10^-3 A.
#define NARX_PARAMETER_PHASE_CURRENT_MAX 269

// Digital shutdown input.
#define NARX_PARAMETER_SHUTDOWN_INPUT 270

// Duty slew limit, 10^-2 %/ms.
#define NARX_PARAMETER_DUTY_SLEW 271

// Minimum on-time, ns.
#define NARX_PARAMETER_ON_TIME_MIN 272

// Timing advance, 10^-2 deg.
#define NARX_PARAMETER_TIMING_ADVANCE 273

// Refused frames.
#define NARX_PARAMETER_REFUSED_FRAMES 274

// Malformed frames.
#define NARX_PARAMETER_MALFORMED_FRAMES 275

// Start refusal.
#define NARX_PARAMETER_START_REFUSAL 276

// Hall invalid codes.
#define NARX_PARAMETER_HALL_INVALID 277

// Hall jumps.
#define NARX_PARAMETER_HALL_JUMPS 278

// Hall calibration state.
#define NARX_PARAMETER_HALL_CALIBRATION_STATE 279

// Active limiter.
#define NARX_PARAMETER_ACTIVE_LIMITER 280

// Hall interpolation speed, rpm.
#define NARX_PARAMETER_HALL_INTERPOLATION_SPEED 281

// Extended fault code.
#define NARX_PARAMETER_EXTENDED_FAULT_CODE 282

// Winding inductance, 10^-6 H.
#define NARX_PARAMETER_WINDING_INDUCTANCE 283

// Frames lost.
#define NARX_PARAMETER_FRAMES_LOST 284

// Rejected parameter.
#define NARX_PARAMETER_REJECTED_PARAMETER 285

// ZC falling delay difference, 10^-2 ticks.
#define NARX_PARAMETER_ZC_DELAY_FALLING 286

// Last zero crossing.
#define NARX_PARAMETER_CROSSING 287

// Zero crossing margin, 10^-2 deg.
#define NARX_PARAMETER_CROSSING_MARGIN 288

// Zero crossings.
#define NARX_PARAMETER_CROSSINGS 289

// Scope trigger.
#define NARX_PARAMETER_SCOPE_TRIGGER 290

// Scope trigger signal.
#define NARX_PARAMETER_SCOPE_TRIGGER_SIGNAL 291

// Scope trigger level, 10^-3 of the signal's base.
#define NARX_PARAMETER_SCOPE_TRIGGER_LEVEL 292

// Bus error state.
#define NARX_PARAMETER_BUS_STATE 293

// Transmit error counter.
#define NARX_PARAMETER_TRANSMIT_ERRORS 294

// Receive error counter.
#define NARX_PARAMETER_RECEIVE_ERRORS 295

// Bus-offs.
#define NARX_PARAMETER_BUS_OFFS 296

// Accel meas offset, 10^-3 V.
#define NARX_PARAMETER_ACCEL_MEAS_OFFSET 297

// Tilt, 10^-2 deg.
#define NARX_PARAMETER_TILT 298

// Vibration, 10^-3 g.
#define NARX_PARAMETER_VIBRATION 299

// Scope inputs.
#define NARX_PARAMETER_SCOPE_INPUTS 300

// Scope words.
#define NARX_PARAMETER_SCOPE_WORDS 301

// Reset cause.
#define NARX_PARAMETER_RESET_CAUSE 302

// Failed self-tests.
#define NARX_PARAMETER_FAILED_SELF_TESTS 303

// Diagnostics.
#define NARX_PARAMETER_DIAGNOSTICS 304

// Scope room, words.
#define NARX_PARAMETER_SCOPE_ROOM 305

// Scope refusal.
#define NARX_PARAMETER_SCOPE_REFUSAL 306

// Automatic store.
#define NARX_PARAMETER_AUTOMATIC_STORE 307

// Other rotor source.
#define NARX_PARAMETER_OTHER_SOURCE 308

// Values of the field "motor mode".
typedef enum narx_motor_mode_t {
    NARX_MOTOR_MODE_STANDBY = 0,
    NARX_MOTOR_MODE_DRIVE = 1,
    NARX_MOTOR_MODE_REVERSE = 2,
    NARX_MOTOR_MODE_FAULT = 3,
} narx_motor_mode_t;

// Values of the field "control mode".
typedef enum narx_control_mode_t {
    NARX_CONTROL_MODE_OFF = 0,
    NARX_CONTROL_MODE_OPEN_LOOP = 1,
    NARX_CONTROL_MODE_SENSORLESS_CLOSED_LOOP = 2,
    NARX_CONTROL_MODE_HALL_CLOSED_LOOP = 3,
} narx_control_mode_t;

// Values of the field "logging state".
typedef enum narx_logging_state_t {
    NARX_LOGGING_STATE_LOG_BOOT_UP = 0,
    NARX_LOGGING_STATE_LOG_INIT = 1,
    NARX_LOGGING_STATE_LOG_WRITE_WAIT_PER = 2,
    NARX_LOGGING_STATE_LOG_WRITE = 3,
    NARX_LOGGING_STATE_LOG_READ_REQ_INIT = 4,
    NARX_LOGGING_STATE_LOG_SEND_READ_REQ = 5,
    NARX_LOGGING_STATE_LOG_WAIT_READ_RESULT = 7,
    NARX_LOGGING_STATE_LOG_READ_SEND_CAN_FRAMES = 8,
    NARX_LOGGING_STATE_LOG_ERASE_ONGOING = 9,
    NARX_LOGGING_STATE_LOG_ERASE_END = 10,
    NARX_LOGGING_STATE_LOG_READ_END = 11,
} narx_logging_state_t;

// Values of the field "parameter status".
typedef enum narx_parameter_status_t {
    NARX_PARAMETER_STATUS_DONE = 0,
    NARX_PARAMETER_STATUS_UNKNOWN_NUMBER = 1,
    NARX_PARAMETER_STATUS_READ_ONLY = 2,
    NARX_PARAMETER_STATUS_OUT_OF_RANGE = 3,
    NARX_PARAMETER_STATUS_WRONG_STATE = 4,
    NARX_PARAMETER_STATUS_STORAGE = 5,
    NARX_PARAMETER_STATUS_NOT_EQUIPPED = 6,
} narx_parameter_status_t;

// Bit of the fault word (Table 9).
#define NARX_FAULT_TEMPERATURE_WARNING 1

// Bit of the fault word (Table 9).
#define NARX_FAULT_OVER_TEMPERATURE 2

// Bit of the fault word (Table 9).
#define NARX_FAULT_OVER_VOLTAGE 4

// Bit of the fault word (Table 9).
#define NARX_FAULT_UNDER_VOLTAGE 8

// Bit of the fault word (Table 9).
#define NARX_FAULT_OVER_CURRENT 0x10u

// Bit of the fault word (Table 9).
#define NARX_FAULT_LEGS_DRIVER 0x20u

// Bit of the fault word (Table 9).
#define NARX_FAULT_HALL_SENSORS 0x40u

// Bit of the fault word (Table 9).
#define NARX_FAULT_OVER_PRESSURE 0x80u

// Bit of the fault word (Table 9).
#define NARX_FAULT_STORE_MISMATCH 0x4000000u

// Bit of the fault word (Table 9).
#define NARX_FAULT_EMERGENCY_SHUTDOWN 0x8000000u

// Bit of the fault word (Table 9).
#define NARX_FAULT_EXTERNAL_SHUTDOWN 0x10000000u

// Bit of the fault word (Table 9).
#define NARX_FAULT_DEVICE_TIMEOUT 0x20000000u

// Bit of the fault word (Table 9).
#define NARX_FAULT_STORE_ABSENT 0x40000000u

// Bit of the fault word (Table 9).
#define NARX_FAULT_STORE_VERSION 0x80000000u

// Extended fault code: temperature above the warning threshold.
#define NARX_CAUSE_TEMPERATURE_WARNING 1

// Extended fault code: temperature above the shutdown threshold.
#define NARX_CAUSE_OVER_TEMPERATURE 0x101u

// Extended fault code: bus voltage above its threshold; at once when 1 V above.
#define NARX_CAUSE_OVER_VOLTAGE 0x201u

// Extended fault code: bus voltage below its threshold.
#define NARX_CAUSE_UNDER_VOLTAGE 0x301u

// Extended fault code: mean DC-link current above its threshold.
#define NARX_CAUSE_OVER_CURRENT 0x401u

// Extended fault code: the gate driver reports a fault.
#define NARX_CAUSE_DRIVER_LINE 0x501u

// Extended fault code: a phase carries no current (three revolutions, or 100 ms at rest).
#define NARX_CAUSE_OPEN_PHASE 0x502u

// Extended fault code: hall codes 000 or 111 (64 more than one a millisecond).
#define NARX_CAUSE_HALL_INVALID 0x601u

// Extended fault code: hall sectors skipped (5 more than one in 13 ms).
#define NARX_CAUSE_HALL_JUMPS 0x602u

// Extended fault code: torque applied at speed 0 (parameter 113) for the stall time (parameter 265).
#define NARX_CAUSE_HALL_STALL 0x603u

// Extended fault code: hall edges run against the torque: wiring, or a load that drives backwards.
#define NARX_CAUSE_HALL_DIRECTION 0x604u

// Extended fault code: the motor goes on without its hall sensors (parameter 308); no fault bit.
#define NARX_CAUSE_HALLS_GIVEN_UP 0x605u

// Extended fault code: pressure above its threshold.
#define NARX_CAUSE_OVER_PRESSURE 0x701u

// Extended fault code: parameter store has another layout.
#define NARX_CAUSE_STORE_MISMATCH 0x1A01u

// Extended fault code: hardware break input.
#define NARX_CAUSE_EMERGENCY_LINE 0x1B01u

// Extended fault code: self-test failed.
#define NARX_CAUSE_SELF_TEST 0x1B02u

// Extended fault code: speed above 130 % of the mode's maximum set-point.
#define NARX_CAUSE_OVERSPEED 0x1B03u

// Extended fault code: the sensorless motor stalls or does not start, five times (one is forgiven in 10 s).
#define NARX_CAUSE_SENSORLESS_STALL 0x1B04u

// Extended fault code: zero crossings jump by more than half an interval, five times (one is forgiven in 10 s).
#define NARX_CAUSE_DESYNCHRONISATION 0x1B05u

// Extended fault code: sensorless speed and applied voltage do not fit together for 150 ms, five times (one is forgiven in 10 s).
#define NARX_CAUSE_WRONG_LOCK 0x1B06u

// Extended fault code: the motor goes on with its hall sensors (parameter 308); no fault bit.
#define NARX_CAUSE_BACK_EMF_GIVEN_UP 0x1B07u

// Extended fault code: shutdown requested over CAN (motor mode 3).
#define NARX_CAUSE_SHUTDOWN_COMMANDED 0x1C01u

// Extended fault code: the digital input configured for shutdown.
#define NARX_CAUSE_SHUTDOWN_LINE 0x1C02u

// Extended fault code: no valid command while driving for the time-out (parameter 114).
#define NARX_CAUSE_COMMAND_TIMEOUT 0x1D01u

// Extended fault code: parameter store absent.
#define NARX_CAUSE_STORE_ABSENT 0x1E01u

// Extended fault code: parameter store of another firmware version.
#define NARX_CAUSE_STORE_VERSION 0x1F01u

// 2000h Node-ID, 1 to 127. Address on the bus, different for every node of it.
#define NARX_TX_ENTRY_NODE_ID 0

// 2001h Bitrate Index, 0 to 4. 0: 50, 1: 100, 2: 250, 3: 500, 4: 1000 kbit/s. The same for every node of the bus.
#define NARX_TX_ENTRY_BITRATE_INDEX 1

// 2002h Nr Of Nodes, 1 to 127. TX-Drivers on the bus, which share half of it among their PDO1 when the update time is 65535.
#define NARX_TX_ENTRY_NR_OF_NODES 2

// 2003h Update Time, 0 to 65535. Period of PDO1. 0: no PDO1. 65535: as short as half of the bus allows for all nodes together.
#define NARX_TX_ENTRY_UPDATE_TIME 3

// 2004h Can Config Register, 0 to 7. Bit 0: Operational after boot-up. Bit 1: PDOs carry the encoder. Bit 2: heartbeat every 2 s.
#define NARX_TX_ENTRY_CAN_CONFIG 4

// 2005h Basic Config Register, 0 to 6. Bit 1: the encoder is rotary, else linear. Bit 2: it counts the other way round. Bit 0 is reserved.
#define NARX_TX_ENTRY_BASIC_CONFIG 5

// 2006h.1 Filter, 0 to 4. Edge frequency of channel 1. 0: no filter, 1: 10 Hz, 2: 100 Hz, 3: 1 kHz, 4: 10 kHz.
#define NARX_TX_ENTRY_FILTER_1 6

// 2006h.2 Filter, 0 to 4. Edge frequency of channel 2, likewise; without effect on a driver of one channel.
#define NARX_TX_ENTRY_FILTER_2 7

// 2007h.1 Comparator, 0 to 1073741824. Output 1 is high while channel 1 is above this fraction of its measuring range.
#define NARX_TX_ENTRY_COMPARATOR_1 8

// 2007h.2 Comparator, 0 to 1073741824. Output 2 likewise for channel 2, or on a driver of one channel for channel 1: a second threshold.
#define NARX_TX_ENTRY_COMPARATOR_2 9

// 2008h Counts Per Revolution, 1 to 65535. Counts of a rotary encoder, four to a period: its value runs from 0 to one less.
#define NARX_TX_ENTRY_COUNTS_PER_REVOLUTION 0xAu

// 2009h Encoder Resolution, 1 to 65535. Length of a linear encoder's count, four to a period. Told to whoever asks; PDOs carry counts.
#define NARX_TX_ENTRY_ENCODER_RESOLUTION 0xBu

// 200Ah Reset Encoder, 0 to 255. Any write, with or without data: the present place of a linear encoder becomes 0.
#define NARX_TX_ENTRY_RESET_ENCODER 0xCu

// 2100h Firmware Version, 0 to 65535. Our own: release of the firmware, major in the high byte.
#define NARX_TX_ENTRY_FIRMWARE_VERSION 0xDu

// Which message: type and opcode, the low 11 bits of its identifier (PROTOCOL.md, section 2).
typedef enum narx_message_kind_t {
    NARX_MESSAGE_BUILD_INFO_REQUEST = 1024,
    NARX_MESSAGE_BUILD_INFO = 0,
    NARX_MESSAGE_DEVICE_INFO_REQUEST = 1025,
    NARX_MESSAGE_DEVICE_INFO = 1,
    NARX_MESSAGE_REQUEST_WORD = 514,
    NARX_MESSAGE_STATUS_WORD = 3,
    NARX_MESSAGE_FAULT_WORD = 4,
    NARX_MESSAGE_CRITICAL_FAULT = 5,
    NARX_MESSAGE_REBOOT_SET = 613,
    NARX_MESSAGE_REBOOT = 101,
    NARX_MESSAGE_MOTOR_CMD_SET = 614,
    NARX_MESSAGE_MOTOR_CMD = 102,
    NARX_MESSAGE_DSIO_DATA_CMD = 615,
    NARX_MESSAGE_DISABLE_HALL_PS = 616,
    NARX_MESSAGE_PARAMETER_SET = 622,
    NARX_MESSAGE_PARAMETER_REQUEST = 1134,
    NARX_MESSAGE_PARAMETER = 110,
    NARX_MESSAGE_LOG_VIRTUAL_SCOPE_SET = 624,
    NARX_MESSAGE_LOG_VIRTUAL_SCOPE_REQUEST = 1136,
    NARX_MESSAGE_LOG_VIRTUAL_SCOPE = 112,
    NARX_MESSAGE_RESTORE_FACTORY_SETTING = 625,
    NARX_MESSAGE_XML_DOWNLOAD_REQUEST = 1154,
    NARX_MESSAGE_XML_DOWNLOAD_ANSWER = 130,
    NARX_MESSAGE_XML_DOWNLOAD_DATA = 131,
    NARX_MESSAGE_EXT_MEM_LOG_READ_DATA = 140,
    NARX_MESSAGE_MEASUREMENT_0 = 200,
    NARX_MESSAGE_MEASUREMENT_1 = 201,
    NARX_MESSAGE_MEASUREMENT_2 = 202,
    NARX_MESSAGE_MEASUREMENT_3 = 203,
    NARX_MESSAGE_MEASUREMENT_4 = 204,
    NARX_MESSAGE_MEASUREMENT_5 = 205,
    NARX_MESSAGE_MEASUREMENT_7 = 207,
    NARX_MESSAGE_MEASUREMENT_8 = 208,
} narx_message_kind_t;

// Fields that a message has at most.
#define NARX_FIELDS_MAX 7

// The fields of a message: those of its own kind count. Raw numbers, with scale and unit beside each.
typedef union narx_fields_t {
    // In the order of their bits; a signed one as its bits.
    uint32_t raw[NARX_FIELDS_MAX];
    struct {
        uint32_t build_number;
        uint32_t source_modified; // 0 no, 1 yes
        uint32_t build_date;
    } build_info;
    struct {
        uint32_t hardware_release;
        uint32_t software_release;
        uint32_t device_number;
        uint32_t can_address;
    } device_info;
    struct {
        uint32_t motor_mode; // a narx_motor_mode_t
    } request_word;
    struct {
        uint32_t log_erase_possible; // 0 no, 1 yes
        uint32_t log_download_possible; // 0 no, 1 yes
        uint32_t log_memory_erased; // 0 no, 1 yes
        uint32_t log_memory_full; // 0 no, 1 yes
        uint32_t logging_state; // a narx_logging_state_t
        uint32_t control_mode; // a narx_control_mode_t
        uint32_t motor_mode; // a narx_motor_mode_t
    } status_word;
    struct {
        uint32_t faults; // sum of NARX_FAULT_*
    } fault_word;
    struct {
        uint32_t faults; // sum of NARX_FAULT_*
        uint32_t extended_fault_code;
    } critical_fault;
    struct {
        uint32_t acknowledged; // 0 no, 1 yes
    } reboot;
    struct {
        uint32_t speed; // rpm
    } motor_cmd_set;
    struct {
        uint32_t speed; // rpm
    } motor_cmd;
    struct {
        uint32_t dsio1_output_enable; // 0 no, 1 yes
        uint32_t dsio1_level; // 0 low, 1 high
        uint32_t dsio2_output_enable; // 0 no, 1 yes
        uint32_t dsio2_level; // 0 low, 1 high
    } dsio_data_cmd;
    struct {
        uint32_t disable; // 0 no, 1 yes
    } disable_hall_ps;
    struct {
        uint32_t number; // a NARX_PARAMETER_*
        int32_t value; // its unit and scale: PROTOCOL.md
    } parameter_set;
    struct {
        uint32_t number; // a NARX_PARAMETER_*
    } parameter_request;
    struct {
        uint32_t number; // a NARX_PARAMETER_*
        int32_t value; // its unit and scale: PROTOCOL.md
        uint32_t status; // a narx_parameter_status_t
    } parameter;
    struct {
        uint32_t address;
        int32_t sample_1;
        int32_t sample_2;
        int32_t sample_3;
    } log_virtual_scope;
    struct {
        uint32_t serial_number;
    } restore_factory_setting;
    struct {
        uint32_t command; // 0 Length, 1 Start
    } xml_download_request;
    struct {
        uint32_t length; // words
        uint32_t crc_32;
    } xml_download_answer;
    struct {
        uint32_t address;
        uint32_t text_1;
        uint32_t text_2;
        uint32_t text_3;
    } xml_download_data;
    struct {
        uint32_t word_counter;
        uint32_t data_1;
        uint32_t data_2;
        uint32_t data_3;
    } ext_mem_log_read_data;
    struct {
        int32_t accel_x; // 10^-3 g
        int32_t accel_y; // 10^-3 g
        int32_t accel_z; // 10^-3 g
        uint32_t dsi1_dsp; // 0 low, 1 high
    } measurement_0;
    struct {
        int32_t mechanical_estimated_speed_sl; // rpm
        int32_t mechanical_position; // 10^-2 deg
        int32_t electrical_input_power; // 10^-1 W
    } measurement_1;
    struct {
        int32_t hv_voltage; // 10^-2 V
        int32_t hv_current; // 10^-3 A
        int32_t _6v_meas; // 10^-3 V
        int32_t driver_14v_voltage; // 10^-3 V
    } measurement_2;
    struct {
        int32_t ambient_temperature; // 10^-1 deg C
        int32_t vref_accel_1_8v; // 10^-3 V
        int32_t _0_383vref; // 10^-3 V
        int32_t asi_dsp; // 10^-3 V
    } measurement_3;
    struct {
        int32_t voltagephasea; // 10^-2 V
        int32_t voltagephaseb; // 10^-2 V
        int32_t voltagephasec; // 10^-2 V
        int32_t pin_meas; // 10^-3 V
    } measurement_4;
    struct {
        int32_t mechanical_estimated_speed_hes; // rpm
        uint32_t dsi2_dsp; // 0 low, 1 high
    } measurement_5;
} narx_fields_t;

// Size of the name and the unit of a setting in narx_setting_error_t, the closing 0 included.
#define NARX_NAME_SIZE 24

// 64-bit words of a drive on any processor.
#define NARX_DRIVE_WORDS 800

// Bytes of a drive on any processor; narx_drive_size returns the bytes that it needs on this one.
#define NARX_DRIVE_SIZE (NARX_DRIVE_WORDS * 8)

// Values that a TX-Driver keeps over a restart: those of the entries NARX_TX_ENTRY_NODE_ID to
// _ENCODER_RESOLUTION, in their order.
#define NARX_TX_VALUES 12

// 64-bit words of a TX-Driver on any processor.
#define NARX_TX_DRIVER_WORDS 56

// 64-bit words of a TX-Driver's master on any processor.
#define NARX_TX_MASTER_WORDS 60

// 1 in Q16 (I16F16), the library's volts, amperes, degrees Celsius and revolutions per second: -32 768 to
// 32 767.99998.
#define NARX_Q16_ONE (1 << 16)

// 1 in IQ24 (I8F24), as DSP libraries have it: -128 to 127.99999994.
#define NARX_IQ24_ONE (1 << 24)

// 1 in Q15 (I1F15), which is one more than its largest value, 32 767: -1 to 0.99997.
#define NARX_Q15_ONE (1 << 15)

// 1 in Q12 (I4F12), the virtual scope's samples: -8 to 7.9998.
#define NARX_Q12_ONE (1 << 12)

// 1 in U1F15, a duty: 0 to 1.
#define NARX_DUTY_ONE (1 << 15)

// 1 turn of an electrical angle, a wrapping uint16_t.
#define NARX_TURN (1 << 16)

// 64-bit words of a master on any processor.
#define NARX_MASTER_WORDS 552

// Rises whenever coefficients of an earlier library would be wrong for this one: what `narx coefficients`
// prints compares it.
#define NARX_COEFFICIENTS_VERSION 12

// Largest number of pattern changes in one period.
#define NARX_COMMUTATIONS_MAX 2

// Size of the longest line that narx_replay_until writes, the closing 0 included.
#define NARX_OUTPUTS_TEXT_SIZE 1024

// Largest number of edges in one period; more are counted in narx_samples_t.edges_lost.
#define NARX_EDGES_MAX 4

// Bit of narx_samples_t.lines: the gate driver reports a fault.
#define NARX_LINE_DRIVER_FAULT 1

// Bit of narx_samples_t.lines: the hardware break input has tripped.
#define NARX_LINE_EMERGENCY 2

// Bit of narx_samples_t.lines: DSIO1 as an input.
#define NARX_LINE_DSI1 4

// Bit of narx_samples_t.lines: DSIO2 as an input.
#define NARX_LINE_DSI2 8

// 64-bit words of a scope's memory on any processor.
#define NARX_SCOPE_WORDS 1446

// 64-bit words of a narx_storage_t on any processor.
#define NARX_STORAGE_WORDS 320

// Largest number of bytes of one program call: a page, within which it stays.
#define NARX_FLASH_PAGE 256

// Bytes of the smallest erase.
#define NARX_FLASH_SUBSECTOR 4096

// Result of every call: 0 or more if the call did its work, negative if it did nothing.
enum narx_status_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Done.
    NARX_OK = 0,
    // Done; there is nothing to hand out.
    NARX_NOTHING = 1,
    // A required pointer is NULL.
    NARX_ERROR_NULL = -1,
    // A pointer is not aligned as its type requires.
    NARX_ERROR_ALIGNMENT = -2,
    // The storage is too small: see the size function of its type.
    NARX_ERROR_SIZE = -3,
    // The storage holds no object of its type: it was not initialised, or a drive was moved since.
    NARX_ERROR_UNINITIALISED = -4,
    // No working controller can be built from the board's constants.
    NARX_ERROR_BOARD = -5,
    // A field of the samples has an undefined value.
    NARX_ERROR_SAMPLES = -6,
    // Not a CAN frame: identifier or length out of range.
    NARX_ERROR_FRAME = -7,
    // No parameter has this number.
    NARX_ERROR_UNKNOWN_PARAMETER = -8,
    // Only the drive writes this parameter.
    NARX_ERROR_READ_ONLY = -9,
    // The value is outside the parameter's range (PROTOCOL.md).
    NARX_ERROR_OUT_OF_RANGE = -10,
    // The parameter cannot be written in this state.
    NARX_ERROR_WRONG_STATE = -11,
    // The parameter store is missing, busy or failed.
    NARX_ERROR_STORAGE = -12,
    // The bytes do not begin like a recording.
    NARX_ERROR_NOT_A_RECORDING = -13,
    // The recording's container has another version.
    NARX_ERROR_CONTAINER_VERSION = -14,
    // The recording holds a drive with another layout of its state.
    NARX_ERROR_LAYOUT_VERSION = -15,
    // The recording is not one of a drive.
    NARX_ERROR_KIND = -16,
    // The recording ends too early.
    NARX_ERROR_TRUNCATED = -17,
    // Bytes of the recording were changed, lost or moved.
    NARX_ERROR_CHECKSUM = -18,
    // The recording has a field that no recorder writes.
    NARX_ERROR_MALFORMED = -19,
    // The recording's initial state is not one of this drive.
    NARX_ERROR_STATE = -20,
    // Not a message of this protocol: identifier, type or length do not fit.
    NARX_ERROR_NOT_A_MESSAGE = -21,
    // A field of the message has an undefined value.
    NARX_ERROR_FIELD = -22,
    // An undefined request, or an undefined value for it.
    NARX_ERROR_REQUEST = -23,
    // The master is silent: it transmits nothing.
    NARX_ERROR_SILENT = -24,
    // Earlier answers were not taken yet, or earlier messages wait for the bus.
    NARX_ERROR_FULL = -25,
    // No answer after all attempts.
    NARX_ERROR_NO_ANSWER = -26,
    // The drive has refused a message to which the protocol has no answer.
    NARX_ERROR_NOT_OBEYED = -27,
    // The drive has no log memory.
    NARX_ERROR_NO_LOG = -28,
    // A record of the log was received whole, but its content is damaged.
    NARX_ERROR_SPOILED = -29,
    // The download was aborted, or the job was ended by another command.
    NARX_ERROR_ABORTED = -30,
    // The node-id is not 1 to 127.
    NARX_ERROR_NODE = -31,
    // No TX-Driver has these channels, sample rate or measuring range.
    NARX_ERROR_VARIANT = -32,
    // No entry has this number.
    NARX_ERROR_UNKNOWN_ENTRY = -33,
    // The node refuses to read or write the entry.
    NARX_ERROR_ENTRY = -34,
    // The node refused to read or write the entry.
    NARX_ERROR_BUS_STATE = -35,
    // A block cannot be built from its settings; narx_setting_error_t names the setting.
    NARX_ERROR_SETTING = -36,
    // An argument has an undefined value.
    NARX_ERROR_ARGUMENT = -37,
    // The drive would clamp this set-point: narx_master_speed_limits.
    NARX_ERROR_SPEED = -38,
    // The board lacks equipment that the value needs (narx_board_t, equipment).
    NARX_ERROR_NOT_EQUIPPED = -39,
    // The drive is in Fault.
    NARX_ERROR_FAULT = -40,
    // The drive refuses the start.
    NARX_ERROR_START_REFUSED = -41,
    // The job has taken too long.
    NARX_ERROR_TIMED_OUT = -42,
    // The hall calibration has not found the sensors.
    NARX_ERROR_NOT_CALIBRATED = -43,
    // The scope is not armed or forced: it is in another state, or the drive refuses it.
    NARX_ERROR_SCOPE_REFUSED = -44,
    // No working controller can be built from the parameters; narx_parameter_error_t names one.
    NARX_ERROR_PARAMETERS = -45,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_status_t narx_status_t;
#else
typedef int32_t narx_status_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A switch pattern: first letter switched (PWM), second held low, third phase floating.
enum narx_step_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // All six switches off.
    NARX_STEP_COAST,
    // A switched, B low.
    NARX_STEP_AB,
    // A switched, C low.
    NARX_STEP_AC,
    // B switched, C low.
    NARX_STEP_BC,
    // B switched, A low.
    NARX_STEP_BA,
    // C switched, A low.
    NARX_STEP_CA,
    // C switched, B low.
    NARX_STEP_CB,
    // Three-phase lock: A switched, B and C low. Pulls the rotor to 180 degrees.
    NARX_STEP_LOCK_A,
    // Three-phase lock: A and B switched, C low. Pulls to 240 degrees.
    NARX_STEP_LOCK_AB,
    // Three-phase lock: B switched, C and A low. Pulls to 300 degrees.
    NARX_STEP_LOCK_B,
    // Three-phase lock: B and C switched, A low. Pulls to 0 degrees.
    NARX_STEP_LOCK_BC,
    // Three-phase lock: C switched, A and B low. Pulls to 60 degrees.
    NARX_STEP_LOCK_C,
    // Three-phase lock: C and A switched, B low. Pulls to 120 degrees.
    NARX_STEP_LOCK_CA,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_step_t narx_step_t;
#else
typedef uint8_t narx_step_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Which part of the PWM cycle the phase voltages show.
enum narx_sample_mode_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // In the off-time: referred to ground or to the mean of the three phases.
    NARX_SAMPLE_MODE_OFF_TIME,
    // In the middle of the on-time: referred to half the bus voltage.
    NARX_SAMPLE_MODE_ON_TIME,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_sample_mode_t narx_sample_mode_t;
#else
typedef uint8_t narx_sample_mode_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Freewheeling of a switched leg's current while its high side is off.
enum narx_rectification_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Through the low side's body diode. Current cannot reverse, so the motor cannot feed the bus.
    NARX_RECTIFICATION_DIODE,
    // Through the low-side switch (complementary PWM with dead time): less loss, current may reverse.
    NARX_RECTIFICATION_SYNCHRONOUS,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_rectification_t narx_rectification_t;
#else
typedef uint8_t narx_rectification_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// System states, numbered as the specification numbers them.
enum narx_state_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // 0: boot and self-tests, PWM off.
    NARX_STATE_INITIALIZATION = 0,
    // 1: PWM off.
    NARX_STATE_STANDBY = 1,
    // 2: holds the rotor at a known position.
    NARX_STATE_ROTOR_LOCK = 2,
    // 3: rotates the field at a commanded speed.
    NARX_STATE_OPEN_LOOP = 3,
    // 4: commutates on back-EMF zero crossings.
    NARX_STATE_SENSORLESS_CLOSED_LOOP = 4,
    // 5: commutates on hall sensors.
    NARX_STATE_HALL_CLOSED_LOOP = 5,
    // 6: PWM off until acknowledged.
    NARX_STATE_FAULT = 6,
    // 7: tries to catch or restart a sensorless motor that has stopped.
    NARX_STATE_SENSORLESS_AUTO_RESTART = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_state_t narx_state_t;
#else
typedef uint8_t narx_state_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The meaning of the bus current's reading. Recordings keep it, but the drive ignores it and takes every
// reading for [`CurrentMode::Average`].
enum narx_current_mode_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Mean DC-link current over the last period.
    NARX_CURRENT_MODE_AVERAGE,
    // Sampled in the middle of the on-time: the phase current.
    NARX_CURRENT_MODE_ON_TIME,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_current_mode_t narx_current_mode_t;
#else
typedef uint8_t narx_current_mode_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Source of an edge.
enum narx_edge_source_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // A hall line.
    NARX_EDGE_SOURCE_HALL,
    // A back-EMF comparator.
    NARX_EDGE_SOURCE_COMPARATOR,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_edge_source_t narx_edge_source_t;
#else
typedef uint8_t narx_edge_source_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Data that can be downloaded.
enum narx_download_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The description of the drive, XML; the high byte of a word comes first.
    NARX_DOWNLOAD_KIND_DESCRIPTION = 0,
    // The scope's record: `count` words, selected signals times samples, at most 65 536. Q3.12.
    NARX_DOWNLOAD_KIND_SCOPE = 1,
    // `count` records of the log from index `first` on; each has half as many words as parameter 69 has
    // bytes.
    NARX_DOWNLOAD_KIND_LOG = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_download_kind_t narx_download_kind_t;
#else
typedef uint8_t narx_download_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A conversation of several messages.
enum narx_job_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Starts the motor as soon as the drive accepts a start; ends when it is in closed loop, or in open loop
    // where no closed loop is enabled.
    NARX_JOB_KIND_START = 0,
    // Calibrates the hall sensors: the motor turns one electrical revolution each way. Ends when it is at
    // rest again.
    NARX_JOB_KIND_CALIBRATE_HALL = 1,
    // Restarts a stopped drive; ends when it is in Standby or Fault again.
    NARX_JOB_KIND_REBOOT = 2,
    // Sets the scope up and arms it.
    NARX_JOB_KIND_ARM_SCOPE = 3,
    // Triggers the armed scope now.
    NARX_JOB_KIND_FORCE_SCOPE = 4,
    // Waits until the scope's record is complete.
    NARX_JOB_KIND_AWAIT_SCOPE = 5,
    // Arms the scope and waits for its record; without a trigger it forces the scope as soon as the samples
    // before the trigger were taken.
    NARX_JOB_KIND_CAPTURE_SCOPE = 6,
    // Erases the log; ends when that is done, after minutes for a full memory.
    NARX_JOB_KIND_ERASE_LOG = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_job_kind_t narx_job_kind_t;
#else
typedef uint8_t narx_job_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Kind of a request to a drive.
enum narx_request_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Read parameter `number`.
    NARX_REQUEST_KIND_READ = 0,
    // Write `value` to parameter `number`.
    NARX_REQUEST_KIND_WRITE = 1,
    // Run the command parameter `number`: NARX_PARAMETER_STORE and others of its kind.
    NARX_REQUEST_KIND_RUN = 2,
    // Read BUILD_INFO; its content is in the frame that answers: narx_message_decode.
    NARX_REQUEST_KIND_BUILD_INFO = 3,
    // Read DEVICE_INFO; its content is in the frame that answers: narx_message_decode.
    NARX_REQUEST_KIND_DEVICE_INFO = 4,
    // Restart the drive.
    NARX_REQUEST_KIND_REBOOT = 5,
    // Restore factory values; `value` is the serial number of the addressed board.
    NARX_REQUEST_KIND_RESTORE_FACTORY = 6,
    // Set the digital lines: `value` bit 0 enables DSIO1, bit 1 is its level, bits 2 and 3 are the same for
    // DSIO2.
    NARX_REQUEST_KIND_DIGITAL_OUTPUTS = 7,
    // Switch the hall supply off (`value` 1), or leave it to parameter 97 (0).
    NARX_REQUEST_KIND_DISABLE_HALL_SUPPLY = 8,
    // Arm the scope; if it is armed, force its trigger.
    NARX_REQUEST_KIND_TRIGGER_SCOPE = 9,
    // Read length and CRC-32 of the description; they are in the frame that answers: narx_message_decode.
    NARX_REQUEST_KIND_DESCRIPTION_INFO = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_request_kind_t narx_request_kind_t;
#else
typedef uint8_t narx_request_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Kind of a message.
enum narx_tx_kind_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Master: NMT command `command` to node `node`, or to all for 0: 1 start, 2 stop, 128 pre-operational,
    // 129 reset.
    NARX_TX_KIND_NMT = 0,
    // Master: SYNC; all nodes sample now and send PDO2.
    NARX_TX_KIND_SYNC = 1,
    // Master: request to `node` for PDO3, of `size` bytes.
    NARX_TX_KIND_REQUEST_PDO = 2,
    // Master: read request for entry `index`, `subindex` of `node`.
    NARX_TX_KIND_READ = 3,
    // Master: request to write `value` to the entry `index`, `subindex` of `node`; `size` is 1 to 4 bytes,
    // or 0 if only the node knows it.
    NARX_TX_KIND_WRITE = 4,
    // Node: boot-up or heartbeat; `command` is its state: 0 boot-up, 4 Stopped, 5 Operational, 127
    // Pre-Operational.
    NARX_TX_KIND_HEARTBEAT = 5,
    // Node: an error; `value` is its code.
    NARX_TX_KIND_ERROR = 6,
    // Node: PDO with `positions` and `encoder`, as far as the layout has them; `command` is the number of
    // the PDO, 1 to 3.
    NARX_TX_KIND_PDO = 7,
    // Node: the entry was written.
    NARX_TX_KIND_WRITTEN = 8,
    // Node: the entry holds `value`, of `size` bytes.
    NARX_TX_KIND_VALUE = 9,
    // Master or node: the request was refused or is aborted; `value` is the abort code (Table 10).
    NARX_TX_KIND_ABORT = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_tx_kind_t narx_tx_kind_t;
#else
typedef uint8_t narx_tx_kind_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A commutation: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_commutator_t {
    // Private.
    uint64_t words[4];
} narx_commutator_t;

// Settings for narx_commutation_init.
typedef struct narx_commutation_settings_t {
    // Timing advance, electrical, 0 to 3000 in 0.01 degree (parameter 273).
    uint16_t advance_cdeg;
    // First instant of a period at which a new step can act, 1/65 536 of it: when the caller has its answer.
    uint16_t earliest;
} narx_commutation_settings_t;

// A setting from which no block can be built.
typedef struct narx_setting_error_t {
    // The rejected value.
    int64_t value;
    // Smallest value that builds, with the other settings as they are.
    int64_t min;
    // Largest value that builds.
    int64_t max;
    // Fraction bits of the three values: 16 for a Q16, 0 for a count.
    uint8_t fraction_bits;
    // Name of the setting: the name of its field.
    char setting[NARX_NAME_SIZE];
    // Its unit, empty without one.
    char unit[NARX_NAME_SIZE];
} narx_setting_error_t;

// Coefficients of the commutator.
typedef struct narx_commutator_coefficients_t {
    // First instant of a period at which a pattern can change, in 1/65 536.
    uint16_t earliest;
    // Timing advance, u32 turn (parameter 273).
    uint32_t advance;
} narx_commutator_coefficients_t;

// One pattern change.
typedef struct narx_commutation_t {
    // Instant of the change, in 1/65 536 of the period.
    uint16_t instant;
    // Pattern from then on.
    narx_step_t step;
} narx_commutation_t;

// The steps of one period.
typedef struct narx_steps_t {
    // The step at the earliest instant.
    narx_step_t step;
    // Number of valid entries of `commutations`.
    uint8_t commutation_count;
    // Changes later in the period, in order of time.
    struct narx_commutation_t commutations[NARX_COMMUTATIONS_MAX];
} narx_steps_t;

// Settings for narx_fault_init. The time for which each condition must hold is listed with its cause in
// PROTOCOL.md.
typedef struct narx_fault_settings_t {
    // Ticks a second, 1 000 to 100 000 Hz.
    uint32_t tick_rate;
    // Largest bus voltage, 0 to 1 000 V; cleared 0.5 V below. Q16.
    int32_t over_voltage;
    // Least bus voltage, 0 V to 1 V below the largest; cleared 0.5 V above. Q16.
    int32_t under_voltage;
    // Largest magnitude of the mean DC-link current, 0 to 1 000 A; cleared 1/16 below. Q16.
    int32_t over_current;
    // Temperature of the shutdown, -100 to 1 000 degrees C; cleared 2 below. Q16.
    int32_t over_temperature;
    // Temperature of the warning, no more than that of the shutdown. Q16.
    int32_t warning;
    // Largest pressure reading, -1 000 to 1 000 V; cleared 1/16 below. Q16.
    int32_t over_pressure;
    // Largest electrical speed that is requested, 0 to 10 000 rev/s: 30 % above is overspeed. Q16.
    int32_t speed_max;
    // Critical fault mask (parameter 115, 1 = critical); faults that protect the power stage are critical
    // while driving in any case.
    uint32_t critical_mask;
    // Torque without a hall edge for this long is a stall, 1 to 65 535 ms (parameter 265).
    uint32_t hall_stall_ms;
    // Digital inputs that shut down. Sum of NARX_LINE_*.
    uint8_t shutdown_lines;
} narx_fault_settings_t;

// Fault logic: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_fault_t {
    // Private.
    uint64_t words[29];
} narx_fault_t;

// A limit with hysteresis, raw I16F16. `clear` lies on the safe side of `trip`.
typedef struct narx_limit_t {
    // Beyond this the fault qualifies.
    int32_t trip;
    // Back beyond this its cause is gone.
    int32_t clear;
    // Ticks in a row that the condition must hold, at least 1.
    uint16_t ticks;
} narx_limit_t;

// Coefficients of the fault logic.
typedef struct narx_protection_coefficients_t {
    // Bus over-voltage.
    struct narx_limit_t over_voltage;
    // Bus voltage above which that qualifies at once.
    int32_t over_voltage_at_once;
    // Bus under-voltage.
    struct narx_limit_t under_voltage;
    // Mean DC-link current, magnitude.
    struct narx_limit_t over_current;
    // Temperature, shutdown.
    struct narx_limit_t over_temperature;
    // Temperature, warning.
    struct narx_limit_t warning;
    // Pressure reading, volts.
    struct narx_limit_t over_pressure;
    // Speed above 130 % of the mode's maximum, electrical rev/s: hall.
    struct narx_limit_t overspeed_hall;
    // Speed above 130 % of the maximum of sensorless and open loop.
    struct narx_limit_t overspeed_sensorless;
    // Which digital inputs shut down.
    uint8_t shutdown_lines;
    // Ticks a shutdown line must hold.
    uint16_t shutdown_ticks;
    // Bits that are critical (parameter 115).
    uint32_t critical_mask;
    // Ticks under torque at speed 0, which is itself parameter 113 without a hall edge (parameter 265).
    uint32_t hall_stall_ticks;
    // Below this bus voltage a diagnostic is shown, raw I16F16.
    int32_t supply_low;
    // Ticks in a millisecond, 1/256: the leak of the plausibility counts.
    uint16_t ticks_per_ms;
} narx_protection_coefficients_t;

// Inputs of the fault logic in one tick. Quantities are Q16; a flag is set if it is not 0. All zeros
// describe a board at rest without a supply.
typedef struct narx_evidence_t {
    // Bus voltage.
    int32_t bus_voltage;
    // Mean DC-link current of this tick.
    int32_t bus_current;
    // Mean DC-link current after a first-order filter of 64 ticks.
    int32_t bus_current_filtered;
    // Temperature of the power stage.
    int32_t temperature;
    // Pressure reading, V.
    int32_t pressure;
    // Electrical speed, magnitude, rev/s.
    int32_t speed;
    // Faults of a parameter store: NARX_FAULT_STORE_*.
    uint32_t store_faults;
    // Failure of sensorless control: NARX_CAUSE_SENSORLESS_STALL, _DESYNCHRONISATION or _WRONG_LOCK; 0
    // without one.
    uint16_t sensorless;
    // Digital inputs: sum of NARX_LINE_*.
    uint8_t lines;
    // The master's request: 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown.
    uint8_t request;
    // A self-test has failed.
    uint8_t self_test_failed;
    // The hall code is 000 or 111.
    uint8_t hall_invalid;
    // The hall sensors have jumped over a sector.
    uint8_t hall_jump;
    // Sectors that the hall sensors have turned in this tick, signed.
    int8_t hall_sectors;
    // No hall edge came for the hall time-out.
    uint8_t hall_stopped;
    // The hall closed loop is running: its sensors are checked for plausibility.
    uint8_t hall_driving;
    // The bridge is on, or a start is about to turn it on.
    uint8_t driving;
    // Sign of the torque that was applied in the last tick: 1 forward, -1 reverse, 0 none.
    int8_t torque;
    // A phase is open.
    uint8_t open_phase;
} narx_evidence_t;

// Outputs of the fault logic.
typedef struct narx_faults_t {
    // Faults that are present or latched: sum of NARX_FAULT_*.
    uint32_t word;
    // Latched faults.
    uint32_t critical;
    // Extended code of the first critical fault, a NARX_CAUSE_*; 0 without one.
    uint16_t cause;
    // Not 0: a critical fault is present; the bridge must be switched off.
    uint8_t present;
    // Not 0: none of the latched causes is present any more.
    uint8_t causes_gone;
} narx_faults_t;

// A change of state.
typedef struct narx_change_t {
    // State before: a narx_state_t.
    uint8_t from;
    // State after.
    uint8_t to;
    // Not 0: the change fired because of the command time-out.
    uint8_t timed_out;
} narx_change_t;

// Settings for narx_hall_init.
typedef struct narx_hall_settings_t {
    // Ticks a second, 1 000 to 100 000 Hz.
    uint32_t tick_rate;
    // Offset of the edges beyond their place, -18 000 to 18 000 in 0.01 electrical degree (parameter 80).
    int32_t offset_cdeg;
    // No edge for this long means standstill, 1 to 65 535 ms (parameter 113), and no more than 65 535 ticks.
    uint32_t timeout_ms;
    // Slowest electrical speed that is interpolated between edges, rev/s; below, the middle of the sector
    // stands for all of it. Q16.
    int32_t interpolation_min;
    // Permutation of the lines, 0 to 5 (parameter 262); 0 is A, B, C.
    uint8_t order;
    // Lines to invert before the permutation, 0 to 7: bit 0 = A, bit 1 = B, bit 2 = C.
    uint8_t polarity;
    // Not 0: edges are time-stamped; else only the level is read, once a tick.
    uint8_t captured;
} narx_hall_settings_t;

// A hall station: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_hall_t {
    // Private.
    uint64_t words[15];
} narx_hall_t;

// Coefficients of the hall station.
typedef struct narx_hall_coefficients_t {
    // Sector by raw code, 0xFF = invalid; built from the wiring.
    uint8_t sectors[8];
    // Angle by which the edges lie beyond 30 + 60 k degrees.
    uint16_t offset;
    // No edge for this long, in 1/65 536 tick, means standstill (parameter 113).
    uint32_t timeout;
    // Slowest speed that is interpolated between edges, in 2^-32 turn a tick.
    uint32_t interpolation_min;
    // Edges come time-stamped; the level alone is a late witness.
    bool captured;
    // Ticks of an invalid level after which the position is lost.
    uint8_t lost_after;
} narx_hall_coefficients_t;

// A factor: `mantissa` x 2^-`shift`. A gain in IQ24 is {gain, 24}, one in Q15 {gain, 15}.
typedef struct narx_gain_t {
    // 0 to 2^30 - 1, so that the product with any 32-bit value fits 64 bits.
    int32_t mantissa;
    // Fraction bits, 0 to 62.
    uint32_t shift;
} narx_gain_t;

// Ready-made coefficients of a hall station: those that its settings build.
typedef struct narx_hall_ready_t {
    // The station's own.
    struct narx_hall_coefficients_t station;
    // Rev/s (raw I16F16) of 2^-32 turn a tick.
    struct narx_gain_t speed_of_turns;
} narx_hall_ready_t;

// One time-stamped edge.
typedef struct narx_edge_t {
    // Instant, in 1/65 536 of the period that has just ended.
    uint16_t instant;
    // Source of the edge: a narx_edge_source_t.
    uint8_t source;
    // The three lines after the edge: bit 0 = A, bit 1 = B, bit 2 = C.
    uint8_t code;
} narx_edge_t;

// Reading of the sensors after a tick.
typedef struct narx_hall_reading_t {
    // Electrical angle at the present period's boundary, 2^32 a turn; for narx_commutation_step.
    uint32_t angle;
    // Speed, 2^-32 turn a tick, signed; for narx_commutation_step.
    int32_t turn_speed;
    // Electrical speed, Q16 rev/s, signed, limited by the time for which the next edge has not come.
    int32_t speed;
    // Sector, 0 to 5: sector s spans 30 + 60 s to 90 + 60 s degrees; 255 until the first valid code.
    uint8_t sector;
    // Sectors turned in this tick, signed.
    int8_t sectors;
    // Not 0: the present code is 000 or 111.
    uint8_t invalid;
    // Not 0: a sector was jumped over in this tick.
    uint8_t jump;
    // Not 0: no edge came for the time-out: standstill.
    uint8_t stopped;
    // Not 0: the position is doubtful; torque by this position could act in any direction.
    uint8_t doubtful;
} narx_hall_reading_t;

// A PI controller: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_pi_t {
    // Private.
    uint64_t words[5];
} narx_pi_t;

// Settings for narx_pi_init. Errors and outputs are Q16 in units of the caller's choice.
typedef struct narx_pi_settings_t {
    // Kp: output per error.
    struct narx_gain_t proportional;
    // Ki: output per error and second.
    struct narx_gain_t integral;
    // Steps a second, 1 to 1 000 000 Hz.
    uint32_t step_rate;
    // Least output, Q16.
    int32_t minimum;
    // Largest output, Q16, not below the least.
    int32_t maximum;
} narx_pi_settings_t;

// Gains of a PI controller, built for one step rate.
typedef struct narx_pi_gains_t {
    // Output per error.
    struct narx_gain_t proportional;
    // Output per error and step: Ki x step time.
    struct narx_gain_t integral;
} narx_pi_gains_t;

// Ready-made coefficients of a PI controller: those that its settings build.
typedef struct narx_pi_ready_t {
    // Gains of one step: Kp, and Ki x step time.
    struct narx_pi_gains_t gains;
    // Least output, raw I16F16.
    int32_t minimum;
    // Largest output, raw I16F16, not below the least.
    int32_t maximum;
} narx_pi_ready_t;

// A ramp: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_ramp_t {
    // Private.
    uint64_t words[3];
} narx_ramp_t;

// Settings for narx_ramp_init.
typedef struct narx_ramp_settings_t {
    // Steepest change, Q16 a second, more than 0.
    int32_t rate;
    // Steps a second, 1 to 1 000 000 Hz.
    uint32_t step_rate;
} narx_ramp_settings_t;

// Ready-made coefficients of a ramp: those that its settings build.
typedef struct narx_ramp_ready_t {
    // Largest change of one step, raw I16F16 with 16 extra bits.
    int64_t rate;
} narx_ramp_ready_t;

// Settings for narx_state_init. Durations are 0 to 3 600 000 ms.
typedef struct narx_state_settings_t {
    // Ticks a second, 1 000 to 100 000 Hz.
    uint32_t tick_rate;
    // Boot time (T01).
    uint32_t boot_ms;
    // Rotor lock (T23).
    uint32_t lock_ms;
    // Open loop before sensorless (T34).
    uint32_t open_loop_ms;
    // Auto-restart (T71, T74).
    uint32_t auto_restart_ms;
    // Wait before a fault can be acknowledged (T61).
    uint32_t fault_wait_ms;
    // Longest time without a command while driving; more is a fault.
    uint32_t command_timeout_ms;
    // Not 0: open loop may run the motor (Table 6).
    uint8_t open_loop;
    // Not 0: the sensorless loop may run the motor (Table 6).
    uint8_t sensorless;
    // Not 0: the hall loop may run the motor (Table 6), before the others.
    uint8_t hall;
} narx_state_settings_t;

// A state machine: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_state_machine_t {
    // Private.
    uint64_t words[12];
} narx_state_machine_t;

// Coefficients of the state machine. Durations are in ticks.
typedef struct narx_machine_coefficients_t {
    // Open loop may run the motor (Table 6).
    bool open_loop_enable;
    // The sensorless loop may run the motor (Table 6).
    bool sensorless_enable;
    // The hall loop may run the motor (Table 6), before the others.
    bool hall_enable;
    // Boot-up time (T01): 0.5 s.
    uint32_t boot;
    // Rotor lock (T23).
    uint32_t lock;
    // Rotor lock level (parameter 89).
    int32_t lock_level;
    // Its rise a millisecond with 16 extra bits: a quarter of the lock.
    int64_t lock_rate;
    // Open loop before sensorless (T34).
    uint32_t open_loop;
    // Auto-restart time (T71, T74): 2 s.
    uint32_t auto_restart;
    // Wait before a fault can be acknowledged (T61).
    uint32_t fault_wait;
    // Command time-out.
    uint32_t command_timeout;
    // A closed loop goes on by the other one's source where its own fails (parameter 308); both are enabled.
    bool other_source;
} narx_machine_coefficients_t;

// Inputs of the state machine in one tick; a flag is set if it is not 0.
typedef struct narx_state_inputs_t {
    // A critical fault is present.
    uint8_t critical;
    // Self-tests or parameter store failed.
    uint8_t unhealthy;
    // None of the latched faults' causes is present.
    uint8_t causes_gone;
    // Estimated speed is 0, as the running mode judges it.
    uint8_t stopped;
    // A hall calibration has a result.
    uint8_t calibrated;
    // A working controller can be built from the present parameters.
    uint8_t parameters_fit;
} narx_state_inputs_t;

// Present state of the machine.
typedef struct narx_state_report_t {
    // Ticks in the present state, saturating.
    uint32_t age;
    // A narx_state_t.
    uint8_t state;
    // Direction of this start: 0 forward, 1 reverse.
    uint8_t direction;
    // Reason why the last start was refused: 0 it was not, 1 no mode is enabled, 2 parameters, 4 Standby was
    // not requested since the last stop.
    uint8_t refusal;
    // Not 0: this tick turns the bridge on unless a condition prevents the start.
    uint8_t starting;
} narx_state_report_t;

// One channel of the converter: value = (code - zero) * micro_per_code / 1 000 000.
typedef struct narx_channel_t {
    // Nominal code at 0 V or 0 A, 0 to 4095.
    uint16_t zero;
    // Micro-units (uV or uA) of one code; positive.
    int32_t micro_per_code;
} narx_channel_t;

// Settings for narx_zero_crossing_init.
typedef struct narx_zero_crossing_settings_t {
    // Ticks a second, 1 000 to 100 000 Hz.
    uint32_t tick_rate;
    // Scale of the three phase terminals.
    struct narx_channel_t terminal;
    // Scale of the bus voltage.
    struct narx_channel_t bus_voltage;
    // Least blanking after a commutation, 0 to 100 000 us (parameter 86).
    uint32_t blanking_us;
    // Delay of a rising crossing, -10 000 to 10 000 us (parameter 100).
    int32_t delay_rising_us;
    // Delay of a falling crossing, -10 000 to 10 000 us.
    int32_t delay_falling_us;
    // Line-to-line back-EMF, 0 to 1 000 000 uV a mechanical rpm (parameter 267); 0 unknown, then off-time
    // crossings are not corrected for their threshold.
    uint32_t back_emf_uv_per_rpm;
    // Instant of the period at which a new step acts, 1/65 536 of it, and the advance of the next
    // commutation.
    struct narx_commutation_settings_t commutation;
    // Pole pairs, 1 to 100.
    uint16_t pole_pairs;
    // No crossing for this long is standstill, 1 to 32 767 ticks (parameter 85).
    uint16_t timeout_ticks;
    // Smallest signal that stands out of the noise, 1 to 255 codes of a terminal.
    uint8_t noise_codes;
    // Not 0: comparators with captured edges take the place of samples.
    uint8_t comparator;
} narx_zero_crossing_settings_t;

// A zero crossing detector with its estimator: memory that the caller owns. It may be copied and moved
// between calls.
typedef struct narx_zero_crossing_t {
    // Private.
    uint64_t words[38];
} narx_zero_crossing_t;

// One converter channel: `value = (code - zero) x gain + offset`, as one multiplication and one sum.
typedef struct narx_channel_scale_t {
    // Raw I16F16 per code, with 16 extra bits.
    uint32_t gain;
    // Offset that is added to every value, raw I16F16; `bias` contains it.
    int32_t offset;
    // Value of code 0, raw I16F16 with 32 extra bits.
    int64_t bias;
} narx_channel_scale_t;

// Coefficients of the back-EMF station.
typedef struct narx_back_emf_coefficients_t {
    // Scale of the phase terminals.
    struct narx_channel_scale_t terminal;
    // Smallest signal of one sample that stands out of the noise, converter codes.
    int32_t noise;
    // Terminals below this code show no back-EMF: less than the noise.
    uint16_t silence;
    // Ticks without voltage after which the windings carry no more current.
    uint16_t settle;
    // Least blanking after a commutation, 1/65 536 tick (parameter 86).
    uint32_t discard;
    // First instant of a period at which a pattern changes, 1/65 536.
    uint16_t earliest;
    // Back-EMF comparators with capture take the converter's place.
    bool comparator;
    // Delay of a rising crossing, 1/65 536 tick (parameter 100).
    int32_t delay_rising;
    // Delay of a falling crossing, 1/65 536 tick (parameters 100 and 286).
    int32_t delay_falling;
    // Volts of back-EMF per electrical rev/s (parameter 267), 0 unknown.
    struct narx_gain_t back_emf;
    // Back-EMF per 2^-32 turn a tick.
    struct narx_gain_t emf_of_turns;
} narx_back_emf_coefficients_t;

// Ready-made coefficients of a detector: those that its settings build.
typedef struct narx_zero_crossing_ready_t {
    // The station's own.
    struct narx_back_emf_coefficients_t back_emf;
    // Of the commutation that follows a crossing.
    struct narx_commutator_coefficients_t commutator;
    // Scale of the bus voltage.
    struct narx_channel_scale_t bus_voltage;
    // Rev/s (raw I16F16) of 2^-32 turn a tick.
    struct narx_gain_t speed_of_turns;
    // No crossing for this long is standstill, 1/65 536 tick.
    uint32_t timeout;
} narx_zero_crossing_ready_t;

// All inputs of the tick `tick`, measured in period `tick` at the instant that the previous command
// requested.
typedef struct narx_samples_t {
    // Number of this PWM period since power-up.
    uint64_t tick;
    // Terminal voltages of phases A, B, C against ground, converter codes.
    uint16_t phase_voltage[3];
    // Bus voltage, converter code.
    uint16_t bus_voltage;
    // Bus current, converter code; see current_mode.
    uint16_t bus_current;
    // Time from the bus voltage's conversion to phase C's, in 1/65 536 of a period (A and B lie evenly
    // between).
    uint16_t skew;
    // Part of the period in which the phase voltages were sampled: a narx_sample_mode_t.
    uint8_t sample_mode;
    // Kind of bus_current: a narx_current_mode_t. The drive ignores it and takes every reading for
    // NARX_CURRENT_MODE_AVERAGE.
    uint8_t current_mode;
    // Hall lines at the sampling instant: bit 0 = A, bit 1 = B, bit 2 = C.
    uint8_t hall;
    // Digital inputs at the sampling instant: sum of NARX_LINE_*, a bit is set while the input is asserted.
    uint8_t lines;
    // Number of valid `edges`.
    uint8_t edge_count;
    // Number of edges of period `tick` - 1 beyond NARX_EDGES_MAX.
    uint8_t edges_lost;
    // Edges captured during the whole of period `tick` - 1, oldest first.
    struct narx_edge_t edges[NARX_EDGES_MAX];
} narx_samples_t;

// The pattern that was applied in the period that has ended.
typedef struct narx_applied_t {
    // Instant at which the phases were sampled, in 1/65 536 of the period.
    uint16_t sample_at;
    // Step at the period's earliest instant: a narx_step_t.
    uint8_t step;
    // Number of changes that followed.
    uint8_t commutation_count;
    // Instants of the changes, in 1/65 536 of the period.
    uint16_t instants[NARX_COMMUTATIONS_MAX];
    // Steps after the changes.
    uint8_t steps[NARX_COMMUTATIONS_MAX];
} narx_applied_t;

// Reading of the terminals after a tick.
typedef struct narx_zero_crossing_reading_t {
    // Age of a crossing that was seen in this tick: time from it to the present boundary, 1/65 536 tick,
    // negative after the boundary; INT32_MIN without one.
    int32_t crossing;
    // Time from the present boundary to the next commutation, 1/65 536 tick: 0 is now, UINT32_MAX is
    // unknown.
    uint32_t commutation;
    // Electrical angle at the present boundary, 2^32 a turn; for narx_commutation_step.
    uint32_t angle;
    // Speed, 2^-32 turn a tick, signed; for narx_commutation_step.
    int32_t turn_speed;
    // Electrical speed, Q16 rev/s, signed; 0 while unknown.
    int32_t speed;
    // Crossings accepted since narx_zero_crossing_init, wrapping.
    uint32_t accepted;
    // Lag of the last accepted crossing behind its prediction, 65 536 a turn.
    int16_t margin;
    // Outcome of the last step's crossing: 0 none yet, 1 accepted, 2 too early, 3 not seen, 4 hidden by
    // demagnetisation, 5 seen on a coasting motor.
    uint8_t why;
    // Not 0: six consistent crossings of both polarities; the position may close a loop.
    uint8_t running;
    // Not 0: the bridge must be switched off: 1 stalled, 2 out of step.
    uint8_t lost;
} narx_zero_crossing_reading_t;

// Constants of a board.
typedef struct narx_board_t {
    // Control ticks, and PWM periods, per second (Hz): 1 000 to 100 000.
    uint32_t tick_rate;
    // First instant of a period at which a new step can act, in 1/65 536 of the period: the sample is taken
    // and narx_drive_step has returned.
    uint16_t earliest;
    // Time for which both switches of a leg stay off between one and the other, ns.
    uint16_t dead_time_ns;
    // Resistance of the two switches that conduct in a step, milliohm; the drive computes its losses from it
    // (output power, Table 1).
    uint16_t bridge_milliohm;
    // Not 0: the hall lines have time-stamping input captures.
    uint8_t hall_capture;
    // Not 0: back-EMF comparators with time-stamping input captures watch the floating phase.
    uint8_t comparator_capture;
    // Parts that the board has; the drive refuses a parameter value that needs another one. Sum of 1
    // external temperature sensor, 2 switch for the supply of the hall sensors, 4 DSIO1 and DSIO2 as inputs,
    // 8 as outputs, 16 accelerometer, 32 pressure input, 64 memory of the log.
    uint8_t equipment;
    // Bus voltage, uV per code.
    struct narx_channel_t bus_voltage;
    // Terminal voltages of the three phases against ground, uV per code.
    struct narx_channel_t phase_voltage;
    // DC-link current, uA per code; positive from the supply into the bridge.
    struct narx_channel_t bus_current;
} narx_board_t;

// A drive: memory that the caller owns, static, on a stack or from a pool. Its content is private to the
// library. It must neither move nor be copied after narx_drive_init. To end a drive, stop calling it.
typedef struct narx_drive_t {
    // Private.
    uint64_t words[NARX_DRIVE_WORDS];
} narx_drive_t;

// Identity of firmware and board (BUILD_INFO, DEVICE_INFO, parameters 4 to 7).
typedef struct narx_identity_t {
    // Date of the build, YYYYMMDD in decimal.
    uint32_t build_date;
    // Build number of the firmware.
    uint16_t build_number;
    // Release of the board.
    uint16_t hardware_release;
    // Release of the firmware: major in the high byte, minor in the low byte.
    uint16_t software_release;
    // Not 0: built from sources that were not committed.
    uint8_t source_modified;
} narx_identity_t;

// A parameter that was stored.
typedef struct narx_stored_t {
    // Number of the parameter: a NARX_PARAMETER_*.
    uint16_t number;
    // Raw value.
    int32_t value;
} narx_stored_t;

// The answer to the samples of period k. `step` and `commutations` act in period k, the rest from period k +
// 1.
typedef struct narx_pwm_command_t {
    // Duty of the switched legs in period k + 1: U1F15, at most 32 768 = 1. The on-time is centred on the
    // period's boundary.
    uint16_t duty;
    // Sampling instant in period k + 1, in 1/65 536 of it.
    uint16_t sample_at;
    // Part of the period in which that sample is taken.
    narx_sample_mode_t sample_mode;
    // Freewheeling in period k + 1.
    narx_rectification_t rectification;
    // The pattern to apply at once, when the call that writes it returns. Coast turns all six switches off.
    narx_step_t step;
    // Number of valid entries of `commutations`.
    uint8_t commutation_count;
    // Pattern changes later in period k, in order of time, none before the board's `earliest`.
    struct narx_commutation_t commutations[NARX_COMMUTATIONS_MAX];
} narx_pwm_command_t;

// A classic CAN frame.
typedef struct narx_frame_t {
    // Identifier: 11 bits, or 29 if `extended`.
    uint32_t id;
    // Not 0: the identifier has 29 bits.
    uint8_t extended;
    // Not 0: a remote request, without data.
    uint8_t remote;
    // Number of data bytes, or of those that a remote frame requests: 0 to 8.
    uint8_t length;
    // Data bytes; the first `length` are valid.
    uint8_t data[8];
} narx_frame_t;

// A TX-Driver: memory that the caller owns. Its content is private to the library; it may be copied and
// moved between calls. Calls for one TX-Driver must not interrupt each other.
typedef struct narx_tx_driver_t {
    // Private.
    uint64_t words[NARX_TX_DRIVER_WORDS];
} narx_tx_driver_t;

// Hardware and firmware of a TX-Driver. Positions in 2^-27 mm.
typedef struct narx_tx_variant_t {
    // Number of sensors: 1 or 2.
    uint8_t channels;
    // Release of the firmware, major in the high byte (2100h).
    uint16_t firmware;
    // Rate at which narx_tx_driver_handle_sample is called, Hz.
    uint32_t sample_rate;
    // Start of each sensor's measuring range.
    int32_t range_start[2];
    // End of each sensor's measuring range, beyond its start.
    int32_t range_end[2];
} narx_tx_variant_t;

// Fault confinement of the CAN controller (ISO 11898-1).
typedef struct narx_bus_state_t {
    // 0: error active, 1: error passive, 2: off the bus.
    uint8_t error;
    // Transmit error counter.
    uint16_t transmit_errors;
    // Receive error counter.
    uint16_t receive_errors;
} narx_bus_state_t;

// Layout of a node's PDOs.
typedef struct narx_tx_layout_t {
    // Number of sensors: 1 or 2.
    uint8_t channels;
    // Not 0: the encoder's value follows.
    uint8_t encoder;
} narx_tx_layout_t;

// State of a TX-Driver that its board needs.
typedef struct narx_tx_driver_report_t {
    // Bit rate for the CAN controller, bit/s.
    uint32_t bits_per_second;
    // The node-id in force.
    uint8_t node;
    // NMT state: 4 Stopped, 5 Operational, 127 Pre-Operational.
    uint8_t state;
    // Layout of its PDOs.
    struct narx_tx_layout_t layout;
    // Levels of the two switching outputs.
    uint8_t outputs[2];
} narx_tx_driver_report_t;

// The master of one TX-Driver: memory that the caller owns. Its content is private to the library; it may be
// copied and moved between calls. Calls for one master must not interrupt each other.
typedef struct narx_tx_master_t {
    // Private.
    uint64_t words[NARX_TX_MASTER_WORDS];
} narx_tx_master_t;

// Answer to a request.
typedef struct narx_tx_answer_t {
    // NARX_OK, NARX_ERROR_NO_ANSWER, or NARX_ERROR_ENTRY with the abort code of Table 10 in `value`.
    narx_status_t status;
    // Value that was read or written.
    uint32_t value;
    // Entry of the request: a NARX_TX_ENTRY_*.
    uint8_t entry;
    // Not 0: the request was a write; else a read.
    uint8_t written;
} narx_tx_answer_t;

// State of a node, from its last messages.
typedef struct narx_tx_node_report_t {
    // Time of reception of the last positions, microseconds; UINT64_MAX before the first.
    uint64_t at;
    // The last positions, 2^-27 mm; 0 before the first.
    int32_t positions[2];
    // Number of boot-up messages.
    uint32_t boots;
    // Number of error messages.
    uint32_t errors;
    // Number of the node's frames that cannot be decoded: most likely PDOs of another layout.
    uint32_t malformed;
    // Encoder, counts; 0 before the first.
    uint16_t encoder;
    // Code of the last error message; 0 before the first.
    uint16_t last_error;
    // Not 0: a frame of the node was received within the last 5 s.
    uint8_t present;
    // State in the last heartbeat; 255 before the first.
    uint8_t state;
} narx_tx_node_report_t;

// An eddyCAN message (PROTOCOL.md, section 10). Fields that are not named at its kind are ignored.
typedef struct narx_tx_message_t {
    // Kind: a narx_tx_kind_t.
    uint8_t kind;
    // Node-id, 1 to 127.
    uint8_t node;
    // NMT command or state, or number of the PDO.
    uint8_t command;
    // Subindex of the entry.
    uint8_t subindex;
    // Index of the entry.
    uint16_t index;
    // Counts of the encoder.
    uint16_t encoder;
    // Number of bytes of a value.
    uint8_t size;
    // Not 0: the node sends this NARX_TX_KIND_ABORT; else the master does.
    uint8_t from_node;
    // Value, error code or abort code.
    uint32_t value;
    // Position of each channel, 2^-27 mm.
    int32_t positions[2];
} narx_tx_message_t;

// Readings of the board besides the tick's samples, before calibration. Volts and degrees Celsius in Q16:
// 65 536 is 1 (narx_q16_from_milli).
typedef struct narx_slow_inputs_t {
    // Sensor on the power board.
    int32_t ambient_temperature;
    // External sensor, if there is one (parameter 8).
    int32_t external_temperature;
    // Pressure input after its amplifier.
    int32_t pressure;
    // Outputs of the accelerometer along X, Y, Z: 0.5 V a g about its zero-g level.
    int32_t accel[3];
    // 1.8 V reference of the accelerometer.
    int32_t accel_reference;
    // 0.383 VREF.
    int32_t reference;
    // 6 V rail.
    int32_t rail_6v;
    // 14 V rail of the gate drivers.
    int32_t rail_14v;
    // Analog signal input.
    int32_t asi;
    // Not 0: DSIO1 reads high.
    uint8_t dsi1;
    // Not 0: DSIO2 reads high.
    uint8_t dsi2;
} narx_slow_inputs_t;

// Levels to apply to the board: 0 or 1.
typedef struct narx_outputs_t {
    // 1: DSIO1 is an output; 0: an input.
    uint8_t dsio1_enable;
    // Level of DSIO1.
    uint8_t dsio1_level;
    // 1: DSIO2 is an output; 0: an input.
    uint8_t dsio2_enable;
    // Level of DSIO2.
    uint8_t dsio2_level;
    // Switch for the supply of the hall sensors.
    uint8_t hall_supply;
} narx_outputs_t;

// Configuration of a master. Times in microseconds.
typedef struct narx_master_config_t {
    // Period of the set-points, at least 1 000; default 50 000.
    uint64_t setpoint_period;
    // Longest time until an answer, at least 1 000; default 100 000.
    uint64_t timeout;
    // Silence after which the drive counts as lost; default 500 000.
    uint64_t lost_after;
    // CAN address of the drive; default 170.
    uint8_t drive;
    // CAN address of the master; default 85.
    uint8_t master;
    // Not 0: listens only and transmits nothing; default 0.
    uint8_t silent;
    // Not 0: reads every parameter when the first frame of the drive is received, and after it was lost;
    // default 1.
    uint8_t read_parameters;
    // Number of times that a message is sent before it counts as not answered; default 3.
    uint8_t attempts;
} narx_master_config_t;

// The master of one drive: memory that the caller owns. Its content is private to the library; it may be
// copied and moved between calls. Calls for one master must not interrupt each other; different masters
// share nothing.
typedef struct narx_master_t {
    // Private.
    uint64_t words[NARX_MASTER_WORDS];
} narx_master_t;

// Set-points that the drive accepts unchanged, and the parameters that state them.
typedef struct narx_speed_limits_t {
    // Smallest magnitude, rpm.
    uint16_t min;
    // Largest magnitude, rpm.
    uint16_t max;
    // Number of the parameter of `min`: 102, 104, or 88 in open loop; 65 535 while no mode is enabled.
    uint16_t min_parameter;
    // Number of the parameter of `max`: 101, 103, or 88 in open loop; 65 535 while no mode is enabled.
    uint16_t max_parameter;
} narx_speed_limits_t;

// State of a drive, from its last messages.
typedef struct narx_drive_report_t {
    // Not 0: a frame of the drive was received within `lost_after` of narx_master_config_t, or within three
    // of its broadcast periods if that is longer.
    uint8_t connected;
    // State: a narx_state_t, or 255 while unknown.
    uint8_t state;
    // Motor mode of the last STATUS_WORD: a narx_motor_mode_t, or 255 before the first.
    uint8_t motor_mode;
    // Control mode of the last STATUS_WORD: a narx_control_mode_t, or 255 before the first.
    uint8_t control_mode;
    // Set-point that the drive uses, rpm; 0 before the drive sent one.
    uint16_t accepted_speed;
    // Estimated mechanical speed, rpm, negative in reverse; 0 before the first.
    int16_t speed;
    // Live and latched faults: sum of NARX_FAULT_*.
    uint32_t faults;
    // Critical faults of the last CRITICAL_FAULT.
    uint32_t critical;
    // Extended fault code of that CRITICAL_FAULT: NARX_CAUSE_*.
    uint16_t cause;
} narx_drive_report_t;

// A NarMotion-X message (PROTOCOL.md, section 2).
typedef struct narx_message_t {
    // Kind: a narx_message_kind_t.
    uint16_t kind;
    // CAN address of the drive; 170 as shipped.
    uint8_t drive;
    // CAN address of the master; 85 as shipped.
    uint8_t master;
    // Fields: raw numbers, with unit and scale beside each. The fields of other messages are ignored.
    narx_fields_t fields;
} narx_message_t;

// Up to three words of a download.
typedef struct narx_chunk_t {
    // Place of the first word in the download, words.
    uint32_t offset;
    // Number of valid `words`.
    uint8_t length;
    // The words.
    uint16_t words[3];
} narx_chunk_t;

// Settings of a record of the scope: raw values of its parameters.
typedef struct narx_scope_setup_t {
    // Recorded signals, a bit each (parameter 22); 0 records the inputs of every control tick instead.
    uint32_t channels;
    // Level of the triggers 1 to 4, thousandths of the signal's base (parameter 292).
    int32_t level;
    // Samples of each signal (parameter 23); of a record of inputs, control ticks.
    uint16_t samples;
    // Control ticks from one sample to the next (parameter 24).
    uint16_t prescaler;
    // Samples from before the trigger (parameter 26), fewer than all.
    uint16_t before;
    // Kind of the trigger (parameter 290); 0 for none.
    uint8_t trigger;
    // Signal of the triggers 1 to 4 (parameter 291).
    uint8_t signal;
} narx_scope_setup_t;

// Details of a job that has failed; 0, or 255 for a state that is unknown or does not matter, where there
// are none.
typedef struct narx_job_failure_t {
    // Faults of a drive in Fault: sum of NARX_FAULT_*.
    uint32_t faults;
    // Extended fault code: NARX_CAUSE_*.
    uint16_t cause;
    // Parameter that does not fit the others, for refusal 2 of a start; setting of the scope that is out of
    // range; parameter that the drive refuses.
    uint16_t parameter;
    // Reason of a refused start: parameter 276; of a refused record: parameter 306.
    uint8_t refusal;
    // State of the drive: a narx_state_t, or 255.
    uint8_t state;
    // State of the scope: parameter 260, or 255.
    uint8_t scope;
} narx_job_failure_t;

// A request to a drive.
typedef struct narx_request_t {
    // Kind: a narx_request_kind_t.
    uint8_t kind;
    // Number of the parameter, if the request is about one.
    uint16_t number;
    // Raw value, if the request has one.
    int32_t value;
} narx_request_t;

// Answer to a request.
typedef struct narx_answer_t {
    // The request.
    struct narx_request_t request;
    // NARX_OK, NARX_ERROR_NO_ANSWER, NARX_ERROR_NOT_OBEYED, or the reason why the drive refuses the
    // parameter.
    narx_status_t status;
    // The raw value that the parameter has now; 0 for a request without a parameter.
    int32_t value;
} narx_answer_t;

// A motor's control: memory that the caller owns. It may be copied and moved between calls.
typedef struct narx_motor_t {
    // Private.
    uint64_t words[190];
} narx_motor_t;

// Scales of the fast channels.
typedef struct narx_measurement_scales_t {
    // Bus voltage (parameter 14 is its offset).
    struct narx_channel_scale_t bus_voltage;
    // DC-link current (parameter 13 is its offset).
    struct narx_channel_scale_t bus_current;
    // Phase terminal voltages.
    struct narx_channel_scale_t phase_voltage;
    // Periods of 100 us in a tick, 1/65 536: the filter of the bus current takes 1/64 of a difference in
    // each.
    uint32_t filter;
} narx_measurement_scales_t;

// Coefficients of the calibration.
typedef struct narx_hall_calibration_coefficients_t {
    // Speed of the field, 2^-32 turn a tick: half a revolution a second.
    uint32_t speed;
    // The rotor lock level (parameter 89).
    int32_t level;
} narx_hall_calibration_coefficients_t;

// Coefficients of the open-loop generator.
typedef struct narx_open_loop_coefficients_t {
    // Speed at the end of the ramp, electrical rev/s, raw I16F16 (parameter 88).
    int32_t speed;
    // Rise a millisecond, raw I16F16 with 16 extra bits (parameters 88 and 109).
    int64_t rate;
    // Level while the field stands still (rotor lock level, but no more than the open-loop level). Levels as
    // `initial_level` of the control's coefficients.
    int32_t level_start;
    // Level at the end of the ramp (parameter 87).
    int32_t level;
    // `(level - level_start) / speed` as mantissa x 2^-shift.
    struct narx_gain_t slope;
    // Turns of 2^-32 a tick per raw rev/s.
    struct narx_gain_t turns;
} narx_open_loop_coefficients_t;

// Coefficients of the rails.
typedef struct narx_rail_coefficients_t {
    // Volts per raw ampere (parameter 268), 0 unknown.
    struct narx_gain_t resistance;
    // Volts that turning the current over in six commutations a revolution costs, per raw ampere and raw
    // rev/s: 3 L (parameter 283) with 16 extra bits, 0 unknown.
    struct narx_gain_t commutation;
    // Volts per electrical rev/s (parameter 267), 0 unknown.
    struct narx_gain_t back_emf;
    // Milliseconds in which the bucket loses one episode.
    uint32_t leak;
} narx_rail_coefficients_t;

// Coefficients of the sensorless station. Times are in ticks, levels as `initial_level` of the control's
// coefficients.
typedef struct narx_sensorless_coefficients_t {
    // The floating phase.
    struct narx_back_emf_coefficients_t back_emf;
    // Desynchronisation and stall.
    struct narx_rail_coefficients_t rails;
    // No crossing for this long is speed 0 (parameter 85), 1/65 536 tick.
    uint32_t timeout;
    // Silent terminals for this long mean a rotor at rest.
    uint32_t rest;
    // Two locks together.
    uint32_t align;
    // Rise of the lock level a millisecond, 16 extra bits.
    int64_t align_rate;
    // Level of the locks (parameter 89).
    int32_t align_level;
    // Rise of the kick a millisecond, 16 extra bits.
    int64_t kick_rate;
    // Level at which the kick ends (parameter 87).
    int32_t kick_level;
    // Without any crossing at the full level the field steps on after this.
    uint32_t kick_patience;
    // A kick that has not led to closed loop within this is given up.
    uint32_t kick_limit;
    // Largest back-EMF that is braked by a short circuit, 2^-32 turn a tick: what the phase current limit
    // allows.
    int32_t brake_max;
} narx_sensorless_coefficients_t;

// Coefficients of the current limits, raw I16F16.
typedef struct narx_limit_coefficients_t {
    // Limit at the beginning of a start (parameter 105), A.
    int32_t soft_start;
    // Limit afterwards (parameter 106), at most the 7 A input rating of Table 1, A.
    int32_t maximum;
    // Slope from one to the other (parameter 96), A per millisecond with 16 extra bits.
    int64_t rate;
    // Estimated mean phase current (parameter 269), A.
    int32_t phase_current_max;
    // From this temperature the limits fall (parameter 121), degrees C.
    int32_t derating_start;
    // Per degree above it: 1 / (shutdown - warning).
    struct narx_gain_t derating;
    // Resistance of the two switches that conduct, raw I16F16 ohm.
    int32_t bridge;
} narx_limit_coefficients_t;

// Coefficients of the control station. Volts, amperes and rev/s are raw I16F16, duties raw U1F15.
typedef struct narx_control_coefficients_t {
    // Ticks in a millisecond, 1/256.
    uint16_t ticks_per_ms;
    // Part of its distance that the speed loop goes in a tick while something else decides, 1/65 536.
    uint16_t track;
    // Bus current limiter, per tick.
    struct narx_pi_gains_t current;
    // Current ratings.
    struct narx_limit_coefficients_t limits;
    // Speed set-point ramp, electrical rev/s per millisecond with 16 extra bits (parameter 99).
    int64_t speed_rate;
    // Largest change of the duty in a tick (parameter 271).
    uint16_t slew;
    // Shortest on-time (parameter 272).
    uint16_t duty_min;
    // Duty that dead time takes away under synchronous rectification.
    uint16_t dead_time;
    // Above this bus voltage nothing may flow back: the over-voltage threshold less a margin.
    int32_t bus_guard;
    // First level in closed loop (parameter 84). A level is raw I16F16: volts, or a share of the bus voltage
    // (`levels_of_bus`).
    int32_t initial_level;
    // Levels are shares of the live bus voltage: there is no nominal supply (parameter 266 is 0).
    bool levels_of_bus;
    // Back-EMF per electrical rev/s (parameter 267); 0 unknown.
    struct narx_gain_t back_emf;
} narx_control_coefficients_t;

// Coefficients of one closed-loop mode. Speeds are raw I16F16 electrical rev/s.
typedef struct narx_mode_coefficients_t {
    // Speed loop, volts per electrical rev/s, per millisecond.
    struct narx_pi_gains_t speed;
    // Smallest set-point.
    int32_t speed_min;
    // Largest set-point.
    int32_t speed_max;
    // Largest duty, raw U1F15.
    uint16_t duty_max;
    // The speed is known from crossings alone, once in a sector.
    bool sparse;
} narx_mode_coefficients_t;

// Everything configurable that the tick needs, in its own units.
typedef struct narx_coefficients_t {
    // Converter scales.
    struct narx_measurement_scales_t measurement;
    // Hall sensors.
    struct narx_hall_coefficients_t hall;
    // Hall calibration.
    struct narx_hall_calibration_coefficients_t hall_calibration;
    // Open loop.
    struct narx_open_loop_coefficients_t open_loop;
    // Back-EMF estimator and start sequence.
    struct narx_sensorless_coefficients_t sensorless;
    // Fault logic.
    struct narx_protection_coefficients_t protection;
    // State machine.
    struct narx_machine_coefficients_t machine;
    // Loops and limits.
    struct narx_control_coefficients_t control;
    // Commutation.
    struct narx_commutator_coefficients_t commutator;
    // Hall closed loop.
    struct narx_mode_coefficients_t hall_mode;
    // Sensorless closed loop.
    struct narx_mode_coefficients_t sensorless_mode;
    // Rev/s (raw I16F16) of 2^-32 turn a tick.
    struct narx_gain_t speed_of_turns;
    // Settling after the end of the on-time before an off-time sample, in 1/65 536 of a period.
    uint16_t sample_settle;
} narx_coefficients_t;

// Parameter that does not fit the others.
typedef struct narx_parameter_error_t {
    // Smallest raw value that fits the others.
    int64_t min;
    // Largest raw value that fits the others.
    int64_t max;
    // Its raw value.
    int32_t value;
    // Its number: a NARX_PARAMETER_*.
    uint16_t number;
} narx_parameter_error_t;

// Report of a motor's control as of the last step. Speeds are electrical, Q16 rev/s, positive forward.
typedef struct narx_motor_report_t {
    // Tick of this report.
    uint64_t tick;
    // Faults that are present or latched: FAULT_WORD of PROTOCOL.md.
    uint32_t faults;
    // Latched critical faults.
    uint32_t critical;
    // Set-point after its limits and its ramp.
    int32_t setpoint;
    // Speed by the hall sensors.
    int32_t speed_hall;
    // Speed by the back-EMF; in open loop that of the field.
    int32_t speed_sensorless;
    // Sectors turned since power-up: 6 an electrical revolution.
    int32_t sectors;
    // Bus voltage, Q16 V.
    int32_t bus_voltage;
    // Mean bus current, Q16 A.
    int32_t bus_current;
    // Electrical input power, Q16 W.
    int32_t power;
    // Terminal voltages, Q16 V.
    int32_t phase_voltage[3];
    // Zero crossings accepted since power-up, wrapping.
    uint32_t crossings;
    // Extended code of the first critical fault (PROTOCOL.md), 0 without one.
    uint16_t extended_code;
    // Electrical angle that the commutation uses, 65 536 a turn.
    uint16_t angle;
    // Applied duty, U1F15.
    uint16_t duty;
    // Times that the hall sensors lost their code, saturating.
    uint16_t hall_invalid;
    // Hall changes between sectors that are not neighbours, saturating.
    uint16_t hall_jumps;
    // Distance of the last accepted crossing behind its prediction, 65 536 an electrical turn.
    int16_t crossing_margin;
    // Result of the hall calibration, if `calibration` is 2: angle by which the edges lie beyond their
    // place, 65 536 a turn.
    int16_t hall_offset;
    // Permutation of the lines (parameter 262), if `calibration` is 2.
    uint8_t hall_order;
    // Lines to invert (parameter 263), if `calibration` is 2.
    uint8_t hall_polarity;
    // Hall calibration: 0 none, 1 running, 2 done, 3 failed.
    uint8_t calibration;
    // State.
    narx_state_t state;
    // Commanded direction: 0 forward, 1 reverse.
    uint8_t direction;
    // Reason why the last start was refused: 0 it was not, 1 no mode is enabled, 4 Standby was not requested
    // since the last stop.
    uint8_t refusal;
    // The limit that bounds the duty: the numbers of parameter 280.
    uint8_t limiter;
    // Outcome of the last step's zero crossing: the numbers of parameter 287.
    uint8_t crossing;
    // 1: no command for the time-out.
    uint8_t command_expired;
    // 1: the bus is below 18 V, which is no fault.
    uint8_t supply_low;
    // 1: the rotor is known to stand.
    uint8_t standstill;
    // 1: nothing shows the rotor now; it may turn while `sectors` stands.
    uint8_t unseen;
} narx_motor_report_t;

// Result of a replay.
typedef struct narx_outcome_t {
    // Number of ticks that were run.
    uint64_t ticks;
    // Digest of the outputs of this replay.
    uint64_t digest;
    // Digest of the outputs when they were recorded; equal to `digest` if they were the same, bit for bit.
    uint64_t recorded_digest;
    // A warning: the behaviour version of the recorder if it differs from this library's (the digests may
    // then rightly differ); otherwise 0.
    uint16_t other_behaviour;
} narx_outcome_t;

// Memory of a virtual scope. It has room for the largest number of samples of one signal that parameter 23
// can request (4096), or for 68 ms of inputs at 10 kHz. Its content is private to the library. It must stay
// at its address as long as the drive lives.
typedef struct narx_scope_t {
    // Private.
    uint64_t words[NARX_SCOPE_WORDS];
} narx_scope_t;

// Storage of a drive's parameters and its log: memory that the caller owns. Its content is private to the
// library.
typedef struct narx_storage_t {
    // Private.
    uint64_t words[NARX_STORAGE_WORDS];
} narx_storage_t;

// A serial NOR flash, as the board drives it. The functions wait until the flash is done and return 0, or
// another number if it is absent or has failed. The drive then reports fault bit 30 on the bus.
typedef struct narx_flash_t {
    // Bytes of the flash: whole subsectors, 512 KiB or more. The log uses the space that the parameters
    // leave.
    uint32_t size;
    // Pointer that is passed to the functions.
    void *context;
    // Reads `length` bytes from `address` on.
    int32_t (*read)(void *context, uint32_t address, uint8_t *bytes, size_t length);
    // Programs `length` bytes from `address` on, within one page of NARX_FLASH_PAGE: bits change from 1 to
    // 0.
    int32_t (*program)(void *context, uint32_t address, const uint8_t *bytes, size_t length);
    // Erases from `from` to before `to`, whole subsectors of NARX_FLASH_SUBSECTOR: all bits become 1. The
    // function may erase larger sectors in between at once.
    int32_t (*erase)(void *context, uint32_t from, uint32_t to);
} narx_flash_t;

// The pattern that rotor lock holds before a calibration starts: settles at 0 degrees.
#define HallCalibrator_LOCK narx_step_t_LockBC

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Writes the step that gives torque in direction `towards` (0 forward, 1 reverse) to a rotor in `sector`, 0
// to 5. Any context; no state.
narx_status_t narx_commutation_step_for(uint8_t sector,
                                        uint8_t towards,
                                        narx_step_t *step);

// Writes the action of a step (a narx_step_t) on the legs of phases A, B, C into `legs`, 3 bytes: 0 both
// switches off, 1 low side on, 2 switched with the duty. Any context; no state.
narx_status_t narx_commutation_legs(uint8_t step,
                                    uint8_t *legs);

// Makes a commutation that knows no rotor position yet. Returns NARX_ERROR_SETTING if it cannot be built
// from the settings; `error`, which may be NULL, then names the setting.
narx_status_t narx_commutation_init(struct narx_commutator_t *commutation,
                                    size_t size,
                                    const struct narx_commutation_settings_t *settings,
                                    struct narx_setting_error_t *error);

// Makes a commutation that knows no rotor position yet from ready-made coefficients: what narx has computed
// on the desk from such settings as narx_commutation_init takes. They are not checked. It takes a few
// hundred bytes of flash where narx_commutation_init takes thousands.
narx_status_t narx_commutation_init_ready(struct narx_commutator_t *commutation,
                                          size_t size,
                                          const struct narx_commutator_coefficients_t *ready);

// Writes the steps of this period for a rotor at `angle` (2^32 a turn) that turns with `turn_speed`
// (2^-32 turn a tick, signed), both at the period's boundary, with torque in direction `towards` (0 forward,
// 1 reverse). A rotor that seems to have fallen back by less than 15 degrees is not commutated back.
narx_status_t narx_commutation_step(struct narx_commutator_t *commutation,
                                    uint32_t angle,
                                    int32_t turn_speed,
                                    uint8_t towards,
                                    struct narx_steps_t *steps);

// Forgets the sector; call it after the bridge was off.
narx_status_t narx_commutation_reset(struct narx_commutator_t *commutation);

// Writes the drive's factory values at 10 kHz, as a start for your own settings; no speed counts as too
// high.
narx_status_t narx_fault_settings_default(struct narx_fault_settings_t *settings);

// Makes a fault logic without a fault. Returns NARX_ERROR_SETTING if it cannot be built from the settings;
// `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
narx_status_t narx_fault_init(struct narx_fault_t *fault,
                              size_t size,
                              const struct narx_fault_settings_t *settings,
                              struct narx_setting_error_t *error);

// Makes a fault logic without a fault from ready-made coefficients: what narx has computed on the desk from
// such settings as narx_fault_init takes. They are not checked. It takes a few hundred bytes of flash where
// narx_fault_init takes thousands.
narx_status_t narx_fault_init_ready(struct narx_fault_t *fault,
                                    size_t size,
                                    const struct narx_protection_coefficients_t *ready);

// Runs one tick. A critical fault latches.
narx_status_t narx_fault_step(struct narx_fault_t *fault,
                              const struct narx_evidence_t *evidence,
                              struct narx_faults_t *faults);

// Follows a state change of the state machine beside it (narx_state_step): a time-out and a failed boot are
// latched, leaving Fault acknowledges, and the plausibility checks of the sensors start anew in every driven
// episode.
narx_status_t narx_fault_handle_change(struct narx_fault_t *fault,
                                       const struct narx_change_t *change,
                                       const struct narx_evidence_t *evidence);

// Clears the latched faults if none of their causes is present any more; else returns NARX_ERROR_WRONG_STATE
// and does nothing.
narx_status_t narx_fault_acknowledge(struct narx_fault_t *fault);

// Writes default settings, as a start for your own: 10 kHz, lines in the order A, B, C, the factory's
// time-out, interpolation from 1 rev/s, captured edges.
narx_status_t narx_hall_settings_default(struct narx_hall_settings_t *settings);

// Makes a station that has not seen the sensors yet. Returns NARX_ERROR_SETTING if it cannot be built from
// the settings; `error`, which may be NULL, then names the setting.
narx_status_t narx_hall_init(struct narx_hall_t *hall,
                             size_t size,
                             const struct narx_hall_settings_t *settings,
                             struct narx_setting_error_t *error);

// Makes a station that has not seen the sensors yet from ready-made coefficients: what narx has computed on
// the desk from such settings as narx_hall_init takes. They are not checked. It takes a few hundred bytes of
// flash where narx_hall_init takes thousands.
narx_status_t narx_hall_init_ready(struct narx_hall_t *hall,
                                   size_t size,
                                   const struct narx_hall_ready_t *ready);

// Runs one tick with the lines now (bit 0 = A, bit 1 = B, bit 2 = C) and the `count` edges of the period
// that has ended, oldest first, at most NARX_EDGES_MAX; `edge` may be NULL if `count` is 0.
narx_status_t narx_hall_step(struct narx_hall_t *hall,
                             uint8_t code,
                             const struct narx_edge_t *edge,
                             size_t count,
                             struct narx_hall_reading_t *reading);

// Makes a controller at rest: its integrator is 0. Returns NARX_ERROR_SETTING if it cannot be built from the
// settings; `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
narx_status_t narx_pi_init(struct narx_pi_t *pi,
                           size_t size,
                           const struct narx_pi_settings_t *settings,
                           struct narx_setting_error_t *error);

// Makes a controller at rest from ready-made coefficients: what narx has computed on the desk from such
// settings as narx_pi_init takes. They are not checked. It takes a few hundred bytes of flash where
// narx_pi_init takes thousands.
narx_status_t narx_pi_init_ready(struct narx_pi_t *pi,
                                 size_t size,
                                 const struct narx_pi_ready_t *ready);

// Writes the output for an error, both Q16: u = Kp e + integral of Ki e dt, within its limits. The
// integrator never holds more than brings the output to a limit.
narx_status_t narx_pi_step(struct narx_pi_t *pi, int32_t error, int32_t *output);

// Follows the output `applied` (Q16) that something else decided in this step, whose error was `error`. The
// integrator goes an eighth of the way to the value that would have given `applied`, so that the controller
// takes over again without a bump.
narx_status_t narx_pi_track(struct narx_pi_t *pi,
                            int32_t applied,
                            int32_t error);

// Sets the integrator so that it alone gives `output` (Q16).
narx_status_t narx_pi_hold(struct narx_pi_t *pi, int32_t output);

// Makes a ramp at 0. Returns NARX_ERROR_SETTING if it cannot be built from the settings; `error`, which may
// be NULL, then names the setting. Not for an interrupt: it divides.
narx_status_t narx_ramp_init(struct narx_ramp_t *ramp,
                             size_t size,
                             const struct narx_ramp_settings_t *settings,
                             struct narx_setting_error_t *error);

// Makes a ramp at 0 from ready-made coefficients: what narx has computed on the desk from such settings as
// narx_ramp_init takes. They are not checked. It takes a few hundred bytes of flash where narx_ramp_init
// takes thousands.
narx_status_t narx_ramp_init_ready(struct narx_ramp_t *ramp,
                                   size_t size,
                                   const struct narx_ramp_ready_t *ready);

// Moves one step towards `target` and writes the new value to `value`, both Q16.
narx_status_t narx_ramp_step(struct narx_ramp_t *ramp, int32_t target, int32_t *value);

// Continues from `value`, Q16.
narx_status_t narx_ramp_set(struct narx_ramp_t *ramp, int32_t value);

// Writes the drive's factory values at 10 kHz, with hall sensors, as a start for your own settings.
narx_status_t narx_state_settings_default(struct narx_state_settings_t *settings);

// Makes a machine in Initialization. Returns NARX_ERROR_SETTING if it cannot be built from the settings;
// `error`, which may be NULL, then names the setting.
narx_status_t narx_state_init(struct narx_state_machine_t *machine,
                              size_t size,
                              const struct narx_state_settings_t *settings,
                              struct narx_setting_error_t *error);

// Makes a machine in Initialization from ready-made coefficients: what narx has computed on the desk from
// such settings as narx_state_init takes. They are not checked. It takes a few hundred bytes of flash where
// narx_state_init takes thousands.
narx_status_t narx_state_init_ready(struct narx_state_machine_t *machine,
                                    size_t size,
                                    const struct narx_machine_coefficients_t *ready);

// Takes a command: `mode` is 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown, `speed` the electrical set-point,
// Q16 rev/s. It restarts the command time-out. Standby acknowledges a fault; Drive and Reverse start the
// motor if Standby was requested before.
narx_status_t narx_state_handle_command(struct narx_state_machine_t *machine,
                                        uint8_t mode,
                                        int32_t speed);

// Runs one tick: time passes, and at most one transition fires. Returns NARX_OK and writes the transition to
// `change`, or returns NARX_NOTHING.
narx_status_t narx_state_step(struct narx_state_machine_t *machine,
                              const struct narx_state_inputs_t *inputs,
                              struct narx_change_t *change);

// Writes the present state of the machine.
narx_status_t narx_state_report(struct narx_state_machine_t *machine,
                                struct narx_state_report_t *report);

// Writes default settings, as a start for your own: 10 kHz, narx's own converter, 4 codes of noise, 200 us
// of blanking, samples, no delays, no advance, 500 ticks; the back-EMF is unknown.
narx_status_t narx_zero_crossing_settings_default(struct narx_zero_crossing_settings_t *settings);

// Makes a detector that has not seen the motor yet. Returns NARX_ERROR_SETTING if it cannot be built from
// the settings; `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
narx_status_t narx_zero_crossing_init(struct narx_zero_crossing_t *detector,
                                      size_t size,
                                      const struct narx_zero_crossing_settings_t *settings,
                                      struct narx_setting_error_t *error);

// Makes a detector that has not seen the motor yet from ready-made coefficients: what narx has computed on
// the desk from such settings as narx_zero_crossing_init takes. They are not checked. It takes a few hundred
// bytes of flash where narx_zero_crossing_init takes thousands.
narx_status_t narx_zero_crossing_init_ready(struct narx_zero_crossing_t *detector,
                                            size_t size,
                                            const struct narx_zero_crossing_ready_t *ready);

// Begins to bring up a rotor that rests at `angle` (2^32 a turn), in direction `towards` (0 forward, 1
// reverse).
narx_status_t narx_zero_crossing_start(struct narx_zero_crossing_t *detector,
                                       uint32_t angle,
                                       uint8_t towards);

// Goes on by a step without any evidence: the rotor that is being brought up has not moved.
narx_status_t narx_zero_crossing_force_step(struct narx_zero_crossing_t *detector);

// Runs one tick with the samples (phase and bus voltages with their mode, edges of comparators) and the
// pattern that was applied in the period that has ended, with torque in direction `towards` (0 forward, 1
// reverse).
narx_status_t narx_zero_crossing_step(struct narx_zero_crossing_t *detector,
                                      const struct narx_samples_t *samples,
                                      const struct narx_applied_t *applied,
                                      uint8_t towards,
                                      struct narx_zero_crossing_reading_t *reading);

// Writes the default board, as a start for your own: 10 kHz, a tick that takes at most 12.5 us, 500 ns dead
// time, 12-bit converters to 80 V and +-16.4 A.
narx_status_t narx_board_default(struct narx_board_t *board);

// Returns the bytes that a drive needs on this processor: at most NARX_DRIVE_SIZE. Any context.
size_t narx_drive_size(void);

// Returns the alignment that a drive needs on this processor: at most that of narx_drive_t. Any context.
size_t narx_drive_align(void);

// Makes a drive at power-up, with factory parameters, in `size` bytes of memory (sizeof(narx_drive_t), or
// narx_drive_size() in memory of your own). `board` is NULL for the default board. The previous content of
// the memory is lost. If it was a drive, this reboots it.
//
// Call it before any other use, not during another call for the same drive. A narx_drive_step that
// interrupts it returns NARX_ERROR_UNINITIALISED and writes a coast command.
narx_status_t narx_drive_init(struct narx_drive_t *drive,
                              size_t size,
                              const struct narx_board_t *board);

// Makes a drive as narx_drive_init does, with stored parameters and an identity. `stored` has `count`
// parameters and may be NULL if `count` is 0; `identity` may be NULL. A set is accepted or rejected as a
// whole: with NARX_ERROR_UNKNOWN_PARAMETER or NARX_ERROR_OUT_OF_RANGE the memory is unchanged. If no working
// controller can be built from an accepted set, the drive refuses to start;
// NARX_PARAMETER_REJECTED_PARAMETER holds the number of the parameter.
narx_status_t narx_drive_init_stored(struct narx_drive_t *drive,
                                     size_t size,
                                     const struct narx_board_t *board,
                                     const struct narx_identity_t *identity,
                                     const struct narx_stored_t *stored,
                                     size_t count);

// Runs one control tick: takes the samples of this period and writes the command to apply. Tick half: call
// it from the control interrupt, once a PWM period. It may interrupt every other call for the same drive
// except narx_drive_init and itself.
//
// On an error the command, if `command` is a valid pointer, is coast at duty 0: a caller that ignores the
// status still turns the bridge off.
narx_status_t narx_drive_step(struct narx_drive_t *drive,
                              const struct narx_samples_t *samples,
                              struct narx_pwm_command_t *command);

// Takes a frame that has arrived. Frames that are not for this drive, or not well formed, are counted or
// ignored (PROTOCOL.md). Background half.
narx_status_t narx_drive_handle_frame(struct narx_drive_t *drive,
                                      const struct narx_frame_t *frame);

// Advances the drive's background to the control tick `now` and exchanges data with the tick half. Call it
// once a period or less often, after narx_drive_handle_frame and before narx_drive_poll_frame. Background
// half.
narx_status_t narx_drive_run(struct narx_drive_t *drive,
                             uint64_t now);

// Writes the next frame to send, or returns NARX_NOTHING. Call it until it returns NARX_NOTHING. Background
// half.
narx_status_t narx_drive_poll_frame(struct narx_drive_t *drive,
                                    struct narx_frame_t *frame);

// Writes the next frame of a download that the master has requested, or returns NARX_NOTHING, as it does
// while narx_drive_poll_frame has frames. Call it when no more than one frame is in the controller, the one
// that is on the bus: more would delay the drive's other messages. A program that never calls it serves no
// downloads. Background half.
narx_status_t narx_drive_poll_bulk_frame(struct narx_drive_t *drive,
                                         struct narx_frame_t *frame);

// Writes a parameter as the master does: number, access, range and state are checked, then it takes effect
// as described in PROTOCOL.md. `value` is the raw value, with the unit and scale of PROTOCOL.md; a 32-bit
// unsigned value is passed as its bits. Background half.
narx_status_t narx_drive_set_parameter(struct narx_drive_t *drive,
                                       uint16_t number,
                                       int32_t value);

// Reads a parameter, raw as in narx_drive_set_parameter, measured values included. Background half.
narx_status_t narx_drive_get_parameter(struct narx_drive_t *drive, uint16_t number, int32_t *value);

// Returns the bytes that a TX-Driver needs on this processor: at most sizeof(narx_tx_driver_t). Any context.
size_t narx_tx_driver_size(void);

// Makes a TX-Driver at power-up in `size` bytes of memory: sizeof(narx_tx_driver_t), or
// narx_tx_driver_size() of your own. `values` are the NARX_TX_VALUES values that were stored, or NULL for
// factory state. Returns NARX_ERROR_VARIANT if there is no such driver, NARX_ERROR_OUT_OF_RANGE for a stored
// value outside the range of its entry.
narx_status_t narx_tx_driver_init(struct narx_tx_driver_t *driver,
                                  size_t size,
                                  const struct narx_tx_variant_t *variant,
                                  const uint32_t *values);

// Takes a frame that arrived at `now`, microseconds. A frame for another node or of another protocol changes
// nothing.
narx_status_t narx_tx_driver_handle_frame(struct narx_tx_driver_t *driver,
                                          const struct narx_frame_t *frame,
                                          uint64_t now);

// Takes a sample, at the variant's rate: positions in 2^-27 mm (the second is ignored on a driver with one
// channel), and the encoder's free-running counter, four counts to a period.
narx_status_t narx_tx_driver_handle_sample(struct narx_tx_driver_t *driver,
                                           int32_t position_1,
                                           int32_t position_2,
                                           uint16_t counter);

// Takes the state of the CAN controller, as often as the board reads it. Off the bus no frame is handed out,
// and positions and answers that wait are dropped; drop the frames that wait in the controller, too. An
// error message among them is sent again.
narx_status_t narx_tx_driver_handle_bus_state(struct narx_tx_driver_t *driver,
                                              const struct narx_bus_state_t *state);

// Advances time to `now`, microseconds.
narx_status_t narx_tx_driver_poll(struct narx_tx_driver_t *driver, uint64_t now);

// Writes the latest time of the next poll, microseconds, if nothing is handled until then; UINT64_MAX for
// never.
narx_status_t narx_tx_driver_next_poll(struct narx_tx_driver_t *driver,
                                       uint64_t *at);

// Writes the next frame to send, or returns NARX_NOTHING.
narx_status_t narx_tx_driver_poll_frame(struct narx_tx_driver_t *driver,
                                        struct narx_frame_t *frame);

// Writes the NARX_TX_VALUES values to store, or returns NARX_NOTHING. It hands out nothing more until
// narx_tx_driver_handle_store was called with the result.
narx_status_t narx_tx_driver_poll_store(struct narx_tx_driver_t *driver,
                                        uint32_t *values);

// Takes the result of storing the values of narx_tx_driver_poll_store: not 0 if they are stored. A board
// that could not read its memory at power-up passes 0, too.
narx_status_t narx_tx_driver_handle_store(struct narx_tx_driver_t *driver,
                                          uint8_t done);

// Returns NARX_OK, once, when the board must restart the driver now: call narx_tx_driver_init with the
// stored values. Returns NARX_NOTHING otherwise.
narx_status_t narx_tx_driver_take_reset(struct narx_tx_driver_t *driver);

// Writes the state that the board needs.
narx_status_t narx_tx_driver_report(struct narx_tx_driver_t *driver,
                                    struct narx_tx_driver_report_t *report);

// Returns the bytes that a TX-Driver's master needs on this processor: at most sizeof(narx_tx_master_t). Any
// context.
size_t narx_tx_master_size(void);

// Makes the master of node `number` (1 to 127) with this layout, in `size` bytes of memory:
// sizeof(narx_tx_master_t), or narx_tx_master_size() of your own. It sends nothing until it gets a command
// or a request. It waits 100 ms for an answer, sends a request up to three times, and counts a node as gone
// after 5 s without a message.
narx_status_t narx_tx_master_init(struct narx_tx_master_t *master,
                                  size_t size,
                                  uint8_t number,
                                  const struct narx_tx_layout_t *layout);

// Takes a frame that arrived at `now`, microseconds. Frames of other nodes are ignored.
narx_status_t narx_tx_master_handle_frame(struct narx_tx_master_t *master,
                                          const struct narx_frame_t *frame,
                                          uint64_t now);

// Writes the next frame that is due at `now`, microseconds, or returns NARX_NOTHING.
narx_status_t narx_tx_master_poll_frame(struct narx_tx_master_t *master,
                                        uint64_t now,
                                        struct narx_frame_t *frame);

// Writes the latest time of the next poll, microseconds, if no frame arrives and nothing is requested until
// then; UINT64_MAX for never.
narx_status_t narx_tx_master_next_poll(struct narx_tx_master_t *master,
                                       uint64_t now,
                                       uint64_t *at);

// Commands the node, or with `all` not 0 every node of the bus: 1 start, 2 stop, 128 pre-operational, 129
// reset. Returns NARX_ERROR_FULL while four messages wait for the bus, NARX_ERROR_FIELD for another command.
narx_status_t narx_tx_master_command(struct narx_tx_master_t *master,
                                     uint8_t command,
                                     uint8_t all);

// Sends a SYNC: every node of the bus samples and sends PDO2. Returns NARX_ERROR_FULL while four messages
// wait for the bus.
narx_status_t narx_tx_master_sync(struct narx_tx_master_t *master);

// Asks the node for PDO3. Returns NARX_ERROR_FULL while four messages wait for the bus.
narx_status_t narx_tx_master_ask_positions(struct narx_tx_master_t *master);

// Requests the value of an entry (NARX_TX_ENTRY_*). Answers come in the order of the requests. Returns
// NARX_ERROR_FULL while there are eight requests whose answers were not taken.
narx_status_t narx_tx_master_read(struct narx_tx_master_t *master,
                                  uint8_t number);

// Requests to write an entry (NARX_TX_ENTRY_*). Order and errors are those of narx_tx_master_read.
narx_status_t narx_tx_master_write(struct narx_tx_master_t *master, uint8_t number, uint32_t value);

// Writes the next answer, or returns NARX_NOTHING.
narx_status_t narx_tx_master_poll_answer(struct narx_tx_master_t *master,
                                         struct narx_tx_answer_t *answer);

// Writes the state of the node as known at `now`, microseconds.
narx_status_t narx_tx_master_report(struct narx_tx_master_t *master,
                                    uint64_t now,
                                    struct narx_tx_node_report_t *report);

// Decodes a frame of a bus whose nodes have this layout. Returns NARX_ERROR_NOT_A_MESSAGE if it is no
// eddyCAN message, or one of another layout; NARX_ERROR_FIELD if a field has an undefined value. Any
// context; no state.
narx_status_t narx_tx_message_decode(const struct narx_frame_t *frame,
                                     const struct narx_tx_layout_t *layout,
                                     struct narx_tx_message_t *message);

// Encodes a message as a frame of a bus whose nodes have this layout. Returns NARX_ERROR_NOT_A_MESSAGE if
// `kind` is no narx_tx_kind_t; NARX_ERROR_FIELD or NARX_ERROR_NODE if a field has an undefined value. Any
// context; no state.
narx_status_t narx_tx_message_encode(const struct narx_tx_message_t *message,
                                     const struct narx_tx_layout_t *layout,
                                     struct narx_frame_t *frame);

// Converts a whole number of thousandths (mV, mA, 0.001 degrees) to Q16, rounded to nearest; saturates
// beyond 32 767 999. Any context.
int32_t narx_q16_from_milli(int32_t milli);

// Converts a Q16 to thousandths, rounded to nearest; saturates. Any context.
int32_t narx_milli_from_q16(int32_t value);

// Returns the sum of two Q16, saturating. Any context.
int32_t narx_q16_add(int32_t a, int32_t b);

// Returns the difference of two Q16, saturating. Any context.
int32_t narx_q16_subtract(int32_t a, int32_t b);

// Returns the product of two Q16, rounded down, saturating. Any context.
int32_t narx_q16_multiply(int32_t a, int32_t b);

// Returns the quotient of two Q16, rounded towards 0, saturating; a division by 0 gives the largest or
// smallest value, or 0 for 0 / 0. Not for a control interrupt: a processor without a 64-bit division takes
// hundreds of instructions. Any context.
int32_t narx_q16_divide(int32_t a,
                        int32_t b);

// Converts a Q16 to IQ24, exactly; saturates beyond 127.99999994. Any context.
int32_t narx_iq24_from_q16(int32_t value);

// Converts an IQ24 to Q16, rounded down. Any context.
int32_t narx_q16_from_iq24(int32_t value);

// Converts a Q16 to Q15, rounded down; saturates beyond 0.99997. Any context.
int16_t narx_q15_from_q16(int32_t value);

// Converts a Q15 to Q16, exactly. Any context.
int32_t narx_q16_from_q15(int16_t value);

// Converts a Q16 to Q12, rounded down; saturates beyond 7.9998. Any context.
int16_t narx_q12_from_q16(int32_t value);

// Converts a Q12 to Q16, exactly. Any context.
int32_t narx_q16_from_q12(int16_t value);

// Takes a reading of the slow inputs, about every 10 ms. Temperature and pressure limits act from the first
// reading on. Background half.
narx_status_t narx_drive_handle_inputs(struct narx_drive_t *drive,
                                       const struct narx_slow_inputs_t *inputs);

// Takes the state of the CAN controller, as often as the board reads it (parameters 293 to 296). Off the bus
// no frame is handed out, and frames that wait are dropped; drop those that wait in the controller, too.
// Background half.
narx_status_t narx_drive_handle_bus_state(struct narx_drive_t *drive,
                                          const struct narx_bus_state_t *state);

// Writes the levels that the board's lines must have now. Background half.
narx_status_t narx_drive_outputs(struct narx_drive_t *drive, struct narx_outputs_t *outputs);

// Returns NARX_OK, once, when the master has requested a reboot and the acknowledgement was polled: reset
// the processor, or call narx_drive_init. Returns NARX_NOTHING otherwise. Background half.
narx_status_t narx_drive_take_reboot(struct narx_drive_t *drive);

// Writes the default configuration, with the values of Figure 9 of the specification, as a start for your
// own.
narx_status_t narx_master_config_default(struct narx_master_config_t *config);

// Returns the bytes that a master needs on this processor: at most sizeof(narx_master_t). Any context.
size_t narx_master_size(void);

// Makes a master without a command yet in `size` bytes of memory: sizeof(narx_master_t), or
// narx_master_size() of your own. `config` may be NULL for the default. The master sends set-points of 0,
// which keep measurements coming, but neither stops a motor nor acknowledges a fault.
narx_status_t narx_master_init(struct narx_master_t *master,
                               size_t size,
                               const struct narx_master_config_t *config);

// Takes a frame that arrived at `now`, microseconds. Frames of other nodes are ignored.
narx_status_t narx_master_handle_frame(struct narx_master_t *master,
                                       const struct narx_frame_t *frame,
                                       uint64_t now);

// Writes the next frame that is due at `now`, microseconds, or returns NARX_NOTHING. Call it until it
// returns NARX_NOTHING, at the latest at the time of narx_master_next_poll.
narx_status_t narx_master_poll_frame(struct narx_master_t *master,
                                     uint64_t now,
                                     struct narx_frame_t *frame);

// Writes the latest time of the next poll, microseconds, if no frame arrives and nothing is requested until
// then; UINT64_MAX for never.
narx_status_t narx_master_next_poll(struct narx_master_t *master,
                                    uint64_t now,
                                    uint64_t *at);

// Requests a start at a speed, mechanical rpm, negative in reverse, and repeats the request every period. A
// drive accepts a start only if it received Standby since it last stopped: call narx_master_stop first, or
// use narx_master_begin, which does so and reports the result. Returns NARX_ERROR_SPEED for a speed outside
// the limits of narx_master_speed_limits, or, before these were received, outside the range of MOTOR_CMD.
// Open loop runs at parameter 88, whatever speed is requested. `accepted_speed` of narx_master_report is the
// speed that the drive uses.
narx_status_t narx_master_start(struct narx_master_t *master,
                                int32_t rpm);

// Requests another speed in the same direction, rpm. Returns NARX_ERROR_SPEED as narx_master_start does.
narx_status_t narx_master_set_speed(struct narx_master_t *master,
                                    uint16_t rpm);

// Writes the limits of the set-point in the mode that the drive's parameters enable. Returns NARX_NOTHING
// before those parameters were received (78, 81 to 83, and those of narx_speed_limits_t); `read_parameters`
// of narx_master_config_t makes the master read them.
narx_status_t narx_master_speed_limits(struct narx_master_t *master,
                                       struct narx_speed_limits_t *limits);

// Requests Standby, which also acknowledges a fault.
narx_status_t narx_master_stop(struct narx_master_t *master);

// Requests a shutdown (motor mode 3): fault bit 28.
narx_status_t narx_master_shut_down(struct narx_master_t *master);

// Writes the state of the drive as known at `now`, microseconds.
narx_status_t narx_master_report(struct narx_master_t *master,
                                 uint64_t now,
                                 struct narx_drive_report_t *report);

// Writes the last measurement frame of one kind, NARX_MESSAGE_MEASUREMENT_0 to _8, as a message, and the
// time of its reception (microseconds; `at` may be NULL). Returns NARX_NOTHING before the first.
narx_status_t narx_master_measurement(struct narx_master_t *master,
                                      uint16_t kind,
                                      struct narx_message_t *message,
                                      uint64_t *at);

// Writes the value of a parameter as last received, raw, and the time of its reception (microseconds; `at`
// may be NULL). Returns NARX_NOTHING while it was not received. It sends nothing on the bus; to read a
// parameter anew use NARX_REQUEST_KIND_READ.
narx_status_t narx_master_parameter(struct narx_master_t *master,
                                    uint16_t number,
                                    int32_t *value,
                                    uint64_t *at);

// Begins a download: a narx_download_kind_t with its arguments, 0 for those that it does not need. Returns
// NARX_ERROR_FULL while there is another whose result was not taken, NARX_ERROR_SILENT for a silent master,
// NARX_ERROR_REQUEST for an undefined kind.
narx_status_t narx_master_download(struct narx_master_t *master,
                                   uint8_t kind,
                                   uint32_t first,
                                   uint32_t count);

// Writes the next words of the download, or returns NARX_NOTHING. Words may come more than once, each time
// the same.
narx_status_t narx_master_poll_chunk(struct narx_master_t *master,
                                     struct narx_chunk_t *chunk);

// Returns the result of the download, once all its chunks were taken: NARX_OK, with its length in words,
// NARX_NOTHING before the end, or the error: NARX_ERROR_NO_ANSWER, NARX_ERROR_NO_LOG, NARX_ERROR_SPOILED,
// NARX_ERROR_ABORTED, or the reason of the drive's refusal.
narx_status_t narx_master_poll_download(struct narx_master_t *master,
                                        uint32_t *words);

// Aborts the download; its result is NARX_ERROR_ABORTED.
narx_status_t narx_master_abort_download(struct narx_master_t *master);

// Begins a job of the motor: a narx_job_kind_t, and for a start its speed, mechanical rpm, negative in
// reverse. One that is under way ends without a result; narx_master_start, narx_master_stop and
// narx_master_shut_down end one, too. Returns NARX_ERROR_SILENT for a silent master, NARX_ERROR_SPEED as
// narx_master_start does, and NARX_ERROR_REQUEST for another kind.
narx_status_t narx_master_begin(struct narx_master_t *master,
                                uint8_t kind,
                                int32_t rpm);

// Begins a job of the scope or the log: a narx_job_kind_t, its settings (which may be NULL where it arms
// nothing), and the longest wait for a record, microseconds. One that is under way ends without a result;
// jobs of the motor go on. Returns NARX_ERROR_SILENT for a silent master, and NARX_ERROR_REQUEST for another
// kind.
narx_status_t narx_master_begin_record(struct narx_master_t *master,
                                       uint8_t kind,
                                       const struct narx_scope_setup_t *setup,
                                       uint64_t within);

// Returns the result of the motor's job: NARX_OK, NARX_NOTHING before its end, or the error, with its
// details in `failure` (which may be NULL): NARX_ERROR_FAULT, NARX_ERROR_START_REFUSED,
// NARX_ERROR_TIMED_OUT, NARX_ERROR_NOT_CALIBRATED, NARX_ERROR_ABORTED, NARX_ERROR_NO_ANSWER,
// NARX_ERROR_NOT_OBEYED, or the reason of the drive's refusal of a parameter.
narx_status_t narx_master_poll_job(struct narx_master_t *master,
                                   struct narx_job_failure_t *failure);

// Returns the result of the job of the scope or the log, as narx_master_poll_job does. Its own errors:
// NARX_ERROR_OUT_OF_RANGE for a setting (`parameter`), NARX_ERROR_SCOPE_REFUSED (`refusal`, or `scope` where
// its state forbids the job), NARX_ERROR_NOT_EQUIPPED without a memory, NARX_ERROR_TIMED_OUT for a record
// that was not complete in time (`scope`).
narx_status_t narx_master_poll_record(struct narx_master_t *master,
                                      struct narx_job_failure_t *failure);

// Ends the job of the scope or the log; its result is NARX_ERROR_ABORTED. What the drive has begun goes on.
narx_status_t narx_master_abort_record(struct narx_master_t *master);

// Queues a request to the drive. Answers come in the order of the requests. Returns NARX_ERROR_FULL while
// there are eight requests whose answers were not taken, NARX_ERROR_SILENT for a silent master,
// NARX_ERROR_REQUEST for an undefined kind or number.
narx_status_t narx_master_request(struct narx_master_t *master,
                                  const struct narx_request_t *request);

// Writes the next answer, or returns NARX_NOTHING.
narx_status_t narx_master_poll_answer(struct narx_master_t *master, struct narx_answer_t *answer);

// Decodes a frame. Returns NARX_ERROR_NOT_A_MESSAGE if it is none of narx_message_kind_t, or not well
// formed; NARX_ERROR_FIELD if a field has an undefined value. The priority in the identifier is ignored. Any
// context; no state.
narx_status_t narx_message_decode(const struct narx_frame_t *frame,
                                  struct narx_message_t *message);

// Encodes a message as a frame. Returns NARX_ERROR_NOT_A_MESSAGE if `kind` is no narx_message_kind_t;
// NARX_ERROR_FIELD if a field has an undefined value or one that does not fit in its bits. Any context; no
// state.
narx_status_t narx_message_encode(const struct narx_message_t *message,
                                  struct narx_frame_t *frame);

// Makes a control at power-up, in Initialization, in `size` bytes of memory. `coefficients` are those that
// `narx coefficients` has printed, or narx_coefficients_build has built. They are copied, and not checked.
narx_status_t narx_motor_init(struct narx_motor_t *motor,
                              size_t size,
                              const struct narx_coefficients_t *coefficients);

// Runs one control tick: takes the samples of this period and writes the command to apply. Call it from the
// control interrupt, once a PWM period.
//
// On an error the command, if `command` is a valid pointer, is coast at duty 0: a caller that ignores the
// status still turns the bridge off.
narx_status_t narx_motor_step(struct narx_motor_t *motor,
                              const struct narx_samples_t *samples,
                              struct narx_pwm_command_t *command);

// Takes a command: `mode` is 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown, `speed` the magnitude of the
// electrical set-point, Q16 rev/s: rpm x pole pairs / 60 x 65 536. It restarts the command time-out, so
// repeat it. Standby acknowledges a fault; Drive and Reverse start the motor if Standby was requested
// before.
narx_status_t narx_motor_handle_command(struct narx_motor_t *motor,
                                        uint8_t mode,
                                        int32_t speed);

// Takes a set-point alone, Q16 rev/s as in narx_motor_handle_command: the request stays. It restarts the
// command time-out, too.
narx_status_t narx_motor_handle_set_point(struct narx_motor_t *motor,
                                          int32_t speed);

// Takes a temperature, Q16 degrees Celsius, and a pressure reading, Q16 V, about every 10 ms. Their limits
// act from the first reading on.
narx_status_t narx_motor_handle_inputs(struct narx_motor_t *motor,
                                       int32_t temperature,
                                       int32_t pressure);

// Takes other coefficients, in any state: they hold from the next tick on.
narx_status_t narx_motor_change_coefficients(struct narx_motor_t *motor,
                                             const struct narx_coefficients_t *coefficients);

// The next start finds the wiring of the hall sensors instead of running the motor (`run` is not 0), or runs
// it again (0). narx_motor_report_t shows the result.
narx_status_t narx_motor_calibrate_hall(struct narx_motor_t *motor,
                                        uint8_t run);

// Builds coefficients from parameters: the factory's, and `count` others, raw with the units and scales of
// PROTOCOL.md. `stored` may be NULL if `count` is 0, `board` for the default board. Parameters that do not
// fit each other give NARX_ERROR_PARAMETERS; `error`, which may be NULL, then names one. Not for an
// interrupt: it divides.
//
// It takes 11 KB of flash, or 30 in a library with the texts of the parameters. Where the parameters are
// known when the program is built, let `narx coefficients` print what this would build.
narx_status_t narx_coefficients_build(struct narx_coefficients_t *coefficients,
                                      const struct narx_board_t *board,
                                      const struct narx_stored_t *stored,
                                      size_t count,
                                      struct narx_parameter_error_t *error);

// Writes the report of the last step if one is due, or returns NARX_NOTHING: one is due every millisecond,
// and when the state or the faults change.
narx_status_t narx_motor_poll_report(struct narx_motor_t *motor,
                                     struct narx_motor_report_t *report);

// Runs a drive from a recording's initial state through all of its ticks. `bytes` is the recording, `length`
// bytes.
//
// The drive is on the stack. Any context.
narx_status_t narx_replay(const uint8_t *bytes,
                          size_t length,
                          struct narx_outcome_t *outcome);

// Runs the first `ticks` ticks of a recording, or all of a shorter one, as narx_replay does;
// `recorded_digest` is then 0. Writes all outputs of the last tick in one line into `text`, which has
// `text_size` bytes: NARX_OUTPUTS_TEXT_SIZE are enough. A longer text is cut; a closing 0 ends it. The line
// is empty if no tick was run. If the recording cannot be replayed, the line holds the reason and the place.
//
// `text` may be NULL if `text_size` is 0.
narx_status_t narx_replay_until(const uint8_t *bytes,
                                size_t length,
                                uint64_t ticks,
                                struct narx_outcome_t *outcome,
                                char *text,
                                size_t text_size);

// Powers up a drive's node, or a TX-Driver, as described in a transcript, and makes the first `calls` calls
// of the transcript, or all of a shorter one (UINT64_MAX: all). `bytes` is the transcript, `length` bytes.
// In the outcome `ticks` counts calls, and `recorded_digest` is 0 unless all calls were requested.
//
// The device is on the stack. Any context.
narx_status_t narx_replay_transcript(const uint8_t *bytes,
                                     size_t length,
                                     uint64_t calls,
                                     struct narx_outcome_t *outcome);

// Returns the bytes that a scope with room for `samples` needs on this processor. Any context.
size_t narx_scope_size(uint16_t samples);

// Gives the drive's virtual scope its memory of `size` bytes: sizeof(narx_scope_t), or narx_scope_size() of
// memory of your own that is aligned like a narx_scope_t. Returns NARX_ERROR_SIZE if it has no room for one
// sample. Without memory the scope cannot be armed. Call it after narx_drive_init and before the first
// narx_drive_step; narx_drive_init detaches the memory again.
narx_status_t narx_drive_attach_scope(struct narx_drive_t *drive,
                                      struct narx_scope_t *memory,
                                      size_t size);

// Returns the version of the library, "major.minor.patch": a constant string.
const char *narx_version(void);

// Returns a status in words, for a log: a constant string, never NULL, whatever the number.
const char *narx_status_text(int32_t status);

// Returns the bytes that a storage needs on this processor: at most sizeof(narx_storage_t). Any context.
size_t narx_storage_size(void);

// Makes a storage in `size` bytes of memory. `flash` is copied. Its functions, none of which may be NULL,
// are called only within narx_storage_init_drive and narx_storage_serve.
narx_status_t narx_storage_init(struct narx_storage_t *storage,
                                size_t size,
                                const struct narx_flash_t *flash);

// Makes a drive as narx_drive_init does, with the parameters that the flash holds, or factory values for
// those that it does not hold. The drive then keeps its parameters and its log on this flash. The drive
// reports the state of the flash on the bus, including fault bits 26, 30 and 31. `identity` may be NULL.
narx_status_t narx_storage_init_drive(struct narx_storage_t *storage,
                                      struct narx_drive_t *drive,
                                      size_t size,
                                      const struct narx_board_t *board,
                                      const struct narx_identity_t *identity);

// Runs one bounded step of the drive's work on its flash: a store, a record of the log, a piece of an erase.
// Returns NARX_NOTHING if there is none. Call it in every pass of the main loop. It takes as long as your
// flash does, and some 6 KiB of stack. Background half.
narx_status_t narx_storage_serve(struct narx_storage_t *storage,
                                 struct narx_drive_t *drive);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* NARX_H */
