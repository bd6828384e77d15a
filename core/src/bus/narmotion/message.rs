//! Every message with its fields. Documents, data base files and the drive's description are made from this
//! table. Encoders and decoders are written separately; `tests/protocol/messages.rs` checks that both use the
//! same bits.

use super::id::MessageKind::{DataRequest, DataSet, SlaveTx};
use super::id::{Addresses, MessageId, MessageKind, Opcode};
use super::signal::{SIGNALS, Signal};
use super::words::{DecodeError, Words};

/// One row of Figure 14, the request of REBOOT, or a message of programming, which is ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message {
    /// Name as printed.
    pub name: &'static str,
    /// The opcode.
    pub opcode: Opcode,
    /// Type, and with it the direction.
    pub kind: MessageKind,
    /// Fields besides measurements, which stand in [`SIGNALS`].
    own: &'static [Field],
}

/// A part of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name of the field.
    pub name: &'static str,
    /// Place of its first and highest bit: 0 is the highest bit of word 0, 63 the lowest of word 3.
    pub first_bit: u8,
    /// Length in bits, 1..=48.
    pub bits: u8,
    /// Two's complement, or else unsigned.
    pub signed: bool,
    /// Unit of the scaled value; "-" without one.
    pub unit: &'static str,
    /// Value = raw * 10^exponent.
    pub exponent: i8,
    /// Meaning of the number.
    pub meaning: Meaning,
}

/// Meaning of a field's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// A quantity or a plain number.
    Number,
    /// One of a few values with names.
    Named(&'static Names),
    /// Bits of the fault word (Table 9).
    Faults,
    /// A parameter's number.
    ParameterNumber,
    /// A parameter's raw value: the dictionary's row says type, unit and scale.
    ParameterValue,
}

/// Values with names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Names {
    /// Quantity that has these values.
    pub of: &'static str,
    /// Value and name; other values are not used.
    pub values: &'static [(u16, &'static str)],
}

/// Every set of names that a field has.
pub const NAMES: [&Names; if cfg!(feature = "update") { 9 } else { 7 }] = [
    &FLAG,
    &LEVEL,
    &MOTOR_MODE,
    &CONTROL_MODE,
    &LOGGING_STATE,
    &PARAMETER_STATUS,
    &DOWNLOAD_COMMAND,
    #[cfg(feature = "update")]
    &UPDATE_STATE,
    #[cfg(feature = "update")]
    &UPDATE_CODE,
];

