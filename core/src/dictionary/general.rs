//! General parameters, numbers 0 to 77 (Table 10).

use super::category::Category::{
    Calibration, CommonInfo, Identification, Instrumentation, LoggingControl, LoggingData,
};
use super::number;
use super::parameter::Kind::{I32, U16, U32};
use super::row::Row;

/// General parameters, numbers 0 to 77 (Table 10).
pub(super) const GENERAL: [Row; 78] = [
    Row::new(number::MEMORY_MAPPING_FLAG, "Memory Mapping Flag", CommonInfo, U16)
        .range(0, 1)
        .factory(1)
        .read_only()
        .about(
            "1 when the parameter store has the layout that this firmware expects, 0 when it has another (fault \
             bit 26).",
        ),
    Row::new(number::DEVICE_NUMBER, "Device Number", CommonInfo, U16)
        .range(0, 65535)
        .factory(1)
        .after_reboot()
        .about(
            "Serial number of the board. Kept by RESTORE_FACTORY_SETTING, which must quote it; stored by \
             parameter 257 only.",
        ),
    Row::new(number::SLAVE_CAN_ADDRESS, "Slave CAN address", CommonInfo, U16)
        .range(0, 255)
        .factory(170)
        .after_reboot()
        .about("Address of this drive: destination of what it accepts, source of what it sends."),
    Row::new(number::MASTER_CAN_ADDRESS, "Master CAN address", CommonInfo, U16)
        .range(0, 255)
        .factory(85)
        .after_reboot()
        .about("Address of the master whose frames are accepted."),
    Row::new(number::HARDWARE_RELEASE, "Hardware Release", CommonInfo, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Release of the board."),
    Row::new(number::BUILD_NUMBER, "Build number", Identification, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Build number of the firmware, as in BUILD_INFO."),
    Row::new(number::SOFTWARE_RELEASE, "Software Release", Identification, U16)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Release of the firmware: major in the high byte, minor in the low byte."),
    Row::new(number::SOURCE_MODIFIED, "Source modified", Identification, U16)
        .range(0, 1)
        .factory(0)
        .read_only()
        .about("0 when the firmware was built from committed sources, 1 when not."),
    Row::new(number::TEMPERATURE_SOURCE, "Temperature measurement source selection", Calibration, U16)
        .range(0, 1)
        .factory(0)
        .about("Sensor that the temperature faults watch: 0 on the power board, 1 external."),
    Row::new(number::ACCEL_USE_REFERENCE, "Accel use ref for scaling selection", Calibration, U16)
        .range(0, 1)
        .factory(1)
        .about("Zero-g level of the accelerometer: 1 measured 1.8 V reference, 0 parameter 297."),
    Row::new(number::ACCEL_X_OFFSET, "Accel X calib offset", Calibration, I32)
        .in_unit("g", -3)
        .range(-2000, 2000)
        .factory(0)
        .about("Added to the measured acceleration along X."),
    Row::new(number::ACCEL_Y_OFFSET, "Accel Y calib offset", Calibration, I32)
        .in_unit("g", -3)
        .range(-2000, 2000)
        .factory(0)
        .about("Added to the measured acceleration along Y."),
    Row::new(number::ACCEL_Z_OFFSET, "Accel Z calib offset", Calibration, I32)
        .in_unit("g", -3)
        .range(-2000, 2000)
        .factory(0)
        .about("Added to the measured acceleration along Z."),
    Row::new(number::HV_CURRENT_OFFSET, "HV current calib offset", Calibration, I32)
        .in_unit("A", -3)
        .range(-2000, 2000)
        .factory(0)
        .about("Added to the measured bus current."),
    Row::new(number::HV_VOLTAGE_OFFSET, "HV voltage calib offset", Calibration, I32)
        .in_unit("V", -3)
        .range(-5000, 5000)
        .factory(0)
        .about("Added to the measured bus voltage."),
    Row::new(number::TEMPERATURE_OFFSET, "Temperature calib offset", Calibration, I32)
        .in_unit("°C", -1)
        .range(-500, 500)
        .factory(0)
        .about("Added to the measured temperature."),
    Row::new(number::POSITION_CALIBRATION, "Mechanical position calibration value", Calibration, I32)
        .in_unit("deg", -2)
        .range(-i32::MAX as i64, i32::MAX as i64)
        .factory(0)
        .about("Mechanical position that the present one becomes at the rising edge of parameter 17."),
    Row::new(number::SET_POSITION, "Set position calibration value (rising edge)", Calibration, U16)
        .range(0, 1)
        .factory(0)
        .command()
        .about("Writing 0 then 1 makes the mechanical position equal to parameter 16."),
    Row::new(number::PRESSURE_CALIB_OFFSET, "Pressure calib offset", Calibration, I32)
        .in_unit("V", -3)
        .range(-10000, 10000)
        .factory(0)
        .about("Added to the pressure reading after its gain (volts at the amplified bridge)."),
    Row::new(number::PRESSURE_CALIB_GAIN, "Pressure calib gain", Calibration, I32)
        .in_unit("-", -6)
        .range(-100_000_000, 100_000_000)
        .factory(1_000_000)
        .about("Factor of the pressure reading."),
    Row::new(number::PRESSURE_MEAS_OFFSET, "Pressure meas offset", Calibration, I32)
        .in_unit("V", -3)
        .range(-10000, 10000)
        .factory(0)
        .about("Offset of the scaling from volts to the transmitted pressure."),
    Row::new(number::PRESSURE_MEAS_GAIN, "Pressure meas gain", Calibration, I32)
        .in_unit("-", -6)
        .range(-100_000_000, 100_000_000)
        .factory(1_000_000)
        .about("Gain of the scaling from volts to the transmitted pressure."),
    Row::new(number::SCOPE_CHANNELS, "Virtual Scop Channels Selection", Instrumentation, U32)
        .range(1, (1 << 23) - 1)
        .factory(7)
        .about("Signals that the scope records: one bit each. It reads 4 in a tick."),
    Row::new(number::SCOPE_SAMPLES, "Virtual Scop Samples Number", Instrumentation, U16)
        .in_unit("samples", 0)
        .range(1, 4096)
        .factory(256)
        .about("Samples that the scope records of each signal; with more than its memory has room for (parameter 305) it refuses to be armed."),
    Row::new(number::SCOPE_PRESCALER, "Virtual Scop Sampling Prescaler", Instrumentation, U16)
        .range(1, 10000)
        .factory(1)
        .about("Control ticks from one scope sample to the next; with fewer than one for every 4 signals it refuses to be armed."),
    Row::new(number::SCOPE_SAMPLING_TIME, "Virtual Scop Sampling Time", Instrumentation, U32)
        .in_unit("s", -6)
        .range(0, u32::MAX as i64)
        .factory(100)
        .read_only()
        .about("Time from one scope sample to the next."),
    Row::new(number::SCOPE_TRIGGER_PHASE, "Virtual Scop Trig phase", Instrumentation, U16)
        .in_unit("samples", 0)
        .range(0, 4096)
        .factory(0)
        .about("Samples kept from before the trigger, fewer than parameter 23."),
    Row::new(number::LOGGING_START, "01 - Logging start index", LoggingData, U16)
        .range(0, 65535)
        .factory(43605)
        .read_only()
        .about("Marker that begins each log record."),
    Row::new(number::LOGGING_PACKAGE, "02 - Logging package index", LoggingData, U32)
        .range(0, u32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Number of the last log record, one more at each write."),
    slot(29, "03 - Logging slot"),
    slot(30, "04 - Logging slot"),
    slot(31, "05 - Logging slot"),
    slot(32, "06 - Logging slot"),
    slot(33, "07 - Logging slot"),
    slot(34, "08 - Logging slot"),
    slot(35, "09 - Logging slot"),
    slot(36, "10 - Logging slot"),
    slot(37, "11 - Logging slot"),
    slot(38, "12 - Logging slot"),
    slot(39, "13 - Logging slot"),
    slot(40, "14 - Logging slot"),
    slot(41, "15 - Logging slot"),
    slot(42, "16 - Logging slot"),
    slot(43, "17 - Logging slot"),
    slot(44, "18 - Logging slot"),
    slot(45, "19 - Logging slot"),
    slot(46, "20 - Logging slot"),
    slot(47, "21 - Logging slot"),
    slot(48, "22 - Logging slot"),
    slot(49, "23 - Logging slot"),
    slot(50, "24 - Logging slot"),
    slot(51, "25 - Logging slot"),
    slot(52, "26 - Logging slot"),
    slot(53, "27 - Logging slot"),
    slot(54, "28 - Logging slot"),
    slot(55, "29 - Logging slot"),
    slot(56, "30 - Logging slot"),
    slot(57, "31 - Logging slot"),
    slot(58, "32 - Logging slot"),
    slot(59, "33 - Logging slot"),
    slot(60, "34 - Logging slot"),
    slot(61, "35 - Logging slot"),
    slot(62, "36 - Logging slot"),
    slot(63, "37 - Logging slot"),
    slot(64, "38 - Logging slot"),
    slot(65, "39 - Logging slot"),
    Row::new(number::LOGGING_END, "40 - Logging end index", LoggingData, U16)
        .range(0, 65535)
        .factory(21930)
        .read_only()
        .about("Marker that ends each log record."),
    Row::new(number::LOG_READ_START, "Logging read start index", LoggingControl, U32)
        .range(0, i32::MAX as i64)
        .factory(0)
        .about("First record that a log download sends."),
    Row::new(number::LOG_READ_COUNT, "Logging read number of indexes", LoggingControl, U32)
        .range(0, i32::MAX as i64)
        .factory(1)
        .about("Records that a log download sends."),
    Row::new(number::LOG_RECORD_BYTES, "Logging data size bytes", LoggingControl, U16)
        .in_unit("bytes", 0)
        .range(0, 65535)
        .factory(0)
        .read_only()
        .about("Size of one log record with the present slots."),
    Row::new(number::LOG_INDEX_MAX, "Logging data max index", LoggingControl, U32)
        .range(0, i32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Records that the log memory holds; 0 without log memory."),
    Row::new(number::LOG_WRITE_INDEX, "Logging data write index", LoggingControl, U32)
        .range(0, i32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Index that the next log record gets."),
    Row::new(number::LOG_PERIOD, "Logging period", LoggingControl, U32)
        .in_unit("ms", 0)
        .range(1, 3_600_000)
        .factory(1000)
        .about("Time from one log record to the next."),
    Row::new(number::LOG_SUBSECTORS, "Logging data subsectors number", LoggingControl, U32)
        .range(0, i32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Flash subsectors given to the log."),
    Row::new(number::LOG_ERASE_SUBSECTOR, "Logging data ongoing subsector erase index", LoggingControl, U32)
        .range(0, i32::MAX as i64)
        .factory(0)
        .read_only()
        .about("Subsector that an erase has reached."),
    Row::new(number::LOG_READ_REQUEST, "Logging read request", LoggingControl, U16)
        .range(0, 1)
        .factory(0)
        .command()
        .about("Writing 0 then 1 starts a log download."),
    Row::new(number::LOG_ERASE_REQUEST, "Logging erase request", LoggingControl, U16)
        .range(0, 1)
        .factory(0)
        .command()
        .about("Writing 0 then 1 erases the log; refused while driving."),
    Row::new(number::LOG_MEMORY_FULL, "Logging memory full flag", LoggingControl, U16)
        .range(0, 1)
        .factory(0)
        .read_only()
        .about("1 when the log memory is full."),
];

/// One of the 37 values of a log record: bits 15:0 the number of a parameter (65535: nothing), bits 17:16
/// which value of it since the record before: 0 live, 1 smallest, 2 largest, 3 mean.
const fn slot(number: u16, name: &'static str) -> Row {
    Row::new(number, name, LoggingData, U32).range(0, 0x3_FFFF).factory(0xFFFF).about(
        "Logged value: bits 15:0 parameter number (65535 nothing), bits 17:16 live 0, smallest 1, largest 2, mean 3.",
    )
}
