//! Real data from a bench: a recording, the scope's inputs of a motor that turns, a flash with parameters on
//! it.

use narx_core::commissioning::Mode;
use narx_core::dictionary::{Parameters, number};
use narx_core::master::{Download, Request};
use narx_core::motor::State;
use narx_core::recording::{Recording, Tick};
use narx_core::storage::{FlashReply, FlashTask, Opened, Part, Storage};
use narx_sim::flash::{Flash, KBYTE_512, Sparse, finish};
use narx_sim::presets::preset;
use narx_sim::session::{Session, SessionConfig};
use std::sync::LazyLock;

/// The smallest flash of a drive.
pub(crate) type Chip = Flash<Sparse>;

/// Recording of a motor with hall sensors that turns for some milliseconds: the file, and its ticks.
pub(crate) fn recording() -> &'static (Vec<u8>, Vec<Tick>) {
    static MADE: LazyLock<(Vec<u8>, Vec<Tick>)> = LazyLock::new(|| {
        let mut session = session();
        session.run(0.02);
        let file = session.bench().recording();
        let ticks = Recording::open(&file).and_then(|recording| recording.ticks().collect());
        (file, ticks.expect("our own"))
    });
    &MADE
}

/// Words of a scope that has recorded the inputs of a motor that begins to turn.
pub(crate) fn scoped() -> &'static [u16] {
    static MADE: LazyLock<Vec<u16>> = LazyLock::new(|| {
        let mut session = session();
        session.start(2000);
        session.run(0.7);
        assert_eq!(session.bench().status().state, State::HallClosedLoop);
        let write = |number, raw| Request::Write { number, raw };
        let orders = [
            write(number::SCOPE_INPUTS, 1),
            write(number::SCOPE_SAMPLES, 300),
            write(number::SCOPE_TRIGGER_PHASE, 150),
            Request::TriggerScope,
            Request::TriggerScope,
        ];
        for order in orders {
            session.master().request(order).expect("there is room");
            session.run(0.1);
            let answer = session.master().poll_answer().expect("time enough");
            answer.result.expect("what may be asked for");
        }
        let words = session.bench().node().read_parameter(number::SCOPE_WORDS).expect("it is known");
        session.master().download(Download::Scope { words: words as u32 }).expect("there is none yet");
        let mut record = vec![0; words as usize];
        for _ in 0..20_000 {
            session.step();
            while let Some(chunk) = session.master().poll_chunk() {
                record[chunk.offset as usize..][..chunk.words().len()].copy_from_slice(chunk.words());
            }
        }
        assert_eq!(session.master().poll_download(), Some(Ok(words as u32)));
        record
    });
    &MADE
}

fn session() -> Session {
    let preset = preset("ec45-flat-50w-18v").expect("it is in the table");
    let config = SessionConfig {
        rated_current: preset.data.rated_current,
        trace: false,
        ..SessionConfig::new(preset.motor, 18.0, Mode::Hall)
    };
    Session::new(&config).expect("the preset runs")
}

/// Parameters of a drive with hall sensors that is ready to start.
pub(crate) fn parameters() -> &'static Parameters {
    static MADE: LazyLock<Parameters> = LazyLock::new(|| session().commissioning().parameters.clone());
    &MADE
}

/// A flash with these parameters.
pub(crate) fn chip() -> &'static Chip {
    static MADE: LazyLock<Chip> = LazyLock::new(|| {
        let mut storage = Storage::new(blank());
        assert!(now(storage.format(parameters())));
        storage.into_flash()
    });
    &MADE
}

/// A flash in delivery state.
pub(crate) fn blank() -> Chip {
    Flash::new(KBYTE_512, Sparse::new(), 1)
}

/// Result of a future that never waits.
pub(crate) fn now<T>(future: impl Future<Output = T>) -> T {
    finish(future).expect("simulated flash never waits")
}

/// Content of the flash, as a drive finds it at power-up.
pub(crate) fn open(storage: &mut Storage<Chip>) -> Opened {
    match now(storage.execute(FlashTask::Open)) {
        FlashReply::Opened(opened) => opened,
        other => panic!("{other:?}"),
    }
}

/// Stores a part; returns whether it was stored.
pub(crate) fn store(storage: &mut Storage<Chip>, parameters: &Parameters, part: Part) -> bool {
    match now(storage.execute(FlashTask::Store(parameters.clone(), part))) {
        FlashReply::Stored { done, .. } => done,
        other => panic!("{other:?}"),
    }
}