/// Every message in the order of the opcodes.
pub static MESSAGES: [Message; if cfg!(feature = "update") { 44 } else { 33 }] = [
    message("BUILD_INFO", Opcode::BUILD_INFO, DataRequest, &[]),
    message(
        "BUILD_INFO",
        Opcode::BUILD_INFO,
        SlaveTx,
        &[word("Build number", 0), named("Source modified", 16, 16, &FLAG), long("Build date", 32)],
    ),
    message("DEVICE_INFO", Opcode::DEVICE_INFO, DataRequest, &[]),
    message(
        "DEVICE_INFO",
        Opcode::DEVICE_INFO,
        SlaveTx,
        &[
            word("Hardware release", 0),
            word("Software release", 16),
            word("Device number", 32),
            word("CAN address", 48),
        ],
    ),
    message("REQUEST_WORD", Opcode::REQUEST_WORD, DataSet, &[named("Motor mode", 28, 4, &MOTOR_MODE)]),
    message(
        "STATUS_WORD",
        Opcode::STATUS_WORD,
        SlaveTx,
        &[
            named("Log erase possible", 7, 1, &FLAG),
            named("Log download possible", 8, 1, &FLAG),
            named("Log memory erased", 9, 1, &FLAG),
            named("Log memory full", 10, 1, &FLAG),
            named("Logging state", 11, 5, &LOGGING_STATE),
            named("Control mode", 20, 4, &CONTROL_MODE),
            named("Motor mode", 28, 4, &MOTOR_MODE),
        ],
    ),
    message("FAULT_WORD", Opcode::FAULT_WORD, SlaveTx, &[FAULTS]),
    message("CRITICAL_FAULT", Opcode::CRITICAL_FAULT, SlaveTx, &[FAULTS, word("Extended fault code", 32)]),
    message("REBOOT", Opcode::REBOOT, DataSet, &[]),
    message("REBOOT", Opcode::REBOOT, SlaveTx, &[named("Acknowledged", 0, 16, &FLAG)]),
    message("MOTOR_CMD", Opcode::MOTOR_CMD, DataSet, &[SPEED]),
    message("MOTOR_CMD", Opcode::MOTOR_CMD, SlaveTx, &[SPEED]),
    message(
        "DSIO_DATA_CMD",
        Opcode::DSIO_DATA_CMD,
        DataSet,
        &[
            named("DSIO1 output enable", 0, 16, &FLAG),
            named("DSIO1 level", 16, 16, &LEVEL),
            named("DSIO2 output enable", 32, 16, &FLAG),
            named("DSIO2 level", 48, 16, &LEVEL),
        ],
    ),
    message("Disable_Hall_PS", Opcode::DISABLE_HALL_PS, DataSet, &[named("Disable", 0, 16, &FLAG)]),
    message("PARAMETER", Opcode::PARAMETER, DataSet, &[NUMBER, VALUE]),
    message("PARAMETER", Opcode::PARAMETER, DataRequest, &[NUMBER]),
    message(
        "PARAMETER",
        Opcode::PARAMETER,
        SlaveTx,
        &[NUMBER, VALUE, named("Status", 48, 16, &PARAMETER_STATUS)],
    ),
    message("LOG VIRTUAL SCOPE", Opcode::LOG_VIRTUAL_SCOPE, DataSet, &[]),
    message("LOG VIRTUAL SCOPE", Opcode::LOG_VIRTUAL_SCOPE, DataRequest, &[]),
    message(
        "LOG VIRTUAL SCOPE",
        Opcode::LOG_VIRTUAL_SCOPE,
        SlaveTx,
        &[word("Address", 0), sample("Sample 1", 16), sample("Sample 2", 32), sample("Sample 3", 48)],
    ),
    message("RESTORE_FACTORY_SETTING", Opcode::RESTORE_FACTORY_SETTING, DataSet, &[word("Serial number", 0)]),
    message(
        "XML_DOWNLOAD_REQUEST",
        Opcode::XML_DOWNLOAD_REQUEST,
        DataRequest,
        &[named("Command", 0, 16, &DOWNLOAD_COMMAND)],
    ),
    message(
        "XML_DOWNLOAD_ANSWER",
        Opcode::XML_DOWNLOAD_REQUEST,
        SlaveTx,
        &[Field { unit: "words", ..word("Length", 0) }, long("CRC-32", 32)],
    ),
    message(
        "XML_DOWNLOAD_DATA",
        Opcode::XML_DOWNLOAD_DATA,
        SlaveTx,
        &[word("Address", 0), word("Text 1", 16), word("Text 2", 32), word("Text 3", 48)],
    ),
    message(
        "EXT_MEM_LOG_READ_DATA",
        Opcode::EXT_MEM_LOG_READ_DATA,
        SlaveTx,
        &[word("Word counter", 0), word("Data 1", 16), word("Data 2", 32), word("Data 3", 48)],
    ),
    #[cfg(feature = "update")]
    message("UPDATE_DEVICE", Opcode::UPDATE_DEVICE, DataRequest, &[]),
    #[cfg(feature = "update")]
    message(
        "UPDATE_DEVICE",
        Opcode::UPDATE_DEVICE,
        SlaveTx,
        &[long("Hardware id", 0), Field { unit: "bytes", ..long("Room", 32) }],
    ),
    #[cfg(feature = "update")]
    message("UPDATE_VERSION", Opcode::UPDATE_VERSION, DataRequest, &[]),
    #[cfg(feature = "update")]
    message(
        "UPDATE_VERSION",
        Opcode::UPDATE_VERSION,
        SlaveTx,
        &[
            byte("Major version", 0),
            byte("Minor version", 8),
            word("Patch level", 16),
            word("Build number", 32),
        ],
    ),
    #[cfg(feature = "update")]
    message(
        "UPDATE_BEGIN",
        Opcode::UPDATE_BEGIN,
        DataSet,
        &[Field { unit: "bytes", ..long("Length", 0) }, long("Hardware id", 32)],
    ),
    #[cfg(feature = "update")]
    message(
        "UPDATE_DATA",
        Opcode::UPDATE_DATA,
        DataSet,
        &[word("Block", 0), word("Image 1", 16), word("Image 2", 32), word("Image 3", 48)],
    ),
    #[cfg(feature = "update")]
    message("UPDATE_STATUS", Opcode::UPDATE_STATUS, DataRequest, &[]),
    #[cfg(feature = "update")]
    message(
        "UPDATE_STATUS",
        Opcode::UPDATE_STATUS,
        SlaveTx,
        &[
            named("State", 0, 8, &UPDATE_STATE),
            named("Code", 8, 8, &UPDATE_CODE),
            Field { unit: "blocks", ..word("Window", 16) },
            Field { unit: "bytes", ..long("Offset", 32) },
        ],
    ),
    #[cfg(feature = "update")]
    message("UPDATE_END", Opcode::UPDATE_END, DataSet, &[long("Checksum", 0)]),
    #[cfg(feature = "update")]
    message("UPDATE_ABORT", Opcode::UPDATE_ABORT, DataSet, &[]),
    #[cfg(feature = "update")]
    message("UPDATE_CONFIRM", Opcode::UPDATE_CONFIRM, DataSet, &[]),
    measurement("MEASUREMENT_0", 0),
    measurement("MEASUREMENT_1", 1),
    measurement("MEASUREMENT_2", 2),
    measurement("MEASUREMENT_3", 3),
    measurement("MEASUREMENT_4", 4),
    measurement("MEASUREMENT_5", 5),
    measurement("MEASUREMENT_7", 7),
    measurement("MEASUREMENT_8", 8),
];

