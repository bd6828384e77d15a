//! Tests of frame bits against vectors worked by hand, an independent encoder, and the known worst cases.

use crate::frames::{extended, standard};
use narx_core::bus::{Frame, Id};
use narx_sim::can::{WireBits, frame_bits, worst_case_bits};
use proptest::prelude::*;

fn text(bits: impl Iterator<Item = bool>) -> String {
    bits.map(|bit| if bit { '1' } else { '0' }).collect()
}

/// Encodes a frame field by field as text, with the CRC by polynomial division on the text, and stuffing by
/// replacing runs; returns it without and with stuff bits.
fn by_text(frame: &Frame) -> (String, String) {
    let rtr = if frame.is_remote() { "1" } else { "0" };
    let head = match frame.id() {
        Id::Standard { raw: id, .. } => format!("0{id:011b}{rtr}00"),
        Id::Extended { raw: id, .. } => {
            let id = format!("{id:029b}");
            format!("0{}11{}{rtr}00", &id[..11], &id[11..])
        }
    };
    let data: String = frame.payload().iter().map(|byte| format!("{byte:08b}")).collect();
    let body = format!("{head}{:04b}{data}", frame.dlc());
    let unstuffed = format!("{body}{}", remainder(&body));
    let mut stuffed = String::new();
    for bit in unstuffed.chars() {
        stuffed.push(bit);
        if stuffed.ends_with("00000") {
            stuffed.push('1');
        } else if stuffed.ends_with("11111") {
            stuffed.push('0');
        }
    }
    // CRC delimiter, acknowledgement, its delimiter, end of frame.
    (unstuffed, stuffed + "101" + "1111111")
}

/// Remainder of `bits` x^15 divided by the CRC-15 generator, by long division on the digits.
fn remainder(bits: &str) -> String {
    let generator = b"1100010110011001";
    let mut work: Vec<u8> = bits.bytes().chain([b'0'; 15]).collect();
    for start in 0..bits.len() {
        if work[start] == b'1' {
            for (digit, divisor) in work[start..].iter_mut().zip(generator) {
                *digit = if *digit == *divisor { b'0' } else { b'1' };
            }
        }
    }
    String::from_utf8(work[bits.len()..].to_vec()).unwrap()
}

#[test]
fn worked_by_hand() {
    // Identifier 0, no data: 19 zeros, whose CRC is 0. That makes 34 zeros: a stuff bit comes after 5, then
    // each stuff bit is followed by five zeros: after 5, 10, 15, 20, 25 and 30 zeros.
    let zero = standard(0, &[]);
    let wire = WireBits::new(&zero);
    assert_eq!(text(wire.unstuffed()), "0".repeat(34));
    assert_eq!(wire.stuff_bits(), 6);
    assert_eq!(text(wire.on_wire()), "000001".repeat(6) + "0000" + "1011111111");
    assert_eq!(frame_bits(&zero), 47 + 6);

    // One bit set at the end, DLC 1 and a data byte 0: the remainder of x^8 x^15 by hand takes 23 - 15 = 8
    // steps. The generator is x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1 = 0x4599 below x^15; doubling it
    // modulo itself gives: 4599, 4eab, 58cf, 7407, 2d97, 5b2e, 73c5, 2213, 4426.
    let wire = WireBits::new(&standard(0, &[0]));
    assert!(text(wire.unstuffed()).ends_with(&format!("0001{:08b}{:015b}", 0, 0x4426)));
}

#[test]
fn drive_request_of_the_specification() {
    // 0AAD5202 # 00 00 00 01 00 00 00 00 on the bus at 500 kbit/s.
    let frame = extended(0x0AAD_5202, &[0, 0, 0, 1, 0, 0, 0, 0]);
    let (_, stuffed) = by_text(&frame);
    assert_eq!(text(WireBits::new(&frame).on_wire()), stuffed);
    assert_eq!(frame_bits(&frame), stuffed.len() as u32 + 3);
    println!("{} bits, {} us", frame_bits(&frame), 2 * frame_bits(&frame));
}

fn frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0..1u16 << 11).prop_map(|id| Id::standard(id).unwrap()),
        (0..1u32 << 29).prop_map(|id| Id::extended(id).unwrap()),
    ];
    // Bytes with long runs of equal bits, so that stuffing is dense.
    let byte = prop_oneof![any::<u8>(), Just(0), Just(0xff), Just(0xf0), Just(0x0f), Just(0x78), Just(0x87)];
    let content = (any::<bool>(), prop::collection::vec(byte, 0..=8));
    (id, content).prop_map(|(id, (remote, data))| {
        if remote { Frame::remote(id, data.len() as u8).unwrap() } else { Frame::data(id, &data).unwrap() }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]
    #[test]
    fn agrees_with_an_independent_encoder(frame in frame()) {
        let (unstuffed, stuffed) = by_text(&frame);
        let wire = WireBits::new(&frame);
        prop_assert_eq!(text(wire.unstuffed()), unstuffed);
        prop_assert_eq!(text(wire.on_wire()), &stuffed[..]);
        prop_assert_eq!(frame_bits(&frame), stuffed.len() as u32 + 3);
        prop_assert_eq!(wire.crc15(), 0);
    }

    #[test]
    fn never_longer_than_the_worst_case(frame in frame()) {
        let extended = matches!(frame.id(), Id::Extended { .. });
        let bytes = frame.payload().len() as u8;
        prop_assert!(frame_bits(&frame) <= worst_case_bits(extended, bytes));
    }
}

#[test]
fn worst_case_formulas() {
    for n in 0..=8u32 {
        assert_eq!(worst_case_bits(true, n as u8), 67 + 8 * n + (53 + 8 * n) / 4);
        assert_eq!(worst_case_bits(false, n as u8), 47 + 8 * n + (33 + 8 * n) / 4);
    }
    assert_eq!(worst_case_bits(true, 8), 160);
    assert_eq!(worst_case_bits(false, 8), 135);
}

/// Length of the longest frame among those whose free bits change every four: after a stuff bit of one level
/// come four bits of that level, so that every fifth bit is a stuff bit. The CRC cannot be chosen; many
/// identifiers give many CRCs.
fn adversary(extended_id: bool, bytes: usize) -> u32 {
    let mut longest = 0;
    for id in 0..1u32 << 11 {
        for phase in 0..8 {
            let pattern = 0x0f0f_0f0f_0f0f_0f0fu64.rotate_left(phase);
            let data = pattern.to_be_bytes();
            let frame = if extended_id {
                extended(id << 18 | (pattern as u32 & 0x3_ffff), &data[..bytes])
            } else {
                standard(id as u16, &data[..bytes])
            };
            longest = longest.max(frame_bits(&frame));
        }
    }
    longest
}

#[test]
fn adversarial_frames_come_near_the_worst_case() {
    for (is_extended, bytes) in [(false, 8), (true, 8), (false, 4), (true, 4)] {
        let bound = worst_case_bits(is_extended, bytes as u8);
        let longest = adversary(is_extended, bytes);
        println!("extended {is_extended}, {bytes} bytes: longest found {longest} of {bound} bits");
        assert!(longest <= bound && longest + 4 >= bound, "{longest} of {bound}");
    }
}
