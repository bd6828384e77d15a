//! Parameter numbers: 0 to 121 are the rows of Tables 10 and 11 in printed order (5 to 121 are not printed),
//! from 256 on our own, without gaps: a new one takes the next number. A number never changes once published.

// General parameters (Table 10)

/// Memory Mapping Flag.
pub const MEMORY_MAPPING_FLAG: u16 = 0;
/// Device Number.
pub const DEVICE_NUMBER: u16 = 1;
/// Slave CAN address.
pub const SLAVE_CAN_ADDRESS: u16 = 2;
/// Master CAN address.
pub const MASTER_CAN_ADDRESS: u16 = 3;
/// Hardware Release.
pub const HARDWARE_RELEASE: u16 = 4;
/// Build number.
pub const BUILD_NUMBER: u16 = 5;
/// Software Release.
pub const SOFTWARE_RELEASE: u16 = 6;
/// Source modified.
pub const SOURCE_MODIFIED: u16 = 7;
/// Temperature measurement source selection.
pub const TEMPERATURE_SOURCE: u16 = 8;
/// Accel use ref for scaling selection.
pub const ACCEL_USE_REFERENCE: u16 = 9;
/// Accel X calib offset, 10^-3 g.
pub const ACCEL_X_OFFSET: u16 = 10;
/// Accel Y calib offset, 10^-3 g.
pub const ACCEL_Y_OFFSET: u16 = 11;
/// Accel Z calib offset, 10^-3 g.
pub const ACCEL_Z_OFFSET: u16 = 12;
/// HV current calib offset, 10^-3 A.
pub const HV_CURRENT_OFFSET: u16 = 13;
/// HV voltage calib offset, 10^-3 V.
pub const HV_VOLTAGE_OFFSET: u16 = 14;
/// Temperature calib offset, 10^-1 °C.
pub const TEMPERATURE_OFFSET: u16 = 15;
/// Mechanical position calibration value, 10^-2 deg.
pub const POSITION_CALIBRATION: u16 = 16;
/// Set position calibration value (rising edge).
pub const SET_POSITION: u16 = 17;
/// Pressure calib offset, 10^-3 V.
pub const PRESSURE_CALIB_OFFSET: u16 = 18;
/// Pressure calib gain.
pub const PRESSURE_CALIB_GAIN: u16 = 19;
/// Pressure meas offset, 10^-3 V.
pub const PRESSURE_MEAS_OFFSET: u16 = 20;
/// Pressure meas gain.
pub const PRESSURE_MEAS_GAIN: u16 = 21;
/// Virtual Scop Channels Selection.
pub const SCOPE_CHANNELS: u16 = 22;
/// Virtual Scop Samples Number, samples.
pub const SCOPE_SAMPLES: u16 = 23;
/// Virtual Scop Sampling Prescaler.
pub const SCOPE_PRESCALER: u16 = 24;
/// Virtual Scop Sampling Time, 10^-6 s.
pub const SCOPE_SAMPLING_TIME: u16 = 25;
/// Virtual Scop Trig phase, samples.
pub const SCOPE_TRIGGER_PHASE: u16 = 26;
/// 01 - Logging start index.
pub const LOGGING_START: u16 = 27;
/// 02 - Logging package index.
pub const LOGGING_PACKAGE: u16 = 28;
/// First of the 37 logging slots.
pub const LOGGING_SLOT_FIRST: u16 = 29;
/// Last of the 37 logging slots.
pub const LOGGING_SLOT_LAST: u16 = 65;
/// 40 - Logging end index.
pub const LOGGING_END: u16 = 66;
/// Logging read start index.
pub const LOG_READ_START: u16 = 67;
/// Logging read number of indexes.
pub const LOG_READ_COUNT: u16 = 68;
/// Logging data size bytes, bytes.
pub const LOG_RECORD_BYTES: u16 = 69;
/// Logging data max index.
pub const LOG_INDEX_MAX: u16 = 70;
/// Logging data write index.
pub const LOG_WRITE_INDEX: u16 = 71;
/// Logging period, ms.
pub const LOG_PERIOD: u16 = 72;
/// Logging data subsectors number.
pub const LOG_SUBSECTORS: u16 = 73;
/// Logging data ongoing subsector erase index.
pub const LOG_ERASE_SUBSECTOR: u16 = 74;
/// Logging read request.
pub const LOG_READ_REQUEST: u16 = 75;
/// Logging erase request.
pub const LOG_ERASE_REQUEST: u16 = 76;
/// Logging memory full flag.
pub const LOG_MEMORY_FULL: u16 = 77;

// Control parameters (Table 11)

