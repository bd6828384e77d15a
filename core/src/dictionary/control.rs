//! Control parameters, numbers 78 to 121 (Table 11).

use super::category::Category::{CommandSaturation, Control, Limitation, Machine, Timing};
use super::number;
use super::parameter::Kind::{I32, U16, U32};
use super::row::Row;

/// Control parameters, numbers 78 to 121 (Table 11).
pub(super) const CONTROL: [Row; 44] = [
    Row::new(number::MOTOR_POLE_PAIRS, "Motor pair poles", Machine, U16)
        .range(1, 50)
        .factory(4)
        .about("Pole pairs of the motor: electrical over mechanical speed."),
    Row::new(number::STANDARD_HALL_SEQUENCE, "Select control sequence for standard motor", Machine, U16)
        .range(0, 1)
        .factory(1)
        .about(
            "1: the hall sensors have the positions of a standard motor; 0: parameter 80 is their offset.",
        ),
    Row::new(number::HALL_OFFSET_ANGLE, "Hall effect offset angle", Machine, I32)
        .in_unit("deg", -2)
        .range(-18000, 18000)
        .factory(0)
        .about(
            "Offset of the hall edges from their nominal position, electrical degrees; used when parameter 79 \
             is 0.",
        ),
    Row::new(number::OPEN_LOOP_ENABLE, "Open-loop enable", Control, U16)
        .range(0, 1)
        .factory(0)
        .at_next_start()
        .about(
            "Enables open loop (Table 6). All three enables are 0 until a motor is commissioned: such a drive \
             stays in Standby.",
        ),
    Row::new(number::SENSORLESS_ENABLE, "Closed-loop Sensorless enable", Control, U16)
        .range(0, 1)
        .factory(0)
        .at_next_start()
        .about("Enables sensorless closed loop, which starts through open loop (Table 6)."),
    Row::new(number::HALL_ENABLE, "Closed-loop Hall Effect Sensors enable", Control, U16)
        .range(0, 1)
        .factory(0)
        .at_next_start()
        .about("Enables hall closed loop; it has priority over the other two (Table 6)."),
    Row::new(number::INITIAL_DUTY, "Closed-Loop initial duty cycle", Control, U16)
        .in_unit("%", -2)
        .range(0, 10000)
        .factory(0)
        .about(
            "First duty in state 5, and in state 4 when not 0; 0 takes over the duty applied before. Per cent \
             of the bus voltage, or of the nominal supply voltage where parameter 266 gives one.",
        ),
    Row::new(number::ZC_PERIOD_MAX, "Max period between two ZC events", Control, U16)
        .in_unit("ticks", 0)
        .range(10, 32767)
        .factory(500)
        .about("Time without an accepted zero crossing after which the sensorless speed counts as 0, ticks of 100 us."),
    Row::new(number::ZC_DISCARD, "N periods to discard after a sector change", Control, U16)
        .in_unit("ticks", 0)
        .range(0, 100)
        .factory(2)
        .about("Least blanking of the zero-crossing detection after a commutation, ticks of 100 us."),
    Row::new(number::OPEN_LOOP_DUTY, "Open-Loop duty cycle", Control, U16)
        .in_unit("%", -2)
        .range(0, 10000)
        .factory(400)
        .about(
            "Duty applied in open loop: per cent of the bus voltage, or of the nominal supply voltage where \
             parameter 266 gives one.",
        ),
    Row::new(number::OPEN_LOOP_SPEED, "Open-loop speed setpoint", Control, I32)
        .in_unit("rpm", 0)
        .range(0, 65535)
        .factory(500)
        .about(
            "Mechanical speed that open loop ramps to within parameter 109, and at which it hands over to sensorless closed \
             loop.",
        ),
    Row::new(number::LOCK_DUTY, "Rotor lock duty cycle", Control, U16)
        .in_unit("%", -2)
        .range(0, 10000)
        .factory(400)
        .about(
            "Duty applied in rotor lock: per cent of the bus voltage, or of the nominal supply voltage where \
             parameter 266 gives one.",
        ),
    Row::new(number::SPEED_KI_SL, "Speed Ki coefficient SL", Control, I32)
        .in_unit("V/rad", -6)
        .range(0, i32::MAX as i64)
        .factory(1_800_000)
        .about("Integral gain of the sensorless speed loop, on mechanical rad/s."),
    Row::new(number::SPEED_KP_SL, "Speed Kp coefficient SL", Control, I32)
        .in_unit("V.s/rad", -6)
        .range(0, i32::MAX as i64)
        .factory(2400)
        .about("Proportional gain of the sensorless speed loop, on mechanical rad/s."),
    Row::new(number::SPEED_KI_HES, "Speed Ki coefficient HES", Control, I32)
        .in_unit("V/(rpm.s)", -9)
        .range(0, i32::MAX as i64)
        .factory(188_000_000)
        .about(
            "Integral gain of the hall speed loop, on mechanical rpm. Table 11 prints V/rpm; the dimension needs \
             the second.",
        ),
    Row::new(number::SPEED_KP_HES, "Speed Kp coefficient HES", Control, I32)
        .in_unit("V/rpm", -9)
        .range(0, i32::MAX as i64)
        .factory(250_000)
        .about("Proportional gain of the hall speed loop, on mechanical rpm. Table 11 prints V.s/rpm."),
    Row::new(number::HV_CURRENT_KP, "HV current Kp coefficient", Control, I32)
        .in_unit("V/A", -6)
        .range(0, i32::MAX as i64)
        .factory(100_000)
        .about("Proportional gain of the bus current limiter."),
    Row::new(number::HV_CURRENT_KI, "HV current Ki coefficient", Control, I32)
        .in_unit("V/(A.s)", -3)
        .range(0, i32::MAX as i64)
        .factory(180_000)
        .about("Integral gain of the bus current limiter. Table 11 prints V.s/A."),
    Row::new(number::HV_CURRENT_RATE, "Max HV current setpoint rate", Control, I32)
        .in_unit("A/s", -3)
        .range(100, 10_000_000)
        .factory(60000)
        .about("Rate at which the bus current limit moves from its soft-start value to its final one."),
    Row::new(number::HALL_SUPPLY_ENABLE, "Hall Effect Sensors PS enable", Control, U16)
        .range(0, 1)
        .factory(1)
        .about("Supplies the hall sensors; Disable_Hall_PS wins over it."),
    Row::new(number::DUTY_MAX_SL, "Max duty cycle SL", Control, U16)
        .in_unit("%", -2)
        .range(0, 10000)
        .factory(9500)
        .about("Largest duty in every state but hall closed loop: without sensors, in open loop and in rotor lock."),
    Row::new(number::SPEED_RATE, "Speed setpoint rate", Control, I32)
        .in_unit("rpm/s", 0)
        .range(1, 10_000_000)
        .factory(2000)
        .about("Ramp of the speed set-point in closed loop."),
    Row::new(number::ZC_DELAY, "ZC delay compensation", Control, U16)
        .in_unit("ticks", -2)
        .range(0, 10000)
        .factory(0)
        .about("Delay of the zero-crossing comparator, taken off the wait from crossing to commutation, ticks of 100 us."),
    Row::new(number::SPEED_MAX_SL, "Speed setpoint max saturation SL", CommandSaturation, I32)
        .in_unit("rpm", 0)
        .range(0, 65535)
        .factory(4000)
        .about(
            "Largest speed set-point in sensorless closed loop. A value of 4000 means 4000 rpm x 4 / \
             parameter 78.",
        ),
    Row::new(number::SPEED_MIN_SL, "Speed setpoint min saturation SL", CommandSaturation, I32)
        .in_unit("rpm", 0)
        .range(0, 65535)
        .factory(500)
        .about(
            "Smallest speed set-point in sensorless closed loop. A value of 500 means 500 rpm x 4 / parameter \
             78.",
        ),
    Row::new(number::SPEED_MAX_HES, "Speed setpoint max saturation HES", CommandSaturation, I32)
        .in_unit("rpm", 0)
        .range(0, 65535)
        .factory(4000)
        .about(
            "Largest speed set-point in hall closed loop. A value of 4000 means 4000 rpm x 4 / parameter 78.",
        ),
    Row::new(number::SPEED_MIN_HES, "Speed setpoint min saturation HES", CommandSaturation, I32)
        .in_unit("rpm", 0)
        .range(0, 65535)
        .factory(500)
        .about(
            "Smallest speed set-point in hall closed loop. A value of 500 means 500 rpm x 4 / parameter 78.",
        ),
    Row::new(number::HV_CURRENT_SOFT_START, "Max HV current limitation soft start", CommandSaturation, U16)
        .in_unit("A", -3)
        .range(0, 7000)
        .factory(3000)
        .about("Bus current limit at the beginning of a start."),
    Row::new(number::HV_CURRENT_MAX, "Max HV current limitation", CommandSaturation, U16)
        .in_unit("A", -3)
        .range(0, 7000)
        .factory(6000)
        .about("Bus current limit once the soft start is over."),
    Row::new(number::DUTY_MAX, "Max duty cycle", CommandSaturation, U16)
        .in_unit("%", -2)
        .range(0, 10000)
        .factory(9500)
        .about("Largest duty in hall closed loop."),
    Row::new(number::OPEN_LOOP_DURATION, "Open-Loop phase duration", Timing, U16)
        .in_unit("s", -3)
        .range(0, 60000)
        .factory(500)
        .about("Length of the open-loop state before sensorless closed loop (T34)."),
    Row::new(number::OPEN_LOOP_RAMP, "Open-Loop ramp rising time", Timing, U16)
        .in_unit("s", -3)
        .range(0, 60000)
        .factory(400)
        .about("Time in which open loop ramps from standstill to its speed."),
    Row::new(number::LOCK_DURATION, "Rotor lock phase duration", Timing, U16)
        .in_unit("s", -3)
        .range(0, 60000)
        .factory(150)
        .about("Length of rotor lock before open loop (T23)."),
    Row::new(number::AUTOSEND_PERIOD, "can_autosend_period", Timing, U16)
        .in_unit("ms", 0)
        .range(1, 60000)
        .factory(50)
        .about(
            "Period of the broadcast frames; a shorter one than 30 % of the bus allows acts as the shortest \
             allowed.",
        ),
    Row::new(number::FAULT_WAIT, "Fault state wait time before acknowledgement", Timing, U16)
        .in_unit("ms", 0)
        .range(0, 60000)
        .factory(500)
        .about("Least time in Fault before a Standby request acknowledges (T61)."),
    Row::new(number::HALL_PERIOD_TIMEOUT, "Electrical period measurement time-out", Limitation, U16)
        .in_unit("s", -3)
        .range(1, 6000)
        .factory(100)
        .about("Time without a hall edge after which the hall speed counts as 0."),
    Row::new(number::CAN_TIMEOUT, "Can TimeOut period", Limitation, U16)
        .in_unit("ms", 0)
        .range(1, 60000)
        .factory(250)
        .about(
            "Time without a valid REQUEST_WORD or MOTOR_CMD after which the master counts as silent: fault bit 29 \
             while driving.",
        ),
    Row::new(number::CRITICAL_FAULT_MASK, "Critical fault mask", Limitation, U32)
        .range(0, u32::MAX as i64)
        .factory(0xFC00_007E)
        .about(
            "Bit set: that bit of the fault word (Table 9) is critical. Bit 0 never is; bits 2 to 5, 27 and 29 \
             to 31 always are while driving.",
        ),
    Row::new(number::OVER_CURRENT, "Over-current HV threshold", Limitation, U16)
        .in_unit("A", -3)
        .range(100, 7000)
        .factory(7000)
        .about("Bus current of fault bit 4."),
    Row::new(number::OVER_PRESSURE, "Over-pressure threshold", Limitation, I32)
        .in_unit("V", -3)
        .range(-10000, 10000)
        .factory(3300)
        .about("Pressure reading of fault bit 7, after calibration."),
    Row::new(number::OVER_TEMPERATURE, "Over-temperature shutdown threshold", Limitation, I32)
        .in_unit("°C", -1)
        .range(0, 2000)
        .factory(1900)
        .about("Temperature of fault bit 1."),
    Row::new(number::OVER_VOLTAGE, "Over-voltage HV threshold", Limitation, U16)
        .in_unit("V", -3)
        .range(18000, 62000)
        .factory(61000)
        .about("Bus voltage of fault bit 2; clears 0.5 V below."),
    Row::new(number::UNDER_VOLTAGE, "Under-voltage HV threshold", Limitation, U16)
        .in_unit("V", -3)
        .range(8000, 60000)
        .factory(16000)
        .about("Bus voltage of fault bit 3."),
    Row::new(number::TEMPERATURE_WARNING, "Over-temperature warning threshold", Limitation, I32)
        .in_unit("°C", -1)
        .range(0, 2000)
        .factory(1850)
        .about("Temperature of fault bit 0 (a warning), from which the current limit is derated."),
];
