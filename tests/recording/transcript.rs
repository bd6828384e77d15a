//! Tests of transcripts: the calls of nodes run again to the same answers, and damage is always detected.

use crate::support::container;
use narx_core::bus::{BusState, Frame, Id};
use narx_core::dictionary::Parameters;
use narx_core::eddycan::TxDriver;
use narx_core::motor::sense::front_end::Board;
use narx_core::node::{Identity, Node};
use narx_core::recording::transcript::{
    Answers, CALLS_VERSION, NodeCall, NodeSetup, Transcribable, Transcriber, Transcript, TxDriverCall,
    replay, replay_until,
};
use narx_core::recording::{
    CHUNK_BYTES, Kind, LABEL_MAX, MAGIC, ReadError, RecordError, Recording, ReplayError, header, replay_any,
    replay_any_until,
};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

type Buffer = heapless::Vec<u8, 8192>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

fn files() -> Vec<PathBuf> {
    let files = narx_lab::vectors::transcripts(root()).unwrap();
    assert!(files.len() >= 10, "{files:?}");
    files
}

fn setup() -> NodeSetup {
    NodeSetup::new(Identity::default(), Board::BENCH, Parameters::new())
}

/// Transcript of a node whose identity is requested after `quiet` ticks.
fn transcript(quiet: u64) -> Vec<u8> {
    let mut node = Node::power_up(setup()).unwrap();
    let mut transcriber = Transcriber::<Node, _>::new(Buffer::new(), 10_000, "identity", &setup()).unwrap();
    for now in 1..=quiet {
        transcriber.told(NodeCall::Poll(1)).unwrap();
        node.poll(now);
    }
    let ask = Frame::full(Id::extended(0x0AAD_5400).unwrap(), [0; 8]);
    transcriber.told(NodeCall::Frame(ask)).unwrap();
    node.handle_frame(&ask);
    while let Some(frame) = node.poll_frame() {
        transcriber.asked(NodeCall::PollFrame, &Some(frame)).unwrap();
    }
    transcriber.finish(&node).unwrap().to_vec()
}

#[test]
fn every_vector_of_a_node_replays() {
    let mut size = 0;
    for file in files() {
        let bytes = std::fs::read(&file).unwrap();
        size += bytes.len();
        let outcome = replay_any(&bytes).unwrap();
        assert!(outcome.is_identical() && outcome.ticks > 1000, "{}: {outcome:?}", file.display());
        // Replays of its parts lead to the whole.
        let whole = replay_any_until(&bytes, u64::MAX).unwrap();
        assert_eq!((whole.ticks, whole.digest), (outcome.ticks, outcome.digest), "{}", file.display());
        let part = replay_any_until(&bytes, outcome.ticks / 2).unwrap();
        assert_eq!(part.ticks, outcome.ticks / 2);
        assert_ne!(part.digest, outcome.digest);
    }
    assert!(size < 1_000_000, "{size} bytes");
}

/// A poll without an answer changes nothing: a transcript may therefore leave it out, and a shell may poll at
/// any rate.
#[test]
fn who_has_nothing_to_say_stays_the_same() {
    for file in files() {
        let bytes = std::fs::read(&file).unwrap();
        let transcript = Transcript::open(&bytes).unwrap();
        match transcript.header().kind {
            Kind::Node => visit::<Node>(&transcript, |node| {
                let polls: [fn(&mut Node) -> bool; 6] = [
                    |node| node.poll_frame().is_none(),
                    |node| node.poll_bulk_frame().is_none(),
                    |node| node.poll_event().is_none(),
                    |node| node.poll_storage().is_none(),
                    |node| node.poll_scope().is_none(),
                    |node| node.poll_action().is_none(),
                ];
                // Each poll by itself: the answer of another hides nothing.
                for (place, is_silent) in polls.into_iter().enumerate() {
                    let mut asked = node.clone();
                    assert!(!is_silent(&mut asked) || asked == *node, "{}: poll {place}", file.display());
                }
            }),
            Kind::TxDriver => visit::<TxDriver>(&transcript, |driver| {
                let polls: [fn(&mut TxDriver) -> bool; 3] = [
                    |driver| driver.poll_frame().is_none(),
                    |driver| driver.poll_store().is_none(),
                    |driver| !driver.take_reset(),
                ];
                for (place, is_silent) in polls.into_iter().enumerate() {
                    let mut asked = driver.clone();
                    assert!(!is_silent(&mut asked) || asked == *driver, "{}: poll {place}", file.display());
                }
            }),
            Kind::Drive => unreachable!("{}", file.display()),
        }
    }
}

/// Passes a device to `see` after each of a transcript's calls.
fn visit<D: Transcribable>(transcript: &Transcript<'_>, mut see: impl FnMut(&D)) {
    let mut device = transcript.power_up::<D>().unwrap();
    let (mut calls, mut clock, mut answers) = (transcript.calls::<D>(), 0, Answers::default());
    while let Some(call) = calls.read().unwrap() {
        device.call(call, &mut clock, &mut answers);
        see(&device);
    }
}

