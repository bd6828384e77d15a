/**
 * @file
 * Numbers and names of parameters, faults, messages and their fields, from the tables of the protocol (PROTOCOL.md).
 * narx.h includes this file. Made by `cargo xtask header`: do not edit.
 */

#ifndef NARX_TABLES_H
#define NARX_TABLES_H

#include <stdint.h>

/// Memory Mapping Flag.
#define NARX_PARAMETER_MEMORY_MAPPING_FLAG 0

/// Device Number.
#define NARX_PARAMETER_DEVICE_NUMBER 1

/// Slave CAN address.
#define NARX_PARAMETER_SLAVE_CAN_ADDRESS 2

/// Master CAN address.
#define NARX_PARAMETER_MASTER_CAN_ADDRESS 3

/// Hardware Release.
#define NARX_PARAMETER_HARDWARE_RELEASE 4

/// Build number.
#define NARX_PARAMETER_BUILD_NUMBER 5

/// Software Release.
#define NARX_PARAMETER_SOFTWARE_RELEASE 6

/// Source modified.
#define NARX_PARAMETER_SOURCE_MODIFIED 7

/// Temperature measurement source selection.
#define NARX_PARAMETER_TEMPERATURE_SOURCE 8

/// Accel use ref for scaling selection.
#define NARX_PARAMETER_ACCEL_USE_REFERENCE 9

/// Accel X calib offset, 10^-3 g.
#define NARX_PARAMETER_ACCEL_X_OFFSET 10

/// Accel Y calib offset, 10^-3 g.
#define NARX_PARAMETER_ACCEL_Y_OFFSET 11

/// Accel Z calib offset, 10^-3 g.
#define NARX_PARAMETER_ACCEL_Z_OFFSET 12

/// HV current calib offset, 10^-3 A.
#define NARX_PARAMETER_HV_CURRENT_OFFSET 13

/// HV voltage calib offset, 10^-3 V.
#define NARX_PARAMETER_HV_VOLTAGE_OFFSET 14

/// Temperature calib offset, 10^-1 °C.
#define NARX_PARAMETER_TEMPERATURE_OFFSET 15

/// Mechanical position calibration value, 10^-2 deg.
#define NARX_PARAMETER_POSITION_CALIBRATION 16

/// Set position calibration value (rising edge).
#define NARX_PARAMETER_SET_POSITION 17

/// Pressure calib offset, 10^-3 V.
#define NARX_PARAMETER_PRESSURE_CALIB_OFFSET 18

/// Pressure calib gain.
#define NARX_PARAMETER_PRESSURE_CALIB_GAIN 19

/// Pressure meas offset, 10^-3 V.
#define NARX_PARAMETER_PRESSURE_MEAS_OFFSET 20

/// Pressure meas gain.
#define NARX_PARAMETER_PRESSURE_MEAS_GAIN 21

/// Virtual Scop Channels Selection.
#define NARX_PARAMETER_SCOPE_CHANNELS 22

/// Virtual Scop Samples Number, samples.
#define NARX_PARAMETER_SCOPE_SAMPLES 23

/// Virtual Scop Sampling Prescaler.
#define NARX_PARAMETER_SCOPE_PRESCALER 24

/// Virtual Scop Sampling Time, 10^-6 s.
#define NARX_PARAMETER_SCOPE_SAMPLING_TIME 25

/// Virtual Scop Trig phase, samples.
#define NARX_PARAMETER_SCOPE_TRIGGER_PHASE 26

/// 01 - Logging start index.
#define NARX_PARAMETER_LOGGING_START 27

/// 02 - Logging package index.
#define NARX_PARAMETER_LOGGING_PACKAGE 28

/// First of the 37 logging slots.
#define NARX_PARAMETER_LOGGING_SLOT_FIRST 29

/// Last of the 37 logging slots.
#define NARX_PARAMETER_LOGGING_SLOT_LAST 65

