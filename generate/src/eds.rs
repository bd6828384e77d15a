//! `docs/eddycan-*.eds`: the TX-Driver for CANopen tools (CiA 306), one file for each layout of its PDOs,
//! made from core's table of objects.
//!
//! The files have two things that the device does not: communication and mapping of the PDOs, which eddyCAN
//! fixes (1800h to 1A02h), and the values in the PDOs (2200h to 2202h). Tools need both to decode a PDO, and
//! must take them from the file instead of reading them.

use crate::Made;
use narx_core::bus::eddycan::{Bitrate, Channels, Layout, PdoKind};
use narx_core::eddycan::{Access, Kind, OBJECTS, Object};
use std::fmt::Write;
use std::path::Path;

/// Data types of CiA 301.
const UNSIGNED8: u8 = 0x05;
const UNSIGNED16: u8 = 0x06;
const UNSIGNED32: u8 = 0x07;
const INTEGER16: u8 = 0x03;
const INTEGER24: u8 = 0x10;
const INTEGER32: u8 = 0x04;
/// Object types of CiA 301.
const VARIABLE: u8 = 0x7;
const ARRAY: u8 = 0x8;
const RECORD: u8 = 0x9;
/// Contents of PDOs: entries of the file alone.
const POSITION_1: u16 = 0x2200;
const POSITION_2: u16 = 0x2201;
const ENCODER: u16 = 0x2202;

const TRIGGERS: [PdoKind; 3] = [PdoKind::Timer, PdoKind::Sync, PdoKind::Remote];

/// Makes a file for each layout.
///
/// # Errors
/// None.
pub fn make(_: &Path) -> Result<Made, String> {
    let files = Layout::ALL.map(|layout| (format!("docs/{}", file_name(layout)), render(layout)));
    let summary = format!("{} files of {} objects", Layout::ALL.len(), OBJECTS.len());
    Ok(Made { files: files.into(), summary })
}

/// Name of the file of a layout, in `docs`.
pub fn file_name(layout: Layout) -> String {
    let channels = match layout.channels {
        Channels::Single => "single",
        Channels::Dual => "dual",
    };
    let encoder = if layout.encoder { "-encoder" } else { "" };
    format!("eddycan-{channels}{encoder}.eds")
}

/// Parts of a PDO in their order: index, name and data type.
fn parts(layout: Layout) -> Vec<(u16, &'static str, u8)> {
    let position =
        if layout == (Layout { channels: Channels::Dual, encoder: true }) { INTEGER24 } else { INTEGER32 };
    let mut parts = vec![(POSITION_1, "Position 1", position)];
    if layout.channels == Channels::Dual {
        parts.push((POSITION_2, "Position 2", position));
    }
    if layout.encoder {
        parts.push((ENCODER, "Encoder", INTEGER16));
    }
    parts
}

/// Renders the file as text.
pub fn render(layout: Layout) -> String {
    let mut out = header(layout);
    let mut indices: Vec<u16> = OBJECTS.iter().map(|row| row.index).collect();
    indices.dedup();
    indices.extend(parts(layout).iter().map(|part| part.0));
    let pdos = (0..3).map(|n| 0x1800 + n).chain((0..3).map(|n| 0x1A00 + n));
    list(&mut out, "MandatoryObjects", &[]);
    list(&mut out, "OptionalObjects", &pdos.collect::<Vec<u16>>());
    list(&mut out, "ManufacturerObjects", &indices);
    for (number, kind) in TRIGGERS.into_iter().enumerate() {
        communication(&mut out, 0x1800 + number as u16, kind);
    }
    for (number, kind) in TRIGGERS.into_iter().enumerate() {
        mapping(&mut out, 0x1A00 + number as u16, kind, layout);
    }
    let mut last = None;
    for row in &OBJECTS {
        if row.subindex.is_some() && last != Some(row.index) {
            let count = OBJECTS.iter().filter(|other| other.index == row.index).count();
            record(&mut out, row.index, row.name, ARRAY, count);
        }
        last = Some(row.index);
        object(&mut out, row);
    }
    for (index, name, data_type) in parts(layout) {
        let _ = write!(
            out,
            "\n[{index:04X}]\nParameterName={name}\nObjectType=0x{VARIABLE:X}\nDataType=0x{data_type:04X}\nAccessType=ro\n\
             PDOMapping=1\n"
        );
    }
    out
}

