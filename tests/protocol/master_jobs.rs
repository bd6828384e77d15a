//! Tests of the master's jobs on the simulated bus: conversations of several messages, and their ends.

use crate::master_bench::Rig;
use narx_core::commissioning::Mode;
use narx_core::dictionary::number;
use narx_core::master::{Config, Job, JobError, Master, NotTaken, Request};
use narx_core::motor::State;
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_sim::plant::{Injection, Phase};

/// Runs until the job ends; returns its result and its time, s.
fn end(rig: &mut Rig) -> (Result<(), JobError>, f64) {
    let begin = rig.bench.time();
    for _ in 0..800_000 {
        if let Some(end) = rig.master.poll_job() {
            assert!(!rig.master.is_at_work());
            return (end, rig.bench.time() - begin);
        }
        rig.step();
    }
    panic!("a job always ends");
}

fn start(rig: &mut Rig, rpm: i32) -> (Result<(), JobError>, f64) {
    rig.master.begin(Job::Start { rpm }).unwrap();
    end(rig)
}

fn set(rig: &mut Rig, number: u16, raw: i32) {
    assert_eq!(rig.ask(Request::Write { number, raw }).result, Ok(raw));
}

/// A start that is begun before the drive has booted ends in the loop of its mode.
#[test]
fn a_start_ends_in_the_loop_of_its_mode() {
    for (mode, rpm, state, longest) in [
        (Mode::Hall, -2000, State::HallClosedLoop, 1.0),
        (Mode::Sensorless, 2000, State::SensorlessClosedLoop, 2.0),
        (Mode::OpenLoop, 300, State::OpenLoop, 2.0),
    ] {
        let mut rig = Rig::new(mode, Config::default());
        let (result, time) = start(&mut rig, rpm);
        assert_eq!((result, rig.master.state()), (Ok(()), Some(state)), "{mode:?}");
        assert!(time < longest, "{mode:?}: {time} s");
        rig.run(0.5);
        assert!(rig.speed() * f64::from(rpm.signum()) > 100.0, "{mode:?}: {} rpm", rig.speed());
    }
}

/// A start by the caller's own command is watched, whether it comes before or after.
#[test]
fn a_start_of_the_caller_is_awaited() {
    for early in [false, true] {
        let mut rig = Rig::new(Mode::Hall, Config::default());
        rig.until(State::Standby);
        rig.master.stop();
        rig.run(0.12);
        if early {
            rig.master.start(-1500);
        }
        rig.master.begin(Job::AwaitStart { rpm: -1500 }).unwrap();
        if !early {
            rig.run(0.1);
            rig.master.start(-1500);
        }
        let (result, _) = end(&mut rig);
        assert_eq!((result, rig.master.state()), (Ok(()), Some(State::HallClosedLoop)), "{early}");
    }
}

/// A second start, after a stop, asks for Standby by itself.
#[test]
fn a_motor_is_started_again() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    assert_eq!(start(&mut rig, 2000).0, Ok(()));
    rig.master.stop();
    rig.run(0.02);
    let (result, _) = start(&mut rig, -1500);
    assert_eq!((result, rig.master.state()), (Ok(()), Some(State::HallClosedLoop)));
    rig.run(1.0);
    assert!((rig.speed() + 1500.0).abs() < 30.0, "{}", rig.speed());
}

/// A speed that is asked for while a start waits becomes the start's.
#[test]
fn the_speed_of_a_waiting_start_can_be_changed() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.master.begin(Job::Start { rpm: -2000 }).unwrap();
    rig.run(0.1);
    assert!(rig.master.is_start_pending());
    rig.master.set_speed(1200);
    assert_eq!(end(&mut rig).0, Ok(()));
    assert!(!rig.master.is_start_pending());
    rig.run(1.5);
    assert!((rig.speed() + 1200.0).abs() < 30.0, "{}", rig.speed());
}

#[test]
fn a_refused_start_says_why() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    for mode in [number::HALL_ENABLE, number::SENSORLESS_ENABLE] {
        set(&mut rig, mode, 0);
    }
    set(&mut rig, number::OPEN_LOOP_ENABLE, 0);
    let error = start(&mut rig, 2000).0.unwrap_err();
    assert_eq!(error, JobError::StartRefused { reason: 1, parameter: None });
    assert_eq!(error.to_string(), "the drive refused the start: no mode is enabled");
}

