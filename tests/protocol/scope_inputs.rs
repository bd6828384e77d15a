//! Tests of the scope's recording mode: the inputs of every tick after the drive's state, downloaded over the
//! bus, and run again bit for bit.

use crate::scope_bench::{
    Pair, press, running, scope_state, session, set_trigger, set_up, wait, words, write,
};
use narx_core::commissioning::Mode as ControlMode;
use narx_core::dictionary::number;
use narx_core::motor::machine::event::{Command, Health, SlowMeasurements};
use narx_core::motor::signal::Signal;
use narx_core::motor::{
    Board, Coefficients, CurrentMode, Drive, Edge, EdgeSource, Event, Lines, RunRequest, SampleMode, Samples,
    State,
};
use narx_core::recording::{LAYOUT_VERSION, Recording, Scoped, ScopedError, Tick, record_scoped, replay};
use narx_core::scope::{Inputs, MalformedInputs, ScopeReply, ScopeTask, Setup, State as ScopeState};
use narx_core::units::{Celsius, ElectricalSpeed, Volts};
use narx_sim::plant::Injection;
use narx_sim::recording::RecordingBuffer;
use narx_sim::session::Session;
use proptest::prelude::*;

fn ask_for_inputs(session: &mut Session, ticks: i32, before: i32) {
    set_up(session, &[Signal::State], ticks, 1, before);
    write(session, number::SCOPE_INPUTS, 1);
}

/// Downloads the whole record over the bus.
fn fetch(session: &mut Session) -> Vec<u16> {
    assert_eq!(scope_state(session), ScopeState::Done as i32);
    let length = session.bench().node().read_parameter(number::SCOPE_WORDS).unwrap();
    words(session, length as usize)
}

fn rerun(words: &[u16]) -> Scoped<RecordingBuffer> {
    record_scoped(words, "from the scope", RecordingBuffer::default()).unwrap()
}

fn ticks(recording: &[u8]) -> Vec<Tick> {
    Recording::open(recording).unwrap().ticks().map(Result::unwrap).collect()
}

/// Checks that the scope's recording has the ticks that the bench recorded at the same time, and gives the
/// same commands when it runs again.
fn holds_what_happened(session: &Session, scoped: &Scoped<RecordingBuffer>) {
    let bench = session.bench().recording();
    let all = ticks(&bench);
    let begin = all.iter().position(|tick| tick.samples.tick == scoped.first).unwrap();
    let recorded = ticks(&scoped.sink.0);
    assert_eq!(recorded.len() as u64, scoped.ticks);
    assert!(recorded == all[begin..][..recorded.len()], "the inputs are others");

    let outcome = replay::<Drive>(&Recording::open(&scoped.sink.0).unwrap()).unwrap();
    assert!(outcome.is_identical());
    assert_eq!(outcome.other_behaviour, None);

    // Compares the drive with its whole history with the one that began at the checkpoint.
    let whole = Recording::open(&bench).unwrap();
    let part = Recording::open(&scoped.sink.0).unwrap();
    let mut old: Drive = postcard::from_bytes(whole.state()).unwrap();
    let mut new: Drive = postcard::from_bytes(part.state()).unwrap();
    let step = |drive: &mut Drive, tick: &Tick| {
        if let Some(event) = &tick.event {
            drive.handle_event(event.clone());
        }
        drive.step(&tick.samples)
    };
    for tick in &all[..begin] {
        step(&mut old, tick);
        old.poll_status();
    }
    for tick in &recorded {
        assert_eq!(step(&mut old, tick), step(&mut new, tick), "tick {}", tick.samples.tick);
        assert_eq!(old.poll_status(), new.poll_status());
    }
}

