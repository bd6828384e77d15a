//! Tests of frames and identifiers: their fields, their texts, and their stored form.

use crate::frames::{extended, standard};
use embedded_can::Frame as _;
use narx_core::bus::{BusState, ErrorState, Frame, Id};

#[test]
fn a_frame_tells_what_it_was_made_of() {
    let (narrow, wide) = (Id::standard(0x7FF).unwrap(), Id::extended(0x1FFF_FFFF).unwrap());
    let eight = [1, 2, 3, 4, 5, 6, 7, 8];
    for (frame, id, is_remote, dlc, payload, full) in [
        (standard(0x7FF, &[]), narrow, false, 0, &[][..], None),
        (standard(0x7FF, &[9; 7]), narrow, false, 7, &[9; 7], None),
        (extended(0x1FFF_FFFF, &eight), wide, false, 8, &eight, Some(eight)),
        (Frame::full(wide, eight), wide, false, 8, &eight, Some(eight)),
        // A remote frame requests eight bytes and has none.
        (Frame::remote(wide, 8).unwrap(), wide, true, 8, &[], None),
        (Frame::remote(narrow, 0).unwrap(), narrow, true, 0, &[], None),
    ] {
        assert_eq!((frame.id(), frame.is_remote(), frame.dlc()), (id, is_remote, dlc), "{frame:?}");
        assert_eq!((frame.payload(), frame.full_payload()), (payload, full), "{frame:?}");
        // `embedded_can` gives the same.
        assert_eq!(embedded_can::Frame::id(&frame), embedded_can::Id::from(id), "{frame:?}");
        assert_eq!((frame.is_extended(), frame.is_remote_frame()), (id == wide, is_remote), "{frame:?}");
        assert_eq!(
            (embedded_can::Frame::dlc(&frame), frame.data()),
            (usize::from(dlc), payload),
            "{frame:?}"
        );
    }
    assert_eq!(Frame::new_remote(embedded_can::Id::from(narrow), 9), None);
    assert_eq!(Frame::new_remote(embedded_can::Id::from(narrow), 256), None);
}

#[test]
fn identifiers_and_frames_are_printed_as_analysers_do() {
    assert_eq!(format!("{0} {0:?}", Id::standard(0x7F).unwrap()), "07F Id(07F)");
    assert_eq!(format!("{0} {0:?}", Id::extended(0x7F).unwrap()), "0000007F Id(0000007F)");
    let text = format!("{:?}", standard(0x1A2, &[0xDE]));
    assert_eq!(text, "Frame { id: Id(1A2), remote: false, length: 1, data: [222, 0, 0, 0, 0, 0, 0, 0] }");
}

/// Bit 31 of an identifier's number marks 29 bits.
#[test]
fn identifiers_are_kept_as_a_number() {
    for (number, id) in [
        (0, Id::standard(0)),
        (0x7FF, Id::standard(0x7FF)),
        (0x800, None),
        (0x1_0005, None),
        (0x7FFF_FFFF, None),
        (0x8000_0000, Id::extended(0)),
        (0x9FFF_FFFF, Id::extended(0x1FFF_FFFF)),
        (0xA000_0000, None),
    ] {
        assert_eq!(Id::try_from(number).ok(), id, "{number:x}");
        assert!(id.is_none_or(|id| u32::from(id) == number), "{number:x}");
    }
}

/// A stored frame that no controller could send is refused.
#[test]
fn a_frame_is_kept_without_anything_behind_its_data() {
    let kept = |remote: bool, length: u8, data: [u8; 8]| {
        let bytes = postcard::to_stdvec(&(5_u32, remote, length, data)).unwrap();
        postcard::from_bytes::<Frame>(&bytes).ok()
    };
    let two = [1, 2, 0, 0, 0, 0, 0, 0];
    assert_eq!(kept(false, 2, two), Some(standard(5, &[1, 2])));
    assert_eq!(kept(false, 8, two), Some(standard(5, &two)));
    assert_eq!(kept(false, 1, two), None);
    assert_eq!(kept(false, 9, [0; 8]), None);
    assert_eq!(kept(true, 8, [0; 8]), Frame::remote(Id::standard(5).unwrap(), 8));
    assert_eq!(kept(true, 8, two), None);
    assert_eq!(kept(true, 9, [0; 8]), None);
}

/// The smaller identifier wins and, if the first 11 bits are equal, the shorter one (ISO 11898-1).
#[test]
fn identifiers_sort_as_the_bus_arbitrates() {
    let order = [
        Id::standard(0).unwrap(),
        Id::extended(0).unwrap(),
        Id::extended(1).unwrap(),
        Id::standard(1).unwrap(),
        Id::extended(1 << 18).unwrap(),
        Id::standard(2).unwrap(),
    ];
    assert!(order.is_sorted() && order.iter().rev().is_sorted_by(|a, b| a > b));
}

#[test]
fn a_controller_is_off_the_bus_or_not() {
    for (error, is_off) in
        [(ErrorState::Active, false), (ErrorState::Passive, false), (ErrorState::BusOff, true)]
    {
        assert_eq!(BusState { error, ..BusState::default() }.is_off(), is_off);
    }
}
