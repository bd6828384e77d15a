//! When the configuration is stored. The shell does it; here is what it shall do next.

/// Least time between two stores, microseconds: bounds the wear of the memory.
const SPACING_US: u64 = 1_000_000;

/// The configuration in memory and the stored one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Store {
    progress: Progress,
    /// No store before this time.
    from: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Progress {
    /// Both are the same.
    #[default]
    Stored,
    /// They differ.
    Wanted,
    /// The shell stores.
    UnderWay,
    /// The shell stores what is no longer the newest.
    Outdated,
    /// They differ, and the last store has failed: the next write tries again, even of the same value.
    Failed,
}

impl Store {
    /// The configuration was written; `changed` if it is another one now.
    pub(super) fn note_write(&mut self, changed: bool) {
        self.progress = match self.progress {
            Progress::Stored if changed => Progress::Wanted,
            Progress::UnderWay if changed => Progress::Outdated,
            Progress::Failed => Progress::Wanted,
            other => other,
        };
    }

    /// Whether to store now. A restart does not wait for the spacing.
    pub(super) fn begin(&mut self, now: u64, restarting: bool) -> bool {
        let due = self.progress == Progress::Wanted && (restarting || now >= self.from);
        if due {
            *self = Self { progress: Progress::UnderWay, from: now.saturating_add(SPACING_US) };
        }
        due
    }

    /// The shell has stored, or failed to.
    pub(super) fn finish(&mut self, done: bool) {
        self.progress = match (self.progress, done) {
            (Progress::UnderWay, true) => Progress::Stored,
            (Progress::UnderWay, false) => Progress::Failed,
            (Progress::Outdated, _) => Progress::Wanted,
            // Nothing was asked for.
            (other, _) => other,
        };
    }

    /// Nothing is under way or waits.
    pub(super) fn is_idle(&self) -> bool {
        matches!(self.progress, Progress::Stored | Progress::Failed)
    }
}
