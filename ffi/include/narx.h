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
 *     narx_drive_handle_frame(&drive, &frame);            main loop: what the CAN bus brings,
 *     narx_drive_run(&drive, tick);                       then this,
 *     while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) send(&frame);    then what it takes
 *
 *
 * Which call may interrupt which
 *
 *     A drive has two halves that share nothing but two queues. The tick half is narx_drive_step;
 *     the background half is narx_drive_run, _handle_frame, _poll_frame, _set_parameter and
 *     _get_parameter. Either half may interrupt the other at any instruction, or run on another
 *     thread or processor. Within a half, calls for one drive must not interrupt each other.
 *     Different drives have nothing in common: the library has no variables.
 *
 *
 * Memory
 *
 *     All memory is the caller's; the library has no heap. It keeps no pointer that it is given
 *     but the drive's own: every other object may go when the call returns. A pointer shows
 *     readable (const) or writable memory of its type. NULL is answered by NARX_ERROR_NULL unless
 *     the function says what NULL means, a misaligned pointer by NARX_ERROR_ALIGNMENT.
 *
 *
 * Numbers
 *
 *     Duty is U1F15: 32 768 is 1. Instants are 1/65 536 of a PWM period. Converter codes are what
 *     the converter gives; narx_board_t has their scales. Parameters are raw integers, whose unit
 *     and decimal scale stand in PROTOCOL.md.
 */

#ifndef NARX_H
#define NARX_H

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

// 64-bit words of a drive on any processor.
#define NARX_DRIVE_WORDS 800

// Bytes of a drive on any processor; narx_drive_size tells what it needs on this one.
#define NARX_DRIVE_SIZE (NARX_DRIVE_WORDS * 8)

// Pattern changes that one period can hold.
#define NARX_COMMUTATIONS_MAX 2

// Room for the longest line that narx_replay_until writes, the closing 0 included.
#define NARX_OUTPUTS_TEXT_SIZE 1024

// Edges that one period can carry; more are counted in narx_samples_t.edges_lost.
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
#define NARX_SCOPE_WORDS 1432

// What every call answers: 0 or more when it did its work, negative when it did nothing.
enum narx_status_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Done.
    NARX_OK = 0,
    // Done, and there is nothing to hand out.
    NARX_NOTHING = 1,
    // A pointer is NULL that must not be.
    NARX_ERROR_NULL = -1,
    // A pointer is not aligned as its type asks for.
    NARX_ERROR_ALIGNMENT = -2,
    // The storage is too small: see narx_drive_size.
    NARX_ERROR_SIZE = -3,
    // The storage holds no drive: narx_drive_init did not run, or the storage was moved since.
    NARX_ERROR_UNINITIALISED = -4,
    // The board's constants lead to no working controller.
    NARX_ERROR_BOARD = -5,
    // A field of the samples has a value that does not exist.
    NARX_ERROR_SAMPLES = -6,
    // Not a CAN frame: identifier or length out of range.
    NARX_ERROR_FRAME = -7,
    // No parameter has this number.
    NARX_ERROR_UNKNOWN_PARAMETER = -8,
    // The drive alone writes this parameter.
    NARX_ERROR_READ_ONLY = -9,
    // The value is outside the parameter's range (PROTOCOL.md).
    NARX_ERROR_OUT_OF_RANGE = -10,
    // The parameter cannot be written in this state.
    NARX_ERROR_WRONG_STATE = -11,
    // The parameter store is missing, busy or failed.
    NARX_ERROR_STORAGE = -12,
    // The bytes do not begin as a recording does.
    NARX_ERROR_NOT_A_RECORDING = -13,
    // The recording's container has another version.
    NARX_ERROR_CONTAINER_VERSION = -14,
    // The recording holds a drive of another layout.
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
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum narx_status_t narx_status_t;
#else
typedef int32_t narx_status_t;
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

// How the current of a switched leg freewheels while its high side is off.
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

// What the bus current reading is.
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

// Where an edge comes from.
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

// One channel of the converter: value = (code - zero) * micro_per_code / 1 000 000.
typedef struct narx_channel_t {
    // Nominal code at 0 V or 0 A, 0 to 4095.
    uint16_t zero;
    // Micro-units (uV or uA) of one code; positive.
    int32_t micro_per_code;
} narx_channel_t;

