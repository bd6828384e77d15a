//! Tests of the master's jobs of the scope and the log: records on the simulated bus, and every end against a
//! scripted drive.

use crate::download_bench::sent;
use crate::master_bench::Rig;
use crate::pair::said;
use narx_core::bus::narmotion::{FromDrive, ParameterStatus, StatusWord, ToDrive};
use narx_core::commissioning::Mode;
use narx_core::dictionary::number;
use narx_core::master::{
    Config, Download, ErrorKind, Job, JobError, Master, NotTaken, Request, RequestError, ScopeSetup,
};
use narx_core::motor::State;
use narx_core::scope::State as Scope;
use narx_sim::plant::{Injection, Phase};
use std::collections::HashMap;

const SETUP: ScopeSetup =
    ScopeSetup { channels: 1, samples: 100, prescaler: 1, before: 20, trigger: 0, signal: 0, level: 0 };
/// Trigger: a new bit in FAULT_WORD.
const FAULT: u8 = 6;
/// Trigger: the signal is above the level.
const ABOVE: u8 = 1;

fn capture(setup: ScopeSetup) -> Job {
    Job::CaptureScope { setup, within: 1_000_000 }
}

/// Runs until the job of the scope or the log ends; returns its result and its time, s.
fn end(rig: &mut Rig, job: Job) -> (Result<(), JobError>, f64) {
    let begin = rig.bench.time();
    rig.master.begin(job).unwrap();
    for _ in 0..200_000 {
        if let Some(end) = rig.master.poll_record() {
            assert!(!rig.master.is_at_work());
            return (end, rig.bench.time() - begin);
        }
        rig.step();
    }
    panic!("a job always ends");
}

fn read(rig: &mut Rig, number: u16) -> i32 {
    rig.ask(Request::Read { number }).result.unwrap()
}

/// A record without a trigger holds all samples before and after it, which can be downloaded.
#[test]
fn a_record_is_forced_without_a_trigger() {
    for (setup, words) in [
        (SETUP, 100),
        (ScopeSetup { channels: 0b111, before: 99, prescaler: 20, ..SETUP }, 300),
        (ScopeSetup { channels: 0b1_1111, prescaler: 2, before: 0, ..SETUP }, 500),
    ] {
        let mut rig = Rig::new(Mode::Hall, Config::default());
        rig.until(State::Standby);
        let (result, time) = end(&mut rig, capture(setup));
        assert_eq!(result, Ok(()), "{setup:?}");
        assert!(time > f64::from(u32::from(setup.samples) * u32::from(setup.prescaler)) * 1e-4, "{time} s");
        assert_eq!(read(&mut rig, number::SCOPE_STATE), Scope::Done as i32);
        assert_eq!(read(&mut rig, number::SCOPE_WORDS), words, "{setup:?}");
        rig.master.download(Download::Scope { words: words as u32 }).unwrap();
        let downloaded = (0..50_000).find_map(|_| {
            rig.step();
            while rig.master.poll_chunk().is_some() {}
            rig.master.poll_download()
        });
        assert_eq!(downloaded, Some(Ok(words as u32)));
    }
}

/// The samples before a forced trigger do not count as waiting for it.
#[test]
fn samples_before_a_forced_trigger_may_take_longer_than_the_wait() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    let slow = ScopeSetup { samples: 50, before: 49, prescaler: 200, ..SETUP };
    let (result, time) = end(&mut rig, Job::CaptureScope { setup: slow, within: 100_000 });
    assert_eq!(result, Ok(()));
    assert!((0.98..1.1).contains(&time), "{time} s");
}

/// A start and a fault are recorded while the job waits for them: neither command ends the other's job.
#[test]
fn a_start_is_recorded_while_both_jobs_run() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    let inputs = ScopeSetup { channels: 0, samples: 300, before: 200, trigger: FAULT, ..SETUP };
    rig.master.begin(Job::Start { rpm: 2000 }).unwrap();
    rig.master.begin(Job::CaptureScope { setup: inputs, within: 5_000_000 }).unwrap();
    rig.run(1.0);
    assert_eq!((rig.master.poll_job(), rig.master.poll_record()), (Some(Ok(())), None));
    assert_eq!(read(&mut rig, number::SCOPE_STATE), Scope::Armed as i32);
    rig.bench.plant_mut().inject(Injection::Driver(Phase::A));
    rig.run(0.2);
    assert_eq!((rig.master.poll_job(), rig.master.poll_record()), (None, Some(Ok(()))));
    assert_eq!(rig.master.state(), Some(State::Fault));
    // The motor's own commands do not end it either.
    rig.master.begin(Job::AwaitScope { within: 0 }).unwrap();
    rig.master.stop();
    rig.run(0.1);
    assert_eq!(rig.master.poll_record(), Some(Ok(())));
}

