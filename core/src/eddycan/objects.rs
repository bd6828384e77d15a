//! The object dictionary (Table 4) as one table: name, range and effect of each entry. The SDO server, the
//! tables of PROTOCOL.md and the EDS are made from it.

use crate::blind;
use crate::bus::eddycan::AbortCode;
use Access::{ReadOnly, ReadWrite, WriteOnly};
use Kind::{U8, U16, U32};

/// An entry, in the order of [`OBJECTS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Entry {
    /// 2000h.
    NodeId,
    /// 2001h.
    BitrateIndex,
    /// 2002h.
    NrOfNodes,
    /// 2003h.
    UpdateTime,
    /// 2004h.
    CanConfig,
    /// 2005h.
    BasicConfig,
    /// 2006h, subindex 1.
    Filter1,
    /// 2006h, subindex 2.
    Filter2,
    /// 2007h, subindex 1.
    Comparator1,
    /// 2007h, subindex 2.
    Comparator2,
    /// 2008h.
    CountsPerRevolution,
    /// 2009h.
    EncoderResolution,
    /// 200Ah.
    ResetEncoder,
    /// 2100h, our own.
    FirmwareVersion,
}

/// All properties of an entry except its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object {
    /// The entry.
    pub entry: Entry,
    /// Index.
    pub index: u16,
    /// Subindex; `None` if the entry has none and any is accepted.
    pub subindex: Option<u8>,
    /// Name as printed.
    pub name: &'static str,
    /// Type; for an entry that is written without data, the type that tools show.
    pub kind: Kind,
    /// Read and write access.
    pub access: Access,
    /// Unit; "-" without one.
    pub unit: &'static str,
    /// Smallest value.
    pub min: u32,
    /// Largest value.
    pub max: u32,
    /// Bits that must be 0.
    pub reserved: u32,
    /// Factory value.
    pub default: u32,
    /// A written value acts after a restart, or else at once.
    pub restart: bool,
    /// Effect, in one or two sentences.
    pub description: &'static str,
}

/// Type of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One byte.
    U8,
    /// Two bytes.
    U16,
    /// Four bytes.
    U32,
}

/// Read and write access to an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read and write.
    ReadWrite,
    /// Read only.
    ReadOnly,
    /// Write only.
    WriteOnly,
}

/// Entries with a value that is kept over a restart: the first ones of the table.
pub const STORED: usize = 12;

/// Update time that makes the node compute it from the number of nodes.
pub(super) const UPDATE_TIME_HALF_LOAD: u32 = 65_535;
/// Comparator value of the whole measuring range.
pub(super) const COMPARATOR_ONE: u32 = 1 << 30;

/// Table 4, and an entry of our own.
pub static OBJECTS: [Object; STORED + 2] = [
    object(Entry::NodeId, 0x2000, "Node-ID", U8)
        .range(1, 127)
        .factory(1)
        .after_restart()
        .about("Address on the bus, different for every node of it."),
    object(Entry::BitrateIndex, 0x2001, "Bitrate Index", U8)
        .range(0, 4)
        .factory(3)
        .after_restart()
        .about("0: 50, 1: 100, 2: 250, 3: 500, 4: 1000 kbit/s. The same for every node of the bus."),
    object(Entry::NrOfNodes, 0x2002, "Nr Of Nodes", U8)
        .range(1, 127)
        .factory(1)
        .about("TX-Drivers on the bus, which share half of it among their PDO1 when the update time is 65535."),
    object(Entry::UpdateTime, 0x2003, "Update Time", U16)
        .unit("ms")
        .range(0, UPDATE_TIME_HALF_LOAD)
        .factory(0)
        .about("Period of PDO1. 0: no PDO1. 65535: as short as half of the bus allows for all nodes together."),
    object(Entry::CanConfig, 0x2004, "Can Config Register", U16)
        .range(0, 7)
        .factory(0)
        .about("Bit 0: Operational after boot-up. Bit 1: PDOs carry the encoder. Bit 2: heartbeat every 2 s."),
    object(Entry::BasicConfig, 0x2005, "Basic Config Register", U16)
        .range(0, 6)
        .without(1)
        .factory(0)
        .about("Bit 1: the encoder is rotary, else linear. Bit 2: it counts the other way round. Bit 0 is reserved."),
    object(Entry::Filter1, 0x2006, "Filter", U8)
        .channel(1)
        .range(0, 4)
        .factory(0)
        .about("Edge frequency of channel 1. 0: no filter, 1: 10 Hz, 2: 100 Hz, 3: 1 kHz, 4: 10 kHz."),
    object(Entry::Filter2, 0x2006, "Filter", U8)
        .channel(2)
        .range(0, 4)
        .factory(0)
        .about("Edge frequency of channel 2, likewise; without effect on a driver of one channel."),
    object(Entry::Comparator1, 0x2007, "Comparator", U32)
        .channel(1)
        .unit("2^-30")
        .range(0, COMPARATOR_ONE)
        .factory(COMPARATOR_ONE / 2)
        .about("Output 1 is high while channel 1 is above this fraction of its measuring range."),
    object(Entry::Comparator2, 0x2007, "Comparator", U32)
        .channel(2)
        .unit("2^-30")
        .range(0, COMPARATOR_ONE)
        .factory(COMPARATOR_ONE / 2)
        .about("Output 2 likewise for channel 2, or on a driver of one channel for channel 1: a second threshold."),
    object(Entry::CountsPerRevolution, 0x2008, "Counts Per Revolution", U16)
        .range(1, 65_535)
        .factory(4096)
        .about("Counts of a rotary encoder, four to a period: its value runs from 0 to one less."),
    object(Entry::EncoderResolution, 0x2009, "Encoder Resolution", U16)
        .unit("nm")
        .range(1, 65_535)
        .factory(100)
        .about("Length of a linear encoder's count, four to a period. Told to whoever asks; PDOs carry counts."),
    object(Entry::ResetEncoder, 0x200A, "Reset Encoder", U8)
        .access(WriteOnly)
        .range(0, 255)
        .about("Any write, with or without data: the present place of a linear encoder becomes 0."),
    object(Entry::FirmwareVersion, 0x2100, "Firmware Version", U16)
        .access(ReadOnly)
        .range(0, 65_535)
        .about("Our own: release of the firmware, major in the high byte."),
];