#[test]
fn a_fault_is_run_again() {
    for mode in [ControlMode::Hall, ControlMode::Sensorless] {
        let mut session = running(mode, 3000);
        ask_for_inputs(&mut session, 400, 200);
        write(&mut session, number::SCOPE_TRIGGER, 6);
        press(&mut session);
        session.run(0.3);
        assert_eq!(scope_state(&session), ScopeState::Armed as i32);
        session.bench_mut().plant_mut().inject(Injection::Break);
        wait(&mut session, ScopeState::Done);
        // The record is kept as long as necessary.
        session.run(1.0);
        let scoped = rerun(&fetch(&mut session));
        assert_eq!(scoped.agrees, Some(true), "{mode:?}");
        assert!((335..=685).contains(&scoped.ticks), "{mode:?}: {} ticks", scoped.ticks);
        holds_what_happened(&session, &scoped);

        // The fault is at the requested position of the trigger: 200 ticks follow it.
        let recording = Recording::open(&scoped.sink.0).unwrap();
        let mut drive: Drive = postcard::from_bytes(recording.state()).unwrap();
        let mut driving = 0;
        for tick in ticks(&scoped.sink.0) {
            if let Some(event) = tick.event {
                drive.handle_event(event);
            }
            drive.step(&tick.samples);
            driving += u64::from(drive.state().is_driving());
        }
        assert_eq!(drive.state(), State::Fault);
        assert_eq!(scoped.ticks - driving, 200, "{mode:?}");
    }
}

/// The recording includes all that the drive gets meanwhile: set-points, slow measurements, calibration, and
/// new coefficients, which begin a new segment.
#[test]
fn commands_and_parameters_on_the_way() {
    let mut session = running(ControlMode::Hall, 2000);
    ask_for_inputs(&mut session, 300, 100);
    set_trigger(&mut session, 3, Signal::SetPoint, 500);
    press(&mut session);
    session.run(0.1);
    write(&mut session, number::SPEED_KP_HES, 20);
    session.run(0.05);
    session.set_speed(2600);
    wait(&mut session, ScopeState::Done);
    let scoped = rerun(&fetch(&mut session));
    holds_what_happened(&session, &scoped);
    let events = ticks(&scoped.sink.0).into_iter().filter_map(|tick| tick.event);
    assert!(events.clone().any(|event| matches!(event, Event::Slow(_))));
    assert!(events.into_iter().any(|event| matches!(event, Event::Command(_) | Event::SetPoint(_))));
}

/// During the start of a motor a forced record has 68 ms at most and 34 ms at least.
#[test]
fn forced_at_any_instant() {
    for wait_ms in [0, 7, 33, 34, 35, 68, 100, 250, 400, 700] {
        let mut session = session(ControlMode::Sensorless);
        ask_for_inputs(&mut session, 100, 99);
        session.start(3000);
        session.run(0.3);
        press(&mut session);
        session.run(f64::from(wait_ms) / 1000.0);
        press(&mut session);
        wait(&mut session, ScopeState::Done);
        let scoped = rerun(&fetch(&mut session));
        holds_what_happened(&session, &scoped);
        if wait_ms > 100 {
            assert!((335..=685).contains(&scoped.ticks), "{wait_ms} ms: {} ticks", scoped.ticks);
            assert_eq!(scoped.agrees, Some(true));
        }
    }
}

/// The requested number of ticks follows the trigger, as far as they fit.
#[test]
fn the_trigger_is_never_lost() {
    for asked in [1, 50, 300, 340, 2000] {
        let mut session = running(ControlMode::Hall, 3000);
        ask_for_inputs(&mut session, asked, 0);
        press(&mut session);
        session.run(0.123);
        press(&mut session);
        // The trigger has come by now.
        let triggered = session.bench().now_ns() / 100_000;
        wait(&mut session, ScopeState::Done);
        let scoped = rerun(&fetch(&mut session));
        assert!(scoped.ticks >= u64::from(asked.min(335) as u32), "{asked}: {}", scoped.ticks);
        assert!(scoped.first <= triggered, "{asked}: begins at {}, triggered by {triggered}", scoped.first);
        holds_what_happened(&session, &scoped);
    }
}