/// The steps of a record, one job each, and what the scope refuses meanwhile.
#[test]
fn an_armed_scope_is_forced_and_awaited() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    let level = ScopeSetup { trigger: ABOVE, signal: 4, level: 7999, before: 0, ..SETUP };
    let waiting = JobError::NoTrigger { state: Scope::Armed, within: 200_000 };
    let table = [
        (Job::ForceScope, Err(JobError::NotArmed(Scope::Idle))),
        (Job::ArmScope(level), Ok(())),
        (Job::ArmScope(SETUP), Err(JobError::ScopeBusy(Scope::Armed))),
        (Job::AwaitScope { within: 200_000 }, Err(waiting)),
        (Job::ForceScope, Ok(())),
        (Job::AwaitScope { within: 200_000 }, Ok(())),
        (Job::ForceScope, Err(JobError::NotArmed(Scope::Done))),
        (Job::CaptureScope { setup: level, within: 200_000 }, Err(waiting)),
    ];
    for (job, expected) in table {
        assert_eq!(end(&mut rig, job).0, expected, "{job:?}");
    }
    assert_eq!(read(&mut rig, number::SCOPE_TRIGGER_LEVEL), 7999);
    assert_eq!(read(&mut rig, number::SCOPE_TRIGGER_SIGNAL), 4);
}

#[test]
fn the_log_is_erased() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    for (number, raw) in [(29, i32::from(number::DRIVE_STATE)), (number::LOG_PERIOD, 10)] {
        assert_eq!(rig.ask(Request::Write { number, raw }).result, Ok(raw));
    }
    rig.run(1.0);
    assert!(read(&mut rig, number::LOG_WRITE_INDEX) > 20);
    assert_eq!(rig.ask(Request::Write { number: 29, raw: 0xFFFF }).result, Ok(0xFFFF));
    let (result, time) = end(&mut rig, Job::EraseLog);
    assert_eq!(result, Ok(()));
    assert!(time > 0.2, "{time} s");
    assert_eq!(read(&mut rig, number::LOG_WRITE_INDEX), 0);
    // While driving it is refused.
    rig.master.begin(Job::Start { rpm: 2000 }).unwrap();
    rig.run(1.0);
    assert_eq!(rig.master.poll_job(), Some(Ok(())));
    let error = end(&mut rig, Job::EraseLog).0.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Refused, "{error}");
}

/// A drive that answers from a table of parameters.
struct Scripted {
    master: Master,
    now: u64,
    parameters: HashMap<u16, i32>,
    /// Reason why it refuses to arm and to force; 0 for none.
    refuses: i32,
    /// A parameter that it does not answer to.
    silent: Option<u16>,
    /// Logging states to come, the next one last; one every 100 ms.
    logging: Vec<u8>,
    writes: Vec<(u16, i32)>,
}

impl Scripted {
    fn new(parameters: &[(u16, i32)]) -> Self {
        Self {
            master: Master::new(Config { read_parameters: false, ..Config::default() }),
            now: 0,
            parameters: parameters.iter().copied().collect(),
            refuses: 0,
            silent: None,
            logging: Vec::new(),
            writes: Vec::new(),
        }
    }

    fn refusing(reason: i32) -> Self {
        Self { refuses: reason, ..Self::new(&[(number::SCOPE_ROOM, 4096), (number::SCOPE_REFUSAL, reason)]) }
    }

    fn answer(&mut self, message: ToDrive) {
        let (number, status) = match message {
            ToDrive::SetParameter { number, value } => {
                self.writes.push((number, value));
                let fits = narx_core::dictionary::Dictionary::row(number).unwrap().accepts(value);
                if fits {
                    self.parameters.insert(number, value);
                }
                (number, if fits { ParameterStatus::Done } else { ParameterStatus::OutOfRange })
            }
            ToDrive::RequestParameter { number } => (number, ParameterStatus::Done),
            ToDrive::TriggerScope => {
                *self.parameters.entry(number::REFUSED_FRAMES).or_default() += i32::from(self.refuses != 0);
                return;
            }
            _ => return,
        };
        if self.silent != Some(number) {
            let value = self.parameters.get(&number).copied().unwrap_or(0);
            self.master.handle_frame(&said(FromDrive::Parameter { number, value, status }), self.now);
        }
    }

    fn end(&mut self, job: Job) -> Result<(), JobError> {
        self.master.begin(job).unwrap();
        for tick in 0..100_000 {
            self.now += 1000;
            if tick % 100 == 0
                && let Some(logging) = self.logging.pop()
            {
                let status = StatusWord { logging, ..StatusWord::default() };
                self.master.handle_frame(&said(FromDrive::Status(status)), self.now);
            }
            for message in sent(&mut self.master, self.now) {
                self.answer(message);
            }
            if let Some(end) = self.master.poll_record() {
                return end;
            }
        }
        panic!("a job always ends");
    }
}

