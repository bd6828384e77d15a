//! Tests of hall lines, their edges and wirings, of converter codes, and of the effect of every injection.

use crate::driving::sector_at;
use narx_core::motor::{Board, Edge, EdgeSource, FrontEnd, Lines, PwmCommand, Samples, Step};
use narx_core::units::Duty;
use narx_sim::plant::{
    ComparatorConfig, HallConfig, Injection, InverterConfig, MotorConfig, Observation, Phase, Plant,
    PlantConfig,
};
use narx_sim::random::Random;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Hall code of each sector: A; A and B; B; B and C; C; C and A.
const CODES: [u8; 6] = [1, 3, 2, 6, 4, 5];

/// Plant that coasts at constant speed (rad/s).
fn coasting(speed: f64, hall: HallConfig) -> PlantConfig {
    let motor = MotorConfig { inertia: 1e3, ..MotorConfig::default() };
    let inverter = InverterConfig { own_conductance: 0.0, ..InverterConfig::default() };
    PlantConfig { hall, speed, angle_deg: 40.0, inverter, ..PlantConfig::new(motor, 24.0) }
}

fn coast(plant: &mut Plant) -> Samples {
    let samples = plant.sample();
    plant.finish_period(&PwmCommand::default());
    samples
}

#[test]
fn the_hall_code_names_the_sector() {
    for degrees in 0..720 {
        let angle_deg = f64::from(degrees) * 0.5 + 0.1;
        let mut plant = Plant::new(&PlantConfig { angle_deg, ..coasting(0.0, HallConfig::default()) });
        let sector = sector_at(angle_deg / 360.0);
        assert_eq!(plant.sample().hall, CODES[usize::from(sector)], "{angle_deg} degrees");
    }
}

#[test]
fn edges_are_stamped_where_the_rotor_passes() {
    let placement_deg = [0.0, 4.0, -3.0];
    for (speed, offset_deg) in [(300.0, 0.0), (-300.0, 0.0), (700.0, 12.0)] {
        let hall = HallConfig { placement_deg, offset_deg, ..HallConfig::default() };
        let mut plant = Plant::new(&coasting(speed, hall));
        let degrees_per_period = speed * 4.0 / TAU * 360.0 * 1e-4;
        let mut before = plant.sample().hall;
        plant.finish_period(&PwmCommand::default());
        let mut count = 0;
        for _ in 0..2000 {
            let samples = coast(&mut plant);
            for Edge { instant, code, .. } in &samples.edges {
                let sensor = (before ^ code).trailing_zeros() as usize;
                assert_eq!((before ^ code).count_ones(), 1, "one line at a time");
                before = *code;
                let periods = (samples.tick - 1) as f64 + f64::from(*instant) / 65_536.0;
                let angle = 40.0 + degrees_per_period * periods;
                // Both edges of a sensor repeat every 180 degrees; sensors are 120 degrees apart.
                let place = -30.0 + 120.0 * sensor as f64 + offset_deg + placement_deg[sensor];
                let off = (angle - place + 90.0).rem_euclid(180.0) - 90.0;
                assert!(off.abs() < degrees_per_period.abs() / 30_000.0 + 1e-9, "{off} degrees off");
                count += 1;
            }
        }
        let turned = (degrees_per_period * 2000.0 / 60.0).abs();
        assert!((f64::from(count) - turned).abs() <= 3.0, "{count} edges in {turned} sectors");
    }
}

#[test]
fn edges_beyond_four_are_counted() {
    // 1.5 electrical revolutions per period: nine edges.
    let mut plant = Plant::new(&coasting(1.5 * 10_000.0 * TAU / 4.0, HallConfig::default()));
    plant.inject(Injection::OpenPhase(Phase::A));
    plant.inject(Injection::OpenPhase(Phase::B));
    plant.inject(Injection::OpenPhase(Phase::C));
    coast(&mut plant);
    let samples = coast(&mut plant);
    assert_eq!((samples.edges.len(), samples.edges_lost), (4, 5));
}

