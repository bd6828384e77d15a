//! Tests that written data are read back.

use super::support::{Noise, record, tick, turning};
use narx_core::motor::{PwmCommand, Samples};
use narx_core::recording::{Full, Header, LABEL_MAX, RecordError, Recorder, Recording, Tick};
use narx_sim::recording::RecordingBuffer;
use proptest::prelude::*;

proptest! {
    #[test]
    fn any_ticks(
        ticks in prop::collection::vec(tick(), 0..200),
        state in prop::collection::vec(any::<u8>(), 0..3_000),
        rate: u32,
        label in "\\PC{0,16}",
    ) {
        let header = Header::drive(rate, &label);
        let file = record(&header, &state, &ticks);
        let recording = Recording::open(&file).unwrap();
        prop_assert_eq!(recording.header(), &header);
        prop_assert_eq!(recording.state(), &state[..]);
        prop_assert!(recording.same_behaviour());
        let read: Vec<Tick> = recording.ticks().map(Result::unwrap).collect();
        prop_assert_eq!(&read, &ticks);
        prop_assert_eq!(recording.verify().unwrap().ticks, ticks.len() as u64);
    }
}

/// A recording without a tick is valid, too.
#[test]
fn a_recording_may_be_empty() {
    let header = Header::drive(10_000, "empty");
    let file = record(&header, &[1, 2, 3], &[]);
    let recording = Recording::open(&file).unwrap();
    assert_eq!((recording.header(), recording.state()), (&header, &[1, 2, 3][..]));
    assert_eq!(recording.ticks().count(), 0);
    assert_eq!(recording.verify().unwrap().ticks, 0);
}

#[test]
fn noisy_codes_stay_under_twelve_bytes_a_tick() {
    let ticks = turning(30_000, &mut Noise(1));
    let file = record(&Header::drive(10_000, "size"), &[], &ticks);
    let per_tick = file.len() as f64 / ticks.len() as f64;
    println!("{} ticks: {} bytes, {per_tick:.2} a tick", ticks.len(), file.len());
    assert!(per_tick <= 12.0, "{per_tick}");
    let read: Vec<Tick> = Recording::open(&file).unwrap().ticks().map(Result::unwrap).collect();
    assert!(read == ticks);
}

#[test]
fn what_does_not_fit_is_refused() {
    let header = Header::drive(10_000, "");
    let long = "x".repeat(LABEL_MAX + 1);
    let refused = Recorder::new(RecordingBuffer::default(), &Header { label: &long, ..header }, &[]);
    assert!(matches!(refused, Err(RecordError::LabelTooLong)));
    // A length of 256 + 10 must not be taken for 10.
    let longer = "x".repeat(266);
    let refused = Recorder::new(RecordingBuffer::default(), &Header { label: &longer, ..header }, &[]);
    assert!(matches!(refused, Err(RecordError::LabelTooLong)));
    let refused = Recorder::new(RecordingBuffer::default(), &header, &[0; 65_536]);
    assert!(matches!(refused, Err(RecordError::StateTooLong)));
    assert!(Recorder::new(RecordingBuffer::default(), &header, &[0; 65_535]).is_ok());
    let fits = Header { label: &"x".repeat(LABEL_MAX), ..header };
    assert!(Recorder::new(RecordingBuffer::default(), &fits, &[]).is_ok());
}

#[test]
fn a_full_sink_says_so() {
    let mut recorder =
        Recorder::new(heapless::Vec::<u8, 64>::new(), &Header::drive(10_000, ""), &[]).unwrap();
    for tick in 0..20 {
        // One tick each stays in the unfinished chunk: the sink is only called when that is full.
        let samples = Samples { tick, bus_voltage: tick as u16, ..Samples::default() };
        recorder.record(None, &samples, &PwmCommand::default(), None).unwrap();
    }
    assert_eq!(recorder.finish().unwrap_err(), RecordError::Sink(Full));
}