#[test]
fn a_call_that_is_made_again_is_counted_and_takes_no_room() {
    let [one, many] = [1, 1_000_000].map(transcript);
    assert!(many.len() <= one.len() + 8, "{} and {} bytes", one.len(), many.len());
    for (bytes, quiet) in [(one, 1), (many, 1_000_000)] {
        let outcome = replay_any(&bytes).unwrap();
        assert!(outcome.is_identical());
        assert!(outcome.ticks > quiet + 1, "{outcome:?}");
    }
}

/// An answer that differs changes the digest, and so does a missing one.
#[test]
fn another_answer_is_another_digest() {
    let mut node = Node::power_up(setup()).unwrap();
    let honest = replay_any(&transcript(1)).unwrap();
    for answer in [None, Some(Frame::full(Id::extended(0x1552_A800).unwrap(), [1; 8]))] {
        let mut liar = Transcriber::<Node, _>::new(Buffer::new(), 10_000, "identity", &setup()).unwrap();
        liar.told(NodeCall::Poll(1)).unwrap();
        liar.asked(NodeCall::PollFrame, &answer).unwrap();
        node.poll(1);
        let outcome = replay_any(&liar.finish(&node).unwrap()).unwrap();
        assert_eq!(outcome.is_identical(), answer == node.poll_frame(), "{outcome:?}");
        assert_ne!(outcome.digest, honest.digest);
    }
}

#[test]
fn a_transcript_says_what_it_is_of() {
    let bytes = transcript(1);
    let header = header(&bytes).unwrap();
    let found = (header.kind, header.layout_version, header.tick_rate, header.label);
    assert_eq!(found, (Kind::Node, CALLS_VERSION, 10_000, "identity"));
    assert_eq!(Recording::open(&bytes).unwrap_err(), ReadError::Kind { found: 2 });
    let file = Transcript::open(&bytes).unwrap();
    let wrong = replay::<TxDriver>(&file).unwrap_err();
    assert_eq!(wrong, ReplayError::Read(ReadError::Kind { found: 2 }));
    assert_eq!(wrong.to_string(), "recording of kind 2 (node), which is not replayed here");

    let drive = std::fs::read(root().join("tests/vectors/no-mode.narxrec")).unwrap();
    assert_eq!(Transcript::open(&drive).unwrap_err(), ReadError::Kind { found: 1 });
}

/// A node with other features is not replayed: another build's answers would not show a defect.
#[test]
fn a_node_with_other_features_is_not_replayed() {
    let other = NodeSetup { features: 0b0111, ..setup() };
    let node = Node::power_up(setup()).unwrap();
    let transcriber = Transcriber::<Node, _>::new(Buffer::new(), 10_000, "", &other).unwrap();
    let bytes = transcriber.finish(&node).unwrap();
    let refused = replay_any(&bytes).unwrap_err();
    assert_eq!(refused, ReplayError::Features { recorded: 0b0111, here: 0b1_1111 });
    let words = "recorded by a node with features 0x07, but this one has 0x1f (accelerometer 1, description 2, log 4, scope 8, recorder 16)";
    assert_eq!(refused.to_string(), words);
}

#[test]
fn what_does_not_fit_is_refused() {
    let label = "x".repeat(LABEL_MAX + 1);
    let refused = Transcriber::<Node, _>::new(Buffer::new(), 10_000, &label, &setup()).unwrap_err();
    assert_eq!(refused, RecordError::LabelTooLong);
    let mut small =
        Transcriber::<Node, heapless::Vec<u8, 1024>>::new(heapless::Vec::new(), 10_000, "", &setup())
            .unwrap();
    let mut calls = (1..).map(NodeCall::Poll);
    let full = calls.find_map(|call| small.told(call).err()).unwrap();
    assert!(matches!(full, RecordError::Sink(_)), "{full:?}");
}

/// Calls that no shell makes, with valid check values, are malformed.
#[test]
fn what_no_shell_does_is_malformed() {
    let good = transcript(3);
    let payload = |at: usize| {
        let length = usize::from(u16::from_le_bytes([good[at + 1], good[at + 2]]));
        (&good[at + 3..at + 3 + length], at + 3 + length + 4)
    };
    let (header, at) = payload(MAGIC.len() + 1);
    let (setup, _) = payload(at);
    for (calls, expected) in [
        (&[0xff, 2][..], "a call that can be repeated"),
        (&[10, 1, 0xff, 0], "a call that can be repeated"),
        (&[10, 1, 0xff, 0x80], "how often a call is repeated"),
        (&[0x7f], "a call that this device knows"),
        (&[10], "a call that this device knows"),
    ] {
        let file = container(&[(b'H', header), (b'S', setup), (b'C', calls)]);
        let refused = replay_any(&file).unwrap_err();
        let ReplayError::Read(ReadError::Malformed { expected: found, .. }) = refused else {
            panic!("{calls:?}: {refused:?}");
        };
        assert_eq!(found, expected, "{calls:?}");
    }
    let end = [2_u64.to_le_bytes(), [0; 8]].concat();
    let file = container(&[(b'H', header), (b'S', setup), (b'C', &[10, 1]), (b'E', &end)]);
    let refused = ReadError::TickCount { stored: 2, read: 1 };
    assert_eq!(replay_any(&file).unwrap_err(), ReplayError::Read(refused));
}

