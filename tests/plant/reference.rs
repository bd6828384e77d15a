//! Tests of the plant against an integrator that shares nothing with it: no states of diodes, no decoupled
//! circuit, no closed forms. Each leg is one current-voltage curve (a switch, or two diodes and a megohm),
//! the star point's voltage is found by Newton's method at every step, and time goes on in backward Euler
//! steps of nanoseconds.

use crate::driving::Ideal;
use narx_core::motor::{Commutation, Leg, PwmCommand, Rectification, Step};
use narx_sim::plant::{BackEmf, MotorConfig, Plant, PlantConfig};
use narx_sim::presets::preset;
use std::f64::consts::{PI, TAU};

const R_OFF: f64 = 1e6;

/// Gates of one leg.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Gate {
    Off,
    High,
    Low,
}

/// States of the gates, from the commands alone.
struct Timing<'a> {
    commands: &'a [PwmCommand],
    period: f64,
    dead_time: f64,
    earliest: f64,
}

impl Timing<'_> {
    /// All switching instants with the gates after each, including the dead time.
    fn edges(&self) -> Vec<(f64, [Gate; 3])> {
        let mut raw: Vec<(f64, [Gate; 3])> = Vec::new();
        let none = PwmCommand::default();
        for (k, command) in self.commands.iter().enumerate() {
            // Duty and rectification come from the previous command, and so does the step until `earliest`.
            let latched = if k == 0 { &none } else { &self.commands[k - 1] };
            let half_on = 0.5 * f64::from(latched.duty.to_bits()) / 32_768.0;
            let mut steps = vec![(0.0, last_step(latched))];
            steps.push((self.earliest, command.step));
            steps.extend(command.commutations.iter().map(|c| (f64::from(c.instant) / 65_536.0, c.step)));
            let mut instants = vec![0.0, half_on, 1.0 - half_on];
            instants.extend(steps.iter().map(|step| step.0));
            instants.sort_by(f64::total_cmp);
            for at in instants {
                let step = steps.iter().rev().find(|step| step.0 <= at).unwrap().1;
                let on = at < half_on || at >= 1.0 - half_on;
                let gates = step.legs().map(|leg| match (leg, on, latched.rectification) {
                    (Leg::Floating, ..) => Gate::Off,
                    (Leg::Low, ..) => Gate::Low,
                    (Leg::Switched, true, _) => Gate::High,
                    (Leg::Switched, false, Rectification::Synchronous) => Gate::Low,
                    (Leg::Switched, false, Rectification::Diode) => Gate::Off,
                });
                raw.push(((k as f64 + at) * self.period, gates));
            }
        }
        self.with_dead_time(&raw)
    }

    /// Delays each turning-on until the dead time has passed since the other switch of the leg turned off.
    fn with_dead_time(&self, raw: &[(f64, [Gate; 3])]) -> Vec<(f64, [Gate; 3])> {
        let mut changes: Vec<(f64, usize, Gate)> = Vec::new();
        for leg in 0..3 {
            let mut runs: Vec<(f64, Gate)> = vec![(0.0, Gate::Off)];
            for (t, gates) in raw {
                if runs.last().unwrap().1 != gates[leg] {
                    runs.push((*t, gates[leg]));
                }
            }
            let mut released: Option<(f64, Gate)> = None;
            for (n, &(start, gate)) in runs.iter().enumerate() {
                let end = runs.get(n + 1).map_or(f64::MAX, |next| next.0);
                let mut on_at = start;
                if gate != Gate::Off
                    && let Some((off_at, other)) = released
                    && other != gate
                {
                    on_at = on_at.max(off_at + self.dead_time);
                }
                if on_at > start {
                    changes.push((start, leg, Gate::Off));
                }
                if on_at < end {
                    changes.push((on_at, leg, gate));
                    if gate != Gate::Off {
                        released = Some((end, gate));
                    }
                }
            }
        }
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut now = [Gate::Off; 3];
        changes
            .iter()
            .map(|&(t, leg, gate)| {
                now[leg] = gate;
                (t, now)
            })
            .collect()
    }
}

fn last_step(command: &PwmCommand) -> Step {
    command.commutations.iter().last().map_or(command.step, |c| c.step)
}

