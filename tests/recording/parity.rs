//! Tests of the table vectors x targets: it detects a target with another control core, and locates the
//! difference.

use narx_core::motor::machine::event::{Event, Status};
use narx_core::motor::{Drive, PwmCommand, Samples};
use narx_core::recording::{Recording, Replayable, replay, replay_until};
use narx_core::units::Duty;
use narx_lab::conformance::{Answer, Covered, Native, Random, Replay, Set, compare, locate};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The drive on a target with one wrong bit in one output from its tick 3000 on.
#[derive(Deserialize)]
struct Faulty<const STATUS: bool>(Drive);

const WRONG_FROM: u64 = 3_000;

impl<const STATUS: bool> Replayable for Faulty<STATUS> {
    fn handle_event(&mut self, event: Event) {
        self.0.handle_event(event);
    }
    fn step(&mut self, samples: &Samples) -> PwmCommand {
        let mut command = self.0.step(samples);
        if !STATUS && samples.tick >= WRONG_FROM {
            command.duty = Duty::from_bits(command.duty.to_bits() ^ 1);
        }
        command
    }
    fn poll_status(&mut self) -> Option<Status> {
        let mut status = self.0.poll_status()?;
        if STATUS && status.tick >= WRONG_FROM {
            status.sectors ^= 1;
        }
        Some(status)
    }
}

impl<const STATUS: bool> Replay for Faulty<STATUS> {
    fn name(&self) -> &str {
        "faulty"
    }
    fn replay(&self, files: &[PathBuf], ticks: Option<u64>) -> Vec<Result<Answer, String>> {
        files
            .iter()
            .map(|file| {
                let bytes = std::fs::read(file).unwrap();
                let recording = Recording::open(&bytes).unwrap();
                let whole = replay::<Self>(&recording).unwrap();
                let prefix = replay_until::<Self>(&recording, ticks.unwrap_or(whole.ticks)).unwrap();
                let outputs = ticks.and(prefix.last).map(|outputs| outputs.to_string());
                let recorded = ticks.is_none().then_some(whole.recorded_digest);
                Ok(Answer { ticks: prefix.ticks, digest: prefix.digest, recorded, outputs })
            })
            .collect()
    }
}

/// A target that does not even start.
struct Broken;

impl Replay for Broken {
    fn name(&self) -> &str {
        "broken"
    }
    fn replay(&self, files: &[PathBuf], _: Option<u64>) -> Vec<Result<Answer, String>> {
        files.iter().map(|_| Err("did not start".into())).collect()
    }
}

fn vectors() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    narx_lab::vectors::recordings(root).unwrap()
}

fn faulty<const STATUS: bool>() -> Faulty<STATUS> {
    Faulty(Drive::new(narx_core::motor::Coefficients::default()))
}

#[test]
fn the_first_tick_and_output_that_differ_are_named() {
    let file = &vectors()[0];
    let command = locate(&Native, &faulty::<false>(), file).unwrap().unwrap();
    assert_eq!((command.ticks, command.tick.as_str()), (WRONG_FROM + 1, "tick 3000"));
    assert!(command.found.starts_with("duty ") && command.expected.starts_with("duty "), "{command}");
    assert_ne!(command.found, command.expected);

    let status = locate(&Native, &faulty::<true>(), file).unwrap().unwrap();
    // Reports come every millisecond: the first one at or after the tick.
    assert!((WRONG_FROM + 1..WRONG_FROM + 12).contains(&status.ticks), "{status}");
    assert!(status.found.starts_with("status.sectors "), "{status}");

    assert_eq!(locate(&Native, &Native, file), Ok(None));
}

#[test]
fn the_table_is_green_only_if_every_target_is_the_same() {
    let files = &vectors()[..2];
    let closing = compare(&[&Native, &Native], files).unwrap();
    assert_eq!(closing, ["4 digests equal: 2 vectors x 2 targets"]);
    let wrong = compare(&[&Native, &faulty::<false>()], files).unwrap_err();
    assert_eq!(wrong.lines().count(), 2, "{wrong}");
    assert!(wrong.lines().all(|line| line.contains("faulty: differs first in tick 3000")), "{wrong}");
    let wrong = compare(&[&Native, &Broken], &files[..1]).unwrap_err();
    assert!(wrong.ends_with("broken: did not start"), "{wrong}");
}

#[test]
fn a_set_counts_the_digests_of_each_target() {
    let files = &vectors()[..2];
    let set = Set::of("vectors", &[&Native, &Native], files).unwrap();
    assert_eq!((set.recordings, set.equal.as_slice()), (2, [2, 2].as_slice()));
    let ticks =
        |file: &PathBuf| Recording::open(&std::fs::read(file).unwrap()).unwrap().verify().unwrap().ticks;
    assert_eq!(set.ticks, files.iter().map(ticks).sum::<u64>());
    let wrong = Set::of("vectors", &[&Native, &faulty::<false>()], files).unwrap_err();
    assert!(wrong.contains("faulty: differs first in tick 3000"), "{wrong}");
}

/// The vectors contain every state and every transition.
#[test]
fn what_the_vectors_cover_is_counted() {
    let all = vectors().into_iter().map(|file| Covered::of(&std::fs::read(file).unwrap()));
    let covered = all.fold(Covered::default(), Covered::and);
    assert_eq!(covered.states.values().sum::<u64>(), covered.ticks);
    assert!(covered.states.values().all(|ticks| *ticks > 0), "{:?}", covered.states);
    let missing: Vec<&String> =
        covered.transitions.iter().filter(|(_, times)| **times == 0).map(|(name, _)| name).collect();
    assert!(missing.is_empty(), "{missing:?}");
    assert_eq!(Covered::of(b"narxrec\n"), Covered::default());
}

#[test]
fn recordings_that_nobody_has_chosen_have_every_state_and_find_the_faulty_one() {
    let random = Random { count: 100, first: 7_000_001, ticks: 20_000 };
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("random-parity");
    let closing = random.compare(&[&Native, &Native], &directory).unwrap();
    assert!(closing[0].starts_with("202 digests equal: 101 recordings"), "{closing:?}");
    // A window begins in the middle of a drive's operation.
    let file = directory.join("random-0050.narxrec");
    let window =
        replay_until::<Drive>(&Recording::open(&std::fs::read(&file).unwrap()).unwrap(), 20).unwrap();
    assert!(window.last.unwrap().status.is_none_or(|status| status.tick > 20));
    let wrong = compare(&[&Native, &faulty::<false>()], &[directory.join("long.narxrec")]).unwrap_err();
    assert!(wrong.contains("faulty: differs first in tick 3000"), "{wrong}");
}

#[test]
fn lines_of_replayers_are_read_strictly() {
    let whole = Answer::parse("a", "a 12 00000000000000ff 0123456789abcdef").unwrap();
    assert_eq!(
        whole,
        Answer { ticks: 12, digest: 255, recorded: Some(0x0123_4567_89ab_cdef), outputs: None }
    );
    let part = Answer::parse("a", "a 12 00000000000000ff - tick 11: duty 3, step 0").unwrap();
    assert_eq!((part.recorded, part.outputs.as_deref()), (None, Some("tick 11: duty 3, step 0")));
    assert_eq!(Answer::parse("a", "a error no such file").unwrap_err(), "no such file");
    for line in
        ["", "a", "b 12 00000000000000ff -", "a 12 ff -", "a x 00000000000000ff -", "a 12 00000000000000ff"]
    {
        assert!(Answer::parse("a", line).unwrap_err().contains("not an answer"), "{line:?}");
    }
}