proptest! {
    /// A changed byte gives an error, and never other calls.
    #[test]
    fn a_damaged_transcript_is_refused(at in any::<prop::sample::Index>(), flip in 1..=u8::MAX) {
        let mut bytes = transcript(10);
        let at = at.index(bytes.len());
        bytes[at] ^= flip;
        prop_assert!(replay_any(&bytes).is_err());
    }

    #[test]
    fn a_transcript_that_is_cut_is_refused(keep in any::<prop::sample::Index>()) {
        let bytes = transcript(10);
        prop_assert!(replay_any(&bytes[..keep.index(bytes.len())]).is_err());
    }

    /// All calls that a shell can make are read as they were written.
    #[test]
    fn calls_are_read_as_they_were_written(seed in prop::collection::vec((0..6_u8, any::<u64>()), 0..200)) {
        let calls: Vec<NodeCall> = seed.iter().map(|(what, value)| match what {
            0 => NodeCall::Poll(*value),
            1 => NodeCall::BusState(BusState { transmit_errors: *value as u16, ..BusState::default() }),
            2 => NodeCall::PollFrame,
            3 => NodeCall::Frame(Frame::full(Id::extended(*value as u32 & 0x1fff_ffff).unwrap(), value.to_be_bytes())),
            _ => NodeCall::PollStorage,
        }).collect();
        let bytes = written(&calls);
        let transcript = Transcript::open(&bytes).unwrap();
        let mut reader = transcript.calls::<Node>();
        for call in &calls {
            prop_assert_eq!(reader.read().unwrap(), Some(call));
        }
        // At every further call.
        prop_assert_eq!(reader.read().unwrap(), None);
        prop_assert_eq!(reader.read().unwrap(), None);
    }
}

type Vecs = narx_sim::recording::RecordingBuffer;

/// Transcript of calls without answers.
fn written(calls: &[NodeCall]) -> Vec<u8> {
    let mut transcriber = Transcriber::<Node, Vecs>::new(Vecs::default(), 1, "", &setup()).unwrap();
    for call in calls {
        transcriber.told(call.clone()).unwrap();
    }
    transcriber.finish(&Node::power_up(setup()).unwrap()).unwrap().0
}

/// A chunk may be full before a call, or between a call and the three bytes with its number of repetitions,
/// or anywhere within these.
#[test]
fn a_chunk_may_end_anywhere() {
    for filled in CHUNK_BYTES - 6..=CHUNK_BYTES + 2 {
        // Calls of two bytes, after one of three where the number is odd.
        let odd = filled % 2;
        let longer = std::iter::repeat_n(NodeCall::Poll(200), odd);
        let others = (0..filled / 2 - odd).map(|place| NodeCall::Poll(1 + place as u64 % 2));
        let mut calls: Vec<NodeCall> = longer.chain(others).collect();
        let last = calls[calls.len() - 1].clone();
        calls.extend(std::iter::repeat_n(last, 300));
        calls.push(NodeCall::PollFrame);
        let bytes = written(&calls);
        let transcript = Transcript::open(&bytes).unwrap();
        let mut reader = transcript.calls::<Node>();
        let read: Vec<NodeCall> = std::iter::from_fn(|| reader.read().unwrap().cloned()).collect();
        assert!(read == calls, "{filled} bytes before the count");
    }
}

/// A TX-Driver at rest takes no room, either: a sample and the time are one call, which is repeated.
#[test]
fn a_tx_driver_at_rest_takes_no_room() {
    let file = files().into_iter().find(|file| file.ends_with("tx-driver-configuration.narxrec")).unwrap();
    let bytes = std::fs::read(file).unwrap();
    let transcript = Transcript::open(&bytes).unwrap();
    let outcome = replay::<TxDriver>(&transcript).unwrap();
    assert!(outcome.ticks > 25_000 && bytes.len() < 20_000, "{} bytes, {outcome:?}", bytes.len());
    let mut calls = transcript.calls::<TxDriver>();
    let first = calls.read().unwrap().cloned();
    assert!(matches!(first, Some(TxDriverCall::SampleAndPoll(..))), "{first:?}");
    assert_eq!(replay_until::<TxDriver>(&transcript, 3).unwrap().ticks, 3);
}
