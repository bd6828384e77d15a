//! Tests of the virtual scope: its records, their triggers, and their download.

use crate::scope_bench::{
    Pair, ask, bits, press, running, scope_state, session, set_trigger, set_up, wait, words, write,
};
use narx_core::bus::narmotion::{Addresses, ToDrive};
use narx_core::commissioning::Mode;
use narx_core::dictionary::number;
use narx_core::master::Request;
use narx_core::motor::signal::{DRIVE_SIGNALS, ShaftScale, Signal};
use narx_core::motor::{Board, Coefficients, Drive, Samples, State, Status};
use narx_core::scope::{Block, Refusal, SIGNALS_A_TICK, ScopeReply, ScopeTask, Setup, State as ScopeState};
use narx_core::scope::{Threshold, Trigger};
use narx_core::units::ElectricalSpeed;
use narx_sim::plant::{Injection, LoadConfig};
use narx_sim::session::Session;
use proptest::prelude::*;

/// Downloads the record; a row for each sample.
fn download(session: &mut Session, signals: usize, samples: usize) -> Vec<Vec<i16>> {
    let record: Vec<i16> = words(session, signals * samples).into_iter().map(|word| word as i16).collect();
    record.chunks(signals).map(<[i16]>::to_vec).collect()
}

/// Value of a sample in its unit.
fn value(signal: Signal, sample: i16) -> f64 {
    let base = DRIVE_SIGNALS[signal as usize].base;
    f64::from(sample) / 4096.0 * base.digits as f64 * 10_f64.powi(base.exponent.into())
}

#[test]
fn the_table_is_in_the_order_of_the_bits() {
    for (bit, row) in DRIVE_SIGNALS.iter().enumerate() {
        assert_eq!(row.signal as usize, bit, "{}", row.name);
        assert_eq!(Signal::of_bit(bit as u8), Some(row.signal));
    }
    assert_eq!(Signal::of_bit(DRIVE_SIGNALS.len() as u8), None);
}

/// A record has the drive's answers and the plant's values, tick by tick.
#[test]
fn a_record_is_what_happened() {
    use Signal::{BusVoltage, Duty, SpeedHall, Step};
    let signals = [SpeedHall, BusVoltage, Duty, Step];
    assert_eq!(signals.len(), SIGNALS_A_TICK);
    let mut session = running(Mode::Hall, 3000);
    set_up(&mut session, &signals, 300, 1, 0);
    press(&mut session);
    press(&mut session);
    let mut seen = Vec::new();
    while scope_state(&session) != ScopeState::Done as i32 {
        session.step();
        let command = session.bench().command();
        seen.push([i32::from(command.duty.to_bits()) >> 3, (command.step as i32) << 11]);
    }
    assert!(seen.len() > 100, "some of it went by while the request was answered: {}", seen.len());
    let record = download(&mut session, signals.len(), 300);
    let recorded = record.iter().map(|sample| [sample[2], sample[3]].map(i32::from));
    // The control tick passes the end on in the tick after the last sample.
    assert!(recorded.rev().zip(seen.iter().rev().skip(1)).all(|(recorded, seen)| recorded == *seen));
    for sample in &record {
        let speed = value(SpeedHall, sample[0]);
        assert!((speed / 3000.0 - 1.0).abs() < 0.05, "{speed}");
        let voltage = value(BusVoltage, sample[1]);
        assert!((voltage - 18.0).abs() < 0.5, "{voltage}");
    }
    // 3000 rpm, 8 pole pairs: 72 sectors in 30 ms.
    let steps = record.windows(2).filter(|pair| pair[0][3] != pair[1][3]).count();
    assert!((70..=74).contains(&steps), "{steps}");
}