fn header(layout: Layout) -> String {
    let channels = if layout.channels == Channels::Single { "1 channel" } else { "2 channels" };
    let encoder = if layout.encoder { ", PDOs with encoder (bit 1 of 2004h set)" } else { "" };
    let rates: String = [10, 20, 50, 125, 250, 500, 800, 1000]
        .map(|rate| {
            let known = Bitrate::ALL.iter().any(|bitrate| bitrate.bits_per_second() == rate * 1000);
            format!("BaudRate_{rate}={}\n", u8::from(known))
        })
        .concat();
    let dummies: String = (1..=7).map(|n| format!("Dummy{n:04X}=0\n")).collect();
    format!(
        "[FileInfo]\nFileName={}\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\n\
         Description=TX-Driver, {channels}{encoder}\nCreatedBy=narx\n\n\
         [DeviceInfo]\nVendorName=eddylab\nVendorNumber=0\nProductName=TX-Driver\nProductNumber=0\nRevisionNumber=0\nOrderCode=\n\
         {rates}SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=0\nDynamicChannelsSupported=0\nGroupMessaging=0\n\
         NrOfRXPDO=0\nNrOfTXPDO=3\nLSS_Supported=0\n\n\
         [DummyUsage]\n{dummies}\n\
         [Comments]\nLines=4\nLine1=eddyCAN has no communication profile: 1000h to 1FFFh cannot be read from the device.\n\
         Line2=Instead of 1000h, 1001h, 1017h and 1018h: its node-id 2000h, errors as EMCY messages, heartbeat by bit 2 of 2004h.\n\
         Line3=1800h to 1A02h say here what eddyCAN fixes, and 2200h to 2202h name what its PDOs carry.\n\
         Line4=A sixth bitrate of the device, 100 kbit/s, has no key in this format.\n",
        file_name(layout)
    )
}

fn list(out: &mut String, section: &str, indices: &[u16]) {
    let _ = write!(out, "\n[{section}]\nSupportedObjects={}\n", indices.len());
    for (number, index) in indices.iter().enumerate() {
        let _ = writeln!(out, "{}=0x{index:04X}", number + 1);
    }
}

fn record(out: &mut String, index: u16, name: &str, object_type: u8, entries: usize) {
    let _ = write!(
        out,
        "\n[{index:04X}]\nParameterName={name}\nObjectType=0x{object_type:X}\nSubNumber={entries}\n"
    );
}

fn constant(out: &mut String, index: u16, subindex: usize, name: &str, data_type: u8, value: &str) {
    let _ = write!(
        out,
        "\n[{index:04X}sub{subindex:X}]\nParameterName={name}\nObjectType=0x{VARIABLE:X}\nDataType=0x{data_type:04X}\nAccessType=const\n\
         DefaultValue={value}\nPDOMapping=0\n"
    );
}

/// Writes the conditions under which a PDO is sent. Bit 30 of the identifier: not at a remote frame.
fn communication(out: &mut String, index: u16, kind: PdoKind) {
    let base = 0x80 + 0x100 * kind as u32;
    let (flags, transmission) = match kind {
        PdoKind::Timer => (1 << 30, 0xFE),
        PdoKind::Sync => (1 << 30, 0x01),
        PdoKind::Remote => (0, 0xFD),
    };
    record(out, index, &format!("PDO{} communication", kind as u8), RECORD, 3);
    constant(out, index, 0, "Highest subindex", UNSIGNED8, "2");
    constant(out, index, 1, "COB-ID", UNSIGNED32, &format!("$NODEID+0x{:X}", flags + base));
    constant(out, index, 2, "Transmission type", UNSIGNED8, &transmission.to_string());
}

fn mapping(out: &mut String, index: u16, kind: PdoKind, layout: Layout) {
    let parts = parts(layout);
    record(out, index, &format!("PDO{} mapping", kind as u8), RECORD, parts.len() + 1);
    constant(out, index, 0, "Number of entries", UNSIGNED8, &parts.len().to_string());
    for (place, (target, name, data_type)) in parts.into_iter().enumerate() {
        let bits = match data_type {
            INTEGER16 => 16_u32,
            INTEGER24 => 24,
            _ => 32,
        };
        constant(
            out,
            index,
            place + 1,
            name,
            UNSIGNED32,
            &format!("0x{:08X}", u32::from(target) << 16 | bits),
        );
    }
}

fn object(out: &mut String, row: &Object) {
    let section = match row.subindex {
        Some(subindex) => format!("{:04X}sub{subindex:X}", row.index),
        None => format!("{:04X}", row.index),
    };
    let name = match row.subindex {
        Some(subindex) => format!("{} {subindex}", row.name),
        None => row.name.to_owned(),
    };
    let data_type = match row.kind {
        Kind::U8 => UNSIGNED8,
        Kind::U16 => UNSIGNED16,
        Kind::U32 => UNSIGNED32,
    };
    let access = match row.access {
        Access::ReadWrite => "rw",
        Access::ReadOnly => "ro",
        Access::WriteOnly => "wo",
    };
    let _ = write!(
        out,
        "\n[{section}]\n; {}\nParameterName={name}\nObjectType=0x{VARIABLE:X}\nDataType=0x{data_type:04X}\nAccessType={access}\n",
        row.description
    );
    if row.access == Access::ReadWrite {
        let _ = writeln!(out, "DefaultValue={}", row.default);
    }
    let _ = write!(out, "LowLimit={}\nHighLimit={}\nPDOMapping=0\n", row.min, row.max);
}