/// Yes or no.
const FLAG: Names = Names { of: "flag", values: &[(0, "no"), (1, "yes")] };
/// Level of a digital line.
const LEVEL: Names = Names { of: "level", values: &[(0, "low"), (1, "high")] };
/// Bits 3..0 of request and status word (Table 8).
const MOTOR_MODE: Names =
    Names { of: "motor mode", values: &[(0, "Standby"), (1, "Drive"), (2, "Reverse"), (3, "Fault")] };
/// Bits 11..8 of the status word (Table 8).
const CONTROL_MODE: Names = Names {
    of: "control mode",
    values: &[(0, "Off"), (1, "Open loop"), (2, "Sensorless closed loop"), (3, "Hall closed loop")],
};
/// Bits 20..16 of the status word as Table 8 prints them; 6 is reserved.
const LOGGING_STATE: Names = Names {
    of: "logging state",
    values: &[
        (0, "LOG_BOOT_UP"),
        (1, "LOG_INIT"),
        (2, "LOG_WRITE_WAIT_PER"),
        (3, "LOG_WRITE"),
        (4, "LOG_READ_REQ_INIT"),
        (5, "LOG_SEND_READ_REQ"),
        (7, "LOG_WAIT_READ_RESULT"),
        (8, "LOG_READ_SEND_CAN_FRAMES"),
        (9, "LOG_ERASE_ONGOING"),
        (10, "LOG_ERASE_END"),
        (11, "LOG_READ_END"),
    ],
};
/// Word 3 of the answer to PARAMETER.
const PARAMETER_STATUS: Names = Names {
    of: "parameter status",
    values: &[
        (0, "Done"),
        (1, "Unknown number"),
        (2, "Read-only"),
        (3, "Out of range"),
        (4, "Wrong state"),
        (5, "Storage"),
        (6, "Not equipped"),
    ],
};
/// Word 0 of XML_DOWNLOAD_REQUEST.
const DOWNLOAD_COMMAND: Names = Names { of: "download command", values: &[(0, "Length"), (1, "Start")] };

/// High byte of word 0 of UPDATE_STATUS.
#[cfg(feature = "update")]
const UPDATE_STATE: Names = Names {
    of: "update state",
    values: &[(0, "Idle"), (1, "Erasing"), (2, "Receiving"), (3, "Verifying"), (4, "Marked"), (5, "Trial")],
};
/// Low byte of word 0 of UPDATE_STATUS.
#[cfg(feature = "update")]
const UPDATE_CODE: Names = Names {
    of: "update code",
    values: &[
        (0, "Done"),
        (1, "Wrong state"),
        (2, "Not now"),
        (3, "On trial"),
        (4, "Hardware"),
        (5, "Length"),
        (6, "Sequence"),
        (7, "Flash"),
        (8, "Checksum"),
        (9, "No image"),
        (10, "Older"),
        (11, "Timed out"),
        (12, "Aborted"),
        (13, "Signature"),
        (14, "Reverted"),
    ],
};

