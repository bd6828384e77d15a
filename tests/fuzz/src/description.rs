//! Target: the drive's description as a master reads it: any bytes, or the real document with some of its
//! bytes changed.

use crate::program::Program;
use narx_core::bus::narmotion::Addresses;
use narx_core::description::Document;
use narx_core::dictionary::PARAMETER_COUNT;
use narx_core::master::{Described, DescribedParameter, DescriptionError, DescriptionReader, Reason};
use narx_core::node::Identity;
use std::sync::LazyLock;

static DOCUMENT: LazyLock<String> = LazyLock::new(|| {
    let mut text = String::new();
    let document =
        Document { identity: Identity::default(), addresses: Addresses::FACTORY, tick_rate: 10_000 };
    document.write(&mut text).expect("a string has room");
    text
});

/// Runs an input. First byte even: the text. Odd: changes of the real document, each with a position, a
/// number of bytes, and the bytes that replace them.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    if program.byte().is_multiple_of(2) {
        let (_, _) = read(program.0);
        return;
    }
    let mut text = DOCUMENT.clone().into_bytes();
    let unchanged = program.is_over();
    while !program.is_over() {
        let at = usize::from(program.word()) % text.len();
        let removed = usize::from(program.byte()).min(text.len() - at);
        let length = program.byte() % 8;
        let inserted = program.take(length.into());
        text.splice(at..at + removed, inserted.iter().copied());
        // A document is never empty.
        text.push(b'\n');
    }
    let (parameters, end) = read(&text);
    if unchanged {
        assert_eq!((parameters.len(), end), (PARAMETER_COUNT, Ok(())));
    }
}

/// Reads a text; checks that every row is usable, that an error is final, and that its position is the
/// reader's.
fn read(text: &[u8]) -> (Vec<DescribedParameter>, Result<(), DescriptionError>) {
    let mut reader = DescriptionReader::new();
    let mut parameters = Vec::new();
    for (place, byte) in text.iter().enumerate() {
        match reader.handle_byte(*byte) {
            Ok(Some(Described::Parameter(parameter))) => {
                check(&parameter);
                parameters.push(parameter);
            }
            Ok(Some(Described::Field(field))) => {
                assert!((1..=48).contains(&field.bits) && field.first_bit + field.bits <= 64);
                assert!((-18..=18).contains(&field.exponent));
            }
            Ok(Some(Described::Signal(signal))) => assert!(signal.bit < 32 && signal.base.digits > 0),
            Ok(Some(Described::Category(_)) | None) => {}
            Err(error) => {
                let lines = text[..place].iter().filter(|byte| **byte == b'\n').count();
                assert_eq!((error.byte as usize, error.line as usize), (place, lines + 1));
                assert_eq!(reader.handle_byte(b'>'), Err(error));
                assert_eq!(reader.finish(), Err(error));
                return (parameters, Err(error));
            }
        }
    }
    let end = reader.finish();
    assert!(
        end.is_ok_and(|()| !text.is_empty()) || end.is_err_and(|error| error.reason == Reason::Incomplete)
    );
    (parameters, end)
}

fn check(parameter: &DescribedParameter) {
    let DescribedParameter { kind, exponent, min, max, default, .. } = *parameter;
    assert!(kind.smallest() <= min && min <= default && default <= max && max <= kind.largest());
    assert!((-18..=18).contains(&exponent));
    for value in [min, default, max] {
        let raw = value as i32;
        assert!(parameter.accepts(raw), "{value}");
        assert_eq!(parameter.engineering(raw).rescaled(exponent), Some(value));
    }
}
