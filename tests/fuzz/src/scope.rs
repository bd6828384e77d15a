//! Target: inputs of ticks as the scope records them and a master downloads them.

use crate::program::Program;
use crate::real;
use narx_core::motor::Drive;
use narx_core::recording::{Recording, record_scoped, replay};
use narx_core::scope::Inputs;
use narx_sim::recording::RecordingBuffer;

/// Runs an input. First byte even: the words. Odd: a real download with changed inputs, each change a
/// position and a word.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    if program.byte().is_multiple_of(2) {
        open(&words(program.0));
        return;
    }
    let mut words = real::scoped().to_vec();
    let inputs = inputs(&words);
    let unchanged = program.is_over();
    while !program.is_over() {
        let places: usize = inputs.iter().map(|range| range.len()).sum();
        let mut place = usize::from(program.word()) % places;
        for range in &inputs {
            if place < range.len() {
                words[range.start + place] ^= program.word();
                break;
            }
            place -= range.len();
        }
    }
    open(&words);
    // A record that can be read is run, and that run is a recording like any other.
    let made = record_scoped(&words, "changed", RecordingBuffer::default());
    assert!(made.is_ok() || !unchanged);
    if let Ok(scoped) = made {
        assert!(!unchanged || scoped.agrees == Some(true));
        let recording = Recording::open(&scoped.sink.0).expect("our own");
        let outcome = replay::<Drive>(&recording).expect("our own");
        assert!(outcome.is_identical());
        assert_eq!(outcome.ticks, scoped.ticks);
    }
}

fn words(bytes: &[u8]) -> Vec<u16> {
    bytes.as_chunks::<2>().0.iter().map(|pair| u16::from_le_bytes(*pair)).collect()
}

/// Opens a record. It must have as many ticks as it states, up to the first invalid one.
fn open(words: &[u16]) {
    let Ok(inputs) = Inputs::open(words) else { return };
    let segments: Vec<_> = inputs.segments().collect();
    assert!(matches!(segments.len(), 1..=2));
    for segment in segments {
        assert!(segment.state().count() <= 2 * words.len());
        let ticks = segment.ticks().take_while(Result::is_ok).count();
        assert!(ticks <= usize::from(segment.ticks));
        let again: Vec<_> = segment.ticks().collect();
        assert_eq!(again.len(), usize::from(segment.ticks));
        assert!(again[..ticks].iter().all(Result::is_ok));
    }
}

/// Ranges of the inputs in the words of a download: after its head of 6 words, and in each segment after 7
/// words and the state (`core/src/scope/read.rs`).
fn inputs(words: &[u16]) -> Vec<core::ops::Range<usize>> {
    let mut ranges = Vec::new();
    let mut at = 6;
    for _ in 0..words[5] {
        let (state, length) = (usize::from(words[at + 5]).div_ceil(2), usize::from(words[at + 6]));
        let start = at + 7 + state;
        ranges.push(start..start + length);
        at = start + length;
    }
    ranges
}
