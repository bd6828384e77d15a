//! Our own parameters, from number 256 on, without gaps: [`super::Dictionary`] finds a row by its number. The
//! steps to a new one are in CONTRIBUTING.md, *A new parameter*.

use super::category::Category::{
    Calibration, CommandSaturation, Control, Diagnostics, Instrumentation, Limitation, Machine, Services,
};
use super::number;
use super::parameter::Kind::{I32, U16, U32};
use super::row::Row;

/// Our own parameters, from number 256 on.
pub(super) const OWN: [Row; 53] = [
    Row::new(number::STORE, "Store parameters", Services, U16)
        .range(0, 1)
        .factory(0)
        .command()
        .about("Writing 0 then 1 stores every parameter but those of parameter 257."),
    Row::new(number::STORE_ONCE, "Store once parameters", Services, U16)
        .range(0, 1)
        .factory(0)
        .command()
        .about("Writing 0 then 1 stores the device number and the calibration (category 02)."),
    Row::new(number::RESET_CALIBRATION, "Reset calibration parameters", Services, U16)
        .range(0, 1)
        .factory(0)
        .command()
        .about("Writing 0 then 1 sets the calibration (category 02) to its factory values."),
    Row::new(number::AUTO_CALIBRATE, "Auto-calibrate", Services, U16)
        .range(0, 1)
        .factory(0)
        .command()
        .about(
            "Writing 0 then 1 with the bridge off: the bus current reads 0 and the bus voltage reads parameter \
             266, which must not be 0.",
        ),
    Row::new(number::SCOPE_STATE, "Scope state", Diagnostics, U16)
        .range(0, 3)
        .factory(0)
        .read_only()
        .about("0 idle, 1 armed, 2 recording, 3 done."),
    Row::new(number::DRIVE_STATE, "Drive state", Diagnostics, U16)
        .range(0, 7)
        .factory(0)
        .read_only()
        .about("State of the drive, as numbered in section 7."),
    Row::new(number::HALL_ORDER, "Hall order", Machine, U16)
        .range(0, 5)
        .factory(0)
        .about("Permutation of the hall lines: 0 ABC, 1 ACB, 2 BAC, 3 BCA, 4 CAB, 5 CBA."),
    Row::new(number::HALL_POLARITY, "Hall polarity mask", Machine, U16)
        .range(0, 7)
        .factory(0)
        .about("Hall lines to invert before the permutation: bit 0 A, bit 1 B, bit 2 C."),
    Row::new(number::HALL_CALIBRATE, "Hall calibration request", Services, U16)
        .range(0, 1)
        .factory(0)
        .command()
        .at_next_start()
        .about(
            "Writing 0 then 1 makes the next start turn the motor one electrical revolution each way to find \
             parameters 262, 263 and 80; writing 0 withdraws it.",
        ),
    Row::new(number::HALL_STALL_TIME, "Hall stall time", Limitation, U16)
        .in_unit("ms", 0)
        .range(10, 10000)
        .factory(500)
        .about("Time in state 5 with torque applied at speed 0 (no hall edge for parameter 113) that becomes fault bit 6."),
    Row::new(number::NOMINAL_SUPPLY, "Nominal supply voltage", Machine, U16)
        .in_unit("V", -3)
        .range(0, 60000)
        .factory(0)
        .about(
            "Voltage to which the percentages of parameters 84, 87 and 89 refer, so that their effect does \
             not change with the supply; 0: they are duties of the live bus voltage.",
        ),
    Row::new(number::BACK_EMF_CONSTANT, "Back-EMF constant", Machine, I32)
        .in_unit("V/rpm", -6)
        .range(0, 1_000_000)
        .factory(0)
        .about(
            "Mean six-step back-EMF between two lines per mechanical rpm, the inverse of the speed constant; 0 \
             unknown.",
        ),
    Row::new(number::WINDING_RESISTANCE, "Winding resistance", Machine, I32)
        .in_unit("ohm", -3)
        .range(0, 100_000)
        .factory(0)
        .about("Between two lines; 0 unknown."),
    Row::new(number::PHASE_CURRENT_MAX, "Phase current limit", CommandSaturation, U16)
        .in_unit("A", -3)
        .range(100, 12000)
        .factory(12000)
        .about("Bound of the estimated phase current, peak (Table 1)."),
    Row::new(number::SHUTDOWN_INPUT, "Digital shutdown input", Limitation, U16)
        .range(0, 2)
        .factory(0)
        .about("Digital input that commands a shutdown (fault bit 28): 0 none, 1 DSI1, 2 DSI2."),
    Row::new(number::DUTY_SLEW, "Duty slew limit", Control, U16)
        .in_unit("%/ms", -2)
        .range(1, 10000)
        .factory(1000)
        .about("Fastest change of the duty."),
    Row::new(number::ON_TIME_MIN, "Minimum on-time", Control, U16)
        .in_unit("ns", 0)
        .range(0, 20000)
        .factory(2000)
        .about("Shortest pulse that still gives a valid sample. Smaller duties leave pulses out."),
    Row::new(number::TIMING_ADVANCE, "Timing advance", Control, U16)
        .in_unit("deg", -2)
        .range(0, 3000)
        .factory(0)
        .about("Commutation ahead of its place, electrical degrees."),
    Row::new(number::REFUSED_FRAMES, "Refused frames", Diagnostics, U32)
        .range(0, u32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Well-formed frames of the master that were not accepted, since power-up."),
    Row::new(number::MALFORMED_FRAMES, "Malformed frames", Diagnostics, U32)
        .range(0, u32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Frames with an address or shape that no message has, since power-up."),
    Row::new(number::START_REFUSAL, "Start refusal", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about(
            "Reason why the last start was refused: 0 not refused, 1 no mode enabled, 2 parameters do not fit \
             together, 3 reserved, 4 Standby was not requested since the last stop.",
        ),
    Row::new(number::HALL_INVALID, "Hall invalid codes", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Changes from a valid code to 000 or 111 since power-up, saturating; 0 without sensors."),
    Row::new(number::HALL_JUMPS, "Hall jumps", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Changes between sectors that are not neighbours since power-up, saturating."),
    Row::new(number::HALL_CALIBRATION_STATE, "Hall calibration state", Diagnostics, U16)
        .range(0, 3)
        .factory(0)
        .read_only()
        .about("0 none, 1 running, 2 done, 3 failed."),
    Row::new(number::ACTIVE_LIMITER, "Active limiter", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about(
            "Limit that bounds the duty: 0 bridge off, 1 fixed level, 2 speed loop, 3 bus current, 4 phase \
             current, 5 power, 6 temperature, 7 maximum duty, 8 slew, 9 no regeneration into the bus, 10 zero \
             crossings not seen.",
        ),
    Row::new(number::HALL_INTERPOLATION_SPEED, "Hall interpolation speed", Control, I32)
        .in_unit("rpm", 0)
        .range(0, 65535)
        .factory(100)
        .about("Mechanical speed above which the angle is interpolated between hall edges."),
    Row::new(number::EXTENDED_FAULT_CODE, "Extended fault code", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Code of the first critical fault: fault bit times 256 plus cause; 0 without one."),
    Row::new(number::WINDING_INDUCTANCE, "Winding inductance", Machine, I32)
        .in_unit("H", -6)
        .range(0, 100_000)
        .factory(0)
        .about("Between two lines; 0 unknown."),
    Row::new(number::FRAMES_LOST, "Frames lost", Diagnostics, U32)
        .range(0, u32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Frames that found no room in the output queue, since power-up."),
    Row::new(number::REJECTED_PARAMETER, "Rejected parameter", Diagnostics, U16)
        .range(0, 65535)
        .factory(65535)
        .read_only()
        .about("Number of the parameter for which the set does not build; 65535 when it builds."),
    Row::new(number::ZC_DELAY_FALLING, "ZC falling delay difference", Control, I32)
        .in_unit("ticks", -2)
        .range(-10000, 10000)
        .factory(0)
        .about("Delay of a falling zero crossing in addition to parameter 100, ticks of 100 us."),
    Row::new(number::CROSSING, "Last zero crossing", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about(
            "Outcome of the last step's zero crossing: 0 none yet, 1 accepted, 2 filtered (too early), 3 \
             blind (not seen), 4 late (hidden by demagnetisation), 5 detected while coasting.",
        ),
    Row::new(number::CROSSING_MARGIN, "Zero crossing margin", Diagnostics, I32)
        .in_unit("deg", -2)
        .range(-18000, 18000)
        .factory(0)
        .read_only()
        .about("Lag of the last accepted zero crossing behind its prediction, electrical degrees."),
    Row::new(number::CROSSINGS, "Zero crossings", Diagnostics, U32)
        .range(0, u32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Zero crossings accepted since power-up, wrapping."),
    Row::new(number::SCOPE_TRIGGER, "Scope trigger", Instrumentation, U16)
        .range(0, 6)
        .factory(0)
        .about(
            "Event that starts the record of an armed scope, besides a second request: 0 none, 1 signal above \
             the level, 2 below it, 3 its rising edge through the level, 4 its falling edge, 5 a change of \
             the drive's state, 6 a new bit in FAULT_WORD.",
        ),
    Row::new(number::SCOPE_TRIGGER_SIGNAL, "Scope trigger signal", Instrumentation, U16)
        .range(0, 22)
        .factory(3)
        .about("Signal that parameter 290 compares: its bit in parameter 22."),
    Row::new(number::SCOPE_TRIGGER_LEVEL, "Scope trigger level", Instrumentation, I32)
        .in_unit("-", -3)
        .range(-8000, 7999)
        .factory(0)
        .about("Level that parameter 290 compares with, in bases of the signal."),
    Row::new(number::BUS_STATE, "Bus error state", Diagnostics, U16)
        .range(0, 2)
        .factory(0)
        .read_only()
        .about(
            "Error state of the CAN controller (ISO 11898-1): 0 error active, 1 error passive, 2 bus-off.",
        ),
    Row::new(number::TRANSMIT_ERRORS, "Transmit error counter", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Counter of the CAN controller (ISO 11898-1)."),
    Row::new(number::RECEIVE_ERRORS, "Receive error counter", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Counter of the CAN controller (ISO 11898-1)."),
    Row::new(number::BUS_OFFS, "Bus-offs", Diagnostics, U32)
        .range(0, u32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Times that the CAN controller has gone bus-off since power-up."),
    Row::new(number::ACCEL_MEAS_OFFSET, "Accel meas offset", Calibration, I32)
        .in_unit("V", -3)
        .range(0, 3300)
        .factory(1800)
        .about("Zero-g level of the accelerometer while parameter 9 is 0."),
    Row::new(number::TILT, "Tilt", Diagnostics, U16)
        .in_unit("deg", -2)
        .range(0, 18000)
        .factory(0)
        .read_only()
        .about("Angle between the Z axis and the mean acceleration of the last second; exact to 0.2 degrees."),
    Row::new(number::VIBRATION, "Vibration", Diagnostics, U16)
        .in_unit("g", -3)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Root mean square over the last second of all three axes without their mean."),
    Row::new(number::SCOPE_INPUTS, "Scope inputs", Instrumentation, U16)
        .range(0, 1)
        .factory(0)
        .about(
            "Content of the scope's record: 0 the signals of parameter 22, 1 the drive's state and then the \
             inputs of every control tick, from which the run can be replayed bit for bit.",
        ),
    Row::new(number::SCOPE_WORDS, "Scope words", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Words of 16 bits of the scope's record, which can be downloaded."),
    Row::new(number::RESET_CAUSE, "Reset cause", Diagnostics, U16)
        .range(0, 6)
        .factory(0)
        .read_only()
        .about(
            "Cause of the device's last start: 0 unknown, 1 power-up, 2 reset line, 3 requested, 4 watchdog, \
             5 program error, 6 supply dip.",
        ),
    Row::new(number::FAILED_SELF_TESTS, "Failed self-tests", Diagnostics, U16)
        .range(0, 31)
        .factory(0)
        .read_only()
        .about(
            "Self-tests that have failed since power-up, each of which sets fault bit 27: bit 0 RAM, bit 1 \
             program, bit 2 clocks, bit 3 stack, bit 4 control ticks.",
        ),
    Row::new(number::DIAGNOSTICS, "Diagnostics", Diagnostics, U16)
        .range(0, 7)
        .factory(0)
        .read_only()
        .about(
            "Conditions that are not faults: bit 0 the bus is below 18 V, bit 1 the rotor may have turned \
             undetected since power-up or since parameter 17 set the mechanical position, bit 2 sensorless \
             control is enabled and a stable wrong lock would not be detected, because parameter 267 or 268 \
             is 0.",
        ),
    Row::new(number::SCOPE_ROOM, "Scope room", Diagnostics, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Words of 16 bits that the scope's memory holds, one for each sample of a signal; 0 without a memory."),
    Row::new(number::SCOPE_REFUSAL, "Scope refusal", Diagnostics, U16)
        .range(0, 7)
        .factory(0)
        .read_only()
        .about(
            "Reason why the last LOG VIRTUAL SCOPE was refused: 0 not refused, 1 no record to download, 2 a \
             recording is in progress, 3 signals times samples exceed parameter 305, 4 parameter 24 is below \
             one tick for every 4 signals, 5 parameter 26 is not below parameter 23, 6 no memory, 7 unknown \
             signal.",
        ),
    Row::new(number::AUTOMATIC_STORE, "Automatic store", Services, U16)
        .range(0, 1)
        .factory(1)
        .about(
            "1: a written parameter is stored within 2 s, together with all that parameter 256 stores; 0: \
             only parameter 256 stores. Only parameter 257 stores device number and calibration in either \
             case.",
        ),
    Row::new(number::OTHER_SOURCE, "Other rotor source", Control, U16)
        .range(0, 1)
        .factory(0)
        .about(
            "1: a closed loop whose source fails goes on by the other's (0605h, 1B07h) if both are enabled; 0: it \
             stops.",
        ),
];