/// Circuit and shaft.
struct Reference<'a> {
    config: &'a PlantConfig,
    i: [f64; 3],
    v: f64,
    neutral: f64,
    speed: f64,
    angle: f64,
}

impl Reference<'_> {
    fn emf_per_speed(&self) -> [f64; 3] {
        let motor = &self.config.motor;
        [0.0, TAU / 3.0, 2.0 * TAU / 3.0].map(|lag| {
            let x = self.angle - lag;
            match motor.back_emf {
                BackEmf::Sinusoidal => motor.torque_constant * PI / 3.0 / 3f64.sqrt() * x.sin(),
                BackEmf::Trapezoidal { flat_top_deg } => {
                    assert_eq!(flat_top_deg, 120.0);
                    // A triangle wave with three times the amplitude, clipped at 1: asin(sin x) is a
                    // triangle.
                    (x.sin().asin() * 6.0 / PI).clamp(-1.0, 1.0) * 0.5 * motor.torque_constant
                }
            }
        })
    }

    /// Current, and d(current)/d(neutral), of a phase one step of `dt` later, for an estimate of the neutral.
    fn phase(&self, gate: Gate, i: f64, emf: f64, dt: f64) -> (f64, f64) {
        let motor = &self.config.motor;
        let inverter = &self.config.inverter;
        let (l, r, ron, drop) =
            (0.5 * motor.inductance, 0.5 * motor.resistance, inverter.on_resistance, inverter.diode_drop);
        // i' (L/dt + R) - T(i') = L i / dt - neutral - emf
        let inertia = l / dt + r;
        let right = l * i / dt - self.neutral - emf;
        let line = |offset: f64, slope: f64| ((right + offset) / (inertia + slope), -1.0 / (inertia + slope));
        match gate {
            Gate::High => line(self.v, ron),
            Gate::Low => line(0.0, ron),
            Gate::Off => {
                let edge = (0.5 * self.v + drop) / R_OFF;
                let idle = line(0.5 * self.v, R_OFF);
                if idle.0 > edge {
                    line(-drop + ron * edge, ron)
                } else if idle.0 < -edge {
                    line(self.v + drop - ron * edge, ron)
                } else {
                    idle
                }
            }
        }
    }

    fn step(&mut self, gates: &[Gate; 3], dt: f64) {
        let shape = self.emf_per_speed();
        let mut next = [0.0; 3];
        for _ in 0..60 {
            let (mut sum, mut slope) = (0.0, 0.0);
            for x in 0..3 {
                let (i, di) = self.phase(gates[x], self.i[x], shape[x] * self.speed, dt);
                next[x] = i;
                sum += i;
                slope += di;
            }
            if sum.abs() < 1e-12 {
                break;
            }
            self.neutral -= sum / slope;
        }
        self.i = next;
        let edge = (0.5 * self.v + self.config.inverter.diode_drop) / R_OFF;
        let mut drawn = 0.0;
        for x in 0..3 {
            if gates[x] == Gate::High || (gates[x] == Gate::Off && next[x] < -edge) {
                drawn += next[x];
            }
        }
        let supply = &self.config.supply;
        let c = self.config.inverter.capacitance;
        let g = if supply.may_sink || self.v < supply.voltage { 1.0 / supply.resistance } else { 0.0 };
        self.v = (c * self.v / dt + g * supply.voltage - drawn) / (c / dt + g);
        self.turn(&shape, dt);
    }

    fn turn(&mut self, shape: &[f64; 3], dt: f64) {
        let motor = &self.config.motor;
        let load = &self.config.load;
        let torque: f64 = (0..3).map(|x| shape[x] * self.i[x]).sum();
        let coulomb = (motor.static_friction + load.constant) * self.speed.signum();
        let drag = motor.viscous_friction * self.speed + coulomb;
        self.speed += (torque - drag) / (motor.inertia + load.inertia) * dt;
        self.angle += f64::from(motor.pole_pairs) * self.speed * dt;
    }
}