const fn object(entry: Entry, index: u16, name: &'static str, kind: Kind) -> Object {
    Object {
        entry,
        index,
        subindex: None,
        name,
        kind,
        access: ReadWrite,
        unit: "-",
        min: 0,
        max: 0,
        reserved: 0,
        default: 0,
        restart: false,
        description: "",
    }
}

impl Entry {
    /// Its row of the table.
    pub fn object(self) -> &'static Object {
        let [first, ..] = &OBJECTS;
        OBJECTS.get(self as usize).unwrap_or(first)
    }

    /// Returns whether the entry has no effect in this process.
    pub(super) fn is_blind(self) -> bool {
        let object = self.object();
        blind::to("object", u32::from(object.index) << 8 | u32::from(object.subindex.unwrap_or(0)))
    }

    /// The entry of an address.
    ///
    /// # Errors
    /// There is no such index, or the index has not this subindex.
    pub fn find(index: u16, subindex: u8) -> Result<Self, AbortCode> {
        let mut code = AbortCode::IndexUnknown;
        for object in OBJECTS.iter().filter(|object| object.index == index) {
            if object.subindex.is_none_or(|own| own == subindex) {
                return Ok(object.entry);
            }
            code = AbortCode::SubindexUnknown;
        }
        Err(code)
    }
}

impl Kind {
    /// Bytes of a value.
    pub const fn size(self) -> u8 {
        match self {
            U8 => 1,
            U16 => 2,
            U32 => 4,
        }
    }

    /// Name as Table 4 prints it.
    pub const fn label(self) -> &'static str {
        match self {
            U8 => "Unsigned8",
            U16 => "Unsigned16",
            U32 => "Unsigned32",
        }
    }
}

impl Access {
    /// Name as Table 4 prints it.
    pub const fn label(self) -> &'static str {
        match self {
            ReadWrite => "RW",
            ReadOnly => "R",
            WriteOnly => "W",
        }
    }
}

impl Object {
    /// Returns whether a value is within the range and without reserved bits.
    pub const fn accepts(&self, value: u32) -> bool {
        value >= self.min && value <= self.max && value & self.reserved == 0
    }

    const fn channel(self, subindex: u8) -> Self {
        Self { subindex: Some(subindex), ..self }
    }
    const fn access(self, access: Access) -> Self {
        Self { access, ..self }
    }
    const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }
    const fn range(self, min: u32, max: u32) -> Self {
        Self { min, max, ..self }
    }
    const fn without(self, reserved: u32) -> Self {
        Self { reserved, ..self }
    }
    const fn factory(self, default: u32) -> Self {
        Self { default, ..self }
    }
    const fn after_restart(self) -> Self {
        Self { restart: true, ..self }
    }
    const fn about(self, description: &'static str) -> Self {
        // Texts are half of the table's bytes.
        if cfg!(feature = "description") { Self { description, ..self } } else { self }
    }
}
