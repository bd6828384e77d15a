//! Between edges, crossings and commands a tick looks at nothing but the loops. That must not show: a drive that is made to look at
//! everything in every tick answers the same.

use crate::bench::{Closed, MOTOR, Outcome};
use narx_core::motor::{Request, State};
use narx_sim::plant::{ComparatorConfig, Injection, LoadConfig, PlantConfig};

fn watched(supply: f64) -> Closed {
    let mut config = PlantConfig::new(MOTOR, supply);
    config.angle_deg = 40.0;
    let mut closed = Closed::new(&config, &[]);
    closed.watch();
    closed.boot();
    closed
}

/// Other set-points and loads, the first one from standstill for `start` ticks.
fn drive_around(closed: &mut Closed, start: u64) {
    for (set_point, load, ticks) in
        [(800.0, 0.0, start), (2_500.0, 0.02, 8_000), (1_200.0, 0.0, 8_000), (1_200.0, 0.05, 5_000)]
    {
        closed.set_point = set_point;
        closed.plant.set_load(LoadConfig { constant: load, ..LoadConfig::default() });
        closed.ask(Request::Drive);
        assert_eq!(closed.run(ticks), Outcome::Running, "{set_point} rpm");
    }
}

fn turn_back(closed: &mut Closed) {
    closed.ask(Request::Reverse);
    assert_eq!(closed.run(25_000), Outcome::Running);
    assert!(closed.rpm() < -1_000.0, "{} rpm", closed.rpm());
}

#[test]
fn a_calm_tick_is_a_whole_tick() {
    for supply in [18.0, 24.0, 60.0] {
        let mut closed = watched(supply);
        drive_around(&mut closed, 6_000);
        turn_back(&mut closed);
        closed.plant.inject(Injection::HallGlitches(200.0));
        closed.run(5_000);
        closed.plant.clear(Injection::HallGlitches(200.0));
        closed.plant.inject(Injection::BlockedRotor);
        assert!(matches!(closed.run(10_000), Outcome::Fault { .. }));
    }
}

#[test]
fn a_calm_tick_without_sensors_is_a_whole_tick() {
    for supply in [18.0, 24.0, 60.0] {
        let mut config = PlantConfig::new(MOTOR, supply);
        config.angle_deg = 40.0;
        if supply == 60.0 {
            config.comparator = Some(ComparatorConfig { delay: 2e-6, hysteresis: 0.1 });
            config.board.comparator_capture = true;
        }
        let mut closed = Closed::sensorless(&config, &[]);
        if supply == 18.0 {
            closed.plant.inject(Injection::HallSupplyLost);
        }
        closed.watch();
        closed.boot();
        drive_around(&mut closed, 12_000);
        closed.plant.set_load(LoadConfig::default());
        turn_back(&mut closed);
        // Blocked, it gives up, each try watched.
        closed.plant.inject(Injection::BlockedRotor);
        closed.run(40_000);
        assert!(closed.rpm().abs() < 1.0 && closed.status.state != State::SensorlessClosedLoop);
    }
}