const FAULTS: Field = Field { meaning: Meaning::Faults, ..long("Faults", 0) };
const SPEED: Field = Field { unit: "rpm", ..word("Speed", 0) };
const NUMBER: Field = Field { meaning: Meaning::ParameterNumber, ..word("Number", 0) };
const VALUE: Field = Field { meaning: Meaning::ParameterValue, signed: true, ..long("Value", 16) };

impl Message {
    /// The fields in the order of their bits.
    pub fn fields(&self) -> impl Iterator<Item = Field> + Clone + use<> {
        let opcode = (self.kind == SlaveTx).then_some(self.opcode);
        let signals = SIGNALS.iter().filter(move |signal| Some(signal.opcode) == opcode);
        self.own.iter().copied().chain(signals.map(Field::from))
    }

    /// The message that an identifier is for, if there is one.
    pub fn of(id: MessageId) -> Option<&'static Self> {
        MESSAGES.iter().find(|message| (message.kind, message.opcode) == (id.kind, id.opcode))
    }

    /// Identifier of the message between these addresses.
    pub const fn id(&self, addresses: Addresses) -> MessageId {
        match self.kind {
            SlaveTx => addresses.from_drive(self.opcode),
            kind => addresses.to_drive(kind, self.opcode),
        }
    }
}

impl Field {
    /// The raw number in the words of its message.
    pub fn raw(&self, Words(words): Words) -> i64 {
        let all = words.iter().fold(0, |all: u64, word| all << 16 | u64::from(*word));
        let top = all << self.first_bit.min(63);
        let unused = 64_u32.saturating_sub(self.bits.into()).min(63);
        if self.signed { top as i64 >> unused } else { (top >> unused) as i64 }
    }

    /// Puts a raw number into its bits of the message's words, which must be 0 before.
    ///
    /// # Errors
    /// The number needs more bits; nothing has changed.
    pub fn put(&self, raw: i64, Words(words): &mut Words) -> Result<(), DecodeError> {
        let unused = 64_u32.saturating_sub(self.bits.into()).min(63);
        let top = (raw as u64) << unused;
        let fits = if self.signed { top as i64 >> unused == raw } else { (top >> unused) as i64 == raw };
        if !fits {
            return Err(DecodeError::Value);
        }
        let placed = top >> self.first_bit.min(63);
        for (word, shift) in words.iter_mut().zip([48, 32, 16, 0]) {
            *word |= (placed >> shift) as u16;
        }
        Ok(())
    }
}

impl From<&Signal> for Field {
    fn from(signal: &Signal) -> Self {
        let &Signal { word, words, signed, name, unit, exponent, .. } = signal;
        let meaning = if signed { Meaning::Number } else { Meaning::Named(&LEVEL) };
        Self { name, first_bit: word * 16, bits: words * 16, signed, unit, exponent, meaning }
    }
}

const fn message(name: &'static str, opcode: Opcode, kind: MessageKind, own: &'static [Field]) -> Message {
    Message { name, opcode, kind, own }
}

const fn measurement(name: &'static str, number: u32) -> Message {
    let opcode = Opcode::masked(Opcode::MEASUREMENT_0.raw() as u32 + number);
    message(name, opcode, SlaveTx, &[])
}

#[cfg(feature = "update")]
const fn byte(name: &'static str, first_bit: u8) -> Field {
    Field { bits: 8, ..word(name, first_bit) }
}

const fn word(name: &'static str, first_bit: u8) -> Field {
    Field { name, first_bit, bits: 16, signed: false, unit: "-", exponent: 0, meaning: Meaning::Number }
}

/// A sample of the scope: 4096 is its signal's base (Q3.12).
const fn sample(name: &'static str, first_bit: u8) -> Field {
    Field { signed: true, ..word(name, first_bit) }
}

const fn long(name: &'static str, first_bit: u8) -> Field {
    Field { bits: 32, ..word(name, first_bit) }
}

const fn named(name: &'static str, first_bit: u8, bits: u8, names: &'static Names) -> Field {
    Field { bits, meaning: Meaning::Named(names), ..word(name, first_bit) }
}