/// 40 - Logging end index.
#define NARX_PARAMETER_LOGGING_END 66

/// Logging read start index.
#define NARX_PARAMETER_LOG_READ_START 67

/// Logging read number of indexes.
#define NARX_PARAMETER_LOG_READ_COUNT 68

/// Logging data size bytes, bytes.
#define NARX_PARAMETER_LOG_RECORD_BYTES 69

/// Logging data max index.
#define NARX_PARAMETER_LOG_INDEX_MAX 70

/// Logging data write index.
#define NARX_PARAMETER_LOG_WRITE_INDEX 71

/// Logging period, ms.
#define NARX_PARAMETER_LOG_PERIOD 72

/// Logging data subsectors number.
#define NARX_PARAMETER_LOG_SUBSECTORS 73

/// Logging data ongoing subsector erase index.
#define NARX_PARAMETER_LOG_ERASE_SUBSECTOR 74

/// Logging read request.
#define NARX_PARAMETER_LOG_READ_REQUEST 75

/// Logging erase request.
#define NARX_PARAMETER_LOG_ERASE_REQUEST 76

/// Logging memory full flag.
#define NARX_PARAMETER_LOG_MEMORY_FULL 77

/// Motor pair poles.
#define NARX_PARAMETER_MOTOR_POLE_PAIRS 78

/// Select control sequence for standard motor.
#define NARX_PARAMETER_STANDARD_HALL_SEQUENCE 79

/// Hall effect offset angle, 10^-2 deg.
#define NARX_PARAMETER_HALL_OFFSET_ANGLE 80

/// Open-loop enable.
#define NARX_PARAMETER_OPEN_LOOP_ENABLE 81

/// Closed-loop Sensorless enable.
#define NARX_PARAMETER_SENSORLESS_ENABLE 82

/// Closed-loop Hall Effect Sensors enable.
#define NARX_PARAMETER_HALL_ENABLE 83

/// Closed-Loop initial duty cycle, 10^-2 %.
#define NARX_PARAMETER_INITIAL_DUTY 84

/// Max period between two ZC events, ticks.
#define NARX_PARAMETER_ZC_PERIOD_MAX 85

/// N periods to discard after a sector change, ticks.
#define NARX_PARAMETER_ZC_DISCARD 86

/// Open-Loop duty cycle, 10^-2 %.
#define NARX_PARAMETER_OPEN_LOOP_DUTY 87

/// Open-loop speed setpoint, rpm.
#define NARX_PARAMETER_OPEN_LOOP_SPEED 88

/// Rotor lock duty cycle, 10^-2 %.
#define NARX_PARAMETER_LOCK_DUTY 89

/// Speed Ki coefficient SL, 10^-6 V/rad.
#define NARX_PARAMETER_SPEED_KI_SL 90

/// Speed Kp coefficient SL, 10^-6 V.s/rad.
#define NARX_PARAMETER_SPEED_KP_SL 91

/// Speed Ki coefficient HES, 10^-9 V/(rpm.s).
#define NARX_PARAMETER_SPEED_KI_HES 92

/// Speed Kp coefficient HES, 10^-9 V/rpm.
#define NARX_PARAMETER_SPEED_KP_HES 93

/// HV current Kp coefficient, 10^-6 V/A.
#define NARX_PARAMETER_HV_CURRENT_KP 94

/// HV current Ki coefficient, 10^-3 V/(A.s).
#define NARX_PARAMETER_HV_CURRENT_KI 95

/// Max HV current setpoint rate, 10^-3 A/s.
#define NARX_PARAMETER_HV_CURRENT_RATE 96

/// Hall Effect Sensors PS enable.
#define NARX_PARAMETER_HALL_SUPPLY_ENABLE 97

/// Max duty cycle SL, 10^-2 %.
#define NARX_PARAMETER_DUTY_MAX_SL 98

/// Speed setpoint rate, rpm/s.
#define NARX_PARAMETER_SPEED_RATE 99

