//! The plant whose gates the caller sets: closed forms, and the other plant.

use narx_core::motor::{PwmCommand, Rectification, Step};
use narx_core::units::Duty;
use narx_sim::plant::{Gate, GatedPlant, LoadConfig, MotorConfig, Plant, PlantConfig};

const HIGH_LOW: [Gate; 3] = [Gate::High, Gate::Low, Gate::Off];

fn config() -> PlantConfig {
    let mut config = PlantConfig::new(MotorConfig::default(), 24.0);
    config.inverter.own_conductance = 0.0;
    config.supply.resistance = 0.0;
    config
}

#[test]
fn a_blocked_rotors_current_rises_with_l_over_r() {
    let config = config();
    let mut plant = GatedPlant::new(&config);
    plant.set_blocked(true);
    plant.set_gates(HIGH_LOW);
    let resistance = config.motor.resistance + 2.0 * config.inverter.on_resistance + 1e-4;
    for step in 1..=20 {
        assert!((plant.advance(50e-6, None) - 50e-6).abs() < 1e-15);
        let expected = 24.0 / resistance
            * (1.0 - (-f64::from(step) * 50e-6 * resistance / config.motor.inductance).exp());
        let [a, b, c] = plant.currents();
        assert!((a / expected - 1.0).abs() < 1e-6, "step {step}: {a} A, expected {expected} A");
        assert!(a == -b && c == 0.0);
        assert_eq!(plant.shunts(), [0.0, a, 0.0], "only the low leg's current flows through a shunt");
    }
}

#[test]
fn it_stops_where_a_shunts_current_passes_the_limit() {
    let mut plant = GatedPlant::new(&config());
    plant.set_blocked(true);
    plant.set_gates(HIGH_LOW);
    let passed = plant.advance(1e-3, Some(10.0));
    let current = plant.shunts()[1];
    // 24 V at 0.2 mH are 0.12 A/us; the limit is passed within 50 ns.
    assert!((10.0..10.01).contains(&current), "{current} A after {passed} s");
    assert!(passed < 1e-3 && (plant.time() - passed).abs() < 1e-15);
    assert!((plant.advance(10e-6, Some(10.0)) - 10e-6).abs() < 1e-15, "beyond the limit it goes on");
}

#[test]
fn hall_edges_stop_it_and_carry_their_instants() {
    let mut config = config();
    config.angle_deg = 0.0;
    config.speed = 100.0;
    config.motor.inertia = 1.0;
    let mut plant = GatedPlant::new(&config);
    // Line C falls at 30 electrical degrees, 4 pole pairs: 7.5 mechanical degrees.
    let expected = 7.5_f64.to_radians() / 100.0;
    let before = plant.hall();
    let passed = plant.advance(1.0, None);
    let edges: Vec<_> = plant.hall_edges().collect();
    assert_eq!(edges.len(), 1);
    assert!((edges[0].time - expected).abs() < 1e-8, "{} s, expected {expected} s", edges[0].time);
    assert!(passed > expected - 1e-9 && passed < expected + 200e-6);
    assert_eq!((edges[0].code, plant.hall()), (before & 0b011, before & 0b011));
    plant.advance(1e-4, None);
    assert_eq!(plant.hall_edges().count(), 0, "edges are those of the last stretch");
}

/// Both plants with one duty, dead time and step have one speed, current and bus voltage.
#[test]
fn it_agrees_with_the_plant_of_the_bench() {
    let mut config = config();
    config.load = LoadConfig { viscous: 2e-5, ..LoadConfig::default() };
    config.board.dead_time_ns = 0;
    let command = PwmCommand {
        step: Step::AB,
        duty: Duty::from_bits(9830),
        rectification: Rectification::Synchronous,
        ..PwmCommand::default()
    };
    let mut bench = Plant::new(&config);
    let mut plant = GatedPlant::new(&config);
    bench.sample();
    bench.finish_period(&command);
    plant.set_gates([Gate::Off, Gate::Low, Gate::Off]);
    plant.advance(100e-6, None);
    for _ in 0..200 {
        bench.sample();
        bench.finish_period(&command);
        let half = 0.5 * f64::from(command.duty.to_bits()) / 32_768.0 * 100e-6;
        for (gate, seconds) in [(Gate::High, half), (Gate::Low, 100e-6 - 2.0 * half), (Gate::High, half)] {
            plant.set_gates([gate, Gate::Low, Gate::Off]);
            let end = plant.time() + seconds;
            while end - plant.time() > 1e-12 {
                plant.advance(end - plant.time(), None);
            }
        }
    }
    let truth = bench.observe();
    assert!(
        (plant.speed() - truth.speed).abs() < 0.01 * truth.speed.abs() + 0.2,
        "{} {}",
        plant.speed(),
        truth.speed
    );
    assert!(
        (plant.currents()[0] - truth.current[0]).abs() < 0.05,
        "{:?} {:?}",
        plant.currents(),
        truth.current
    );
    assert!((plant.bus_voltage() - truth.bus_voltage).abs() < 0.01);
}

#[test]
fn a_broken_cable_carries_nothing() {
    let mut plant = GatedPlant::new(&config());
    plant.set_open([true, false, false]);
    plant.set_gates(HIGH_LOW);
    plant.advance(200e-6, None);
    assert_eq!(plant.currents(), [0.0; 3]);
    plant.set_open([false; 3]);
    plant.advance(200e-6, None);
    assert!(plant.currents()[0] > 5.0 && plant.charge() > 0.0);
}
