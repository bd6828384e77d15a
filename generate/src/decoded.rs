//! Raw values that core's decoders read in a frame, by name. They are written field by field, so that tables
//! of fields, and everything made from these, can be checked against them.

use narx_core::bus::Frame;
use narx_core::bus::narmotion::update::{ImageVersion, UpdateAnswer, UpdateRequest, UpdateStatus};
use narx_core::bus::narmotion::{
    Addresses, DecodeError, DigitalOutputs, Field, FromDrive, Meaning, Measurement, Message, MessageKind,
    StatusWord, ToDrive, Words,
};
use narx_core::dictionary::Dictionary;

/// Name and raw value of a field.
pub type Value = (&'static str, i64);

/// Decodes a frame of this message with the decoder of its direction; returns the fields with their raw
/// values.
///
/// # Errors
/// Fails with the decoder's error.
pub fn values(message: &Message, frame: &Frame) -> Result<Vec<Value>, DecodeError> {
    Ok(match message.kind {
        MessageKind::SlaveTx => from_drive(FromDrive::decode(frame)?.1),
        MessageKind::DataSet | MessageKind::DataRequest => to_drive(ToDrive::decode(frame)?.1),
    })
}

/// Frame of this message with a random value in every field, within the range that the field allows.
pub fn random_frame(message: &Message, random: &mut impl FnMut() -> u64) -> Frame {
    let row = Dictionary::rows().nth(random() as usize % Dictionary::rows().count());
    let mut bits = 0_u64;
    for field in message.fields() {
        let raw = match (field.meaning, row) {
            (Meaning::Named(names), _) => names.values[random() as usize % names.values.len()].0.into(),
            (Meaning::ParameterNumber, Some(row)) => row.number.into(),
            (Meaning::ParameterValue, Some(row)) => {
                row.min().wrapping_add((random() % (row.max() - row.min() + 1) as u64) as i64) as u64
            }
            _ => random(),
        };
        bits |= place(&field, raw);
    }
    let words = [48, 32, 16, 0].map(|shift| (bits >> shift) as u16);
    Words(words).frame(message.id(Addresses::FACTORY))
}

/// Places the bits of a field in the 64 of a frame.
fn place(field: &Field, raw: u64) -> u64 {
    let mask = (1 << field.bits) - 1;
    (raw & mask) << (64 - field.first_bit - field.bits)
}

fn to_drive(message: ToDrive) -> Vec<Value> {
    match message {
        ToDrive::RequestWord(word) => vec![("Motor mode", word.mode as i64)],
        ToDrive::MotorCommand { speed } => vec![("Speed", speed.into())],
        ToDrive::DigitalOutputs(DigitalOutputs { enable1, value1, enable2, value2 }) => vec![
            ("DSIO1 output enable", enable1.into()),
            ("DSIO1 level", value1.into()),
            ("DSIO2 output enable", enable2.into()),
            ("DSIO2 level", value2.into()),
        ],
        ToDrive::DisableHallSupply(disable) => vec![("Disable", disable.into())],
        ToDrive::SetParameter { number, value } => vec![("Number", number.into()), ("Value", value.into())],
        ToDrive::RequestParameter { number } => vec![("Number", number.into())],
        ToDrive::RestoreFactory { serial } => vec![("Serial number", serial.into())],
        ToDrive::DownloadXml(command) => vec![("Command", command as i64)],
        ToDrive::RequestBuildInfo
        | ToDrive::RequestDeviceInfo
        | ToDrive::Reboot
        | ToDrive::TriggerScope
        | ToDrive::DownloadScope => vec![],
        ToDrive::Update(request) => update_request(request),
    }
}

fn update_request(request: UpdateRequest) -> Vec<Value> {
    match request {
        UpdateRequest::Begin { length, hardware } => {
            vec![("Length", length.into()), ("Hardware id", hardware.into())]
        }
        UpdateRequest::Data { block, data: [a, b, c, d, e, f] } => {
            let word = |bytes| u16::from_be_bytes(bytes).into();
            vec![
                ("Block", block.into()),
                ("Image 1", word([a, b])),
                ("Image 2", word([c, d])),
                ("Image 3", word([e, f])),
            ]
        }
        UpdateRequest::End { crc } => vec![("Checksum", crc.into())],
        UpdateRequest::Device
        | UpdateRequest::Version
        | UpdateRequest::Status
        | UpdateRequest::Abort
        | UpdateRequest::Confirm => vec![],
    }
}

fn update_answer(answer: UpdateAnswer) -> Vec<Value> {
    match answer {
        UpdateAnswer::Device { hardware, room } => {
            vec![("Hardware id", hardware.into()), ("Room", room.into())]
        }
        UpdateAnswer::Version(ImageVersion { major, minor, patch, build }) => vec![
            ("Major version", major.into()),
            ("Minor version", minor.into()),
            ("Patch level", patch.into()),
            ("Build number", build.into()),
        ],
        UpdateAnswer::Status(UpdateStatus { state, code, window, offset }) => vec![
            ("State", state as i64),
            ("Code", code as i64),
            ("Window", window.into()),
            ("Offset", offset.into()),
        ],
    }
}

fn from_drive(message: FromDrive) -> Vec<Value> {
    match message {
        FromDrive::BuildInfo { number, modified, date } => vec![
            ("Build number", number.into()),
            ("Source modified", modified.into()),
            ("Build date", date.into()),
        ],
        FromDrive::DeviceInfo { hardware, software, device_number, address } => vec![
            ("Hardware release", hardware.into()),
            ("Software release", software.into()),
            ("Device number", device_number.into()),
            ("CAN address", address.into()),
        ],
        FromDrive::Status(StatusWord {
            mode,
            control,
            logging,
            memory_full,
            memory_erased,
            read_enable,
            erase_enable,
        }) => vec![
            ("Log erase possible", erase_enable.into()),
            ("Log download possible", read_enable.into()),
            ("Log memory erased", memory_erased.into()),
            ("Log memory full", memory_full.into()),
            ("Logging state", logging.into()),
            ("Control mode", control as i64),
            ("Motor mode", mode as i64),
        ],
        FromDrive::Faults(faults) => vec![("Faults", faults.bits().into())],
        FromDrive::CriticalFault { faults, code } => {
            vec![("Faults", faults.bits().into()), ("Extended fault code", code.into())]
        }
        // Any value but 1 is not an acknowledgement.
        FromDrive::Reboot => vec![("Acknowledged", 1)],
        FromDrive::MotorCommand { speed } => vec![("Speed", speed.into())],
        FromDrive::Parameter { number, value, status } => {
            vec![("Number", number.into()), ("Value", value.into()), ("Status", status as i64)]
        }
        FromDrive::XmlLength { words, check } => vec![("Length", words.into()), ("CRC-32", check.into())],
        FromDrive::ScopeData { address, data } => {
            let [a, b, c] = data.map(|sample| i64::from(sample as i16));
            vec![("Address", address.into()), ("Sample 1", a), ("Sample 2", b), ("Sample 3", c)]
        }
        FromDrive::XmlData { address, data } => {
            let [a, b, c] = data.map(i64::from);
            vec![("Address", address.into()), ("Text 1", a), ("Text 2", b), ("Text 3", c)]
        }
        FromDrive::LogData { counter, data } => {
            let [a, b, c] = data.map(i64::from);
            vec![("Word counter", counter.into()), ("Data 1", a), ("Data 2", b), ("Data 3", c)]
        }
        FromDrive::Update(answer) => update_answer(answer),
        FromDrive::Measurement(measurement) => measured(measurement),
    }
}

fn measured(measurement: Measurement) -> Vec<Value> {
    match measurement {
        Measurement::M0 { accel: [x, y, z], dsi1 } => vec![
            ("Accel X", x.into()),
            ("Accel Y", y.into()),
            ("Accel Z", z.into()),
            ("DSI1_DSP", dsi1.into()),
        ],
        Measurement::M1 { speed_sensorless, position, power } => vec![
            ("Mechanical estimated speed SL", speed_sensorless.into()),
            ("Mechanical position", position.into()),
            ("Electrical input Power", power.into()),
        ],
        Measurement::M2 { bus_voltage, bus_current, rail_6v, rail_14v } => vec![
            ("HV Voltage", bus_voltage.into()),
            ("HV Current", bus_current.into()),
            ("+6V_MEAS", rail_6v.into()),
            ("Driver 14V Voltage", rail_14v.into()),
        ],
        Measurement::M3 { temperature, accel_reference, reference, asi } => vec![
            ("Ambient Temperature", temperature.into()),
            ("Vref Accel (+1.8V)", accel_reference.into()),
            ("+0.383VREF", reference.into()),
            ("ASI_DSP", asi.into()),
        ],
        Measurement::M4 { phase_voltage: [a, b, c], pressure } => vec![
            ("VoltagePhaseA", a.into()),
            ("VoltagePhaseB", b.into()),
            ("VoltagePhaseC", c.into()),
            ("PIN_MEAS", pressure.into()),
        ],
        Measurement::M5 { speed_hall, dsi2 } => {
            vec![("Mechanical estimated speed HES", speed_hall.into()), ("DSI2_DSP", dsi2.into())]
        }
        Measurement::M7(_) | Measurement::M8(_) => vec![],
    }
}