/// ZC delay compensation, 10^-2 ticks.
#define NARX_PARAMETER_ZC_DELAY 100

/// Speed setpoint max saturation SL, rpm.
#define NARX_PARAMETER_SPEED_MAX_SL 101

/// Speed setpoint min saturation SL, rpm.
#define NARX_PARAMETER_SPEED_MIN_SL 102

/// Speed setpoint max saturation HES, rpm.
#define NARX_PARAMETER_SPEED_MAX_HES 103

/// Speed setpoint min saturation HES, rpm.
#define NARX_PARAMETER_SPEED_MIN_HES 104

/// Max HV current limitation soft start, 10^-3 A.
#define NARX_PARAMETER_HV_CURRENT_SOFT_START 105

/// Max HV current limitation, 10^-3 A.
#define NARX_PARAMETER_HV_CURRENT_MAX 106

/// Max duty cycle, 10^-2 %.
#define NARX_PARAMETER_DUTY_MAX 107

/// Open-Loop phase duration, 10^-3 s.
#define NARX_PARAMETER_OPEN_LOOP_DURATION 108

/// Open-Loop ramp rising time, 10^-3 s.
#define NARX_PARAMETER_OPEN_LOOP_RAMP 109

/// Rotor lock phase duration, 10^-3 s.
#define NARX_PARAMETER_LOCK_DURATION 110

/// can_autosend_period, ms.
#define NARX_PARAMETER_AUTOSEND_PERIOD 111

/// Fault state wait time before acknowledgement, ms.
#define NARX_PARAMETER_FAULT_WAIT 112

/// Electrical period measurement time-out, 10^-3 s.
#define NARX_PARAMETER_HALL_PERIOD_TIMEOUT 113

/// Can TimeOut period, ms.
#define NARX_PARAMETER_CAN_TIMEOUT 114

/// Critical fault mask.
#define NARX_PARAMETER_CRITICAL_FAULT_MASK 115

/// Over-current HV threshold, 10^-3 A.
#define NARX_PARAMETER_OVER_CURRENT 116

/// Over-pressure threshold, 10^-3 V.
#define NARX_PARAMETER_OVER_PRESSURE 117

/// Over-temperature shutdown threshold, 10^-1 °C.
#define NARX_PARAMETER_OVER_TEMPERATURE 118

/// Over-voltage HV threshold, 10^-3 V.
#define NARX_PARAMETER_OVER_VOLTAGE 119

/// Under-voltage HV threshold, 10^-3 V.
#define NARX_PARAMETER_UNDER_VOLTAGE 120

/// Over-temperature warning threshold, 10^-1 °C.
#define NARX_PARAMETER_TEMPERATURE_WARNING 121

/// Store parameters.
#define NARX_PARAMETER_STORE 256

/// Store once parameters.
#define NARX_PARAMETER_STORE_ONCE 257

/// Reset calibration parameters.
#define NARX_PARAMETER_RESET_CALIBRATION 258

/// Auto-calibrate.
#define NARX_PARAMETER_AUTO_CALIBRATE 259

/// Scope state.
#define NARX_PARAMETER_SCOPE_STATE 260

/// Drive state.
#define NARX_PARAMETER_DRIVE_STATE 261

/// Hall order.
#define NARX_PARAMETER_HALL_ORDER 262

/// Hall polarity mask.
#define NARX_PARAMETER_HALL_POLARITY 263

/// Hall calibration request.
#define NARX_PARAMETER_HALL_CALIBRATE 264

/// Hall stall time, ms.
#define NARX_PARAMETER_HALL_STALL_TIME 265

/// Nominal supply voltage, 10^-3 V.
#define NARX_PARAMETER_NOMINAL_SUPPLY 266

/// Back-EMF constant, 10^-6 V/rpm.
#define NARX_PARAMETER_BACK_EMF_CONSTANT 267

/// Winding resistance, 10^-3 ohm.
#define NARX_PARAMETER_WINDING_RESISTANCE 268

