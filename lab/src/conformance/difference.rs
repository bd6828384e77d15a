//! Search for the first tick and output in which two targets differ.

use super::answer::Answer;
use super::replayer::Replay;
use std::fmt;
use std::path::{Path, PathBuf};

/// The first outputs in which a target differs from the reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Number of ticks to replay until the difference; the last of them differs.
    pub ticks: u64,
    /// Number of the tick, as the outputs line gives it.
    pub tick: String,
    /// The first output that differs, with the reference's value: `duty 1200`.
    pub expected: String,
    /// The target's value of the same output.
    pub found: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ticks, tick, expected, found } = self;
        write!(f, "differs first in {tick} (the {ticks}. of the recording): {found}, expected {expected}")
    }
}

/// Finds the first tick in which the answer of `target` differs from that of `reference`; `None` if it never
/// does.
///
/// # Errors
/// Fails if one of them cannot replay the file.
pub fn locate(
    reference: &dyn Replay,
    target: &dyn Replay,
    file: &Path,
) -> Result<Option<Difference>, String> {
    let files = [PathBuf::from(file)];
    let ask = |who: &dyn Replay, ticks| {
        let answer = who.replay(&files, ticks).pop();
        answer
            .unwrap_or_else(|| Err("no answer".into()))
            .map_err(|reason| format!("{}: {reason}", who.name()))
    };
    let whole = (ask(reference, None)?, ask(target, None)?);
    if whole.0 == whole.1 {
        return Ok(None);
    }
    // The digest of a prefix covers all ticks before it: digests are equal up to some length, and different
    // from there on.
    let (mut same, mut different) = (0, whole.0.ticks.max(whole.1.ticks));
    while different - same > 1 {
        let middle = same + (different - same) / 2;
        if ask(reference, Some(middle))? == ask(target, Some(middle))? {
            same = middle;
        } else {
            different = middle;
        }
    }
    let (expected, found) = (ask(reference, Some(different))?, ask(target, Some(different))?);
    Ok(Some(first_output(different, &expected, &found)))
}

fn first_output(ticks: u64, expected: &Answer, found: &Answer) -> Difference {
    let text = |answer: &Answer| answer.outputs.clone().unwrap_or_else(|| "no tick: nothing".into());
    let (expected, found) = (text(expected), text(found));
    let (tick, expected) = expected.split_once(": ").unwrap_or(("", &expected));
    let (_, found) = found.split_once(": ").unwrap_or(("", &found));
    let (mut left, mut right) = (expected.split(", "), found.split(", "));
    // One of them may report a status, and the other not.
    let mut pair = || (left.next().unwrap_or("nothing"), right.next().unwrap_or("nothing"));
    let (expected, found) = (0..expected.len().max(found.len()))
        .map(|_| pair())
        .find(|(expected, found)| expected != found)
        .unwrap_or(("an earlier tick", "an earlier tick"));
    Difference { ticks, tick: tick.to_owned(), expected: expected.to_owned(), found: found.to_owned() }
}
