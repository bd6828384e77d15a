//! The control tick: every conformance vector replays to its digest.

use narx_core::recording::replay_any;
use std::fs;
use std::path::Path;

/// The vectors that most changes of the tick disturb, so that most mutants are noticed within a second.
const FIRST: [&str; 6] = [
    "sensorless-forward",
    "hall-forward",
    "sensorless-reversal",
    "sensorless-flying-start",
    "hall-reversal",
    "open-loop-reversal",
];

#[test]
fn every_vector_replays() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vectors");
    let mut names: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .filter_map(|entry| entry.unwrap().file_name().to_str()?.strip_suffix(".narxrec").map(str::to_string))
        .collect();
    names.sort_by_key(|name| (!FIRST.contains(&name.as_str()), name.clone()));
    assert!(names.len() >= 50 && FIRST.iter().all(|first| names.iter().any(|name| name == first)));
    for name in names {
        let file = fs::read(folder.join(format!("{name}.narxrec"))).unwrap();
        let outcome = replay_any(&file).unwrap();
        assert_eq!(outcome.digest, outcome.recorded_digest, "{name}");
    }
}