/// Currents and bus voltage at the end of every period.
fn reference(config: &PlantConfig, commands: &[PwmCommand], dt: f64) -> Vec<([f64; 3], f64)> {
    let period = 1.0 / f64::from(config.board.tick_rate);
    let timing = Timing {
        commands,
        period,
        dead_time: f64::from(config.board.dead_time_ns) * 1e-9,
        earliest: f64::from(config.board.earliest) / 65_536.0,
    };
    let mut stops: Vec<(f64, Option<[Gate; 3]>)> =
        timing.edges().into_iter().map(|(t, gates)| (t, Some(gates))).collect();
    stops.extend((1..=commands.len()).map(|k| (k as f64 * period, None)));
    stops.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut state = Reference {
        config,
        i: [0.0; 3],
        v: config.supply.voltage,
        neutral: 0.0,
        speed: config.speed,
        angle: config.angle_deg.to_radians(),
    };
    let mut gates = [Gate::Off; 3];
    let mut t = 0.0;
    let mut ends = Vec::new();
    for (stop, change) in stops {
        let steps = ((stop - t) / dt).ceil();
        for _ in 0..steps as usize {
            state.step(&gates, (stop - t) / steps);
        }
        t = stop;
        match change {
            Some(next) => gates = next,
            None => ends.push((state.i, state.v)),
        }
    }
    ends
}

/// RMS difference of all phase currents over 100 ms, as a share of `rated`; the reference may have another
/// plant, `truth`.
fn difference(config: &PlantConfig, truth: &PlantConfig, ideal: Ideal, rated: f64, dt: f64) -> f64 {
    let mut plant = Plant::new(config);
    let mut commands = Vec::new();
    let mut currents = Vec::new();
    for _ in 0..1000 {
        plant.sample();
        let command = ideal.command(&plant.observe(), &plant);
        plant.finish_period(&command);
        commands.push(command);
        currents.push(plant.observe().current);
    }
    let coarse = reference(truth, &commands, dt);
    let fine = reference(truth, &commands, 0.5 * dt);
    let mut squares = 0.0;
    let mut doubt = 0.0;
    for (seen, (coarse, fine)) in currents.iter().zip(coarse.iter().zip(&fine)) {
        for (amp, (coarse, fine)) in seen.iter().zip(coarse.0.iter().zip(fine.0)) {
            // The error of backward Euler is of first order: extrapolation from two runs removes it.
            let exact = 2.0 * fine - coarse;
            squares += (amp - exact).powi(2);
            doubt += (fine - exact).powi(2);
        }
    }
    let rms = |sum: f64| (sum / 3000.0).sqrt() / rated;
    println!("difference {:.2e}, unextrapolated reference {:.2e} (of rated, RMS)", rms(squares), rms(doubt));
    rms(squares)
}

#[test]
fn agrees_with_the_reference_over_100_ms() {
    for (name, rectification, duty) in [
        ("ec45-flat-50w-18v", Rectification::Synchronous, 0.6),
        ("ec45-flat-50w-18v", Rectification::Diode, 0.6),
        ("bly172s-24v", Rectification::Synchronous, 0.35),
        ("bly172s-24v", Rectification::Diode, 0.8),
    ] {
        let preset = preset(name).unwrap();
        let mut motor = MotorConfig { thermal_resistance: 0.0, cogging_torque: 0.0, ..preset.motor };
        if duty == 0.8 {
            motor.back_emf = BackEmf::Trapezoidal { flat_top_deg: 120.0 };
        }
        let mut config = PlantConfig::new(motor, preset.data.nominal_voltage);
        config.inverter.own_conductance = 0.0;
        config.load.constant = 0.03;
        config.speed = 50.0;
        let ideal = Ideal { rectification, ..Ideal::forward(duty) };
        let rms = difference(&config, &config, ideal, preset.data.rated_current.unwrap(), 40e-9);
        assert!(rms < 1e-4, "{name} {rectification:?}: {rms:.2e} of the rated current");
    }
}

#[test]
fn the_comparison_notices_a_small_error() {
    let preset = preset("ec45-flat-50w-18v").unwrap();
    let motor = MotorConfig { thermal_resistance: 0.0, cogging_torque: 0.0, ..preset.motor };
    let mut config = PlantConfig::new(motor, preset.data.nominal_voltage);
    config.inverter.own_conductance = 0.0;
    config.speed = 50.0;
    let ideal = Ideal::forward(0.6);
    let alter: [fn(&mut PlantConfig); 3] = [
        |config| config.board.dead_time_ns += 50,
        |config| config.inverter.diode_drop += 0.05,
        |config| config.motor.inductance *= 1.005,
    ];
    for change in alter {
        let mut truth = config.clone();
        change(&mut truth);
        assert!(difference(&config, &truth, ideal, 3.68, 200e-9) > 1e-4);
    }
}

