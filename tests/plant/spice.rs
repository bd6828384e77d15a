//! Test of one commutation with demagnetisation and dead time against ngspice.
//!
//! `spice/commutation.cir` and its output `spice/commutation.txt` are committed. With `NARX_SPICE=1` the test
//! writes the netlist anew and runs ngspice (Debian's 39 made the committed output) before it compares.

use narx_core::motor::{Board, PwmCommand, Rectification, Step};
use narx_core::units::Duty;
use narx_sim::plant::{BackEmf, MotorConfig, Plant, PlantConfig};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

/// Length of the scenario, and instant of the commutation AB -> AC, us.
const END: usize = 800;
const COMMUTATION: usize = 415;
/// PWM: on until 30 and from 70 of every 100 us; 2 us dead time.
const ON_UNTIL: usize = 30;
const ON_FROM: usize = 70;
const DEAD_TIME: usize = 2;
const SPEED: f64 = 300.0;
const ANGLE_DEG: f64 = 50.0;

fn config() -> PlantConfig {
    let motor = MotorConfig { back_emf: BackEmf::Sinusoidal, inertia: 1e6, ..MotorConfig::default() };
    let mut config = PlantConfig::new(motor, 24.0);
    config.inverter.own_conductance = 0.0;
    // Ticks of 1 us: the commands generate the PWM, and every microsecond can be observed.
    let dead_time_ns = 1000 * DEAD_TIME as u16;
    config.board = Board { tick_rate: 1_000_000, earliest: 0, dead_time_ns, ..Board::BENCH };
    config.supply.may_sink = true;
    config.speed = SPEED;
    config.angle_deg = ANGLE_DEG;
    config
}

fn on_at(t: usize) -> bool {
    !(ON_UNTIL..ON_FROM).contains(&(t % 100))
}

/// Currents, terminals B and C, and bus at every microsecond: i_a i_b i_c v_b v_c v_bus.
fn plant() -> Vec<[f64; 6]> {
    let mut plant = Plant::new(&config());
    let command = |t: usize| PwmCommand {
        duty: if on_at(t + 1) { Duty::ONE } else { Duty::ZERO },
        rectification: Rectification::Synchronous,
        step: if t < COMMUTATION { Step::AB } else { Step::AC },
        ..PwmCommand::default()
    };
    // A tick with all switches off comes first, because the duty of a tick comes from the tick before it.
    let mut before = command(0);
    before.step = Step::Coast;
    plant.sample();
    plant.finish_period(&before);
    let mut rows = Vec::new();
    for t in 0..END {
        plant.sample();
        plant.finish_period(&command(t));
        let seen = plant.observe();
        let ([a, b, c], [_, v_b, v_c]) = (seen.current, seen.terminal);
        rows.push([a, b, c, v_b, v_c, seen.bus_voltage]);
    }
    rows
}

/// Voltage source of a gate: on in these stretches (us).
fn gate(name: &str, stretches: &[(usize, usize)]) -> String {
    let mut points = String::from("0 0");
    for &(on, off) in stretches {
        // Edges of 2 ns around the instant.
        let start = on as f64 * 1e-6;
        if on == 0 {
            points = String::from("0 1");
        } else {
            write!(points, " {:.9e} 0 {:.9e} 1", start - 1e-9, start + 1e-9).unwrap();
        }
        let stop = off as f64 * 1e-6;
        write!(points, " {:.9e} 1 {:.9e} 0", stop - 1e-9, stop + 1e-9).unwrap();
    }
    format!("V{name} {name} 0 PWL({points})\n")
}