/// Motor pair poles.
pub const MOTOR_POLE_PAIRS: u16 = 78;
/// Select control sequence for standard motor.
pub const STANDARD_HALL_SEQUENCE: u16 = 79;
/// Hall effect offset angle, 10^-2 deg.
pub const HALL_OFFSET_ANGLE: u16 = 80;
/// Open-loop enable.
pub const OPEN_LOOP_ENABLE: u16 = 81;
/// Closed-loop Sensorless enable.
pub const SENSORLESS_ENABLE: u16 = 82;
/// Closed-loop Hall Effect Sensors enable.
pub const HALL_ENABLE: u16 = 83;
/// Closed-Loop initial duty cycle, 10^-2 %.
pub const INITIAL_DUTY: u16 = 84;
/// Max period between two ZC events, ticks.
pub const ZC_PERIOD_MAX: u16 = 85;
/// N periods to discard after a sector change, ticks.
pub const ZC_DISCARD: u16 = 86;
/// Open-Loop duty cycle, 10^-2 %.
pub const OPEN_LOOP_DUTY: u16 = 87;
/// Open-loop speed setpoint, rpm.
pub const OPEN_LOOP_SPEED: u16 = 88;
/// Rotor lock duty cycle, 10^-2 %.
pub const LOCK_DUTY: u16 = 89;
/// Speed Ki coefficient SL, 10^-6 V/rad.
pub const SPEED_KI_SL: u16 = 90;
/// Speed Kp coefficient SL, 10^-6 V.s/rad.
pub const SPEED_KP_SL: u16 = 91;
/// Speed Ki coefficient HES, 10^-9 V/(rpm.s).
pub const SPEED_KI_HES: u16 = 92;
/// Speed Kp coefficient HES, 10^-9 V/rpm.
pub const SPEED_KP_HES: u16 = 93;
/// HV current Kp coefficient, 10^-6 V/A.
pub const HV_CURRENT_KP: u16 = 94;
/// HV current Ki coefficient, 10^-3 V/(A.s).
pub const HV_CURRENT_KI: u16 = 95;
/// Max HV current setpoint rate, 10^-3 A/s.
pub const HV_CURRENT_RATE: u16 = 96;
/// Hall Effect Sensors PS enable.
pub const HALL_SUPPLY_ENABLE: u16 = 97;
/// Max duty cycle SL, 10^-2 %.
pub const DUTY_MAX_SL: u16 = 98;
/// Speed setpoint rate, rpm/s.
pub const SPEED_RATE: u16 = 99;
/// ZC delay compensation, 10^-2 ticks.
pub const ZC_DELAY: u16 = 100;
/// Speed setpoint max saturation SL, rpm.
pub const SPEED_MAX_SL: u16 = 101;
/// Speed setpoint min saturation SL, rpm.
pub const SPEED_MIN_SL: u16 = 102;
/// Speed setpoint max saturation HES, rpm.
pub const SPEED_MAX_HES: u16 = 103;
/// Speed setpoint min saturation HES, rpm.
pub const SPEED_MIN_HES: u16 = 104;
/// Max HV current limitation soft start, 10^-3 A.
pub const HV_CURRENT_SOFT_START: u16 = 105;
/// Max HV current limitation, 10^-3 A.
pub const HV_CURRENT_MAX: u16 = 106;
/// Max duty cycle, 10^-2 %.
pub const DUTY_MAX: u16 = 107;
/// Open-Loop phase duration, 10^-3 s.
pub const OPEN_LOOP_DURATION: u16 = 108;
/// Open-Loop ramp rising time, 10^-3 s.
pub const OPEN_LOOP_RAMP: u16 = 109;
/// Rotor lock phase duration, 10^-3 s.
pub const LOCK_DURATION: u16 = 110;
/// can_autosend_period, ms.
pub const AUTOSEND_PERIOD: u16 = 111;
/// Fault state wait time before acknowledgement, ms.
pub const FAULT_WAIT: u16 = 112;
/// Electrical period measurement time-out, 10^-3 s.
pub const HALL_PERIOD_TIMEOUT: u16 = 113;
/// Can TimeOut period, ms.
pub const CAN_TIMEOUT: u16 = 114;
/// Critical fault mask.
pub const CRITICAL_FAULT_MASK: u16 = 115;
/// Over-current HV threshold, 10^-3 A.
pub const OVER_CURRENT: u16 = 116;
/// Over-pressure threshold, 10^-3 V.
pub const OVER_PRESSURE: u16 = 117;
/// Over-temperature shutdown threshold, 10^-1 °C.
pub const OVER_TEMPERATURE: u16 = 118;
/// Over-voltage HV threshold, 10^-3 V.
pub const OVER_VOLTAGE: u16 = 119;
/// Under-voltage HV threshold, 10^-3 V.
pub const UNDER_VOLTAGE: u16 = 120;
/// Over-temperature warning threshold, 10^-1 °C.
pub const TEMPERATURE_WARNING: u16 = 121;

