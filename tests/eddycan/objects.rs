//! Tests of the object table against Table 4, and of the configuration whose bounds it has.

use crate::bench::configured;
use narx_core::bus::eddycan::AbortCode;
use narx_core::eddycan::{Access, Configuration, Entry, Kind, OBJECTS, Object, STORED};
use proptest::prelude::*;

#[test]
fn rows_of_table_4() {
    use Access::{ReadOnly, ReadWrite, WriteOnly};
    use Kind::{U8, U16, U32};
    let table = [
        (0x2000, None, "Node-ID", U8, ReadWrite, 1, 127, 1),
        (0x2001, None, "Bitrate Index", U8, ReadWrite, 0, 4, 3),
        (0x2002, None, "Nr Of Nodes", U8, ReadWrite, 1, 127, 1),
        (0x2003, None, "Update Time", U16, ReadWrite, 0, 65_535, 0),
        (0x2004, None, "Can Config Register", U16, ReadWrite, 0, 7, 0),
        (0x2005, None, "Basic Config Register", U16, ReadWrite, 0, 6, 0),
        (0x2006, Some(1), "Filter", U8, ReadWrite, 0, 4, 0),
        (0x2006, Some(2), "Filter", U8, ReadWrite, 0, 4, 0),
        (0x2007, Some(1), "Comparator", U32, ReadWrite, 0, 1 << 30, 1 << 29),
        (0x2007, Some(2), "Comparator", U32, ReadWrite, 0, 1 << 30, 1 << 29),
        (0x2008, None, "Counts Per Revolution", U16, ReadWrite, 1, 65_535, 4096),
        (0x2009, None, "Encoder Resolution", U16, ReadWrite, 1, 65_535, 100),
        (0x200A, None, "Reset Encoder", U8, WriteOnly, 0, 255, 0),
        (0x2100, None, "Firmware Version", U16, ReadOnly, 0, 65_535, 0),
    ];
    let found = OBJECTS.each_ref().map(|row| {
        let Object { index, subindex, name, kind, access, min, max, default, .. } = *row;
        (index, subindex, name, kind, access, min, max, default)
    });
    assert_eq!(found, table);
    let restart: Vec<u16> = OBJECTS.iter().filter(|row| row.restart).map(|row| row.index).collect();
    assert_eq!(restart, [0x2000, 0x2001]);
}

#[test]
fn the_table_is_sound() {
    for (place, row) in OBJECTS.iter().enumerate() {
        assert_eq!(row.entry as usize, place);
        assert_eq!(row.entry.object(), row);
        assert!(row.access != Access::ReadWrite || row.accepts(row.default), "{}", row.name);
        assert!(u64::from(row.max) < 1 << (8 * row.kind.size()));
        assert!(row.description.ends_with('.'), "{}", row.name);
        assert_eq!(place < STORED, row.access == Access::ReadWrite);
    }
}

/// A lookup of every address finds exactly the rows of the table.
#[test]
fn every_address() {
    for index in 0..=u16::MAX {
        let rows = || OBJECTS.iter().filter(|row| row.index == index);
        let Some(first) = rows().next() else {
            assert_eq!(Entry::find(index, 0), Err(AbortCode::IndexUnknown));
            continue;
        };
        for subindex in 0..=u8::MAX {
            let expected = match (index, subindex) {
                (0x2006 | 0x2007, 1) => Ok(first.entry),
                (0x2006 | 0x2007, 2) => Ok(rows().nth(1).unwrap().entry),
                (0x2006 | 0x2007, _) => Err(AbortCode::SubindexUnknown),
                _ => Ok(first.entry),
            };
            assert_eq!(Entry::find(index, subindex), expected, "{index:04X}h {subindex}");
        }
    }
}

/// Values at the ends of each range are accepted and those beyond are not, with every value of the registers.
#[test]
fn ranges() {
    let mut configuration = Configuration::new();
    for row in &OBJECTS[..STORED] {
        for value in [row.min, row.max] {
            assert_eq!(configuration.set(row.entry, value), Ok(()));
            assert_eq!(configuration.get(row.entry), value);
        }
        let before = configuration;
        for value in [row.min.checked_sub(1), row.max.checked_add(1), Some(u32::MAX)].into_iter().flatten() {
            assert_eq!(configuration.set(row.entry, value), Err(AbortCode::RangeExceeded), "{}", row.name);
        }
        assert_eq!(configuration, before);
    }
    // Tables 7 and 8.
    for value in 0..=0xFFFF {
        assert_eq!(configuration.set(Entry::CanConfig, value).is_ok(), value < 8);
        assert_eq!(configuration.set(Entry::BasicConfig, value).is_ok(), matches!(value, 0 | 2 | 4 | 6));
    }
    for entry in [Entry::ResetEncoder, Entry::FirmwareVersion] {
        assert_eq!(configuration.set(entry, 0), Err(AbortCode::General), "nothing of it is stored");
        assert_eq!(configuration.get(entry), 0);
    }
}

/// The registers have all eight rows of Table 7, and the meaning of the fourth parameter in the rows of
/// Table 8.
#[test]
fn registers() {
    for value in 0..8 {
        let configuration = configured(&[(Entry::CanConfig, value)]);
        let layout = configuration.layout(narx_core::bus::eddycan::Channels::Dual);
        let bits = [configuration.autostart(), layout.encoder, configuration.heartbeat()];
        assert_eq!(bits, [1, 2, 4].map(|bit| value & bit != 0));
    }
    for (value, rotary, reverse) in [(0, false, false), (2, true, false), (4, false, true), (6, true, true)] {
        let setup = configured(&[(Entry::BasicConfig, value)]).encoder();
        assert_eq!(setup.counts_per_revolution, rotary.then_some(4096));
        assert_eq!(setup.reverse, reverse);
    }
}

proptest! {
    /// A configuration from memory with any content has only values that the table allows.
    #[test]
    fn what_is_stored_is_read_or_refused(values: [u32; STORED], keep in 0..=STORED) {
        let mut values = values;
        let factory = <[u32; STORED]>::from(Configuration::new());
        values[..keep].copy_from_slice(&factory[..keep]);
        let bytes = postcard::to_stdvec(&values).unwrap();
        let valid = OBJECTS.iter().zip(values).all(|(row, value)| row.accepts(value));
        match postcard::from_bytes::<Configuration>(&bytes) {
            Ok(configuration) => {
                prop_assert!(valid);
                prop_assert_eq!(postcard::to_stdvec(&configuration).unwrap(), bytes);
            }
            Err(_) => prop_assert!(!valid),
        }
        let error = Configuration::try_from(values).err();
        let first = OBJECTS.iter().zip(values).find(|(row, value)| !row.accepts(*value));
        prop_assert_eq!(error.map(|error| error.0), first.map(|(row, _)| row.entry));
    }
}