#[test]
fn all_48_wirings_permute_and_invert_the_lines() {
    let mut seen = BTreeSet::new();
    for order in 0..6 {
        for polarity in 0..8u8 {
            let hall = HallConfig { order, polarity, ..HallConfig::default() };
            let mut codes = Vec::new();
            for sector in 0..6u8 {
                let angle_deg = 60.0 + 60.0 * f64::from(sector);
                let mut plant = Plant::new(&PlantConfig { angle_deg, ..coasting(0.0, hall) });
                let code = plant.sample().hall;
                let mut expected = 0;
                for line in 0..3 {
                    let sensor = HallConfig::ORDERS[usize::from(order)][line];
                    expected |= (CODES[usize::from(sector)] >> sensor & 1) << line;
                }
                assert_eq!(code, expected ^ polarity);
                codes.push(code);
            }
            seen.insert(codes);
        }
    }
    assert_eq!(seen.len(), 48, "every wiring looks different");
}

#[test]
fn jitter_moves_edges_by_its_standard_deviation() {
    let hall = HallConfig { jitter_deg: 1.5, ..HallConfig::default() };
    let mut plant = Plant::new(&coasting(300.0, hall));
    let degrees_per_period = 300.0 * 4.0 / TAU * 360.0 * 1e-4;
    let (mut squares, mut count) = (0.0, 0);
    for _ in 0..20_000 {
        let samples = coast(&mut plant);
        for edge in &samples.edges {
            let periods = (samples.tick - 1) as f64 + f64::from(edge.instant) / 65_536.0;
            let angle = 40.0 + degrees_per_period * periods;
            let off = (angle - 30.0 + 30.0).rem_euclid(60.0) - 30.0;
            squares += off * off;
            count += 1;
        }
    }
    let deviation = (squares / f64::from(count)).sqrt();
    assert!((deviation - 1.5).abs() < 0.05, "{deviation} degrees over {count} edges");
}

#[test]
fn glitches_come_at_their_rate_and_go() {
    let hall = HallConfig { glitch_rate: 200.0, ..HallConfig::default() };
    let mut plant = Plant::new(&coasting(0.0, hall));
    let mut edges = 0;
    for _ in 0..50_000 {
        let samples = coast(&mut plant);
        edges += samples.edges.len();
    }
    // 5 s x 200 glitches, two edges each.
    assert!((1800..2200).contains(&edges), "{edges} edges");
    assert_eq!(coast(&mut plant).hall, 1);
}

#[test]
fn codes_follow_voltages_and_current() {
    let mut config = coasting(0.0, HallConfig::default());
    config.converter.noise = 0.0;
    config.converter.bus_current_offset = 25.0;
    config.supply.resistance = 0.0;
    let mut plant = Plant::new(&config);
    plant.inject(Injection::BlockedRotor);
    let command = PwmCommand { duty: Duty::ONE, step: Step::AB, sample_at: 100, ..PwmCommand::default() };
    for _ in 0..100 {
        plant.sample();
        plant.finish_period(&command);
    }
    let samples = plant.sample();
    let seen = plant.observe();
    let code = |value: f64, micro: i32| (value * 1e6 / f64::from(micro)).round() as u16;
    let scale = FrontEnd::NARX;
    assert_eq!(samples.bus_voltage, code(seen.bus_voltage, scale.bus_voltage.micro_per_code));
    for x in 0..3 {
        let expected = code(seen.terminal[x].max(0.0), scale.phase_voltage.micro_per_code);
        assert_eq!(samples.phase_voltage[x], expected, "phase {x}");
    }
    // 60 A are beyond the converter's range.
    assert_eq!(samples.bus_current, FrontEnd::CODE_MAX);
    plant.finish_period(&PwmCommand::default());
    for _ in 0..100 {
        coast(&mut plant);
    }
    assert_eq!(coast(&mut plant).bus_current, scale.bus_current.zero + 25);
}

#[test]
fn noise_has_its_standard_deviation() {
    let mut config = coasting(0.0, HallConfig::default());
    config.converter.noise = 3.0;
    let mut plant = Plant::new(&config);
    let codes: Vec<f64> = (0..20_000).map(|_| f64::from(coast(&mut plant).bus_voltage)).collect();
    let mean = codes.iter().sum::<f64>() / codes.len() as f64;
    let variance = codes.iter().map(|code| (code - mean).powi(2)).sum::<f64>() / codes.len() as f64;
    assert!((variance.sqrt() - 3.0).abs() < 0.1, "{}", variance.sqrt());
    assert!((mean * 0.019_531 - 24.0).abs() < 0.002, "{mean}");
}

