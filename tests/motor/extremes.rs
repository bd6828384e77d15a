//! Tests of extreme parameters: with any set that builds, the tick's arithmetic neither overflows nor divides
//! by 0 (tests check both), for any samples.

use narx_core::dictionary::{Access, Category, Dictionary, Parameters, number};
use narx_core::motor::machine::event::SlowMeasurements;
use narx_core::motor::{
    Board, Coefficients, Command, Drive, Edge, EdgeSource, Event, Leg, Lines, RunRequest, Samples, State,
    Step,
};
use narx_core::units::{Celsius, ElectricalSpeed, Volts};
use proptest::prelude::*;

/// Numbers of the parameters from which coefficients are built.
fn numbers() -> Vec<u16> {
    let built = |category| {
        matches!(
            category,
            Category::Calibration
                | Category::Machine
                | Category::Control
                | Category::CommandSaturation
                | Category::Limitation
                | Category::Timing
        )
    };
    let rows = Dictionary::rows().filter(|row| built(row.category) && row.access != Access::ReadOnly);
    rows.map(|row| row.number).collect()
}

/// A parameter at an end of its range, next to it, or anywhere in it.
fn change() -> impl Strategy<Value = (u16, i32)> {
    (prop::sample::select(numbers()), 0..6, any::<u32>()).prop_map(|(number, place, random)| {
        let row = Dictionary::row(number).unwrap();
        let span = row.max() - row.min();
        let value = match place {
            0 => row.min(),
            1 => row.min() + span.min(1),
            2 => row.max(),
            3 => row.max() - span.min(1),
            // Small values and any.
            4 => row.min() + i64::from(random % 100).min(span),
            _ => row.min() + i64::from(random) % (span + 1),
        };
        (number, value as i32)
    })
}

fn boards() -> impl Strategy<Value = Board> {
    let rates = prop::sample::select(vec![1_000, 2_000, 9_999, 10_000, 20_000, 40_000, 100_000]);
    (rates, any::<u16>(), any::<[bool; 2]>()).prop_map(|(tick_rate, earliest, capture)| Board {
        tick_rate,
        earliest,
        hall_capture: capture[0],
        comparator_capture: capture[1],
        ..Board::BENCH
    })
}

/// Samples that are often plausible and often at the ends of the converter.
fn samples() -> impl Strategy<Value = Samples> {
    let voltage = prop_oneof![6 => 1_000..3_000_u16, 1 => Just(0), 1 => any::<u16>()];
    let current = prop_oneof![6 => 1_900..2_300_u16, 1 => any::<u16>()];
    let edge = (any::<u16>(), any::<u8>(), any::<bool>()).prop_map(|(instant, code, hall)| Edge {
        instant,
        source: if hall { EdgeSource::Hall } else { EdgeSource::Comparator },
        code,
    });
    let edges = prop::collection::vec(edge, 0..=4);
    (any::<[u16; 3]>(), voltage, current, any::<u8>(), edges).prop_map(
        |(phase_voltage, bus_voltage, bus_current, hall, edges)| Samples {
            phase_voltage,
            bus_voltage,
            bus_current,
            hall,
            edges: edges.into_iter().collect(),
            lines: Lines::empty(),
            ..Samples::default()
        },
    )
}

fn built(changes: &[(u16, i32)], mode: u16, board: &Board) -> Option<Coefficients> {
    let mut parameters = Parameters::new();
    parameters.set(mode, 1).unwrap();
    for (number, raw) in changes {
        parameters.set(*number, *raw).unwrap();
    }
    Coefficients::build(&parameters, board).ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3_000))]

    #[test]
    fn no_set_that_builds_breaks_the_tick(
        first in prop::collection::vec(change(), 0..6),
        live in prop::collection::vec(change(), 0..4),
        open_loop: bool,
        calibrate in prop::bool::weighted(0.2),
        board in boards(),
        stretches in prop::collection::vec((samples(), 1..60_u16, any::<i32>(), any::<bool>()), 1..12),
        temperature: i32,
    ) {
        let mode = if open_loop { number::OPEN_LOOP_ENABLE } else { number::HALL_ENABLE };
        let Some(c) = built(&first, mode, &board) else { return Ok(()) };
        let mut drive = Drive::new(c);
        let healthy = Samples { bus_voltage: 2_458, bus_current: 2_048, hall: 1, ..Samples::default() };
        let idle = Event::Command(Command::default());
        for _ in 0..=c.machine.boot {
            drive.handle_event(idle.clone());
            drive.step(&healthy);
        }
        drive.handle_event(Event::Slow(SlowMeasurements {
            temperature: Celsius::from_bits(temperature % (186 << 16)),
            pressure: Volts::ZERO,
        }));
        drive.handle_event(Event::CalibrateHall(calibrate));
        for (number, (samples, ticks, speed, forward)) in stretches.iter().enumerate() {
            if number == 1 && let Some(other) = built(&live, mode, &board) {
                drive.handle_event(Event::Coefficients(other));
            }
            let request = if *forward { RunRequest::Drive } else { RunRequest::Reverse };
            drive.handle_event(Event::Command(Command { request, speed: ElectricalSpeed::from_bits(*speed) }));
            for _ in 0..*ticks {
                let output = drive.step(samples);
                let _ = drive.poll_status();
                prop_assert!(output.duty.to_bits() <= 32_768);
                if !drive.state().is_driving() {
                    prop_assert!(output.step == Step::Coast && output.commutations.iter().count() == 0);
                }
            }
        }
    }
}

/// The sets above build often enough, and their drives run.
#[test]
fn extreme_sets_build_and_run() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let (mut sets, mut ran) = (0, 0);
    for _ in 0..200 {
        let changes = prop::collection::vec(change(), 0..6).new_tree(&mut runner).unwrap().current();
        let Some(c) = built(&changes, number::HALL_ENABLE, &Board::BENCH) else { continue };
        sets += 1;
        let mut drive = Drive::new(c);
        let healthy = Samples { bus_voltage: 2_458, bus_current: 2_048, hall: 1, ..Samples::default() };
        for _ in 0..=c.machine.boot {
            drive.handle_event(Event::Command(Command::default()));
            drive.step(&healthy);
        }
        drive.handle_event(Event::Command(Command { request: RunRequest::Drive, ..Command::default() }));
        let driven = (0..20).any(|_| drive.step(&healthy).step.legs() != [Leg::Floating; 3]);
        ran += u32::from(driven || drive.state() == State::HallClosedLoop);
    }
    println!("{sets} of 200 sets build, {ran} run");
    assert!(sets > 60 && ran > 40, "{sets} sets, {ran} run");
}