/// Phase current limit, 10^-3 A.
#define NARX_PARAMETER_PHASE_CURRENT_MAX 269

/// Digital shutdown input.
#define NARX_PARAMETER_SHUTDOWN_INPUT 270

/// Duty slew limit, 10^-2 %/ms.
#define NARX_PARAMETER_DUTY_SLEW 271

/// Minimum on-time, ns.
#define NARX_PARAMETER_ON_TIME_MIN 272

/// Timing advance, 10^-2 deg.
#define NARX_PARAMETER_TIMING_ADVANCE 273

/// Refused frames.
#define NARX_PARAMETER_REFUSED_FRAMES 274

/// Malformed frames.
#define NARX_PARAMETER_MALFORMED_FRAMES 275

/// Start refusal.
#define NARX_PARAMETER_START_REFUSAL 276

/// Hall invalid codes.
#define NARX_PARAMETER_HALL_INVALID 277

/// Hall jumps.
#define NARX_PARAMETER_HALL_JUMPS 278

/// Hall calibration state.
#define NARX_PARAMETER_HALL_CALIBRATION_STATE 279

/// Active limiter.
#define NARX_PARAMETER_ACTIVE_LIMITER 280

/// Hall interpolation speed, rpm.
#define NARX_PARAMETER_HALL_INTERPOLATION_SPEED 281

/// Extended fault code.
#define NARX_PARAMETER_EXTENDED_FAULT_CODE 282

/// Winding inductance, 10^-6 H.
#define NARX_PARAMETER_WINDING_INDUCTANCE 283

/// Frames lost.
#define NARX_PARAMETER_FRAMES_LOST 284

/// Rejected parameter.
#define NARX_PARAMETER_REJECTED_PARAMETER 285

/// ZC falling delay difference, 10^-2 ticks.
#define NARX_PARAMETER_ZC_DELAY_FALLING 286

/// Last zero crossing.
#define NARX_PARAMETER_CROSSING 287

/// Zero crossing margin, 10^-2 deg.
#define NARX_PARAMETER_CROSSING_MARGIN 288

/// Zero crossings.
#define NARX_PARAMETER_CROSSINGS 289

/// Scope trigger.
#define NARX_PARAMETER_SCOPE_TRIGGER 290

/// Scope trigger signal.
#define NARX_PARAMETER_SCOPE_TRIGGER_SIGNAL 291

/// Scope trigger level, 10^-3 of the signal's base.
#define NARX_PARAMETER_SCOPE_TRIGGER_LEVEL 292

/// Bus error state.
#define NARX_PARAMETER_BUS_STATE 293

/// Transmit error counter.
#define NARX_PARAMETER_TRANSMIT_ERRORS 294

/// Receive error counter.
#define NARX_PARAMETER_RECEIVE_ERRORS 295

/// Bus-offs.
#define NARX_PARAMETER_BUS_OFFS 296

/// Accel meas offset, 10^-3 V.
#define NARX_PARAMETER_ACCEL_MEAS_OFFSET 297

/// Tilt, 10^-2 deg.
#define NARX_PARAMETER_TILT 298

/// Vibration, 10^-3 g.
#define NARX_PARAMETER_VIBRATION 299

/// Scope inputs.
#define NARX_PARAMETER_SCOPE_INPUTS 300

/// Scope words.
#define NARX_PARAMETER_SCOPE_WORDS 301

/// Reset cause.
#define NARX_PARAMETER_RESET_CAUSE 302

/// Failed self-tests.
#define NARX_PARAMETER_FAILED_SELF_TESTS 303

/// Diagnostics.
#define NARX_PARAMETER_DIAGNOSTICS 304

/// Scope room, words.
#define NARX_PARAMETER_SCOPE_ROOM 305

/// Scope refusal.
#define NARX_PARAMETER_SCOPE_REFUSAL 306

/// Automatic store.
#define NARX_PARAMETER_AUTOMATIC_STORE 307

