//! Tests of position and speed of the rotor in every mode: mechanical position, electrical angle, speed.

use crate::bench::{Closed, MOTOR};
use narx_core::dictionary::number;
use narx_core::motor::commutate::commutation::{Direction, Step, sector_of};
use narx_core::motor::signal::{ShaftScale, Signal};
use narx_core::motor::{RunRequest, Samples, State};
use narx_sim::plant::{Injection, PlantConfig};

const OPEN_LOOP: [(u16, i32); 3] =
    [(number::SENSORLESS_ENABLE, 0), (number::OPEN_LOOP_ENABLE, 1), (number::OPEN_LOOP_SPEED, 300)];

/// A drive with `changes` whose hall lines show nothing.
fn without_halls(changes: &[(u16, i32)]) -> Closed {
    let mut closed = Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), changes);
    closed.plant.inject(Injection::HallSupplyLost);
    closed.boot();
    closed
}

fn electrical_turns(closed: &Closed) -> f64 {
    closed.plant.observe().electrical_turns
}

/// Number of sectors counted over these ticks, and number that the rotor has turned.
fn counted(closed: &mut Closed, ticks: u64) -> (f64, f64) {
    let (sectors, turns) = (closed.status.sectors, electrical_turns(closed));
    closed.run(ticks);
    (f64::from(closed.status.sectors - sectors), 6.0 * (electrical_turns(closed) - turns))
}

/// Sensorless and in open loop, in both directions, the commutation counts the rotor's sectors, within a
/// sector and the millisecond of a report.
#[test]
fn the_position_is_counted_without_sensors() {
    for request in [RunRequest::Drive, RunRequest::Reverse] {
        for (name, changes) in [("sensorless", &[][..]), ("open loop", &OPEN_LOOP[..])] {
            let mut closed = without_halls(changes);
            closed.ask(request);
            closed.run(15_000);
            let (counted, turned) = counted(&mut closed, 20_000);
            assert!(turned.abs() > 200.0, "{name}: {turned}");
            assert!((counted - turned).abs() < 3.0, "{name} {request:?}: {counted} of {turned}");
            assert!(!closed.status.unseen, "{name} {request:?}");
        }
    }
}

/// The counted sector is the rotor's with any source of the count: a restart loses whole revolutions at most.
#[test]
fn a_restart_keeps_the_electrical_place() {
    let mut closed = without_halls(&[]);
    closed.ask(RunRequest::Drive);
    closed.run(20_000);
    let offset =
        |closed: &Closed| (f64::from(closed.status.sectors) - 6.0 * electrical_turns(closed)).rem_euclid(6.0);
    let before = offset(&closed);
    closed.ask(RunRequest::Standby);
    closed.run(3_000);
    closed.ask(RunRequest::Drive);
    closed.run(30_000);
    let apart = (offset(&closed) - before).abs();
    assert!(apart.min(6.0 - apart) < 2.0, "{before}, then {}", offset(&closed));
}

/// A coasting rotor counts as unseen, not as standing, until its terminals have been quiet; with hall sensors
/// it is always seen.
#[test]
fn a_coasting_rotor_is_unseen_until_it_stands() {
    for changes in [&[][..], &OPEN_LOOP[..]] {
        let mut closed = without_halls(changes);
        assert!(closed.status.standstill && !closed.status.unseen, "{:?}", closed.status);
        closed.ask(RunRequest::Drive);
        closed.run(20_000);
        assert!(!closed.status.standstill && !closed.status.unseen, "{:?}", closed.status);
        closed.ask(RunRequest::Standby);
        closed.run(20);
        assert!(!closed.status.standstill && closed.status.unseen, "{:?}", closed.status);
        let mut ticks = 0;
        while !closed.status.standstill {
            closed.run(100);
            ticks += 100;
            assert!(ticks < 200_000, "{} rpm, {:?}", closed.rpm(), closed.status);
        }
        assert!(closed.rpm().abs() < 10.0, "said to stand at {} rpm", closed.rpm());
        assert!(!closed.status.unseen);
    }
    let mut closed = Closed::new(&PlantConfig::new(MOTOR, 24.0), &[]);
    closed.boot();
    closed.ask(RunRequest::Drive);
    closed.run(20_000);
    closed.ask(RunRequest::Standby);
    closed.run(20);
    assert!(!closed.status.standstill && !closed.status.unseen, "{:?}", closed.status);
    closed.run(50_000);
    assert!(closed.status.standstill, "{:?}", closed.status);
}

