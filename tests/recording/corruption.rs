//! Tests that every truncation and every changed byte is detected, and that no wrong tick is returned before.

use super::support::{Noise, record, turning};
use narx_core::recording::{Header, ReadError, Recording, Tick};

/// Ticks up to the first error, and that error.
fn read(file: &[u8]) -> (Vec<Tick>, Option<ReadError>) {
    let recording = match Recording::open(file) {
        Ok(recording) => recording,
        Err(error) => return (Vec::new(), Some(error)),
    };
    let mut ticks = Vec::new();
    let mut reader = recording.ticks();
    let error = loop {
        match reader.next() {
            Some(Ok(tick)) => ticks.push(tick),
            Some(Err(error)) => break Some(error),
            None => break None,
        }
    };
    assert_eq!(reader.next(), None, "nothing follows, neither an end nor an error");
    assert_eq!(reader.end().is_some(), error.is_none());
    (ticks, error)
}

fn sample_file() -> (Vec<u8>, Vec<Tick>) {
    // Noise of 12 bits: about 10 bytes per tick, so two chunks.
    let ticks = turning(170, &mut Noise(3));
    let file = record(&Header::drive(10_000, "damaged on purpose"), &[7; 40], &ticks);
    assert!(file.len() > 1_200, "{}", file.len());
    assert_eq!(read(&file), (ticks.clone(), None));
    (file, ticks)
}

#[test]
fn every_truncation() {
    let (file, ticks) = sample_file();
    for length in 0..file.len() {
        let (read, error) = read(&file[..length]);
        assert!(
            matches!(error, Some(ReadError::Truncated { at, .. }) if at == length),
            "{length}: {error:?}"
        );
        assert!(ticks.starts_with(&read), "{length}");
    }
}

#[test]
fn every_changed_byte() {
    let (mut file, ticks) = sample_file();
    for at in 0..file.len() {
        for change in 1..=255 {
            file[at] ^= change;
            let (read, error) = read(&file);
            assert!(error.is_some(), "byte {at} ^ {change:#x}");
            assert!(ticks.starts_with(&read), "byte {at} ^ {change:#x}");
            file[at] ^= change;
        }
    }
}

#[test]
fn chunks_lost_repeated_or_exchanged() {
    let ticks = turning(600, &mut Noise(4));
    let file = record(&Header::drive(10_000, ""), &[], &ticks);
    // Begins of the chunks.
    let mut starts = vec![9];
    while *starts.last().unwrap() < file.len() {
        let at = *starts.last().unwrap();
        starts.push(at + 7 + usize::from(u16::from_le_bytes([file[at + 1], file[at + 2]])));
    }
    let chunk = |k: usize| &file[starts[k]..starts[k + 1]];
    let chunks = starts.len() - 1;
    assert!(chunks >= 6, "{chunks}");
    let build = |order: &[usize]| {
        let body: Vec<&[u8]> = order.iter().map(|&k| chunk(k)).collect();
        [&file[..9], &body.concat()].concat()
    };
    let whole: Vec<usize> = (0..chunks).collect();
    assert_eq!(build(&whole), file);
    for k in 0..chunks {
        let mut lost = whole.clone();
        lost.remove(k);
        let mut repeated = whole.clone();
        repeated.insert(k, k);
        let mut exchanged = whole.clone();
        exchanged.swap(k, (k + 1) % chunks);
        for order in [lost, repeated, exchanged] {
            let (read, error) = read(&build(&order));
            assert!(error.is_some(), "{order:?}");
            assert!(ticks.starts_with(&read), "{order:?}");
        }
    }
}

#[test]
fn errors_name_the_place() {
    let (mut file, _) = sample_file();
    let (_, error) = read(&file[..100]);
    assert_eq!(
        error.unwrap().to_string(),
        "truncated: the file ends at byte 100, expected the whole of a chunk"
    );
    file[60] ^= 1;
    let (_, error) = read(&file);
    let message = error.unwrap().to_string();
    assert!(message.starts_with("corrupt: the check value at byte 87 is "), "{message}");
}