#[test]
fn everything_injected_shows_and_clears() {
    type Look = fn(&mut Plant) -> f64;
    let bus: Look = |plant| plant.observe().bus_voltage;
    let shunt: Look = |plant| plant.observe().bus_current;
    let hall: Look = |plant| f64::from(coast(plant).hall);
    let table: [(Injection, Look, f64, f64); 15] = [
        (Injection::Ambient(195.0), |plant| plant.ambient(), 25.0, 195.0),
        (Injection::Supply(62.0), bus, 24.0, 62.0),
        (Injection::Leak(2.0), shunt, 0.0, 24.0 / 2.1),
        (Injection::HallStuck { line: Phase::A, high: false }, hall, 1.0, 0.0),
        (Injection::HallStuck { line: Phase::C, high: true }, hall, 1.0, 5.0),
        (Injection::HallSwapped(Phase::A), hall, 1.0, 2.0),
        (Injection::HallSupplyLost, hall, 1.0, 7.0),
        (Injection::Pressure(2.5), |plant| plant.pressure(), 0.0, 2.5),
        (Injection::OpenPhase(Phase::A), |plant| sign(drive(plant, 50).current[0]), 1.0, 0.0),
        (Injection::BlockedRotor, |plant| sign(drive(plant, 50).speed), 1.0, 0.0),
        (Injection::Driver(Phase::B), |plant| flag(plant, Lines::DRIVER_FAULT), 0.0, 1.0),
        (Injection::Break, |plant| flag(plant, Lines::EMERGENCY), 0.0, 1.0),
        (Injection::Dsi1, |plant| flag(plant, Lines::DSI1), 0.0, 1.0),
        (Injection::Dsi2, |plant| flag(plant, Lines::DSI2), 0.0, 1.0),
        (Injection::HallGlitches(1e4), |plant| coast(plant).edges.len().min(1) as f64, 0.0, 1.0),
    ];
    let kinds: BTreeSet<usize> = table.iter().map(|(injection, ..)| injection.index()).collect();
    assert!(kinds.into_iter().eq(0..Injection::KINDS.len()), "one row or more of every kind");
    for (injection, look, healthy, broken) in table {
        let mut plant = Plant::new(&coasting(0.0, HallConfig::default()));
        let settle = |plant: &mut Plant| {
            for _ in 0..20 {
                coast(plant);
            }
            look(plant)
        };
        assert!((settle(&mut plant) - healthy).abs() < 1e-6, "{injection:?} before");
        plant.inject(injection);
        let seen = settle(&mut plant);
        assert!((seen - broken).abs() < 1e-6, "{injection:?}: {seen}");
        plant.clear(injection);
        // A bus that was raised stays so without a load; everything else returns.
        if !matches!(injection, Injection::Supply(_)) {
            let seen = settle(&mut plant);
            assert!((seen - healthy).abs() < 1e-6, "{injection:?} after: {seen}");
        }
    }
}

fn flag(plant: &mut Plant, line: Lines) -> f64 {
    f64::from(u8::from(coast(plant).lines.contains(line)))
}

/// 1 above 0, else 0.
fn sign(value: f64) -> f64 {
    f64::from(u8::from(value > 0.0))
}

/// Lets current through phases A and B for some periods.
fn drive(plant: &mut Plant, periods: u32) -> Observation {
    let command = PwmCommand { duty: Duty::from_bits(4000), step: Step::AB, ..PwmCommand::default() };
    for _ in 0..periods {
        plant.sample();
        plant.finish_period(&command);
    }
    plant.observe()
}

