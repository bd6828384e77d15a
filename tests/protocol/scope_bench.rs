//! A motor on the bench whose scope is used over the bus, and a scope alone.

use narx_core::commissioning::Mode;
use narx_core::dictionary::number;
use narx_core::master::{Answer, Chunk, Download, Request};
use narx_core::motor::signal::Signal;
use narx_core::motor::{Drive, Event, Samples, State};
use narx_core::scope::{Keeper, Memory, Scope, ScopeReply, ScopeTask, State as ScopeState};
use narx_sim::presets::preset;
use narx_sim::session::{Session, SessionConfig};

/// A session with a motor in this mode that is ready to start.
pub(crate) fn session(mode: Mode) -> Session {
    let preset = preset("ec45-flat-50w-18v").unwrap();
    let config = SessionConfig {
        rated_current: preset.data.rated_current,
        trace: false,
        ..SessionConfig::new(preset.motor, 18.0, mode)
    };
    Session::new(&config).unwrap()
}

pub(crate) fn running(mode: Mode, rpm: i32) -> Session {
    let mut session = session(mode);
    session.start(rpm);
    session.run(4.0);
    assert!(matches!(session.bench().status().state, State::HallClosedLoop | State::SensorlessClosedLoop));
    session
}

pub(crate) fn ask(session: &mut Session, request: Request) -> Answer {
    session.master().request(request).unwrap();
    for _ in 0..20_000 {
        session.step();
        if let Some(answer) = session.master().poll_answer() {
            return answer;
        }
    }
    panic!("no answer to {request:?}");
}

pub(crate) fn write(session: &mut Session, number: u16, raw: i32) {
    let answer = ask(session, Request::Write { number, raw });
    assert!(answer.result.is_ok(), "{answer:?}");
}

/// Value of parameter 22 for these signals.
pub(crate) fn bits(signals: &[Signal]) -> i32 {
    signals.iter().map(|signal| 1 << *signal as i32).sum()
}

pub(crate) fn set_up(session: &mut Session, signals: &[Signal], samples: i32, prescaler: i32, before: i32) {
    write(session, number::SCOPE_CHANNELS, bits(signals));
    write(session, number::SCOPE_SAMPLES, samples);
    write(session, number::SCOPE_PRESCALER, prescaler);
    write(session, number::SCOPE_TRIGGER_PHASE, before);
}

pub(crate) fn set_trigger(session: &mut Session, kind: i32, signal: Signal, level: i32) {
    write(session, number::SCOPE_TRIGGER, kind);
    write(session, number::SCOPE_TRIGGER_SIGNAL, signal as i32);
    write(session, number::SCOPE_TRIGGER_LEVEL, level);
}

pub(crate) fn press(session: &mut Session) -> Answer {
    ask(session, Request::TriggerScope)
}

pub(crate) fn scope_state(session: &Session) -> i32 {
    session.bench().node().read_parameter(number::SCOPE_STATE).unwrap()
}

pub(crate) fn wait(session: &mut Session, state: ScopeState) {
    for _ in 0..100_000 {
        if scope_state(session) == state as i32 {
            return;
        }
        session.step();
    }
    panic!("the scope stays {}", scope_state(session));
}

/// This many words of the record, as received over the bus.
pub(crate) fn words(session: &mut Session, words: usize) -> Vec<u16> {
    session.master().download(Download::Scope { words: words as u32 }).unwrap();
    let mut record = vec![None; words];
    for _ in 0..100_000 {
        session.step();
        while let Some(chunk) = session.master().poll_chunk() {
            let Chunk { offset, .. } = chunk;
            for (place, sample) in (offset as usize..).zip(chunk.samples()) {
                record[place] = Some(sample.to_bits() as u16);
            }
        }
        if let Some(end) = session.master().poll_download() {
            assert_eq!(end, Ok(words as u32));
            return record.into_iter().map(Option::unwrap).collect();
        }
    }
    panic!("the download does not end");
}

/// Both halves of a scope, without a node.
pub(crate) struct Pair {
    scope: Scope<Box<Memory>>,
    keeper: Keeper<Box<Memory>>,
}

impl Pair {
    /// A scope with a memory of `N` words.
    pub(crate) fn new<const N: usize>() -> Self {
        let memory: Box<Memory> = Box::new(Memory::<[u16; N]>::new());
        let mut keeper = Keeper::new(memory);
        assert_eq!(keeper.poll_report(), Some(ScopeReply::Room(N as u16)));
        Self { scope: Scope::default(), keeper }
    }

    pub(crate) fn handle(&mut self, request: ScopeTask) {
        self.exchange();
        self.keeper.handle(request);
        if let Some(order) = self.keeper.poll_order() {
            self.scope.handle(order);
        }
    }

    pub(crate) fn handle_event(&mut self, event: &Event) {
        self.scope.handle_event(event);
    }

    pub(crate) fn step(&mut self, drive: &Drive, samples: &Samples) {
        self.scope.step(drive, samples);
    }

    pub(crate) fn state(&self) -> ScopeState {
        match self.scope.state() {
            ScopeState::Idle => self.keeper.state(),
            state => state,
        }
    }

    /// Report that the node would get.
    pub(crate) fn poll(&mut self) -> Option<ScopeReply> {
        self.exchange();
        self.keeper.poll_report()
    }

    fn exchange(&mut self) {
        if let Some(answer) = self.scope.poll() {
            self.keeper.take(answer);
        }
    }
}