// What a board promises the control core.
typedef struct narx_board_t {
    // Control ticks, and PWM periods, per second (Hz): 1 000 to 100 000.
    uint32_t tick_rate;
    // First instant of a period at which a new step can act, in 1/65 536 of the period: the sample is taken and
    // narx_drive_step has returned.
    uint16_t earliest;
    // Both switches of a leg stay off this long between one and the other, ns.
    uint16_t dead_time_ns;
    // Not 0: the hall lines have time-stamping input captures.
    uint8_t hall_capture;
    // Not 0: back-EMF comparators with time-stamping input captures watch the floating phase.
    uint8_t comparator_capture;
    // Bus voltage, uV per code.
    struct narx_channel_t bus_voltage;
    // Terminal voltages of the three phases against ground, uV per code.
    struct narx_channel_t phase_voltage;
    // DC-link current, uA per code; positive from the supply into the bridge.
    struct narx_channel_t bus_current;
} narx_board_t;

// A drive: memory that the caller owns, static, on a stack or from a pool. Its content is the library's own. It must
// neither move nor be copied after narx_drive_init; to end a drive, stop calling it.
typedef struct narx_drive_t {
    // Private.
    uint64_t words[NARX_DRIVE_WORDS];
} narx_drive_t;

// One time-stamped edge.
typedef struct narx_edge_t {
    // When, in 1/65 536 of the period that has just ended.
    uint16_t instant;
    // What changed: a narx_edge_source_t.
    uint8_t source;
    // The three lines after the edge: bit 0 = A, bit 1 = B, bit 2 = C.
    uint8_t code;
} narx_edge_t;

// Everything the tick `tick` knows of the outside, measured in period `tick` at the instant that the command before
// asked for.
typedef struct narx_samples_t {
    // Number of this PWM period since power-up.
    uint64_t tick;
    // Terminal voltages of phases A, B, C against ground, converter codes.
    uint16_t phase_voltage[3];
    // Bus voltage, converter code.
    uint16_t bus_voltage;
    // Bus current, converter code; see current_mode.
    uint16_t bus_current;
    // From the bus voltage's conversion to phase C's, in 1/65 536 of a period (A and B lie evenly between).
    uint16_t skew;
    // Where in the period the phase voltages were sampled: a narx_sample_mode_t.
    uint8_t sample_mode;
    // What bus_current is: a narx_current_mode_t.
    uint8_t current_mode;
    // Hall lines at the sampling instant: bit 0 = A, bit 1 = B, bit 2 = C.
    uint8_t hall;
    // Digital inputs at the sampling instant: sum of NARX_LINE_*, a bit is set while the input is asserted.
    uint8_t lines;
    // How many of `edges` count.
    uint8_t edge_count;
    // Edges of period `tick` - 1 that found no room.
    uint8_t edges_lost;
    // Edges captured during the whole of period `tick` - 1, oldest first.
    struct narx_edge_t edges[NARX_EDGES_MAX];
} narx_samples_t;

// One pattern change.
typedef struct narx_commutation_t {
    // When, in 1/65 536 of the period.
    uint16_t instant;
    // The pattern from then on.
    narx_step_t step;
} narx_commutation_t;

// The answer to the samples of period k. `step` and `commutations` act in period k, the rest from period k + 1.
typedef struct narx_pwm_command_t {
    // Duty of the switched legs in period k + 1: U1F15, 32 768 = 1, never more. The on-time is centred on the
    // period's boundary.
    uint16_t duty;
    // When to sample in period k + 1, in 1/65 536 of it.
    uint16_t sample_at;
    // What that sample will show.
    narx_sample_mode_t sample_mode;
    // How current freewheels in period k + 1.
    narx_rectification_t rectification;
    // The pattern to apply at once, when narx_drive_step returns. Coast turns all six switches off.
    narx_step_t step;
    // How many of `commutations` count.
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
    // Data bytes, or those asked for: 0 to 8.
    uint8_t length;
    // The data bytes, `length` of which count.
    uint8_t data[8];
} narx_frame_t;

// What a replay found.
typedef struct narx_outcome_t {
    // Ticks run.
    uint64_t ticks;
    // Digest of the outputs now.
    uint64_t digest;
    // Digest of the outputs when they were recorded; equal to `digest` if they were the same, bit for bit.
    uint64_t recorded_digest;
    // A warning: the behaviour version that recorded, where it is another one than this library's (the digests may
    // then rightly differ); otherwise 0.
    uint16_t other_behaviour;
} narx_outcome_t;

// Memory of a virtual scope with room for as many samples as parameter 23 can ask for of one signal (4096), or for 68 ms of inputs at
// 10 kHz. Its content is the library's own; it must stay where it is for as long as the drive lives.
typedef struct narx_scope_t {
    // Private.
    uint64_t words[NARX_SCOPE_WORDS];
} narx_scope_t;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The default board, to change what differs on yours: 10 kHz, a tick that takes at most 12.5 us, 500 ns dead time, 12-bit
// converters to 80 V and +-16.4 A.
narx_status_t narx_board_default(struct narx_board_t *board);

