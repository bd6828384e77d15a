//! Tests that the EDS files are those of this code, and describe what the device does.

use crate::bench::{Bench, frame, node};
use narx_core::bus::Frame;
use narx_core::bus::eddycan::{CobId, Layout, PdoKind, SdoAction, SdoOutcome};
use narx_core::eddycan::OBJECTS;
use narx_generate::{eds, settle};
use std::collections::BTreeMap;
use std::path::Path;

type Sections = BTreeMap<String, BTreeMap<String, String>>;

/// Sections and keys of an INI file; none may occur twice.
fn parse(text: &str) -> Sections {
    let mut sections = Sections::new();
    let mut current = None;
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with(';')) {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            assert!(sections.insert(name.to_owned(), BTreeMap::new()).is_none(), "[{name}] twice");
            current = Some(name.to_owned());
            continue;
        }
        let (key, value) = line.split_once('=').unwrap_or_else(|| panic!("{line}"));
        let section = sections.get_mut(current.as_ref().unwrap()).unwrap();
        assert!(section.insert(key.to_owned(), value.to_owned()).is_none(), "{key} twice");
    }
    sections
}

fn number(text: &str) -> u32 {
    text.strip_prefix("0x").map_or_else(|| text.parse(), |digits| u32::from_str_radix(digits, 16)).unwrap()
}

fn files() -> impl Iterator<Item = (Layout, Sections)> {
    Layout::ALL.into_iter().map(|layout| (layout, parse(&eds::render(layout))))
}

#[test]
fn committed_files_are_up_to_date() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    settle(root, eds::make, true).unwrap();
}

/// Every list names existing sections, and every entry is in a list.
#[test]
fn lists_and_sections_agree() {
    for (_, sections) in files() {
        let mut listed = Vec::new();
        for list in ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"] {
            let list = &sections[list];
            let count = number(&list["SupportedObjects"]);
            assert_eq!(list.len() as u32, count + 1);
            listed.extend((1..=count).map(|n| number(&list[&n.to_string()])));
        }
        let mut found: Vec<u32> =
            sections.keys().filter_map(|name| u32::from_str_radix(name, 16).ok()).collect();
        listed.sort_unstable();
        found.sort_unstable();
        assert_eq!(listed, found);
        for (name, section) in &sections {
            let Some(subs) = section.get("SubNumber") else { continue };
            let own = sections.keys().filter(|other| other.starts_with(&format!("{name}sub"))).count();
            assert_eq!(own as u32, number(subs), "{name}");
        }
    }
}

/// The file describes an entry as the device answers: value, size, and access for reading and writing.
#[test]
fn entries_are_those_of_the_device() {
    for (layout, sections) in files() {
        let mut bench = Bench::new(layout.channels, &[]);
        for row in &OBJECTS {
            let name = match row.subindex {
                Some(subindex) => format!("{:04X}sub{subindex}", row.index),
                None => format!("{:04X}", row.index),
            };
            let section = &sections[&name];
            let subindex = row.subindex.unwrap_or(0);
            let access = section["AccessType"].as_str();
            match bench.read(row.index, subindex) {
                SdoOutcome::Value(value) => {
                    assert!(access.starts_with('r'), "{name}");
                    let size = [0, 0, 0, 0, 0, 1, 2, 4][number(&section["DataType"]) as usize];
                    assert_eq!(value.size(), size, "{name}");
                    if let Some(default) = section.get("DefaultValue") {
                        assert_eq!(value.number(), number(default), "{name}");
                    }
                }
                _ => assert_eq!(access, "wo", "{name}"),
            }
            let limits = ["LowLimit", "HighLimit"].map(|key| number(&section[key]));
            for limit in limits {
                let action = SdoAction::Write { size: None, data: limit.to_le_bytes() };
                let written = bench.ask(row.index, subindex, action) == SdoOutcome::Written;
                assert_eq!(written, access.ends_with('w') || access == "wo", "{name} = {limit}");
            }
        }
    }
}

/// Identifiers and lengths of the PDOs are those that the device sends.
#[test]
fn pdos_are_those_of_the_device() {
    for (layout, sections) in files() {
        for kind in [PdoKind::Timer, PdoKind::Sync, PdoKind::Remote] {
            let number_of = kind as u16 - 1;
            let cob = &sections[&format!("{:04X}sub1", 0x1800 + number_of)]["DefaultValue"];
            let cob = number(cob.strip_prefix("$NODEID+").unwrap());
            let id = CobId::Pdo(kind, node(5)).encode().raw();
            assert_eq!((cob & 0x7FF) + 5, id);
            assert_eq!(cob >> 30 & 1 == 0, kind == PdoKind::Remote, "only PDO3 answers remote frames");
            let mapping = format!("{:04X}sub", 0x1A00 + number_of);
            let count = number(&sections[&format!("{mapping}0")]["DefaultValue"]);
            let mapped =
                (1..=count).map(|place| number(&sections[&format!("{mapping}{place}")]["DefaultValue"]));
            let bits: u32 = mapped.clone().map(|entry| entry & 0xFF).sum();
            assert_eq!(bits, 8 * u32::from(layout.length()));
            for entry in mapped {
                let target = &sections[&format!("{:04X}", entry >> 16)];
                assert_eq!(target["PDOMapping"], "1");
            }
        }
    }
}

/// A CANopen tool that follows the file can configure the device, with sized writes and with reads.
#[test]
fn a_tool_configures_the_device() {
    let mut bench = Bench::new(narx_core::bus::eddycan::Channels::Single, &[]);
    let exchange: [(&[u8; 8], &[u8; 8]); 4] = [
        (&[0x2B, 0x03, 0x20, 0, 0x0A, 0, 0, 0], &[0x60, 0x03, 0x20, 0, 0, 0, 0, 0]),
        (&[0x23, 0x07, 0x20, 1, 0, 0, 0, 0x10], &[0x60, 0x07, 0x20, 1, 0, 0, 0, 0]),
        (&[0x2F, 0x0A, 0x20, 0, 0, 0, 0, 0], &[0x60, 0x0A, 0x20, 0, 0, 0, 0, 0]),
        (&[0x40, 0x03, 0x20, 0, 0, 0, 0, 0], &[0x4B, 0x03, 0x20, 0, 0x0A, 0, 0, 0]),
    ];
    for (request, answer) in exchange {
        bench.give(&frame(0x601, request));
        assert_eq!(bench.frames(), [frame(0x581, answer)] as [Frame; 1]);
    }
}