/// Other rotor source.
#define NARX_PARAMETER_OTHER_SOURCE 308

/// Values of the field "motor mode".
typedef enum narx_motor_mode_t {
    NARX_MOTOR_MODE_STANDBY = 0,
    NARX_MOTOR_MODE_DRIVE = 1,
    NARX_MOTOR_MODE_REVERSE = 2,
    NARX_MOTOR_MODE_FAULT = 3,
} narx_motor_mode_t;

/// Values of the field "control mode".
typedef enum narx_control_mode_t {
    NARX_CONTROL_MODE_OFF = 0,
    NARX_CONTROL_MODE_OPEN_LOOP = 1,
    NARX_CONTROL_MODE_SENSORLESS_CLOSED_LOOP = 2,
    NARX_CONTROL_MODE_HALL_CLOSED_LOOP = 3,
} narx_control_mode_t;

/// Values of the field "logging state".
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

/// Values of the field "parameter status".
typedef enum narx_parameter_status_t {
    NARX_PARAMETER_STATUS_DONE = 0,
    NARX_PARAMETER_STATUS_UNKNOWN_NUMBER = 1,
    NARX_PARAMETER_STATUS_READ_ONLY = 2,
    NARX_PARAMETER_STATUS_OUT_OF_RANGE = 3,
    NARX_PARAMETER_STATUS_WRONG_STATE = 4,
    NARX_PARAMETER_STATUS_STORAGE = 5,
    NARX_PARAMETER_STATUS_NOT_EQUIPPED = 6,
} narx_parameter_status_t;

/// Bit of the fault word (Table 9).
#define NARX_FAULT_TEMPERATURE_WARNING 1

/// Bit of the fault word (Table 9).
#define NARX_FAULT_OVER_TEMPERATURE 2

/// Bit of the fault word (Table 9).
#define NARX_FAULT_OVER_VOLTAGE 4

/// Bit of the fault word (Table 9).
#define NARX_FAULT_UNDER_VOLTAGE 8

/// Bit of the fault word (Table 9).
#define NARX_FAULT_OVER_CURRENT 0x10u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_LEGS_DRIVER 0x20u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_HALL_SENSORS 0x40u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_OVER_PRESSURE 0x80u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_STORE_MISMATCH 0x4000000u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_EMERGENCY_SHUTDOWN 0x8000000u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_EXTERNAL_SHUTDOWN 0x10000000u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_DEVICE_TIMEOUT 0x20000000u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_STORE_ABSENT 0x40000000u

/// Bit of the fault word (Table 9).
#define NARX_FAULT_STORE_VERSION 0x80000000u

/// Extended fault code: temperature above the warning threshold.
#define NARX_CAUSE_TEMPERATURE_WARNING 1

/// Extended fault code: temperature above the shutdown threshold.
#define NARX_CAUSE_OVER_TEMPERATURE 0x101u

/// Extended fault code: bus voltage above its threshold; at once when 1 V above.
#define NARX_CAUSE_OVER_VOLTAGE 0x201u

/// Extended fault code: bus voltage below its threshold.
#define NARX_CAUSE_UNDER_VOLTAGE 0x301u

/// Extended fault code: mean DC-link current above its threshold.
#define NARX_CAUSE_OVER_CURRENT 0x401u

/// Extended fault code: the gate driver reports a fault.
#define NARX_CAUSE_DRIVER_LINE 0x501u

/// Extended fault code: a phase carries no current (three revolutions, or 100 ms at rest).
#define NARX_CAUSE_OPEN_PHASE 0x502u

/// Extended fault code: hall codes 000 or 111 (64 more than one a millisecond).
#define NARX_CAUSE_HALL_INVALID 0x601u

/// Extended fault code: hall sectors skipped (5 more than one in 13 ms).
#define NARX_CAUSE_HALL_JUMPS 0x602u

