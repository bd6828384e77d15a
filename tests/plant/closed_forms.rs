//! Tests of transients with a closed solution.

use narx_core::motor::{Board, PwmCommand, Rectification, Step};
use narx_core::units::Duty;
use narx_sim::plant::{BackEmf, Injection, LoadConfig, MotorConfig, Plant, PlantConfig};
use std::f64::consts::FRAC_PI_3;

const RON: f64 = 0.02;
const DROP: f64 = 0.8;

/// Motor of the tests, on an ideal source of 24 V.
fn config(motor: MotorConfig) -> PlantConfig {
    let mut config = PlantConfig::new(motor, 24.0);
    config.inverter.own_conductance = 0.0;
    config.supply.resistance = 0.0;
    config.inverter.on_resistance = RON;
    config.inverter.diode_drop = DROP;
    config
}

fn full_duty(step: Step) -> PwmCommand {
    PwmCommand { duty: Duty::ONE, step, ..PwmCommand::default() }
}

fn run(plant: &mut Plant, command: &PwmCommand, ticks: u32) {
    for _ in 0..ticks {
        plant.sample();
        plant.finish_period(command);
    }
}

#[test]
fn a_locked_rotors_current_rises_with_l_over_r() {
    let motor = MotorConfig::default();
    let mut plant = Plant::new(&config(motor));
    plant.inject(Injection::BlockedRotor);
    let resistance = motor.resistance + 2.0 * RON + 1e-4;
    run(&mut plant, &full_duty(Step::AB), 1);
    for k in 1..=50 {
        run(&mut plant, &full_duty(Step::AB), 1);
        let t = f64::from(k) * 1e-4;
        let expected = 24.0 / resistance * (1.0 - (-t * resistance / motor.inductance).exp());
        let [a, b, c] = plant.observe().current;
        assert!((a / expected - 1.0).abs() < 1e-6, "tick {k}: {a} A, expected {expected} A");
        assert!(a == -b && c == 0.0);
    }
}

#[test]
fn hot_copper_carries_less_current() {
    // 25 to 190 degrees Celsius: +65 % (0.393 %/K).
    let motor = MotorConfig::default();
    let mut plant = Plant::new(&config(motor));
    plant.inject(Injection::BlockedRotor);
    plant.inject(Injection::Ambient(190.0));
    // Enough ticks for the winding, which follows the ambient at once here, and for L / R.
    run(&mut plant, &full_duty(Step::AB), 400);
    let resistance = motor.resistance * (1.0 + 0.003_93 * 165.0) + 2.0 * RON + 1e-4;
    let current = plant.observe().current[0];
    assert!((current * resistance / 24.0 - 1.0).abs() < 1e-9, "{current} A");
}

#[test]
fn viscous_friction_slows_exponentially_coulomb_linearly_a_fan_hyperbolically() {
    let speed = 200.0;
    let inertia = 1e-4;
    let ticks = 2000;
    let t = f64::from(ticks) * 1e-4;
    let cases = [
        (LoadConfig { viscous: 2e-4, ..LoadConfig::default() }, speed * (-2e-4 / inertia * t).exp()),
        (LoadConfig { constant: 0.05, ..LoadConfig::default() }, speed - 0.05 / inertia * t),
        (LoadConfig { quadratic: 1e-6, ..LoadConfig::default() }, speed / (1.0 + 1e-6 / inertia * speed * t)),
        (LoadConfig { machine: -0.05, ..LoadConfig::default() }, speed + 0.05 / inertia * t),
        (LoadConfig { machine: 0.2, ..LoadConfig::default() }, speed - 0.2 / inertia * t),
    ];
    for (load, expected) in cases {
        let motor = MotorConfig { inertia, ..MotorConfig::default() };
        let mut plant = Plant::new(&PlantConfig { load, speed, ..config(motor) });
        run(&mut plant, &PwmCommand::default(), ticks);
        let seen = plant.observe();
        assert!((seen.speed / expected - 1.0).abs() < 1e-6, "{load:?}: {} rad/s, not {expected}", seen.speed);
        assert_eq!(seen.current, [0.0; 3]);
    }
}

#[test]
fn a_machine_turns_a_resting_shaft_against_its_friction() {
    for (machine, acceleration) in [(0.2, -1500.0), (-0.2, 1500.0), (0.04, 0.0), (-0.04, 0.0)] {
        let motor = MotorConfig { inertia: 1e-4, static_friction: 0.05, ..MotorConfig::default() };
        let load = LoadConfig { machine, ..LoadConfig::default() };
        let mut plant = Plant::new(&PlantConfig { load, ..config(motor) });
        run(&mut plant, &PwmCommand::default(), 100);
        let speed = plant.observe().speed;
        assert!((speed - acceleration * 0.01).abs() < 1e-6, "{machine} N m: {speed} rad/s");
    }
}

#[test]
fn coulomb_friction_stops_the_shaft_and_holds_it() {
    let motor = MotorConfig { inertia: 1e-4, static_friction: 0.05, ..MotorConfig::default() };
    let mut plant = Plant::new(&PlantConfig { speed: 10.0, ..config(motor) });
    // Stops after J w / T = 20 ms, after a way of w^2 J / (2 T) = 0.1 rad.
    run(&mut plant, &PwmCommand::default(), 199);
    assert!(plant.observe().speed > 0.0);
    run(&mut plant, &PwmCommand::default(), 2);
    assert_eq!(plant.observe().speed, 0.0);
    assert!((plant.observe().angle - 0.1).abs() < 1e-6, "{} rad", plant.observe().angle);
    // A torque below friction moves nothing; one above it does: 0.033 N m at 1.8 % duty, 0.17 N m at 9 %.
    let at = |bits| PwmCommand {
        duty: Duty::from_bits(bits),
        rectification: Rectification::Synchronous,
        step: Step::AB,
        ..PwmCommand::default()
    };
    let angle = plant.observe().angle;
    run(&mut plant, &at(600), 500);
    assert_eq!((plant.observe().speed, plant.observe().angle), (0.0, angle));
    run(&mut plant, &at(3000), 500);
    assert!(plant.observe().angle != angle);
}