// Bytes that a drive needs on this processor: at most NARX_DRIVE_SIZE. Any context.
size_t narx_drive_size(void);

// Alignment that a drive needs on this processor: at most that of narx_drive_t. Any context.
size_t narx_drive_align(void);

// Makes a drive at power-up, with factory parameters, in `size` bytes of memory (sizeof(narx_drive_t), or
// narx_drive_size() in memory of your own). `board` is NULL for the default board. What stood in the memory before is lost, a drive
// included: this is its reboot.
//
// Call it before any other use, not during another call for the same drive. A narx_drive_step that interrupts it
// answers NARX_ERROR_UNINITIALISED and coast.
narx_status_t narx_drive_init(struct narx_drive_t *drive,
                              size_t size,
                              const struct narx_board_t *board);

// One control tick: takes the samples of this period and answers what to apply. Tick half: call it from the control
// interrupt, once a PWM period; it may interrupt every other call for the same drive but narx_drive_init and itself.
//
// On an error the command, if there is one to write, is coast at duty 0: a caller who overlooks the status turns the
// bridge off.
narx_status_t narx_drive_step(struct narx_drive_t *drive,
                              const struct narx_samples_t *samples,
                              struct narx_pwm_command_t *command);

// Takes a frame that has arrived. Frames that are not for this drive, or not well formed, are counted or ignored as
// PROTOCOL.md says. Background half.
narx_status_t narx_drive_handle_frame(struct narx_drive_t *drive,
                                      const struct narx_frame_t *frame);

// Advances the drive's background to the control tick `now` and passes on what has come from the tick and what goes
// there. Call it once a period or more seldom, after narx_drive_handle_frame and before narx_drive_poll_frame.
// Background half.
narx_status_t narx_drive_run(struct narx_drive_t *drive,
                             uint64_t now);

// The next frame to send, or NARX_NOTHING. Call it until there is nothing. Background half.
narx_status_t narx_drive_poll_frame(struct narx_drive_t *drive, struct narx_frame_t *frame);

// The next frame of a download that the master has asked for, or NARX_NOTHING; nothing while narx_drive_poll_frame has
// frames. Call it when no more than one frame is in the controller, the one that is on the bus: more would delay what
// the drive has to say next. A program that never calls it serves no downloads. Background half.
narx_status_t narx_drive_poll_bulk_frame(struct narx_drive_t *drive,
                                         struct narx_frame_t *frame);

// Writes a parameter as the master does: number, access, range and state are checked, then it acts as PROTOCOL.md
// says. `value` is the raw value: its unit and scale stand there, too; a 32-bit unsigned one is passed as its bits.
// Background half.
narx_status_t narx_drive_set_parameter(struct narx_drive_t *drive,
                                       uint16_t number,
                                       int32_t value);

// Reads a parameter, raw as in narx_drive_set_parameter, live ones included. Background half.
narx_status_t narx_drive_get_parameter(struct narx_drive_t *drive, uint16_t number, int32_t *value);

// Runs a drive from a recording's initial state through all of its ticks. `bytes` is the recording, `length` bytes.
//
// The drive that it runs lives on the stack. Any context.
narx_status_t narx_replay(const uint8_t *bytes,
                          size_t length,
                          struct narx_outcome_t *outcome);

// The same for the first `ticks` ticks, or all of a shorter recording; `recorded_digest` is 0 then. Writes what the
// last one of them answered, all fields in one line, into `text`, which has `text_size` bytes: NARX_OUTPUTS_TEXT_SIZE
// are enough, a longer text is cut, a 0 closes it. The line is empty if no tick was run. If the recording cannot be
// replayed, it says why and where.
//
// `text` may be NULL if `text_size` is 0.
narx_status_t narx_replay_until(const uint8_t *bytes,
                                size_t length,
                                uint64_t ticks,
                                struct narx_outcome_t *outcome,
                                char *text,
                                size_t text_size);

// Bytes that a scope with room for `samples` needs on this processor. Any context.
size_t narx_scope_size(uint16_t samples);

// Gives the drive's virtual scope its memory: `size` bytes, sizeof(narx_scope_t), or narx_scope_size() of memory of your own that is aligned like
// one; NARX_ERROR_SIZE if there is no room for one sample in it. Without it the scope cannot be armed. Call it after narx_drive_init and before
// the first narx_drive_step; narx_drive_init takes it away again.
narx_status_t narx_drive_attach_scope(struct narx_drive_t *drive,
                                      struct narx_scope_t *memory,
                                      size_t size);

// Version of the library, "major.minor.patch". A constant string.
const char *narx_version(void);

// A status in words, for a log: a constant string, never NULL, whatever the number.
const char *narx_status_text(int32_t status);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* NARX_H */