/// Extended fault code: torque applied at speed 0 (parameter 113) for the stall time (parameter 265).
#define NARX_CAUSE_HALL_STALL 0x603u

/// Extended fault code: hall edges run against the torque: wiring, or a load that drives backwards.
#define NARX_CAUSE_HALL_DIRECTION 0x604u

/// Extended fault code: the motor goes on without its hall sensors (parameter 308); no fault bit.
#define NARX_CAUSE_HALLS_GIVEN_UP 0x605u

/// Extended fault code: pressure above its threshold.
#define NARX_CAUSE_OVER_PRESSURE 0x701u

/// Extended fault code: parameter store has another layout.
#define NARX_CAUSE_STORE_MISMATCH 0x1A01u

/// Extended fault code: hardware break input.
#define NARX_CAUSE_EMERGENCY_LINE 0x1B01u

/// Extended fault code: self-test failed.
#define NARX_CAUSE_SELF_TEST 0x1B02u

/// Extended fault code: speed above 130 % of the mode's maximum set-point.
#define NARX_CAUSE_OVERSPEED 0x1B03u

/// Extended fault code: the sensorless motor stalls or does not start, five times (one is forgiven in 10 s).
#define NARX_CAUSE_SENSORLESS_STALL 0x1B04u

/// Extended fault code: zero crossings jump by more than half an interval, five times (one is forgiven in 10 s).
#define NARX_CAUSE_DESYNCHRONISATION 0x1B05u

/// Extended fault code: sensorless speed and applied voltage do not fit together for 150 ms, five times (one is forgiven in 10 s).
#define NARX_CAUSE_WRONG_LOCK 0x1B06u

/// Extended fault code: the motor goes on with its hall sensors (parameter 308); no fault bit.
#define NARX_CAUSE_BACK_EMF_GIVEN_UP 0x1B07u

/// Extended fault code: shutdown requested over CAN (motor mode 3).
#define NARX_CAUSE_SHUTDOWN_COMMANDED 0x1C01u

/// Extended fault code: the digital input configured for shutdown.
#define NARX_CAUSE_SHUTDOWN_LINE 0x1C02u

/// Extended fault code: no valid command while driving for the time-out (parameter 114).
#define NARX_CAUSE_COMMAND_TIMEOUT 0x1D01u

/// Extended fault code: parameter store absent.
#define NARX_CAUSE_STORE_ABSENT 0x1E01u

/// Extended fault code: parameter store of another firmware version.
#define NARX_CAUSE_STORE_VERSION 0x1F01u

/// 2000h Node-ID, 1 to 127. Address on the bus, different for every node of it.
#define NARX_TX_ENTRY_NODE_ID 0

/// 2001h Bitrate Index, 0 to 4. 0: 50, 1: 100, 2: 250, 3: 500, 4: 1000 kbit/s. The same for every node of the bus.
#define NARX_TX_ENTRY_BITRATE_INDEX 1

/// 2002h Nr Of Nodes, 1 to 127. TX-Drivers on the bus, which share half of it among their PDO1 when the update time is 65535.
#define NARX_TX_ENTRY_NR_OF_NODES 2

/// 2003h Update Time, 0 to 65535. Period of PDO1. 0: no PDO1. 65535: as short as half of the bus allows for all nodes together.
#define NARX_TX_ENTRY_UPDATE_TIME 3

/// 2004h Can Config Register, 0 to 7. Bit 0: Operational after boot-up. Bit 1: PDOs carry the encoder. Bit 2: heartbeat every 2 s.
#define NARX_TX_ENTRY_CAN_CONFIG 4

/// 2005h Basic Config Register, 0 to 6. Bit 1: the encoder is rotary, else linear. Bit 2: it counts the other way round. Bit 0 is reserved.
#define NARX_TX_ENTRY_BASIC_CONFIG 5

/// 2006h.1 Filter, 0 to 4. Edge frequency of channel 1. 0: no filter, 1: 10 Hz, 2: 100 Hz, 3: 1 kHz, 4: 10 kHz.
#define NARX_TX_ENTRY_FILTER_1 6

