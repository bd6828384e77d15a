//! Tests of parameter 304, notable conditions that are no faults, and of the mechanical position that it
//! refers to.

use crate::bench::{Bench, speed};
use narx_core::bus::narmotion::{FromDrive, Measurement, ParameterStatus, ToDrive};
use narx_core::commissioning::Mode;
use narx_core::dictionary::{Parameters, number};
use narx_core::master::{Request, Service};
use narx_core::motor::machine::event::Status;
use narx_core::motor::machine::state::State;
use narx_sim::plant::Injection;
use narx_sim::presets::preset;
use narx_sim::session::{Session, SessionConfig};

const SUPPLY_LOW: i32 = 1;
const POSITION_UNKNOWN: i32 = 2;
const WRONG_LOCK_UNSEEN: i32 = 4;

/// A supply below 18 V is reported while it lasts.
#[test]
fn a_low_supply_is_told() {
    let mut bench = Bench::new();
    for supply_low in [false, true, false] {
        bench.node.handle_status(Status { state: State::Standby, supply_low, ..Status::default() });
        let found = bench.read(number::DIAGNOSTICS).0 & SUPPLY_LOW;
        assert_eq!(found != 0, supply_low);
    }
}

/// Without back-EMF constant or resistance a stable wrong lock cannot be found: this is reported if
/// sensorless control is enabled.
#[test]
fn a_rail_that_cannot_work_is_told() {
    for (sensorless, back_emf, resistance) in
        [(0, 0, 0), (1, 0, 0), (1, 3770, 0), (1, 0, 360), (1, 3770, 360)]
    {
        let mut parameters = Parameters::new();
        parameters.set(number::SENSORLESS_ENABLE, sensorless).unwrap();
        parameters.set(number::BACK_EMF_CONSTANT, back_emf).unwrap();
        parameters.set(number::WINDING_RESISTANCE, resistance).unwrap();
        let found = Bench::with_parameters(parameters).read(number::DIAGNOSTICS).0 & WRONG_LOCK_UNSEEN;
        let off = sensorless == 1 && (back_emf == 0 || resistance == 0);
        assert_eq!(found != 0, off, "{sensorless} {back_emf} {resistance}");
    }
}

/// A rotor that may have turned unseen leaves the position unknown until parameter 17 sets it.
#[test]
fn a_position_is_unknown_until_it_is_set() {
    let mut bench = Bench::new();
    let unknown = |bench: &mut Bench| bench.read(number::DIAGNOSTICS).0 & POSITION_UNKNOWN != 0;
    let tell = |bench: &mut Bench, unseen| {
        bench.node.handle_status(Status { state: State::Standby, unseen, ..Status::default() });
    };
    assert!(!unknown(&mut bench));
    tell(&mut bench, true);
    assert!(unknown(&mut bench));
    tell(&mut bench, false);
    assert!(unknown(&mut bench), "what has been missed is not made good by looking again");
    let set = |bench: &mut Bench| {
        bench.write(number::SET_POSITION, 0);
        assert_eq!(bench.write(number::SET_POSITION, 1).1, ParameterStatus::Done);
    };
    set(&mut bench);
    assert!(!unknown(&mut bench));
    tell(&mut bench, true);
    set(&mut bench);
    assert!(unknown(&mut bench), "it still turns unseen");
}

/// Mechanical position that the master received last, degrees.
fn position(session: &mut Session) -> f64 {
    let sent = session.master().measurements().find("Mechanical position").unwrap().value;
    sent.digits as f64 * 10_f64.powi(sent.exponent.into())
}

/// Diagnostics of the drive, requested over the bus.
fn diagnostics(session: &mut Session) -> i32 {
    session.master().request(Request::Read { number: number::DIAGNOSTICS }).unwrap();
    session.run(0.05);
    session.master().parameters().get(number::DIAGNOSTICS).unwrap().value
}

/// A whole drive without hall sensors sends in MEASUREMENT_1 the position by which the shaft has turned,
/// parameters 16 and 17 set it, and once the bridge is off it is unknown.
#[test]
fn a_drive_without_sensors_tells_its_position() {
    let motor = preset("bly172s-24v").unwrap().motor;
    for mode in [Mode::Sensorless, Mode::OpenLoop] {
        let mut session = Session::new(&SessionConfig::new(motor, 24.0, mode)).unwrap();
        session.bench_mut().plant_mut().inject(Injection::HallSupplyLost);
        session.run(0.6);
        session.start(1999);
        session.run(3.0);
        let shaft = |session: &Session| session.bench().plant().observe().angle.to_degrees();
        let (sent, turned) = (position(&mut session), shaft(&session));
        session.run(1.0);
        let (sent, turned) = (position(&mut session) - sent, shaft(&session) - turned);
        assert!(turned > 1_000.0, "{mode:?}: {turned}");
        // 50 ms between two broadcasts, at either end.
        assert!((sent - turned).abs() < 0.11 * turned, "{mode:?}: {sent} of {turned} degrees");
        assert_eq!(diagnostics(&mut session), 0, "{mode:?}");
        session.stop();
        session.run(0.1);
        assert_eq!(diagnostics(&mut session), POSITION_UNKNOWN, "{mode:?}");
        session.run(3.0);
        let write = Request::Write { number: number::POSITION_CALIBRATION, raw: 9_000 };
        session.master().request(write).unwrap();
        session.run(0.05);
        session.master().request(Request::Run(Service::SetPosition)).unwrap();
        session.run(0.2);
        assert_eq!(diagnostics(&mut session), 0, "{mode:?}");
        assert!((position(&mut session) - 90.0).abs() < 0.01, "{mode:?}");
    }
}

/// The accepted set-point is limited by the motor's pole pairs while parameters 101 to 104 have their factory
/// values.
#[test]
fn the_accepted_set_point_follows_the_pole_pairs() {
    for (enable, pole_pairs, asked, accepted) in [
        (number::HALL_ENABLE, 4, 9000, 4000),
        (number::HALL_ENABLE, 2, 9000, 8000),
        (number::SENSORLESS_ENABLE, 8, 9000, 2000),
        (number::SENSORLESS_ENABLE, 8, 10, 250),
        (number::HALL_ENABLE, 1, 1500, 2000),
    ] {
        let mut parameters = Parameters::new();
        parameters.set(enable, 1).unwrap();
        parameters.set(number::MOTOR_POLE_PAIRS, pole_pairs).unwrap();
        let mut bench = Bench::with_parameters(parameters);
        bench.send(ToDrive::MotorCommand { speed: asked });
        assert_eq!(bench.messages(), [FromDrive::MotorCommand { speed: accepted }], "{pole_pairs}: {asked}");
    }
}

/// In open loop the speed on the bus is the field's.
#[test]
fn open_loop_has_a_speed_on_the_bus() {
    let mut bench = Bench::new();
    bench.node.handle_status(Status {
        state: State::OpenLoop,
        speed_sensorless: speed(300, 4),
        ..Status::default()
    });
    bench.node.poll(0);
    let shows = |message: &FromDrive| {
        matches!(message, FromDrive::Measurement(Measurement::M1 { speed_sensorless: 300, .. }))
    };
    assert!(bench.messages().iter().any(shows));
}