/// Largest differences of any phase current and of the bus voltage at the ends of all periods, A and V, and
/// the number of periods in which the bus is above its source.
fn largest(
    config: &PlantConfig,
    periods: usize,
    next: impl Fn(usize, &Plant) -> PwmCommand,
) -> (f64, f64, i32) {
    let mut plant = Plant::new(config);
    let (mut commands, mut seen) = (Vec::new(), Vec::new());
    for k in 0..periods {
        plant.sample();
        let command = next(k, &plant);
        plant.finish_period(&command);
        commands.push(command);
        seen.push(plant.observe());
    }
    let coarse = reference(config, &commands, 40e-9);
    let fine = reference(config, &commands, 20e-9);
    let (mut amps, mut volts, mut above) = (0.0_f64, 0.0_f64, 0);
    for (seen, (coarse, fine)) in seen.iter().zip(coarse.iter().zip(&fine)) {
        for (amp, (coarse, fine)) in seen.current.iter().zip(coarse.0.iter().zip(fine.0)) {
            amps = amps.max((amp - (2.0 * fine - coarse)).abs());
        }
        volts = volts.max((seen.bus_voltage - (2.0 * fine.1 - coarse.1)).abs());
        above += i32::from(seen.bus_voltage > config.supply.voltage + 0.01);
    }
    println!("{amps:.2e} A, {volts:.2e} V, {above} of {periods} periods above the source");
    (amps, volts, above)
}

/// The plant agrees with the reference while the motor feeds the bus again and again, with a source that
/// takes nothing back: returned energy stays in the capacitor until it is drawn again. A lower duty lets the
/// synchronous bridge return energy for a while, a higher one draws it; commutation returns some too.
#[test]
fn agrees_with_the_reference_while_the_motor_feeds_the_bus() {
    for (name, duty, swing) in [("bly172s-24v", 0.5, 0.02), ("bldc-1-25-058-201-24v", 0.3, 0.03)] {
        let preset = preset(name).unwrap();
        let motor = MotorConfig { thermal_resistance: 0.0, cogging_torque: 0.0, ..preset.motor };
        let mut config = PlantConfig::new(motor, 60.0);
        config.inverter.own_conductance = 0.0;
        config.load.inertia = 4.0 * motor.inertia;
        // About the speed that the motor has at the middle duty.
        config.speed = 0.96 * duty * 60.0 / motor.torque_constant;
        let (amps, volts, above) = largest(&config, 600, |k, plant| {
            let swing = if k / 5 % 2 == 0 { swing } else { -swing };
            Ideal::forward(duty + swing).command(&plant.observe(), plant)
        });
        assert!((100..500).contains(&above), "{name}: {above} periods above the source");
        assert!(amps < 0.03, "{name}: {amps:.2e} A");
        assert!(volts < 5e-3, "{name}: {volts:.2e} V");
    }
}

/// The plant agrees with the reference for a commutation in the very instant at which the on-time ends: the
/// leg that it leaves turns off although another one switches.
#[test]
fn agrees_with_the_reference_where_a_commutation_meets_an_edge() {
    let preset = preset("bly172s-24v").unwrap();
    let motor = MotorConfig { thermal_resistance: 0.0, cogging_torque: 0.0, ..preset.motor };
    let mut config = PlantConfig::new(motor, 24.0);
    config.inverter.own_conductance = 0.0;
    config.speed = 100.0;
    for (before, after) in [(Step::AB, Step::AC), (Step::AB, Step::CB), (Step::CB, Step::CA)] {
        // Half of the on-time and an instant have the same unit: 1/65 536 of a period.
        let meeting = 20_000;
        let ideal = Ideal::forward(f64::from(meeting) / 32_768.0);
        let (amps, volts, _) = largest(&config, 20, |k, _| {
            let mut command = ideal.hold(if k <= 8 { before } else { after });
            if k == 8 {
                command.commutations.push(Commutation { instant: meeting, step: after });
            }
            command
        });
        assert!(amps < 1e-4 && volts < 1e-4, "{before:?} to {after:?}: {amps:.2e} A, {volts:.2e} V");
    }
}
