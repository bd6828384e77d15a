//! Target: transcripts. Any bytes as a file; and chunks of any calls with correct check values, which are
//! made to a node or a TX-Driver.

use crate::program::Program;
use crate::sound::Sound;
use narx_core::bus::eddycan::{Channels, Position};
use narx_core::dictionary::Parameters;
use narx_core::eddycan::{Configuration, MeasuringRange, TxDriver, Variant};
use narx_core::motor::sense::front_end::Board;
use narx_core::node::{Identity, Node};
use narx_core::recording::transcript::{
    Answers, CALLS_VERSION, NodeSetup, Transcribable, Transcriber, Transcript, TxDriverSetup,
};
use narx_core::recording::{BEHAVIOUR_VERSION, Kind, replay_any, replay_any_until};
use narx_sim::recording::RecordingBuffer;

/// Largest number of calls that are replayed: a file may contain far more.
const CALLS_MAX: u64 = 20_000;

/// Runs an input. First byte modulo 3: 0 for a file, 1 for calls of a node, 2 for calls of a TX-Driver.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    match program.byte() % 3 {
        0 => drop(replay_any_until(program.0, CALLS_MAX)),
        1 => calls::<Node>(&NodeSetup::new(Identity::default(), Board::BENCH, Parameters::new()), program.0),
        _ => calls::<TxDriver>(&tx_driver(), program.0),
    }
}

fn tx_driver() -> TxDriverSetup {
    let range = || MeasuringRange::new(Position::default(), Position::from_raw(1 << 28));
    let ranges = [range(), range()].map(|range| range.expect("its end lies beyond its start"));
    let variant = Variant { channels: Channels::Dual, ranges, sample_rate: 40_000, firmware: 1 };
    TxDriverSetup { variant, configuration: Configuration::new() }
}

/// Checks a chunk of calls: those that can be read are made; written again they are read as the same, and two
/// devices give the same answers.
fn calls<D: Transcribable<Call: Clone + core::fmt::Debug>>(setup: &D::Setup, payload: &[u8]) {
    let state = postcard::to_stdvec(setup).expect("memory is enough");
    let mut sound = Sound::begin();
    let [kind, label] = [D::KIND as u8, 0];
    let versions = [BEHAVIOUR_VERSION, CALLS_VERSION].map(u16::to_le_bytes).concat();
    sound.chunk(b'H', &[&[kind][..], &versions, &10_000_u32.to_le_bytes(), &[label]].concat());
    sound.chunk(b'S', &state);
    sound.chunk(b'C', &payload[..payload.len().min(u16::MAX.into())]);
    // Without its end chunk a file is never complete, however often a call is repeated.
    replay_any_until(&sound.file, CALLS_MAX).ok();

    let transcript = Transcript::open(&sound.file).expect("all check values are right");
    let mut device: D = transcript.power_up().expect("our own");
    let mut transcriber = Transcriber::<D, _>::new(RecordingBuffer::default(), 10_000, "", setup)
        .unwrap_or_else(|error| panic!("{error}"));
    let (mut reader, mut clock, mut answers) = (transcript.calls::<D>(), 0, Answers::default());
    let mut read = Vec::new();
    while (read.len() as u64) < CALLS_MAX
        && let Ok(Some(call)) = reader.read()
    {
        device.call(call, &mut clock, &mut answers);
        transcriber.told(call.clone()).unwrap_or_else(|error| panic!("{error}"));
        read.push(call.clone());
    }
    let again = transcriber.finish(&device).unwrap_or_else(|error| panic!("{error}")).0;
    device.show(&mut answers);
    let outcome = replay_any(&again).expect("our own");
    assert_eq!((outcome.ticks, outcome.digest), (read.len() as u64, answers.value()));
    let kept = Transcript::open(&again).expect("our own");
    let mut kept = kept.calls::<D>();
    for call in &read {
        assert!(kept.read().expect("our own") == Some(call), "{call:?}");
    }
    debug_assert_ne!(D::KIND, Kind::Drive);
}