/// 2006h.2 Filter, 0 to 4. Edge frequency of channel 2, likewise; without effect on a driver of one channel.
#define NARX_TX_ENTRY_FILTER_2 7

/// 2007h.1 Comparator, 0 to 1073741824. Output 1 is high while channel 1 is above this fraction of its measuring range.
#define NARX_TX_ENTRY_COMPARATOR_1 8

/// 2007h.2 Comparator, 0 to 1073741824. Output 2 likewise for channel 2, or on a driver of one channel for channel 1: a second threshold.
#define NARX_TX_ENTRY_COMPARATOR_2 9

/// 2008h Counts Per Revolution, 1 to 65535. Counts of a rotary encoder, four to a period: its value runs from 0 to one less.
#define NARX_TX_ENTRY_COUNTS_PER_REVOLUTION 0xAu

/// 2009h Encoder Resolution, 1 to 65535. Length of a linear encoder's count, four to a period. Told to whoever asks; PDOs carry counts.
#define NARX_TX_ENTRY_ENCODER_RESOLUTION 0xBu

/// 200Ah Reset Encoder, 0 to 255. Any write, with or without data: the present place of a linear encoder becomes 0.
#define NARX_TX_ENTRY_RESET_ENCODER 0xCu

/// 2100h Firmware Version, 0 to 65535. Our own: release of the firmware, major in the high byte.
#define NARX_TX_ENTRY_FIRMWARE_VERSION 0xDu

/// Which message: type and opcode, the low 11 bits of its identifier (PROTOCOL.md, section 2).
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

/// Fields that a message has at most.
#define NARX_FIELDS_MAX 7