#[test]
fn damaged_words_are_refused() {
    let mut session = running(ControlMode::Hall, 3000);
    ask_for_inputs(&mut session, 100, 0);
    press(&mut session);
    press(&mut session);
    wait(&mut session, ScopeState::Done);
    let words = fetch(&mut session);
    let error = |words: &[u16]| record_scoped(words, "", RecordingBuffer::default()).map(|_| ()).unwrap_err();
    for length in 0..words.len() {
        assert_eq!(error(&words[..length]), ScopedError::Words(MalformedInputs::Words), "{length} words");
    }
    let layout = format!("the drive's state has layout 999, this version reads layout {LAYOUT_VERSION}");
    for (place, word, expected) in [
        (0, 7, "word 0 of the record is 0x0007, a recording begins with 0x4e01"),
        (1, 999, layout.as_str()),
        (5, 0, "the record ends too early or is damaged"),
        (5, 3, "the record ends too early or is damaged"),
    ] {
        let mut words = words.clone();
        words[place] = word;
        assert_eq!(error(&words).to_string(), expected);
    }
    // The sixth word of the first tick, after the head, the segment's head and the drive's state: it has a
    // bit without a meaning.
    let what = 6 + 7 + usize::from(words[11]).div_ceil(2) + 5;
    let mut other = words.clone();
    other[what] |= 0x8000;
    assert_eq!(error(&other), ScopedError::Words(MalformedInputs::Words));
    let label = "x".repeat(100);
    assert!(matches!(record_scoped(&words, &label, RecordingBuffer::default()), Err(ScopedError::Record(_))));
}

/// Reads the record of a scope that is done.
fn read(pair: &mut Pair) -> Vec<u16> {
    pair.handle(ScopeTask::Read);
    let (mut words, mut length) = (Vec::new(), 0);
    while let Some(report) = pair.poll() {
        match report {
            ScopeReply::State(_, words) => length = usize::from(words),
            ScopeReply::Block(block) => words.extend(block.words),
            ScopeReply::Room(_) => {}
        }
    }
    assert_eq!(words.len(), length.next_multiple_of(3));
    words.truncate(length);
    words
}

/// Each half needs room for the longest tick, of 26 words.
#[test]
fn a_memory_too_small_for_inputs_records_signals_alone() {
    for (mut pair, inputs) in [(Pair::new::<51>(), ScopeState::Idle), (Pair::new::<52>(), ScopeState::Armed)]
    {
        let signals =
            Setup { signals: [Signal::State].into_iter().collect(), samples: 5, ..Setup::default() };
        pair.handle(ScopeTask::Arm(Setup { inputs: true, ..signals.clone() }));
        assert_eq!(pair.state(), inputs);
        if inputs == ScopeState::Idle {
            pair.handle(ScopeTask::Arm(signals));
            assert_eq!(pair.state(), ScopeState::Armed);
        }
    }
}

/// A request for no samples gives no record of signals, and a recording of inputs with the tick of the
/// trigger.
#[test]
fn a_recording_has_at_least_one_tick() {
    let mut pair = Pair::new::<600>();
    let signals = Setup { signals: [Signal::State].into_iter().collect(), ..Setup::default() };
    pair.handle(ScopeTask::Arm(signals.clone()));
    assert_eq!(pair.state(), ScopeState::Idle);
    pair.handle(ScopeTask::Arm(Setup { inputs: true, tick_rate: 10_000, ..signals }));
    pair.handle(ScopeTask::Force);
    let mut drive = Drive::new(Coefficients::build(&Default::default(), &Board::BENCH).unwrap());
    for tick in 0..100 {
        let samples = Samples { tick, ..Samples::default() };
        drive.step(&samples);
        pair.step(&drive, &samples);
    }
    assert_eq!(pair.state(), ScopeState::Done);
    let words = read(&mut pair);
    let ticks =
        Inputs::open(&words).unwrap().segments().map(|segment| segment.ticks().count()).sum::<usize>();
    assert_eq!((ticks, rerun(&words).ticks), (1, 1));
}

