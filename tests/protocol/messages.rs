//! Tests of the table of messages and fields against the decoders, which were written without it.

use narx_core::bus::narmotion::{Addresses, MESSAGES, Meaning, Message, NAMES, Words};
use narx_generate::decoded;
use narx_sim::random::Random;

#[test]
fn fields_are_where_the_decoders_read_them() {
    let mut random = Random::new(3);
    for message in &MESSAGES {
        for _ in 0..300 {
            let mut frame = decoded::random_frame(message, &mut || random.bits());
            if message.name == "REBOOT" {
                // The only valid acknowledgement.
                frame = Words([1, 0, 0, 0]).frame(message.id(Addresses::FACTORY));
            }
            let words = Words::of(&frame).unwrap().1;
            let table: Vec<_> = message.fields().map(|field| (field.name, field.raw(words))).collect();
            let read = decoded::values(message, &frame);
            assert_eq!(read, Ok(table), "{} {frame:?}", message.name);
        }
    }
}

#[test]
fn fields_follow_each_other_without_overlap() {
    for message in &MESSAGES {
        let mut end = 0;
        for field in message.fields() {
            assert!(field.bits > 0 && field.first_bit >= end, "{} {}", message.name, field.name);
            end = field.first_bit + field.bits;
            assert!(end <= 64);
            if let Meaning::Named(names) = field.meaning {
                assert!(NAMES.contains(&names), "{}", names.of);
                assert!(names.values.iter().all(|(value, _)| u64::from(*value) < 1 << field.bits));
            }
        }
    }
}

#[test]
fn what_is_put_into_the_fields_is_the_frame() {
    let mut random = Random::new(4);
    for message in &MESSAGES {
        let frame = decoded::random_frame(message, &mut || random.bits());
        let words = Words::of(&frame).unwrap().1;
        let mut put = Words::default();
        for field in message.fields() {
            let before = put;
            let beyond = if field.signed { 1_i64 << (field.bits - 1) } else { 1 << field.bits };
            for raw in [beyond, -beyond - 1, i64::MAX, i64::MIN] {
                assert!(field.put(raw, &mut put).is_err(), "{} {raw}", field.name);
            }
            assert_eq!(put, before, "{}", field.name);
            assert_eq!(field.put(field.raw(words), &mut put), Ok(()), "{}", field.name);
        }
        assert_eq!(put, words, "{}", message.name);
        assert_eq!(Message::of(message.id(Addresses::FACTORY)), Some(message));
    }
}