/// The fields of a message: those of its own kind count. Raw numbers, with scale and unit beside each.
typedef union narx_fields_t {
    /// In the order of their bits; a signed one as its bits.
    uint32_t raw[NARX_FIELDS_MAX];
    /// Fields of BUILD_INFO.
    struct {
        uint32_t build_number;
        uint32_t source_modified; ///< 0 no, 1 yes
        uint32_t build_date;
    } build_info;
    /// Fields of DEVICE_INFO.
    struct {
        uint32_t hardware_release;
        uint32_t software_release;
        uint32_t device_number;
        uint32_t can_address;
    } device_info;
    /// Fields of REQUEST_WORD.
    struct {
        uint32_t motor_mode; ///< a narx_motor_mode_t
    } request_word;
    /// Fields of STATUS_WORD.
    struct {
        uint32_t log_erase_possible; ///< 0 no, 1 yes
        uint32_t log_download_possible; ///< 0 no, 1 yes
        uint32_t log_memory_erased; ///< 0 no, 1 yes
        uint32_t log_memory_full; ///< 0 no, 1 yes
        uint32_t logging_state; ///< a narx_logging_state_t
        uint32_t control_mode; ///< a narx_control_mode_t
        uint32_t motor_mode; ///< a narx_motor_mode_t
    } status_word;
    /// Fields of FAULT_WORD.
    struct {
        uint32_t faults; ///< sum of NARX_FAULT_*
    } fault_word;
    /// Fields of CRITICAL_FAULT.
    struct {
        uint32_t faults; ///< sum of NARX_FAULT_*
        uint32_t extended_fault_code;
    } critical_fault;
    /// Fields of REBOOT.
    struct {
        uint32_t acknowledged; ///< 0 no, 1 yes
    } reboot;
    /// Fields of MOTOR_CMD_SET.
    struct {
        uint32_t speed; ///< rpm
    } motor_cmd_set;
    /// Fields of MOTOR_CMD.
    struct {
        uint32_t speed; ///< rpm
    } motor_cmd;
    /// Fields of DSIO_DATA_CMD.
    struct {
        uint32_t dsio1_output_enable; ///< 0 no, 1 yes
        uint32_t dsio1_level; ///< 0 low, 1 high
        uint32_t dsio2_output_enable; ///< 0 no, 1 yes
        uint32_t dsio2_level; ///< 0 low, 1 high
    } dsio_data_cmd;
    /// Fields of Disable_Hall_PS.
    struct {
        uint32_t disable; ///< 0 no, 1 yes
    } disable_hall_ps;
    /// Fields of PARAMETER_SET.
    struct {
        uint32_t number; ///< a NARX_PARAMETER_*
        int32_t value; ///< its unit and scale: PROTOCOL.md
    } parameter_set;
    /// Fields of PARAMETER_REQUEST.
    struct {
        uint32_t number; ///< a NARX_PARAMETER_*
    } parameter_request;
    /// Fields of PARAMETER.
    struct {
        uint32_t number; ///< a NARX_PARAMETER_*
        int32_t value; ///< its unit and scale: PROTOCOL.md
        uint32_t status; ///< a narx_parameter_status_t
    } parameter;
    /// Fields of LOG_VIRTUAL_SCOPE.
    struct {
        uint32_t address;
        int32_t sample_1;
        int32_t sample_2;
        int32_t sample_3;
    } log_virtual_scope;
    /// Fields of RESTORE_FACTORY_SETTING.
    struct {
        uint32_t serial_number;
    } restore_factory_setting;
    /// Fields of XML_DOWNLOAD_REQUEST.
    struct {
        uint32_t command; ///< 0 Length, 1 Start
    } xml_download_request;
    /// Fields of XML_DOWNLOAD_ANSWER.
    struct {
        uint32_t length; ///< words
        uint32_t crc_32;
    } xml_download_answer;
    /// Fields of XML_DOWNLOAD_DATA.
    struct {
        uint32_t address;
        uint32_t text_1;
        uint32_t text_2;
        uint32_t text_3;
    } xml_download_data;
    /// Fields of EXT_MEM_LOG_READ_DATA.
    struct {
        uint32_t word_counter;
        uint32_t data_1;
        uint32_t data_2;
        uint32_t data_3;
    } ext_mem_log_read_data;
    /// Fields of MEASUREMENT_0.
    struct {
        int32_t accel_x; ///< 10^-3 g
        int32_t accel_y; ///< 10^-3 g
        int32_t accel_z; ///< 10^-3 g
        uint32_t dsi1_dsp; ///< 0 low, 1 high
    } measurement_0;
    /// Fields of MEASUREMENT_1.
    struct {
        int32_t mechanical_estimated_speed_sl; ///< rpm
        int32_t mechanical_position; ///< 10^-2 deg
        int32_t electrical_input_power; ///< 10^-1 W
    } measurement_1;
    /// Fields of MEASUREMENT_2.
    struct {
        int32_t hv_voltage; ///< 10^-2 V
        int32_t hv_current; ///< 10^-3 A
        int32_t _6v_meas; ///< 10^-3 V
        int32_t driver_14v_voltage; ///< 10^-3 V
    } measurement_2;
    /// Fields of MEASUREMENT_3.
    struct {
        int32_t ambient_temperature; ///< 10^-1 deg C
        int32_t vref_accel_1_8v; ///< 10^-3 V
        int32_t _0_383vref; ///< 10^-3 V
        int32_t asi_dsp; ///< 10^-3 V
    } measurement_3;
    /// Fields of MEASUREMENT_4.
    struct {
        int32_t voltagephasea; ///< 10^-2 V
        int32_t voltagephaseb; ///< 10^-2 V
        int32_t voltagephasec; ///< 10^-2 V
        int32_t pin_meas; ///< 10^-3 V
    } measurement_4;
    /// Fields of MEASUREMENT_5.
    struct {
        int32_t mechanical_estimated_speed_hes; ///< rpm
        uint32_t dsi2_dsp; ///< 0 low, 1 high
    } measurement_5;
} narx_fields_t;

#endif // NARX_TABLES_H