/// Settings that the memory does not take are refused before anything is written, in plain words.
#[test]
fn a_setting_that_does_not_fit_is_named() {
    let nine = ScopeSetup { channels: 0x1FF, samples: 455, prescaler: 3, ..SETUP };
    for (room, setup, text, kind) in [
        (0, SETUP, "the drive has no memory for the scope", ErrorKind::Refused),
        (
            4096,
            ScopeSetup { samples: 456, ..nine },
            "samples 456: must be 1 to 455 for 9 signals, because the memory holds 4096 words; \
             prescaler 3 or more",
            ErrorKind::Range,
        ),
        (
            64,
            ScopeSetup { samples: 0, ..SETUP },
            "samples 0: must be 1 to 64 for 1 signal, because the memory holds 64 words; prescaler 1 or more",
            ErrorKind::Range,
        ),
        (
            4096,
            ScopeSetup { prescaler: 2, ..nine },
            "prescaler 2: must be at least 3 for 9 signals: the drive reads 4 signals per control tick",
            ErrorKind::Range,
        ),
        (
            4096,
            ScopeSetup { before: 100, ..SETUP },
            "before 100: must be 0 to 99, fewer than samples 100",
            ErrorKind::Range,
        ),
    ] {
        for job in [Job::ArmScope(setup), capture(setup)] {
            let mut drive = Scripted::new(&[(number::SCOPE_ROOM, room)]);
            let error = drive.end(job).unwrap_err();
            assert_eq!((error.to_string().as_str(), error.kind()), (text, kind));
            assert_eq!(drive.writes, [], "{text}");
        }
    }
    // A value that the drive does not take is told with its parameter.
    for (setup, number) in [
        (ScopeSetup { prescaler: 10_001, ..SETUP }, number::SCOPE_PRESCALER),
        (ScopeSetup { trigger: 7, ..SETUP }, number::SCOPE_TRIGGER),
        (ScopeSetup { trigger: ABOVE, signal: 23, ..SETUP }, number::SCOPE_TRIGGER_SIGNAL),
        (ScopeSetup { trigger: ABOVE, level: 8000, ..SETUP }, number::SCOPE_TRIGGER_LEVEL),
    ] {
        let error = Scripted::new(&[(number::SCOPE_ROOM, 4096)]).end(Job::ArmScope(setup)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Range, "{error}");
        assert!(error.to_string().starts_with(&format!("parameter {number} \"")), "{error}");
    }
}

/// The settings are written in their order; signal and level only for a trigger that has them.
#[test]
fn settings_are_written_in_their_order() {
    let common = [(number::SCOPE_INPUTS, 0), (23, 100), (24, 1), (26, 20)];
    let level = ScopeSetup { trigger: ABOVE, signal: 4, level: -250, ..SETUP };
    for (setup, rest) in [
        (SETUP, vec![(22, 1), (290, 0)]),
        (level, vec![(22, 1), (291, 4), (292, -250), (290, 1)]),
        (ScopeSetup { channels: 0, trigger: FAULT, ..SETUP }, vec![(300, 1), (290, 6)]),
    ] {
        let mut drive = Scripted::new(&[(number::SCOPE_ROOM, 4096)]);
        assert_eq!(drive.end(Job::ArmScope(setup)), Ok(()));
        assert_eq!(drive.writes, [&common[..], &rest[..]].concat());
    }
}

/// A refusal is told with the drive's reason, once each.
#[test]
fn a_refusal_says_why() {
    for (reason, meaning) in [
        (1, ": no record is stored"),
        (2, ": a recording is in progress"),
        (3, ": the samples of all signals exceed the scope memory"),
        (4, ": the prescaler is too small for this number of signals"),
        (5, ": all samples are before the trigger"),
        (6, ": the drive has no memory for this record"),
        (7, ": an unknown signal is selected"),
        (99, ""),
    ] {
        for (state, job) in [(Scope::Done, capture(SETUP)), (Scope::Armed, Job::ForceScope)] {
            let mut drive = Scripted::refusing(reason);
            drive.parameters.insert(number::SCOPE_STATE, state as i32);
            let error = drive.end(job).unwrap_err();
            assert_eq!(error.to_string(), format!("the drive has refused the request{meaning}"));
            assert_eq!(error.kind(), ErrorKind::Refused);
        }
    }
}

