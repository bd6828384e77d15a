//! Tests of a commissioned drive with its master, and of parameters in their units.

use narx_core::commissioning::Mode;
use narx_core::dictionary::engineering::{self, ValueError};
use narx_core::dictionary::{Dictionary, Parameters, number};
use narx_core::master::{Job, Request};
use narx_core::motor::State;
use narx_core::recording::{Recording, replay};
use narx_sim::presets::preset;
use narx_sim::session::{Session, SessionConfig, SessionError};

fn config() -> SessionConfig {
    SessionConfig::new(preset("ec45-flat-50w-18v").unwrap().motor, 18.0, Mode::Hall)
}

#[test]
fn starts_changes_speed_and_stops_when_asked() {
    let mut session = Session::new(&config()).unwrap();
    session.run(0.6);
    assert_eq!(session.bench().status().state, State::Standby);
    let speed = |session: &Session| session.bench().plant().observe().speed * 60.0 / core::f64::consts::TAU;
    session.master().start(-1500);
    session.run(1.5);
    assert!((speed(&session) + 1500.0).abs() < 15.0, "{} rpm", speed(&session));
    session.master().set_speed(2500);
    session.run(1.5);
    assert!((speed(&session) + 2500.0).abs() < 25.0, "{} rpm", speed(&session));
    session.master().stop();
    session.run(2.0);
    assert_eq!(session.bench().status().state, State::Standby);
    assert!(speed(&session).abs() < 1.0, "{} rpm", speed(&session));

    assert_eq!(session.bench().trace().len(), 56_000);
    let file = session.bench().recording();
    let outcome = replay::<narx_core::motor::Drive>(&Recording::open(&file).unwrap()).unwrap();
    assert_eq!((outcome.ticks, outcome.digest), (56_000, session.bench().digest()));
}

/// The master is polled when it says so. Each access to it is followed by a poll, so the second session polls
/// it in every tick; its frames are the same.
#[test]
fn a_master_that_is_polled_when_it_is_due_sends_the_same_frames() {
    let [mut due, mut always] = [(); 2].map(|()| Session::new(&config()).unwrap());
    let (mut frames, mut ticks) = (0, 0);
    let mut run = |seconds: f64, act: &dyn Fn(&mut Session)| {
        [&mut due, &mut always].into_iter().for_each(act);
        for _ in 0..(seconds * 10_000.0) as u32 {
            due.step();
            always.master();
            always.step();
            loop {
                let frame = due.bench_mut().monitor();
                assert_eq!(frame, always.bench_mut().monitor());
                if frame.is_none() {
                    break;
                }
                frames += 1;
            }
            ticks += 1;
        }
    };
    run(0.7, &|_| {});
    run(1.0, &|session| session.begin(Job::Start { rpm: 1500 }).unwrap());
    run(0.5, &|session| session.set_speed(2500));
    run(0.5, &|session| session.master().request(Request::Read { number: number::SPEED_KP_SL }).unwrap());
    run(0.5, &|session| session.master().request(Request::Reboot).unwrap());
    assert_eq!(due.bench().digest(), always.bench().digest());
    assert!(frames > 500, "{frames} frames in {ticks} ticks");
}

/// The session keeps a request during boot until the drive can take it, because the drive would ignore it.
#[test]
fn a_start_before_the_end_of_boot_is_kept() {
    let mut session = Session::new(&config()).unwrap();
    session.start(-1200);
    session.set_speed(1500);
    session.run(0.59);
    assert!(session.is_start_pending());
    assert_eq!(session.bench().status().state, State::Standby);
    session.run(1.6);
    assert!(!session.is_start_pending());
    assert_eq!(session.bench().status().state, State::HallClosedLoop);
    let speed = session.bench().plant().observe().speed * 60.0 / core::f64::consts::TAU;
    assert!((speed + 1500.0).abs() < 15.0, "{speed} rpm");
    session.stop();
    session.run(0.1);
    assert_eq!(session.bench().status().state, State::Standby);
    // A request that is withdrawn before the drive has seen it is gone.
    let mut session = Session::new(&config()).unwrap();
    session.start(1500);
    session.stop();
    session.run(1.0);
    assert_eq!(session.bench().status().state, State::Standby);
}

/// Sensors that switch late commutate late: the same set-point takes more current.
#[test]
fn hall_sensors_can_be_misplaced() {
    let current = |hall_offset_deg| {
        let mut session = Session::new(&SessionConfig { hall_offset_deg, ..config() }).unwrap();
        session.start(2500);
        session.run(2.0);
        assert_eq!(session.bench().status().state, State::HallClosedLoop);
        session.bench().plant().observe().ledger.source
    };
    let (straight, late) = (current(0.0), current(25.0));
    assert!(late > 1.1 * straight, "{straight} J, {late} J late");
}

#[test]
fn explicit_parameters_win_and_bad_ones_are_named() {
    let speed_max = Dictionary::row(number::SPEED_MAX_HES).unwrap();
    let with = |number, value| SessionConfig { parameters: vec![(number, value)], ..config() }.commission();
    let set = with(speed_max.number, 1234.0).unwrap().parameters;
    assert_eq!(engineering::value(&set, speed_max.number), Some(1234.0));
    for value in [1e9, -1.0, f64::NAN, f64::INFINITY, 1234.5] {
        match with(speed_max.number, value) {
            Err(SessionError::Parameter(ValueError::OutOfRange { parameter, .. })) => {
                assert_eq!(parameter.number, speed_max.number);
            }
            other => panic!("{value}: {other:?}"),
        }
    }
    let text = with(speed_max.number, 1e9).unwrap_err().to_string();
    assert!(
        text.contains(speed_max.name()) && text.contains("1000000000") && text.contains("65535"),
        "{text}"
    );
    let text = with(number::MOTOR_POLE_PAIRS, 2.5).unwrap_err().to_string();
    assert_eq!(text, "parameter 78 \"Motor pair poles\": 2.5 is not a whole number from 1 to 50");
    assert_eq!(with(999, 1.0).unwrap_err().to_string(), "there is no parameter 999");
}

/// Values convert exactly between units and the wire: every end of every range in both directions.
#[test]
fn units_are_exact_both_ways() {
    let mut parameters = Parameters::new();
    for row in Dictionary::rows() {
        for raw in [row.min(), row.max(), row.default()] {
            let value = engineering::to_unit(row, raw);
            engineering::set(&mut parameters, row.number, value).unwrap();
            assert_eq!(row.kind.widen(parameters.value(row.number).unwrap()), raw, "{}", row.name());
            assert_eq!(engineering::value(&parameters, row.number), Some(value));
            assert_eq!(
                row.engineering(parameters.value(row.number).unwrap()).to_string().parse(),
                Ok(value),
                "{}",
                row.name()
            );
        }
        // Half a step beyond still counts as the limit; a whole step is beyond it.
        let step = engineering::to_unit(row, 1);
        let before = parameters.clone();
        assert!(
            engineering::set(&mut parameters, row.number, engineering::to_unit(row, row.max()) + step)
                .is_err()
        );
        assert!(
            engineering::set(&mut parameters, row.number, engineering::to_unit(row, row.min()) - step)
                .is_err()
        );
        assert_eq!(parameters, before);
    }
}
