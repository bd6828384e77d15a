//! Decides when the configuration is stored; the shell stores it.

/// Least time between two stores, microseconds: bounds the wear of the memory.
const SPACING_US: u64 = 1_000_000;

/// The configuration in memory and the stored one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Store {
    progress: Progress,
    /// Earliest time of the next store, microseconds.
    from: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Progress {
    /// The stored configuration is up to date.
    #[default]
    Stored,
    /// The stored configuration is out of date.
    Wanted,
    /// The shell is storing.
    UnderWay,
    /// The shell is storing a configuration that has changed since.
    Outdated,
    /// The stored configuration is out of date, and the last store has failed: the next write tries again,
    /// even of the same value.
    Failed,
}

impl Store {
    /// Notes a write to the configuration; `changed` if a value is another one now.
    pub(super) fn note_write(&mut self, changed: bool) {
        self.progress = match self.progress {
            Progress::Stored if changed => Progress::Wanted,
            Progress::UnderWay if changed => Progress::Outdated,
            Progress::Failed => Progress::Wanted,
            other => other,
        };
    }

    /// Returns whether to store now. A restart does not wait for the spacing.
    pub(super) fn begin(&mut self, now: u64, restarting: bool) -> bool {
        let due = self.progress == Progress::Wanted && (restarting || now >= self.from);
        if due {
            *self = Self { progress: Progress::UnderWay, from: now.saturating_add(SPACING_US) };
        }
        due
    }

    /// Takes the result of a store.
    pub(super) fn finish(&mut self, done: bool) {
        self.progress = match (self.progress, done) {
            (Progress::UnderWay, true) => Progress::Stored,
            (Progress::UnderWay, false) => Progress::Failed,
            (Progress::Outdated, _) => Progress::Wanted,
            // No store was under way.
            (other, _) => other,
        };
    }

    /// Returns whether no store is under way or waiting.
    pub(super) fn is_idle(&self) -> bool {
        matches!(self.progress, Progress::Stored | Progress::Failed)
    }
}
