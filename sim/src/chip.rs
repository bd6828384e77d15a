//! Memory of a drive on the bench, which outlasts a restart.

#[cfg(feature = "flash")]
pub(crate) use with_flash::Chip;
#[cfg(not(feature = "flash"))]
pub(crate) use without_flash::Chip;

#[cfg(feature = "flash")]
mod with_flash {
    use crate::flash::{Flash, MBIT_256, Sparse, finish};
    use narx_core::dictionary::Parameters;
    use narx_core::storage::{FlashReply, FlashTask, Storage};

    /// A flash, with everything on it.
    #[derive(Clone, Debug)]
    pub(crate) struct Chip {
        storage: Storage<Flash<Sparse>>,
    }

    impl Chip {
        /// A new flash that holds these parameters.
        pub(crate) fn new(parameters: &Parameters) -> Self {
            let mut storage = Storage::new(Flash::new(MBIT_256, Sparse::new(), 0));
            // A new flash takes every set.
            finish(storage.format(parameters));
            Self { storage }
        }

        pub(crate) fn with_flash(flash: Flash<Sparse>) -> Self {
            Self { storage: Storage::new(flash) }
        }

        /// Executes a request; returns its report and how long it takes, ns; `None` if the power fails on the
        /// way.
        pub(crate) fn execute(&mut self, request: FlashTask) -> Option<(FlashReply, u64)> {
            let report = finish(self.storage.execute(request));
            let busy = self.storage.flash().take_busy();
            report.map(|report| (report, busy))
        }

        pub(crate) const fn flash(&mut self) -> &mut Flash<Sparse> {
            self.storage.flash()
        }

        pub(crate) fn into_flash(self) -> Flash<Sparse> {
            self.storage.into_flash()
        }
    }
}

#[cfg(not(feature = "flash"))]
mod without_flash {
    use narx_core::dictionary::Parameters;
    use narx_core::motor::FaultWord;
    use narx_core::storage::{FlashReply, FlashTask, Memory, Opened};

    /// The stored parameters alone: where a program must be small. There is no log.
    #[derive(Clone, Debug)]
    pub(crate) struct Chip {
        stored: Parameters,
    }

    /// No memory for one.
    const NO_LOG: Memory =
        Memory { records: 0, written: 0, subsectors: 0, erasing: None, lost: false, values: 0 };

    impl Chip {
        /// One that holds these parameters.
        pub(crate) fn new(parameters: &Parameters) -> Self {
            Self { stored: parameters.clone() }
        }

        /// Executes a request, which takes no time.
        pub(crate) fn execute(&mut self, request: FlashTask) -> Option<(FlashReply, u64)> {
            let report = match request {
                FlashTask::Open => FlashReply::Opened(Opened {
                    parameters: self.stored.clone(),
                    faults: FaultWord::empty(),
                    repaired: false,
                    log: NO_LOG,
                }),
                FlashTask::Store(parameters, part) => {
                    for (row, raw) in parameters.iter().filter(|(row, _)| part.contains(row)) {
                        // The same row has accepted it before.
                        let _ = self.stored.set(row.number, raw);
                    }
                    FlashReply::Stored { done: true, log: NO_LOG }
                }
                FlashTask::Append(_) | FlashTask::Erase => FlashReply::Log { done: true, memory: NO_LOG },
                FlashTask::Read(_) => FlashReply::Record(None),
            };
            Some((report, 0))
        }
    }
}
