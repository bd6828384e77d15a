//! Tests of the container byte for byte, of its versions, and of files with valid check values but without
//! meaning.

use super::support::{HEADER, Noise, container, record, turning};
use narx_core::motor::machine::event::Event;
use narx_core::motor::{Edge, EdgeSource, Lines, SampleMode, Samples};
use narx_core::recording::{
    BEHAVIOUR_VERSION, Header, Kind, LABEL_MAX, LAYOUT_VERSION, ReadError, Recording, Tick,
};
use proptest::prelude::*;

#[test]
fn bytes_by_hand() {
    let first = Samples { tick: 1, bus_voltage: 3, ..Samples::default() };
    let mut second = Samples {
        tick: 2,
        phase_voltage: [0, 0xffff, 0],
        bus_voltage: 3,
        sample_mode: SampleMode::OnTime,
        hall: 5,
        edges_lost: 9,
        lines: Lines::DSI1,
        ..Samples::default()
    };
    second.edges.push(Edge { instant: 0x1234, source: EdgeSource::Comparator, code: 5 }).unwrap();
    let ticks = [
        Tick { event: None, samples: first },
        Tick { event: Some(Event::CoefficientsRejected), samples: second },
    ];
    let file = record(&Header::drive(10_000, ""), &[0xaa, 0xbb], &ticks);

    // Bit 3; +3 as zigzag.
    let mut records = vec![0x08, 0x06];
    // Bits 1, 5, 6, 7, 9, 12, 13 as varint; -1 as zigzag; hall; one edge; event 2; lost; lines.
    let mask: u16 = 1 << 1 | 1 << 5 | 1 << 6 | 1 << 7 | 1 << 9 | 1 << 12 | 1 << 13;
    records.extend([(mask & 0x7f) as u8 | 0x80, (mask >> 7) as u8]);
    records.extend([0x01, 5, 1, 0x34, 0x12, 5 * 2 + 1, 1, 0, 2, 9, 4]);
    let digest = Recording::open(&file).unwrap().verify().unwrap().digest;
    let end = [2u64.to_le_bytes(), digest.to_le_bytes()].concat();
    let expected = container(&[(b'H', &HEADER), (b'S', &[0xaa, 0xbb]), (b'T', &records), (b'E', &end)]);
    assert_eq!(file, expected);
}

#[test]
fn versions_have_errors_of_their_own() {
    let here = Header::drive(10_000, "versions");
    let ticks = turning(5, &mut Noise(2));

    let mut file = record(&here, &[], &ticks);
    file[8] = 2;
    let error = Recording::open(&file).unwrap_err();
    assert_eq!(error, ReadError::ContainerVersion { found: 2 });
    assert_eq!(error.to_string(), "container version 2, but this narx reads version 1");

    for (found, age) in [(LAYOUT_VERSION + 1, "a newer"), (LAYOUT_VERSION - 1, "an older")] {
        let file = record(&Header { layout_version: found, ..here }, &[], &ticks);
        let error = Recording::open(&file).unwrap_err();
        assert_eq!(error, ReadError::LayoutVersion { found, known: here.layout_version });
        assert!(error.to_string().starts_with(&format!("recorded by {age} narx")), "{error}");
    }

    let file = record(&Header { kind: Kind::Node, ..here }, &[], &ticks);
    assert_eq!(Recording::open(&file).unwrap_err(), ReadError::Kind { found: 2 });

    let file = record(&Header { behaviour_version: BEHAVIOUR_VERSION + 1, ..here }, &[], &ticks);
    let recording = Recording::open(&file).unwrap();
    assert!(!recording.same_behaviour());
    assert_eq!(recording.verify().unwrap().ticks, 5);
}

#[test]
fn well_formed_chunks_in_the_wrong_place() {
    let end = [0u8; 16];
    let bad =
        |chunks: &[(u8, &[u8])]| Recording::open(&container(chunks)).and_then(|r| r.verify()).unwrap_err();
    let malformed = |error| matches!(error, ReadError::Malformed { .. });
    assert!(malformed(bad(&[(b'S', &[]), (b'H', &HEADER)])));
    assert!(malformed(bad(&[(b'H', &HEADER), (b'T', &[0])])));
    assert!(malformed(bad(&[(b'H', &HEADER), (b'S', &[]), (b'S', &[])])));
    assert!(malformed(bad(&[(b'H', &HEADER[..9]), (b'S', &[]), (b'E', &end)])));
    assert!(malformed(bad(&[(b'H', &HEADER), (b'S', &[]), (b'E', &end[..15])])));
    assert!(malformed(bad(&[(b'H', &HEADER), (b'S', &[]), (b'E', &[0; 17])])));
    let label = [&HEADER[..9], &[LABEL_MAX as u8 + 1], &[b'x'; LABEL_MAX + 1]].concat();
    assert!(malformed(bad(&[(b'H', &label), (b'S', &[]), (b'E', &end)])));
    // An additional byte after the label.
    assert!(malformed(bad(&[(b'H', &[&HEADER[..], &[0]].concat()), (b'S', &[]), (b'E', &end)])));
    // A mask that announces more bytes, and a fifth edge.
    assert!(malformed(bad(&[(b'H', &HEADER), (b'S', &[]), (b'T', &[0x01]), (b'E', &end)])));
    let edges = [&[0x40, 5][..], &[0; 15]].concat();
    assert!(malformed(bad(&[(b'H', &HEADER), (b'S', &[]), (b'T', &edges), (b'E', &end)])));
    let counted = bad(&[(b'H', &HEADER), (b'S', &[]), (b'T', &[0]), (b'E', &end)]);
    assert_eq!(counted, ReadError::TickCount { stored: 0, read: 1 });
    let mut file = container(&[(b'H', &HEADER), (b'S', &[]), (b'E', &end)]);
    assert!(Recording::open(&file).unwrap().verify().is_ok());
    file.push(0);
    let at = file.len() - 1;
    assert_eq!(Recording::open(&file).unwrap().verify().unwrap_err(), ReadError::TrailingBytes { at });
}

proptest! {
    // Neither random bytes nor invalid content with valid check values makes the reader panic or run
    // endlessly.
    #[test]
    fn noise_is_no_recording(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(Recording::open(&bytes).is_err());
    }

    #[test]
    fn checked_nonsense_ends(
        header in prop::collection::vec(any::<u8>(), 0..100),
        records in prop::collection::vec(any::<u8>(), 0..300),
        end in prop::collection::vec(any::<u8>(), 0..20),
    ) {
        let _ = Recording::open(&container(&[(b'H', &header)]));
        let file = container(&[(b'H', &HEADER), (b'S', &[]), (b'T', &records), (b'E', &end)]);
        let recording = Recording::open(&file).unwrap();
        prop_assert!(recording.ticks().count() <= records.len() + 1);
    }
}