fn netlist() -> String {
    let config = config();
    let (motor, inverter) = (&config.motor, &config.inverter);
    let mut text = String::from(
        "* One commutation AB -> AC with demagnetisation of phase B and dead time in leg A\n\
         * written by tests/plant/spice.rs\n",
    );
    let mut high = Vec::new();
    let mut low = Vec::new();
    let mut t = 0;
    while t < END {
        let end = (t + 1..END).find(|&next| on_at(next) != on_at(t)).unwrap_or(END);
        let start = if t == 0 { 0 } else { t + DEAD_TIME };
        if on_at(t) {
            high.push((start, end))
        } else {
            low.push((start, end))
        }
        t = end;
    }
    text += &gate("gah", &high);
    text += &gate("gal", &low);
    text += &gate("gbl", &[(0, COMMUTATION)]);
    text += &gate("gcl", &[(COMMUTATION, END)]);
    writeln!(text, ".model sw SW(VT=0.5 VH=0 RON={} ROFF=1e6)", inverter.on_resistance).unwrap();
    // A sharp knee: 2.5 mV of junction, and the rest as a source in series.
    writeln!(text, ".model knee D(IS=1e-9 N=0.005 RS={})", inverter.on_resistance).unwrap();
    for leg in ["a", "b", "c"] {
        let drop = inverter.diode_drop - 0.0028;
        if leg == "a" {
            text += "Sah bus ta gah 0 sw\n";
        }
        writeln!(text, "S{leg}l t{leg} 0 g{leg}l 0 sw").unwrap();
        writeln!(text, "Dh{leg} t{leg} h{leg} knee\nVh{leg} h{leg} bus {drop}").unwrap();
        writeln!(text, "Dl{leg} l{leg} t{leg} knee\nVl{leg} 0 l{leg} {drop}").unwrap();
        writeln!(text, "R{leg} t{leg} r{leg} {}", 0.5 * motor.resistance).unwrap();
        writeln!(text, "L{leg} r{leg} e{leg} {} IC=0", 0.5 * motor.inductance).unwrap();
    }
    let electrical = SPEED * f64::from(motor.pole_pairs);
    let amplitude = motor.torque_constant * PI / (3.0 * 3f64.sqrt()) * SPEED;
    for (leg, lag) in [("a", 0.0), ("b", 120.0), ("c", 240.0)] {
        let phase = (ANGLE_DEG - lag).to_radians() + electrical * 1e-6;
        writeln!(text, "Be{leg} e{leg} n V={amplitude:.12}*sin({electrical}*time+({phase:.12}))").unwrap();
    }
    writeln!(text, "Vs vs 0 {}", config.supply.voltage).unwrap();
    writeln!(text, "Rs vs bus {}", config.supply.resistance).unwrap();
    writeln!(text, "Cb bus 0 {} IC={}", inverter.capacitance, config.supply.voltage).unwrap();
    text += "Rn n 0 1e9\n.options method=gear reltol=1e-6 abstol=1e-9 vntol=1e-7\n.control\n";
    writeln!(text, "tran 1u {END}u 0 20n uic\nlinearize\nset wr_singlescale\nset numdgt=7").unwrap();
    text += "wrdata commutation.txt i(la) i(lb) i(lc) v(tb) v(tc) v(bus)\nquit\n.endc\n.end\n";
    text
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("plant/spice")
}

#[test]
fn one_commutation_agrees_with_ngspice() {
    let folder = folder();
    let path = folder.join("commutation.cir");
    if std::env::var_os("NARX_SPICE").is_some() {
        std::fs::write(&path, netlist()).unwrap();
        let done = std::process::Command::new("ngspice")
            .args(["-b", "commutation.cir"])
            .current_dir(&folder)
            .status();
        assert!(done.is_ok_and(|status| status.success()), "ngspice ran");
    }
    let committed = std::fs::read_to_string(&path).unwrap();
    assert_eq!(committed, netlist(), "the committed netlist is this scenario's; NARX_SPICE=1 writes it anew");
    let output = std::fs::read_to_string(folder.join("commutation.txt")).unwrap();
    let waves: Vec<[f64; 6]> = output
        .lines()
        .map(|line| {
            let mut numbers = line.split_whitespace().map(|word| word.parse().unwrap());
            numbers.next();
            [(); 6].map(|()| numbers.next().unwrap())
        })
        .collect();
    compare(&waves, &plant());
}

/// Compares the rows: ngspice's first row is at time 0, the plant's row t is the end of microsecond t.
fn compare(waves: &[[f64; 6]], rows: &[[f64; 6]]) {
    assert_eq!(waves.len(), END + 1);
    let peak = waves.iter().fold(0.0f64, |peak, row| peak.max(row[0].abs()));
    let mut squares = [0.0; 6];
    let mut worst = [0.0f64; 6];
    for t in 0..END {
        for x in 0..6 {
            let off = rows[t][x] - waves[t + 1][x];
            squares[x] += off * off;
            worst[x] = worst[x].max(off.abs());
        }
    }
    let rms = squares.map(|sum| (sum / END as f64).sqrt());
    println!("peak {peak:.3} A; i_a i_b i_c v_b v_c v_bus: RMS {rms:.5?}, worst {worst:.5?}");
    let demagnetised = |rows: &[[f64; 6]], first: usize| {
        (COMMUTATION + 1..END).find(|&t| rows[t + first][1].abs() < 5e-3).unwrap()
    };
    let (ours, theirs) = (demagnetised(rows, 0), demagnetised(waves, 1));
    println!("phase B is demagnetised {} us after the commutation", ours - COMMUTATION);
    assert!(ours.abs_diff(theirs) <= 1, "demagnetised at {ours}, ngspice at {theirs} us");
    for x in 0..3 {
        assert!(rms[x] < 1e-4 * peak, "current {x}: {} A RMS", rms[x]);
        assert!(worst[x] < 5e-4 * peak, "current {x}: {} A", worst[x]);
    }
    assert!(rms[5] < 1e-3, "bus: {} V RMS", rms[5]);
    // Terminals agree except in the microseconds in which an edge is exactly on the grid.
    for x in 3..5 {
        let near = (0..END).filter(|&t| (rows[t][x] - waves[t + 1][x]).abs() < 0.01).count();
        assert!(near > END * 95 / 100, "terminal {x}: only {near} of {END} samples agree");
    }
}