/// After a start that was ended at any moment the rotor is reported to stand a little later.
#[test]
fn a_rotor_whose_start_was_ended_is_seen_to_stand() {
    for ticks in (100..12_000).step_by(700) {
        let mut closed = without_halls(&[]);
        closed.ask(RunRequest::Drive);
        closed.run(ticks);
        let state = closed.status.state;
        closed.ask(RunRequest::Standby);
        closed.run(60_000);
        assert!(closed.rpm().abs() < 10.0, "{} rpm", closed.rpm());
        assert!(closed.status.standstill, "ended after {ticks} ticks in {state:?}: {:?}", closed.status);
    }
}

/// In open loop the angle is the field's, whatever the hall sensors show: the applied step belongs to its
/// sector. In rotor lock the angle is the lock's. Status and scope agree.
#[test]
fn the_angle_is_the_one_that_commutates() {
    let mut closed = Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), &OPEN_LOOP);
    closed.boot();
    closed.ask(RunRequest::Drive);
    let mut sectors = 0_u8;
    for _ in 0..10_000 {
        closed.tick();
        let scoped = closed.drive.signal(Signal::Angle, ShaftScale::new(4), &Samples::default());
        let angle = narx_core::units::ElectricalAngle((scoped as u16) << 4);
        let edge = angle.0.wrapping_add(32_768 / 6) % 10_923;
        if closed.output.step != Step::Coast && (800..10_100).contains(&edge) {
            assert_eq!(
                closed.output.step,
                Step::for_sector(sector_of(angle), Direction::Forward),
                "{angle:?}"
            );
            sectors |= 1 << sector_of(angle);
        }
    }
    assert_eq!(sectors, 63, "all six");

    let mut closed = Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), &[]);
    closed.boot();
    closed.ask(RunRequest::Drive);
    let (mut seen, mut locks) = (0, [0, 0]);
    while closed.drive.state() != State::OpenLoop {
        closed.tick();
        let lock = match closed.output.step {
            Step::LockC => 0,
            Step::LockCA => 1,
            _ => continue,
        };
        if closed.output.duty.to_bits() > 0 {
            let scoped = closed.drive.signal(Signal::Angle, ShaftScale::new(4), &Samples::default());
            let pulls_to = [60.0, 120.0][lock];
            assert!((f64::from(scoped) * 360.0 / 4096.0 - pulls_to).abs() < 1.0, "{scoped}: {pulls_to}");
            let report = f64::from(closed.status.angle.0) * 360.0 / 65_536.0;
            seen += u32::from((report - pulls_to).abs() < 1.0);
            locks[lock] += 1;
        }
    }
    assert!(locks.iter().all(|ticks| *ticks > 300), "{locks:?}");
    assert!(seen > locks.iter().sum::<u32>() - 30, "{seen} of {locks:?} in the reports");
}

/// In open loop speed and set-point are the field's; the speed without sensors has a sign for the direction.
#[test]
fn open_loop_has_a_speed() {
    for (request, sign) in [(RunRequest::Drive, 1.0), (RunRequest::Reverse, -1.0)] {
        let mut closed = without_halls(&OPEN_LOOP);
        closed.ask(request);
        closed.run(20_000);
        // 300 rpm of 4 pole pairs: 20 electrical revolutions per second.
        for speed in [closed.status.speed_sensorless, closed.status.setpoint] {
            let rev_s = f64::from(speed.to_bits()) / 65_536.0;
            assert!((rev_s - 20.0 * sign).abs() < 0.01, "{rev_s}");
        }
    }
}

/// The scope's mechanical position has 24 sectors per revolution and 4096 units per turn, is equal after a
/// whole turn, and never negative.
#[test]
fn the_scope_tells_the_place_within_a_revolution() {
    let scale = ShaftScale::new(4);
    for (sectors, place) in
        [(0, 0), (1, 170), (12, 2048), (23, 3925), (24, 0), (-1, 3925), (24_000_006, 1024)]
    {
        assert_eq!(scale.position(sectors), place, "{sectors}");
    }
    let mut closed = without_halls(&[]);
    closed.ask(RunRequest::Drive);
    closed.run(20_000);
    let mut places: Vec<i16> = (0..3_000)
        .map(|_| {
            closed.tick();
            closed.drive.signal(Signal::Position, scale, &Samples::default())
        })
        .collect();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), 24, "{places:?}");
}