/// A fault on the way to the loop is told with its cause; a drive in Fault does not start.
#[test]
fn a_start_that_ends_in_fault_says_which() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    rig.bench.plant_mut().inject(Injection::Driver(Phase::B));
    for _ in 0..2 {
        let error = start(&mut rig, 2000).0.unwrap_err();
        let JobError::Fault { faults, code } = error else { panic!("{error:?}") };
        assert!(faults.contains(FaultWord::LEGS_DRIVER) && code == Cause::DriverLine as u16, "{error}");
        assert!(error.to_string().starts_with("the drive is in Fault: "), "{error}");
        assert!(error.to_string().ends_with("(legs_driver)"), "{error}");
    }
}

#[test]
fn a_start_without_a_drive_ends_by_its_time() {
    let mut master = Master::new(Config::default());
    let job = Job::Start { rpm: 2000 };
    master.begin(job).unwrap();
    let mut now = 0;
    let error = loop {
        while master.poll_frame(now).is_some() {}
        match master.poll_job() {
            Some(end) => break end.unwrap_err(),
            None => now = master.next_poll(now).max(now + 1),
        }
    };
    assert_eq!(error, JobError::TimedOut { job, within: 10_000_000, state: None });
    assert!((10_000_000..10_010_000).contains(&now), "{now} us");
    assert_eq!(error.to_string(), "no start within 10 s: no frames were received from the drive");
}

/// Another command ends a job; the motor accepts that command.
#[test]
fn another_command_ends_a_job() {
    let orders: [fn(&mut Rig); 3] =
        [|rig| rig.master.stop(), |rig| rig.master.shut_down(), |rig| rig.master.start(1000)];
    for order in orders {
        let mut rig = Rig::new(Mode::Sensorless, Config::default());
        let job = Job::Start { rpm: 2000 };
        rig.master.begin(job).unwrap();
        rig.until(State::RotorLock);
        order(&mut rig);
        assert_eq!(rig.master.poll_job(), Some(Err(JobError::Aborted(job))));
        assert_eq!(rig.master.poll_job(), None);
    }
    let mut silent = Rig::new(Mode::Hall, Config { silent: true, ..Config::default() });
    assert_eq!(silent.master.begin(Job::Reboot), Err(NotTaken::Silent));
}

/// A calibration finds misaligned sensors, and leaves the drive ready for a start.
#[test]
fn hall_sensors_are_calibrated() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.master.begin(Job::CalibrateHall).unwrap();
    let (result, time) = end(&mut rig);
    assert_eq!(result, Ok(()));
    assert!((2.0..15.0).contains(&time), "{time} s");
    assert_eq!(rig.master.state(), Some(State::Standby));
    assert_eq!(rig.ask(Request::Read { number: number::HALL_CALIBRATION_STATE }).result, Ok(2));
    assert_eq!(start(&mut rig, 2000).0, Ok(()));
}

/// A calibration without sensors fails; the next start is none.
#[test]
fn a_calibration_without_sensors_fails() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    for line in [Phase::A, Phase::B, Phase::C] {
        rig.bench.plant_mut().inject(Injection::HallStuck { line, high: false });
    }
    rig.master.begin(Job::CalibrateHall).unwrap();
    let error = end(&mut rig).0.unwrap_err();
    assert!(matches!(error, JobError::NotCalibrated { .. }), "{error:?}");
    assert!(error.to_string().starts_with("the hall calibration failed: the drive is in "), "{error}");
    assert_eq!(rig.ask(Request::Read { number: number::HALL_CALIBRATE }).result, Ok(0));
}

#[test]
fn a_drive_is_restarted() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    rig.master.begin(Job::Reboot).unwrap();
    let (result, time) = end(&mut rig);
    assert_eq!((result, rig.master.state()), (Ok(()), Some(State::Standby)));
    assert!((0.4..1.0).contains(&time), "{time} s");
    // A motor that turns is not restarted.
    assert_eq!(start(&mut rig, 2000).0, Ok(()));
    rig.master.begin(Job::Reboot).unwrap();
    assert!(matches!(end(&mut rig).0, Err(JobError::Request(Request::Reboot, _))));
    assert_eq!(rig.master.state(), Some(State::HallClosedLoop));
}
