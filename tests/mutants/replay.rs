//! The control tick: every conformance vector replays to its digest.

use narx_core::recording::replay_any;
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn every_vector_replays() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vectors");
    let files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    let recordings: Vec<_> =
        files.iter().filter(|path| path.extension() == Some("narxrec".as_ref())).collect();
    assert!(recordings.len() >= 50, "{} vectors", recordings.len());
    for path in recordings {
        let outcome = replay_any(&fs::read(path).unwrap()).unwrap();
        assert_eq!(outcome.digest, outcome.recorded_digest, "{}", path.display());
    }
}