#[test]
fn demagnetisation_takes_what_the_freewheeling_loop_says() {
    // 1 us periods resolve the instant; the commutation acts at the start of one.
    let motor = MotorConfig { inductance: 5e-4, ..MotorConfig::default() };
    let mut config = config(motor);
    config.board = Board { tick_rate: 1_000_000, earliest: 0, dead_time_ns: 0, ..Board::BENCH };
    let mut plant = Plant::new(&config);
    plant.inject(Injection::BlockedRotor);
    run(&mut plant, &full_duty(Step::AB), 150);
    let start = plant.observe();
    let current = -start.current[1];
    assert!(current > 5.0);
    // B's current continues through its high-side diode: A and B at the bus, C low. Its driving voltage is
    // (v + 2 drop) / 3, and it falls with L / R of one phase.
    let (r, l) = (0.5 * motor.resistance + RON, 0.5 * motor.inductance);
    let drive = (start.bus_voltage + 2.0 * DROP) / 3.0;
    let expected = l / r * (1.0 + current * r / drive).ln();
    let mut before = -current;
    for k in 1..1000 {
        run(&mut plant, &full_duty(Step::AC), 1);
        let now = plant.observe().current[1];
        assert!(now <= 0.0, "the diode does not conduct backwards: {now} A");
        if now == 0.0 {
            // At its end the current falls along a straight line.
            let slope = drive / l;
            let time = (f64::from(k) - 1.0) * 1e-6 - before / slope;
            assert!((time - expected).abs() < 2e-8, "{time} s, expected {expected} s");
            // CONTROL's rule of thumb for the time: 1.5 L I / V.
            assert!((time / (1.5 * motor.inductance * current / 24.0) - 1.0).abs() < 0.15);
            return;
        }
        before = now;
    }
    panic!("never demagnetised");
}

#[test]
fn a_motor_turned_faster_than_the_supply_pumps_the_bus_through_its_diodes() {
    let motor = MotorConfig { back_emf: BackEmf::Sinusoidal, inertia: 1.0, ..MotorConfig::default() };
    // The capacitor charges to the line-to-line peak less two drops; from far below, the inductance
    // overshoots a little.
    for (may_sink, speed, swing) in
        [(false, 690.0, 0.15), (false, 800.0, 0.15), (false, 600.0, 0.0), (true, 800.0, 0.0)]
    {
        let mut config = config(motor);
        config.supply.may_sink = may_sink;
        config.speed = speed;
        let mut plant = Plant::new(&config);
        run(&mut plant, &PwmCommand::default(), 5000);
        let seen = plant.observe();
        let peak = FRAC_PI_3 * motor.torque_constant * seen.speed - 2.0 * DROP;
        let expected = if may_sink { 24.0 } else { peak.max(24.0) };
        let above = seen.bus_voltage - expected;
        assert!((-0.01..=swing + 1e-3).contains(&above), "{speed} rad/s: {above} V above {expected} V");
        let quiet = peak < 24.0;
        assert_eq!(seen.diode_events == 0, quiet, "{} events", seen.diode_events);
    }
}

#[test]
fn braking_in_synchronous_pwm_pumps_a_bus_that_cannot_sink() {
    let motor = MotorConfig { inertia: 5e-5, ..MotorConfig::default() };
    let mut tops = [0.0f64; 2];
    for may_sink in [false, true] {
        let mut config = config(motor);
        config.supply.may_sink = may_sink;
        config.speed = 300.0;
        let mut plant = Plant::new(&config);
        for _ in 0..100 {
            plant.sample();
            let sector = crate::driving::sector_at(plant.observe().electrical_turns);
            plant.finish_period(&PwmCommand {
                duty: Duty::from_bits(10_000),
                rectification: Rectification::Synchronous,
                step: Step::for_sector(sector, narx_core::motor::Direction::Forward),
                ..PwmCommand::default()
            });
            let top = &mut tops[usize::from(may_sink)];
            *top = top.max(plant.observe().bus_voltage);
        }
        assert!(plant.observe().speed < 300.0);
    }
    assert!(tops[0] > 32.0, "a bus without sink rises far: {} V", tops[0]);
    assert!(tops[1] < 24.01, "an ideal source holds it: {} V", tops[1]);
}

#[test]
fn an_idle_diode_stays_off() {
    // Coasting below the bus voltage, through every angle: no diode ever changes.
    let motor = MotorConfig { inertia: 1e-2, ..MotorConfig::default() };
    let mut plant = Plant::new(&PlantConfig { speed: 500.0, ..config(motor) });
    run(&mut plant, &PwmCommand::default(), 5000);
    assert_eq!(plant.observe().diode_events, 0);
    // At full duty only commutations move diodes: a demagnetisation ends.
    let mut plant = Plant::new(&PlantConfig { speed: 500.0, ..config(motor) });
    let ideal = crate::driving::Ideal::forward(1.0);
    ideal.run(&mut plant, 0.5);
    let seen = plant.observe();
    let commutations = seen.electrical_turns * 6.0;
    assert!(commutations > 500.0);
    let each = seen.diode_events as f64 / commutations;
    assert!(each < 2.0, "{each} changes of diodes a commutation");
    println!("{each:.2} changes of diodes a commutation at full duty");
}