/// States of the scope in which a job does not begin, or does not end in time.
#[test]
fn a_scope_in_another_state_is_told() {
    use Scope::{Armed, Done, Idle, Recording};
    let wait = Job::AwaitScope { within: 1_500_000 };
    for (state, job, text) in [
        (Armed, Job::ArmScope(SETUP), "the scope is armed: force it, or wait until it is done"),
        (Recording, capture(SETUP), "the scope is recording: force it, or wait until it is done"),
        (Idle, Job::ForceScope, "the scope is idle: only an armed scope can be forced"),
        (Done, Job::ForceScope, "the scope is done: only an armed scope can be forced"),
        (Recording, wait, "the scope is recording after 1.5 s: the trigger has not occurred"),
        (Idle, Job::AwaitScope { within: 0 }, "the scope is idle after 0 s: the trigger has not occurred"),
    ] {
        let state = [(number::SCOPE_ROOM, 4096), (number::SCOPE_STATE, state as i32)];
        let mut drive = Scripted::new(&state);
        let error = drive.end(job).unwrap_err();
        assert_eq!(error.to_string(), text);
        let late = matches!(job, Job::AwaitScope { .. });
        assert_eq!(error.kind(), if late { ErrorKind::NoAnswer } else { ErrorKind::Refused });
        if job == wait {
            assert!((1_500_000..1_530_000).contains(&drive.now), "{} us", drive.now);
        }
    }
}

/// A drive that falls silent midway ends the job; the parameter that was asked for is named.
#[test]
fn a_silent_drive_ends_the_job() {
    for number in [305, 260, 300, 23, 24, 26, 22, 290, number::REFUSED_FRAMES, 25] {
        let mut drive = Scripted::new(&[(number::SCOPE_ROOM, 4096)]);
        drive.silent = Some(number);
        let error = drive.end(capture(SETUP)).unwrap_err();
        assert!(matches!(error, JobError::Request(_, RequestError::NoAnswer)), "{error:?}");
        assert_eq!(error.kind(), ErrorKind::NoAnswer);
        if number != number::REFUSED_FRAMES {
            assert_eq!(error.to_string(), format!("parameter {number}: the drive does not answer"));
        }
    }
}

/// An erase goes on while the status word says so, or while the memory is still full; two looks must agree.
#[test]
fn an_erase_ends_when_the_drive_says_so() {
    for (logging, full, records, longest) in
        [(vec![1, 1], 0, 0, 0.25), (vec![2, 10, 9, 9, 9], 0, 7, 0.55), (vec![2, 9, 2, 2], 0, 0, 0.45)]
    {
        let mut drive = Scripted::new(&[(number::LOG_MEMORY_FULL, full), (number::LOG_WRITE_INDEX, records)]);
        drive.logging.clone_from(&logging);
        assert_eq!(drive.end(Job::EraseLog), Ok(()));
        let took = drive.now as f64 / 1e6;
        assert!((longest - 0.1..longest).contains(&took), "{logging:?}: {took} s");
        assert_eq!(drive.writes, [(number::LOG_ERASE_REQUEST, 0), (number::LOG_ERASE_REQUEST, 1)]);
    }
    // A full memory is not erased yet; the drive is lost meanwhile, or answers no more.
    for silent in [None, Some(number::LOG_WRITE_INDEX), Some(number::LOG_MEMORY_FULL)] {
        let mut drive = Scripted::new(&[(number::LOG_MEMORY_FULL, 1), (number::LOG_WRITE_INDEX, 9)]);
        (drive.silent, drive.logging) = (silent, if silent.is_none() { vec![9] } else { vec![] });
        let error = drive.end(Job::EraseLog).unwrap_err();
        assert_eq!(error, JobError::LostErasing);
        assert_eq!(error.to_string(), "the connection to the drive was lost while it erased its log");
        assert_eq!(error.kind(), ErrorKind::NoAnswer);
    }
}

/// Another job of the scope replaces one without a result; an abort has one.
#[test]
fn a_record_is_ended_by_another_command() {
    let mut drive = Scripted::new(&[(number::SCOPE_STATE, Scope::Armed as i32)]);
    let wait = Job::AwaitScope { within: 1_000_000 };
    drive.master.begin(wait).unwrap();
    assert_eq!(drive.end(Job::ForceScope), Ok(()));
    assert_eq!(drive.master.poll_record(), None);
    drive.master.begin(wait).unwrap();
    drive.master.abort_record();
    let error = drive.master.poll_record().unwrap().unwrap_err();
    assert_eq!((error, error.kind()), (JobError::Aborted(wait), ErrorKind::Refused));
    assert_eq!(error.to_string(), "the scope's record was ended by another command");
    assert!(!drive.master.is_at_work());
    let mut silent = Master::new(Config { silent: true, ..Config::default() });
    assert_eq!(silent.begin(Job::EraseLog), Err(NotTaken::Silent));
}