// Our own

/// Store parameters.
pub const STORE: u16 = 256;
/// Store once parameters.
pub const STORE_ONCE: u16 = 257;
/// Reset calibration parameters.
pub const RESET_CALIBRATION: u16 = 258;
/// Auto-calibrate.
pub const AUTO_CALIBRATE: u16 = 259;
/// Scope state.
pub const SCOPE_STATE: u16 = 260;
/// Drive state.
pub const DRIVE_STATE: u16 = 261;
/// Hall order.
pub const HALL_ORDER: u16 = 262;
/// Hall polarity mask.
pub const HALL_POLARITY: u16 = 263;
/// Hall calibration request.
pub const HALL_CALIBRATE: u16 = 264;
/// Hall stall time, ms.
pub const HALL_STALL_TIME: u16 = 265;
/// Nominal supply voltage, 10^-3 V.
pub const NOMINAL_SUPPLY: u16 = 266;
/// Back-EMF constant, 10^-6 V/rpm.
pub const BACK_EMF_CONSTANT: u16 = 267;
/// Winding resistance, 10^-3 ohm.
pub const WINDING_RESISTANCE: u16 = 268;
/// Phase current limit, 10^-3 A.
pub const PHASE_CURRENT_MAX: u16 = 269;
/// Digital shutdown input.
pub const SHUTDOWN_INPUT: u16 = 270;
/// Duty slew limit, 10^-2 %/ms.
pub const DUTY_SLEW: u16 = 271;
/// Minimum on-time, ns.
pub const ON_TIME_MIN: u16 = 272;
/// Timing advance, 10^-2 deg.
pub const TIMING_ADVANCE: u16 = 273;
/// Refused frames.
pub const REFUSED_FRAMES: u16 = 274;
/// Malformed frames.
pub const MALFORMED_FRAMES: u16 = 275;
/// Start refusal.
pub const START_REFUSAL: u16 = 276;
/// Hall invalid codes.
pub const HALL_INVALID: u16 = 277;
/// Hall jumps.
pub const HALL_JUMPS: u16 = 278;
/// Hall calibration state.
pub const HALL_CALIBRATION_STATE: u16 = 279;
/// Active limiter.
pub const ACTIVE_LIMITER: u16 = 280;
/// Hall interpolation speed, rpm.
pub const HALL_INTERPOLATION_SPEED: u16 = 281;
/// Extended fault code.
pub const EXTENDED_FAULT_CODE: u16 = 282;
/// Winding inductance, 10^-6 H.
pub const WINDING_INDUCTANCE: u16 = 283;
/// Frames lost.
pub const FRAMES_LOST: u16 = 284;
/// Rejected parameter.
pub const REJECTED_PARAMETER: u16 = 285;
/// ZC falling delay difference, 10^-2 ticks.
pub const ZC_DELAY_FALLING: u16 = 286;
/// Last zero crossing.
pub const CROSSING: u16 = 287;
/// Zero crossing margin, 10^-2 deg.
pub const CROSSING_MARGIN: u16 = 288;
/// Zero crossings.
pub const CROSSINGS: u16 = 289;
/// Scope trigger.
pub const SCOPE_TRIGGER: u16 = 290;
/// Scope trigger signal.
pub const SCOPE_TRIGGER_SIGNAL: u16 = 291;
/// Scope trigger level, 10^-3 of the signal's base.
pub const SCOPE_TRIGGER_LEVEL: u16 = 292;
/// Bus error state.
pub const BUS_STATE: u16 = 293;
/// Transmit error counter.
pub const TRANSMIT_ERRORS: u16 = 294;
/// Receive error counter.
pub const RECEIVE_ERRORS: u16 = 295;
/// Bus-offs.
pub const BUS_OFFS: u16 = 296;
/// Accel meas offset, 10^-3 V.
pub const ACCEL_MEAS_OFFSET: u16 = 297;
/// Tilt, 10^-2 deg.
pub const TILT: u16 = 298;
/// Vibration, 10^-3 g.
pub const VIBRATION: u16 = 299;
/// Scope inputs.
pub const SCOPE_INPUTS: u16 = 300;
/// Scope words.
pub const SCOPE_WORDS: u16 = 301;
/// Reset cause.
pub const RESET_CAUSE: u16 = 302;
/// Failed self-tests.
pub const FAILED_SELF_TESTS: u16 = 303;
/// Diagnostics.
pub const DIAGNOSTICS: u16 = 304;
/// Scope room, words.
pub const SCOPE_ROOM: u16 = 305;
/// Scope refusal.
pub const SCOPE_REFUSAL: u16 = 306;
/// Automatic store.
pub const AUTOMATIC_STORE: u16 = 307;
/// Other rotor source.
pub const OTHER_SOURCE: u16 = 308;