#[test]
fn an_open_phase_and_a_dead_leg_carry_no_current() {
    for injection in [Injection::OpenPhase(Phase::A), Injection::Driver(Phase::A)] {
        let mut plant = Plant::new(&coasting(0.0, HallConfig::default()));
        assert!(drive(&mut plant, 50).current[0] > 1.0);
        plant.inject(injection);
        assert_eq!(drive(&mut plant, 50).current, [0.0; 3], "{injection:?}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let run = |seed| {
        let hall = HallConfig { jitter_deg: 1.0, glitch_rate: 50.0, ..HallConfig::default() };
        let config = PlantConfig { seed, ..coasting(300.0, hall) };
        let mut plant = Plant::new(&PlantConfig { board: Board::BENCH, ..config });
        (0..500).map(|_| coast(&mut plant)).collect::<Vec<_>>()
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}

#[test]
fn comparators_see_the_zero_crossings_late_by_delay_and_hysteresis() {
    let (speed, delay, hysteresis) = (300.0, 20e-6, 0.4);
    let comparator = Some(ComparatorConfig { delay, hysteresis });
    let mut config = coasting(speed, HallConfig::default());
    config.board.hall_capture = false;
    let mut plant = Plant::new(&PlantConfig { comparator, ..config });
    let degrees_per_second = speed * 4.0 / TAU * 360.0;
    // On the flank the slope is 1/30 of the peak per degree; the mean of three trapezoids takes a third of
    // it, with the opposite sign.
    let peak = 0.5 * 0.036 * speed;
    let late = 0.5 * hysteresis / (peak / 30.0 * 2.0 / 3.0) + degrees_per_second * delay;
    let mut worst = 0.0f64;
    let mut count = 0;
    for _ in 0..2000 {
        let samples = coast(&mut plant);
        for edge in samples.edges.iter().filter(|edge| edge.source == EdgeSource::Comparator) {
            let time = (samples.tick as f64 - 1.0 + f64::from(edge.instant) / 65_536.0) * 1e-4;
            let angle = 40.0 + degrees_per_second * time;
            if angle > 100.0 {
                worst = worst.max(((angle - late + 30.0).rem_euclid(60.0) - 30.0).abs());
                count += 1;
            }
        }
        assert!(samples.edges.iter().all(|edge| edge.source == EdgeSource::Comparator));
    }
    let turned = degrees_per_second * 0.2 / 60.0;
    assert!((f64::from(count) - turned).abs() <= 3.0, "{count} edges in {turned} sectors");
    assert!(worst < 0.05, "{worst} degrees off");
}

/// Noise has the right tails, and each value of a draw is independent of the others and of later draws.
#[test]
fn noise_is_gaussian_and_white() {
    const COUNT: usize = 4_000_000;
    let mut random = Random::new(7);
    let samples: Vec<f64> = (0..COUNT / 2).flat_map(|_| random.gaussians()).collect();
    let mean_of = |of: &dyn Fn(f64) -> f64| samples.iter().map(|x| of(*x)).sum::<f64>() / COUNT as f64;
    let (mean, square) = (mean_of(&|x| x), mean_of(&|x| x * x));
    let (third, fourth) = (mean_of(&|x| x.powi(3)), mean_of(&|x| x.powi(4)));
    let beyond = [1.0, 2.0, 3.0, 4.0].map(|edge| mean_of(&|x| f64::from(u8::from(x.abs() > edge))));
    println!("mean {mean:.1e}, square {square:.5}, third {third:.1e}, fourth {fourth:.4}, beyond {beyond:?}");
    // Three standard errors of this number of samples: 1.5e-3 of the mean, 2.1e-3 of the square.
    assert!(mean.abs() < 1.5e-3 && (square - 1.0).abs() < 2.1e-3 && third.abs() < 6e-3);
    assert!((fourth - 3.0).abs() < 0.12);
    for (found, gaussian) in beyond.into_iter().zip([0.3173, 0.0455, 2.7e-3, 6.33e-5]) {
        assert!((0.3..1.1).contains(&(found / gaussian)), "{found:.2e} instead of {gaussian:.2e}");
    }
    // Odd lags go from one half of a draw to the other, even ones stay within a half; five samples make a
    // tick.
    for lag in (1..=12).chain([5 * 7, 5 * 128]) {
        let product =
            samples.iter().zip(&samples[lag..]).map(|(x, y)| x * y).sum::<f64>() / (COUNT - lag) as f64;
        let squares =
            samples.iter().zip(&samples[lag..]).map(|(x, y)| (x * x - 1.0) * (y * y - 1.0)).sum::<f64>();
        let squares = squares / (COUNT - lag) as f64;
        assert!(product.abs() < 2e-3 && squares.abs() < 4e-3, "{lag} apart: {product:.1e}, {squares:.1e}");
    }
}