/// Every signal has the drive's own value in its base, compared with the reports of the same time, under load
/// in reverse.
#[test]
fn every_signal_is_what_the_drive_reports() {
    let all = DRIVE_SIGNALS.map(|row| row.signal);
    let mut session = session(Mode::Hall);
    session.bench_mut().plant_mut().set_load(LoadConfig { constant: 0.05, ..LoadConfig::default() });
    session.start(-1500);
    session.run(4.0);
    set_up(&mut session, &all, 178, 6, 0);
    press(&mut session);
    press(&mut session);
    let (mut reports, mut limits, mut steps) = (Vec::new(), [0.0_f64; 2], [false; 7]);
    while scope_state(&session) != ScopeState::Done as i32 {
        session.step();
        reports.push(*session.bench().status());
        let command = session.bench().command();
        limits = [limits[0] + f64::from(command.duty.to_bits()) / 32_768.0, limits[1] + 1.0];
        steps[command.step as usize] = true;
    }
    let record = download(&mut session, all.len(), 178);
    let mean = |signal: Signal| {
        let sum: f64 = record.iter().map(|sample| value(signal, sample[signal as usize])).sum();
        sum / record.len() as f64
    };
    let reported = |of: &dyn Fn(&Status) -> f64| reports.iter().map(of).sum::<f64>() / reports.len() as f64;
    let rpm = |speed: ElectricalSpeed| f64::from(speed.to_bits()) / 65_536.0 * 60.0 / 8.0;
    let raw = |bits: i32| f64::from(bits) / 65_536.0;
    let duty = limits[0] / limits[1];
    let voltage = reported(&|status| raw(status.bus_voltage.to_bits()));
    let current = reported(&|status| raw(status.bus_current.to_bits()));
    // (signal, expected mean, largest deviation)
    let table = [
        (Signal::SetPoint, reported(&|status| rpm(status.setpoint)), 2.0),
        (Signal::SpeedSensorless, 0.0, 0.0),
        (Signal::SpeedHall, reported(&|status| rpm(status.speed_hall)), 5.0),
        (Signal::BusVoltage, voltage, 0.1),
        (Signal::BusCurrent, current, 0.05),
        (Signal::PeriodCurrent, current, 0.05),
        (Signal::Power, voltage * current, 1.0),
        (Signal::Duty, duty * 100.0, 0.2),
        (Signal::Angle, 178.0, 15.0),
        (Signal::State, 5.0, 0.0),
        (Signal::Limiter, 2.0, 0.0),
        (Signal::Step, 3.5, 0.3),
        (Signal::Hall, 3.5, 0.3),
        (Signal::Crossing, 0.0, 0.0),
        (Signal::CrossingMargin, 0.0, 0.0),
        // Less dead time; a shunt in the bus measures the phase current times the duty.
        (Signal::LoopVoltage, duty * voltage, 0.4),
        (Signal::PhaseCurrent, current / duty, 0.2),
        (Signal::Fault, -1.0, 0.0),
        (Signal::Inputs, 0.0, 0.0),
        // 1.5 revolutions.
        (Signal::Position, 180.0, 60.0),
    ];
    assert!(current > 0.3 && steps[1..].iter().all(|seen| *seen), "{current} A through all six steps");
    let wrong: Vec<String> = table
        .iter()
        .filter(|(signal, expected, off)| (mean(*signal) - expected).abs() > *off)
        .map(|(signal, expected, _)| format!("{signal:?} {} instead of {expected}", mean(*signal)))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert_eq!(table.len() + 3, all.len(), "and the terminals:");
    // Steps in which a terminal is switched, and in which it is held low. A sample is taken in six of the
    // eight ticks of a step.
    let terminals = [
        (Signal::TerminalA, [1.0, 2.0], [4.0, 5.0]),
        (Signal::TerminalB, [3.0, 4.0], [1.0, 6.0]),
        (Signal::TerminalC, [5.0, 6.0], [2.0, 3.0]),
    ];
    for (terminal, switched, low) in terminals {
        let mean_in = |steps: [f64; 2]| {
            let step = |sample: &[i16]| value(Signal::Step, sample[Signal::Step as usize]);
            let values = record.iter().filter(|sample| steps.contains(&step(sample)));
            let values: Vec<f64> = values.map(|sample| value(terminal, sample[terminal as usize])).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        let (high, low) = (mean_in(switched), mean_in(low));
        assert!(high > 11.0 && low < 7.0, "{terminal:?}: {high} V switched, {low} V low");
    }
}

/// The outcome and margin of the crossings of a motor without sensors can be recorded, and its terminals: six
/// signals take two ticks a sample.
#[test]
fn a_sensorless_motor_tells_why() {
    use Signal::{Angle, Crossing, CrossingMargin, Limiter, SpeedSensorless, TerminalA};
    let signals = [SpeedSensorless, TerminalA, Angle, Limiter, Crossing, CrossingMargin];
    let mut session = running(Mode::Sensorless, 3000);
    set_up(&mut session, &signals, 400, 2, 0);
    assert_eq!(session.bench().node().read_parameter(number::SCOPE_SAMPLING_TIME), Some(200), "us");
    press(&mut session);
    press(&mut session);
    wait(&mut session, ScopeState::Done);
    let record = download(&mut session, signals.len(), 400);
    for sample in &record {
        let speed = value(SpeedSensorless, sample[0]);
        assert!((speed / 3000.0 - 1.0).abs() < 0.05, "{speed}");
        assert!((-0.5..19.0).contains(&value(TerminalA, sample[1])));
        assert_eq!(value(Limiter, sample[3]), 2.0, "the speed loop");
        assert_eq!(value(Crossing, sample[4]), 1.0, "accepted");
        assert!(value(CrossingMargin, sample[5]).abs() < 10.0);
    }
    // The angle runs on in every tick, also in those in which the drive rests: 28.8 degrees in 0.2 ms at 400
    // Hz.
    for pair in record.windows(2) {
        let turned = (value(Angle, pair[1][2]) - value(Angle, pair[0][2])).rem_euclid(360.0);
        assert!((20.0..38.0).contains(&turned), "{turned}");
    }
}

#[test]
fn prescaler_and_pre_trigger() {
    let signals = [Signal::SetPoint, Signal::State];
    let mut session = session(Mode::Hall);
    session.run(0.6);
    set_up(&mut session, &signals, 200, 7, 50);
    set_trigger(&mut session, 5, Signal::State, 0);
    press(&mut session);
    session.run(0.1);
    assert_eq!(scope_state(&session), ScopeState::Armed as i32);
    session.start(2000);
    wait(&mut session, ScopeState::Done);
    let record = download(&mut session, 2, 200);
    let states: Vec<f64> = record.iter().map(|sample| value(Signal::State, sample[1])).collect();
    assert!(states[..50].iter().all(|state| *state == 1.0), "Standby before the trigger: {states:?}");
    assert!(states[50..].iter().all(|state| *state == 5.0), "closed loop from its own sample on: {states:?}");
    // 0.7 ms from one sample to the next on a ramp.
    let ramp = |sample: &[i16]| value(Signal::SetPoint, sample[0]);
    let rate = session.bench().node().parameters().raw(number::SPEED_RATE);
    assert!(ramp(&record[199]) > ramp(&record[60]), "rate {rate}");
    let gains: Vec<f64> = record[60..200].windows(2).map(|pair| ramp(&pair[1]) - ramp(&pair[0])).collect();
    let mean = gains.iter().sum::<f64>() / gains.len() as f64;
    assert!(gains.iter().all(|gain| (gain - mean).abs() < mean + 3.0), "{gains:?}");
}

/// A trigger by a level, from either side, or by an edge, begins the record where the signal crosses it.
#[test]
fn levels_and_edges() {
    // (kind, level in thousandths of 5000 rpm, speed before and after)
    let cases = [(1, 400, 1000, 3000), (2, 400, 3000, 1000), (3, 400, 1000, 3000), (4, 400, 3000, 1000)];
    for (kind, level, from, to) in cases {
        let mut session = running(Mode::Hall, from);
        set_up(&mut session, &[Signal::SpeedHall], 100, 1, 40);
        set_trigger(&mut session, kind, Signal::SpeedHall, level);
        press(&mut session);
        session.run(0.2);
        assert_eq!(scope_state(&session), ScopeState::Armed as i32, "{kind}: {from} rpm is not beyond");
        session.set_speed(to as u16);
        wait(&mut session, ScopeState::Done);
        let record = download(&mut session, 1, 100);
        let level = level * 4096 / 1000;
        let beyond = |sample: &Vec<i16>| {
            let sample = i32::from(sample[0]);
            if to > from { sample > level } else { sample < level }
        };
        assert!(record[..40].iter().all(|sample| !beyond(sample)), "{kind}");
        assert!(beyond(&record[40]), "{kind}: {:?}", record[40]);
    }
    // A level that is already exceeded triggers at once; an edge that has passed does not.
    for (kind, done) in [(1, true), (3, false)] {
        let mut session = running(Mode::Hall, 3000);
        set_up(&mut session, &[Signal::SpeedHall], 10, 1, 2);
        set_trigger(&mut session, kind, Signal::SpeedHall, 400);
        press(&mut session);
        session.run(0.1);
        assert_eq!(scope_state(&session) == ScopeState::Done as i32, done, "{kind}");
    }
}

/// The record contains the fault, and is kept through acknowledgement and another start until it is
/// downloaded.
#[test]
fn a_capture_of_a_fault_survives() {
    let signals = [Signal::Duty, Signal::State, Signal::Fault, Signal::Inputs];
    let mut session = running(Mode::Hall, 2000);
    set_up(&mut session, &signals, 64, 1, 32);
    set_trigger(&mut session, 6, Signal::Fault, 0);
    press(&mut session);
    session.run(0.1);
    assert_eq!(scope_state(&session), ScopeState::Armed as i32);
    session.bench_mut().plant_mut().inject(Injection::Break);
    session.run(0.2);
    assert_eq!(session.bench().status().state, State::Fault);
    session.bench_mut().plant_mut().clear(Injection::Break);
    session.stop();
    session.run(1.5);
    session.start(1000);
    session.run(2.0);
    assert_eq!(session.bench().status().state, State::HallClosedLoop);
    assert_eq!(scope_state(&session), ScopeState::Done as i32);
    let record = download(&mut session, signals.len(), 64);
    let faults: Vec<f64> = record.iter().map(|sample| value(Signal::Fault, sample[2])).collect();
    assert!(faults[..32].iter().all(|fault| *fault == -1.0), "{faults:?}");
    assert!(faults[32..].iter().all(|fault| *fault == faults[32] && *fault >= 0.0), "{faults:?}");
    assert_eq!(value(Signal::State, record[31][1]), 5.0);
    assert_eq!(value(Signal::State, record[32][1]), 6.0);
    assert_eq!(record[32][0], 0, "off in the fault's own tick");
    assert_eq!(value(Signal::Inputs, record[32][3]), 2.0);
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut session = session(Mode::Hall);
    session.run(0.6);
    let refused = |session: &Session| session.bench().node().read_parameter(number::REFUSED_FRAMES).unwrap();
    // Nothing recorded yet.
    session.bench_mut().send(ToDrive::DownloadScope.encode(Addresses::FACTORY)).unwrap();
    session.run(0.01);
    assert_eq!(refused(&session), 1);
    let (one, all) = ([Signal::BusVoltage], DRIVE_SIGNALS.map(|row| row.signal));
    // Signals that do not exist, and none.
    for raw in [1 << DRIVE_SIGNALS.len(), 0] {
        assert!(ask(&mut session, Request::Write { number: number::SCOPE_CHANNELS, raw }).result.is_err());
    }
    // A third request while it records.
    set_up(&mut session, &one, 4096, 10, 0);
    assert!(press(&mut session).result.is_ok());
    assert!(press(&mut session).result.is_ok());
    assert_eq!(scope_state(&session), ScopeState::Recording as i32);
    assert!(press(&mut session).result.is_err());
    wait(&mut session, ScopeState::Done);
    // Changing the parameters does not change the record.
    write(&mut session, number::SCOPE_SAMPLES, 10);
    assert_eq!(download(&mut session, 1, 4096).len(), 4096);
    // Settings that cannot be recorded are refused: the earlier record stays, and parameter 306 has the
    // reason. 4096 words for 23 signals are 178 samples of each, and reading them takes 6 ticks.
    let read = |session: &Session, number| session.bench().node().read_parameter(number).unwrap();
    assert_eq!(read(&session, number::SCOPE_ROOM), 4096);
    for (samples, prescaler, before, reason) in [
        (179, 6, 0, Refusal::TooLong),
        (4096, 1, 4096, Refusal::TooLong),
        (178, 5, 0, Refusal::TooFast),
        (178, 6, 178, Refusal::TooEarly),
        (178, 6, 177, Refusal::None),
    ] {
        set_up(&mut session, &all, samples, prescaler, before);
        let before = refused(&session);
        let taken = press(&mut session).result.is_ok();
        let counted = refused(&session) - before;
        assert_eq!((taken, counted), (reason == Refusal::None, i32::from(!taken)), "{samples}, {prescaler}");
        assert_eq!(read(&session, number::SCOPE_REFUSAL), reason as i32, "{samples}, {prescaler}");
        if !taken {
            assert_eq!(scope_state(&session), ScopeState::Done as i32);
            assert_eq!(download(&mut session, 1, 4096).len(), 4096, "the record before");
        }
    }
    // Arming has deleted the earlier record.
    session.bench_mut().send(ToDrive::DownloadScope.encode(Addresses::FACTORY)).unwrap();
    session.run(0.01);
    assert_eq!(read(&session, number::SCOPE_REFUSAL), Refusal::NoRecord as i32);
    // Forced at once: the samples before the trigger are still recorded first.
    press(&mut session);
    wait(&mut session, ScopeState::Done);
    let record = download(&mut session, 23, 178);
    assert!(record.iter().all(|sample| (value(Signal::BusVoltage, sample[3]) - 18.0).abs() < 0.5));
}

/// While the drive broadcasts once a minute, a download takes all that 500 kbit/s allow, in stuffed bits.
#[test]
fn a_download_takes_all_of_the_bus() {
    let mut session = session(Mode::Hall);
    session.run(0.6);
    write(&mut session, number::AUTOSEND_PERIOD, 60_000);
    set_up(&mut session, &[Signal::BusVoltage], 4096, 1, 0);
    press(&mut session);
    press(&mut session);
    wait(&mut session, ScopeState::Done);
    session.run(0.1);
    let (before, begin) = (session.bench().bus_statistics(), session.bench().now_ns());
    let record = download(&mut session, 1, 4096);
    let (after, end) = (session.bench().bus_statistics(), session.bench().now_ns());
    assert!(record.iter().all(|sample| (value(Signal::BusVoltage, sample[0]) - 18.0).abs() < 0.5));
    let load = (after.busy_ns - before.busy_ns) as f64 / (end - begin) as f64;
    assert!(load >= 0.95, "{load}");
}

/// A repeated request for a download begins it anew, and arming ends it.
#[test]
fn a_download_begins_anew() {
    let mut session = session(Mode::Hall);
    session.run(0.6);
    set_up(&mut session, &[Signal::BusVoltage], 4096, 1, 0);
    press(&mut session);
    press(&mut session);
    wait(&mut session, ScopeState::Done);
    let whole = download(&mut session, 1, 4096);
    session.bench_mut().send(ToDrive::DownloadScope.encode(Addresses::FACTORY)).unwrap();
    session.run(0.1);
    assert_eq!(download(&mut session, 1, 4096), whole);
    session.bench_mut().send(ToDrive::DownloadScope.encode(Addresses::FACTORY)).unwrap();
    session.run(0.1);
    press(&mut session);
    session.run(0.1);
    let load = session.bench().bus_statistics();
    session.run(0.1);
    let frames = session.bench().bus_statistics().frames - load.frames;
    assert!(frames < 100, "only broadcasts: {frames}");
}

/// The drive gives the same bits with and without a scope record.
#[test]
fn looking_changes_nothing() {
    for mode in [Mode::Hall, Mode::Sensorless] {
        let run = |looks: bool| {
            let mut session = session(mode);
            session.start(3000);
            session.run(3.0);
            let request = |session: &mut Session, message: ToDrive| {
                // Equal numbers of frames in both runs, so that commands arrive at the same times.
                let message = if looks { message } else { ToDrive::RequestBuildInfo };
                session.bench_mut().send(message.encode(Addresses::FACTORY)).unwrap();
            };
            let set = |number, value| ToDrive::SetParameter { number, value };
            request(
                &mut session,
                set(number::SCOPE_CHANNELS, bits(&[Signal::Angle, Signal::SpeedHall, Signal::Crossing])),
            );
            session.run(0.01);
            request(&mut session, ToDrive::TriggerScope);
            session.run(0.1);
            request(&mut session, ToDrive::TriggerScope);
            session.run(0.2);
            assert_eq!(scope_state(&session), if looks { 3 } else { 0 });
            session.bench().digest()
        };
        assert_eq!(run(true), run(false), "{mode:?}");
    }
}

fn drive() -> Drive {
    Drive::new(Coefficients::build(&Default::default(), &Board::BENCH).unwrap())
}

/// A trigger that comes before there are enough samples is ignored if it is a level, and remembered if it is
/// a change of state.
#[test]
fn triggers_that_come_too_early() {
    let threshold = Threshold { signal: Signal::BusVoltage, level: 6 * 256, above: true };
    let setup = |trigger| Setup {
        signals: [Signal::BusVoltage, Signal::State].into_iter().collect(),
        samples: 100,
        before: 50,
        trigger,
        ..Setup::default()
    };
    // Initialization ends half a second after power-up. The bus has a pulse 10 ticks after the arming, and
    // another at 80.
    let run = |trigger| {
        let mut scope = Pair::new::<200>();
        let mut drive = drive();
        let (mut record, mut begun) = (Vec::new(), None);
        for tick in 0..5_400 {
            let age = i32::try_from(tick).unwrap() - 4_980;
            let pulse = (10..15).contains(&age) || (80..85).contains(&age);
            let samples = Samples { tick, bus_voltage: if pulse { 1_230 } else { 0 }, ..Samples::default() };
            if age == 0 {
                scope.handle(ScopeTask::Arm(setup(trigger)));
            }
            if age == 300 {
                scope.handle(ScopeTask::Read);
            }
            drive.step(&samples);
            scope.step(&drive, &samples);
            if begun.is_none() && scope.state() == ScopeState::Recording {
                begun = Some(age);
            }
            while let Some(report) = scope.poll() {
                let ScopeReply::Block(block) = report else { continue };
                record.extend(block.words.map(|word| word as i16));
            }
        }
        (begun, record)
    };
    for trigger in [Trigger::Level(threshold), Trigger::Edge(threshold)] {
        let (begun, record) = run(trigger);
        assert_eq!(begun, Some(80), "{trigger:?}");
        assert!(record[2 * 49] < threshold.level && record[2 * 50] > threshold.level, "{trigger:?}");
    }
    let (begun, record) = run(Trigger::StateChange);
    assert_eq!(begun, Some(50), "as soon as there are enough samples");
    let states: Vec<i16> = record.chunks_exact(2).map(|sample| sample[1]).collect();
    let change = states.windows(2).position(|pair| pair[0] != pair[1]);
    assert!(change.is_some_and(|at| at < 50), "the change stands before: {change:?}");
}

fn setups() -> impl Strategy<Value = Setup> {
    let signal = || (0..DRIVE_SIGNALS.len() as u8).prop_map(|bit| Signal::of_bit(bit).unwrap());
    let threshold = (signal(), any::<i16>(), any::<bool>()).prop_map(|(signal, level, above)| Threshold {
        signal,
        level,
        above,
    });
    let trigger = prop_oneof![
        Just(Trigger::Forced),
        Just(Trigger::StateChange),
        Just(Trigger::Fault),
        threshold.clone().prop_map(Trigger::Level),
        threshold.prop_map(Trigger::Edge),
    ];
    let signals = prop::collection::vec(signal(), 0..=DRIVE_SIGNALS.len());
    (signals, prop_oneof![0..40_u16, any::<u16>()], 0..20_u16, any::<u16>(), trigger).prop_map(
        |(signals, samples, prescaler, before, trigger)| Setup {
            signals: signals.into_iter().collect(),
            samples,
            prescaler,
            before,
            trigger,
            speed: ShaftScale::new(4),
            ..Setup::default()
        },
    )
}

proptest! {
    /// With any memory and any requests at any time, a finished record has the requested number of samples
    /// and is read completely; one that does not fit is not begun.
    #[test]
    fn whatever_is_asked(
        small in any::<bool>(),
        requests in prop::collection::vec((0..300_u16, prop_oneof![
            setups().prop_map(ScopeTask::Arm), Just(ScopeTask::Force), Just(ScopeTask::Read)
        ]), 1..12),
    ) {
        let (mut scope, memory) = if small { (Pair::new::<7>(), 7_usize) } else { (Pair::new::<200>(), 200) };
        let (mut drive, mut tick, mut length) = (drive(), 0, 0);
        let (mut read, mut reading) = (Vec::new(), false);
        for (wait, request) in requests {
            let busy = matches!(scope.state(), ScopeState::Armed | ScopeState::Recording);
            if let ScopeTask::Arm(setup) = &request
                && !busy
            {
                let asked = setup.signals.len() * usize::from(setup.samples);
                length = if asked <= memory { asked } else { 0 };
                reading = false;
            }
            if request == ScopeTask::Read && scope.state() == ScopeState::Done {
                (reading, read) = (true, Vec::new());
            }
            scope.handle(request);
            for _ in 0..wait {
                let samples = Samples { tick, bus_voltage: tick as u16 % 2000, ..Samples::default() };
                drive.step(&samples);
                scope.step(&drive, &samples);
                tick += 1;
                let Some(report) = scope.poll() else { continue };
                match report {
                    ScopeReply::State(state, words) => {
                        prop_assert_eq!(state, scope.state());
                        prop_assert_eq!(usize::from(words), if state == ScopeState::Done { length } else { 0 });
                    }
                    ScopeReply::Block(Block { address, words, last }) => {
                        prop_assert!(reading);
                        prop_assert_eq!(usize::from(address), read.len());
                        read.extend(words);
                        if last {
                            prop_assert_eq!(read.len(), length.div_ceil(3) * 3);
                            reading = false;
                        }
                    }
                    ScopeReply::Room(_) => {}
                }
            }
            prop_assert!(length > 0 || scope.state() == ScopeState::Idle);
        }
    }
}