fn samples() -> impl Strategy<Value = Samples> {
    let edge = (any::<u16>(), any::<bool>(), any::<u8>()).prop_map(|(instant, hall, code)| Edge {
        instant,
        source: if hall { EdgeSource::Hall } else { EdgeSource::Comparator },
        code,
    });
    let rare = (
        prop_oneof![9 => Just(1_u64), 1 => any::<u64>()],
        prop_oneof![9 => Just(0_u16), 1 => any::<u16>()],
        prop_oneof![9 => Just(0_u8), 1 => any::<u8>()],
        prop_oneof![9 => Just(0_u8), 1 => any::<u8>()],
        prop_oneof![5 => Just(vec![]), 1 => prop::collection::vec(edge, 0..=4)],
    );
    (any::<([u16; 3], u16, u16, u8, bool, bool)>(), rare).prop_map(
        |(
            (phase_voltage, bus_voltage, bus_current, hall, on_time, current),
            (tick, skew, lost, lines, edges),
        )| Samples {
            tick,
            phase_voltage,
            bus_voltage,
            bus_current,
            sample_mode: if on_time { SampleMode::OnTime } else { SampleMode::OffTime },
            current_mode: if current { CurrentMode::OnTime } else { CurrentMode::Average },
            skew,
            hall,
            edges: edges.into_iter().collect(),
            edges_lost: lost,
            lines: Lines::from_bits_retain(lines),
        },
    )
}

fn events() -> impl Strategy<Value = Option<Event>> {
    let speed = any::<i32>().prop_map(ElectricalSpeed::from_bits);
    let request = prop_oneof![
        Just(RunRequest::Standby),
        Just(RunRequest::Drive),
        Just(RunRequest::Reverse),
        Just(RunRequest::Shutdown)
    ];
    let slow = any::<(i32, i32)>().prop_map(|(temperature, pressure)| SlowMeasurements {
        temperature: Celsius::from_bits(temperature),
        pressure: Volts::from_bits(pressure),
    });
    let other = prop_oneof![
        3 => (request, speed.clone()).prop_map(|(request, speed)| Event::Command(Command { request, speed })),
        3 => speed.prop_map(Event::SetPoint),
        3 => slow.prop_map(Event::Slow),
        1 => any::<bool>().prop_map(Event::CalibrateHall),
        1 => Just(Event::CoefficientsRejected),
        1 => any::<bool>().prop_map(|failed| Event::Health(Health { self_test_failed: failed, ..Health::default() })),
    ];
    prop_oneof![4 => Just(None), 1 => other.prop_map(Some)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// With any inputs the record has exactly those inputs, and leads from the first state to the same
    /// commands.
    #[test]
    fn any_inputs(given in prop::collection::vec((events(), samples()), 1..400), end in 0..400_usize) {
        let mut pair = Pair::new::<600>();
        let mut drive = Drive::new(Coefficients::build(&Default::default(), &Board::BENCH).unwrap());
        let setup = Setup { inputs: true, samples: 10, before: 5, tick_rate: 20_000, ..Setup::default() };
        pair.handle(ScopeTask::Arm(setup));
        let (mut lived, mut tick) = (Vec::new(), 0_u64);
        for (place, (event, mut samples)) in given.into_iter().cycle().take(900).enumerate() {
            if pair.state() == ScopeState::Done {
                break;
            }
            tick = tick.wrapping_add(samples.tick);
            samples.tick = tick;
            if place == end {
                pair.handle(ScopeTask::Force);
            }
            if let Some(event) = &event {
                pair.handle_event(event);
                drive.handle_event(event.clone());
            }
            drive.step(&samples);
            pair.step(&drive, &samples);
            lived.push((event, samples));
        }
        if pair.state() == ScopeState::Done {
            let words = read(&mut pair);
            let inputs = Inputs::open(&words).unwrap();
            prop_assert_eq!(inputs.tick_rate, 20_000);
            let read: Vec<_> =
                inputs.segments().flat_map(|segment| segment.ticks().map(Result::unwrap)).collect();
            // Health is not recorded: the input before it is the last.
            if lived.last().is_some_and(|(event, _)| matches!(event, Some(Event::Health(_)))) {
                lived.pop();
            }
            let begin = lived.len() - read.len();
            prop_assert!(read == lived[begin..], "{} of {}", read.len(), lived.len());
            let scoped = rerun(&words);
            prop_assert!(scoped.agrees != Some(false));
        }
    }

    /// Arbitrary words are refused or run; nothing panics.
    #[test]
    fn any_words(mut words in prop::collection::vec(any::<u16>(), 0..200), segments in 0..4_u16) {
        for (word, is) in words.iter_mut().zip([0x4e01, 4, 4, 10_000, 0, segments, 0, 0, 0, 0]) {
            *word = is;
        }
        let _ = record_scoped(&words, "", RecordingBuffer::default());
    }
}
