//! Tests of the frames that the drive sends without a request: status word, measurements and their scales,
//! and their share of the bus.

use crate::bench::{Bench, IDENTITY, speed};
use narx_core::bus::narmotion::{ControlMode, FromDrive, Measurement, MotorMode, StatusWord};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::commutate::commutation::Direction;
use narx_core::motor::machine::event::Status;
use narx_core::motor::machine::state::State;
use narx_core::motor::sense::front_end::Board;
use narx_core::node::{Node, SlowInputs};
use narx_core::units::{Amps, Celsius, ElectricalSpeed, Volts, Watts};
use proptest::prelude::*;

#[test]
fn status_word_of_every_state() {
    use ControlMode as C;
    use MotorMode as M;
    let expected = [
        (State::Initialization, M::Standby, C::Off),
        (State::Standby, M::Standby, C::Off),
        (State::RotorLock, M::Reverse, C::OpenLoop),
        (State::OpenLoop, M::Reverse, C::OpenLoop),
        (State::SensorlessClosedLoop, M::Reverse, C::Sensorless),
        (State::HallClosedLoop, M::Reverse, C::Hall),
        (State::Fault, M::Fault, C::Off),
        (State::SensorlessAutoRestart, M::Reverse, C::Sensorless),
    ];
    for (state, mode, control) in expected {
        for (direction, turning) in [(Direction::Reverse, M::Reverse), (Direction::Forward, M::Drive)] {
            let mut bench = Bench::new();
            bench.node.handle_status(Status { state, direction, ..Status::default() });
            bench.node.poll(0);
            let mode = if mode == M::Reverse { turning } else { mode };
            let word = StatusWord { mode, control, ..StatusWord::default() };
            assert_eq!(bench.messages().first(), Some(&FromDrive::Status(word)), "{state:?}");
            assert_eq!(bench.read(number::DRIVE_STATE).0, state as i32);
        }
    }
}

#[test]
fn measurements_stop_when_the_master_is_silent() {
    let mut bench = Bench::new();
    let opcodes = |bench: &mut Bench| -> Vec<u16> {
        bench.messages().into_iter().map(|message| message.opcode().raw()).collect()
    };
    bench.node.poll(0);
    assert_eq!(opcodes(&mut bench), [3, 4, 200, 201, 202, 203, 204, 205]);
    bench.node.poll(499);
    assert!(opcodes(&mut bench).is_empty());
    bench.node.poll(500);
    assert_eq!(opcodes(&mut bench), [3, 4, 200, 201, 202, 203, 204, 205]);
    let status = Status { state: State::Standby, command_expired: true, ..Status::default() };
    bench.node.handle_status(status);
    bench.node.poll(1000);
    assert_eq!(opcodes(&mut bench), [3, 4]);
}

#[test]
fn measurements_carry_their_scales() {
    let mut bench = Bench::new();
    bench.node.handle_status(Status {
        state: State::HallClosedLoop,
        speed_hall: speed(-4000, 4),
        speed_sensorless: speed(2500, 4),
        sectors: -7,
        bus_voltage: Volts::from_milli(47_990),
        bus_current: Amps::from_milli(-1234),
        power: Watts::from_milli(150_040),
        phase_voltage: [Volts::from_milli(48_000), Volts::ZERO, Volts::from_milli(-700)],
        ..Status::default()
    });
    bench.node.handle_inputs(SlowInputs {
        ambient_temperature: Celsius::from_milli(189_960),
        pressure: Volts::from_milli(2500),
        accel: [1301, 1801, 2291].map(Volts::from_milli),
        accel_reference: Volts::from_milli(1801),
        reference: Volts::from_milli(383),
        rail_6v: Volts::from_milli(6010),
        rail_14v: Volts::from_milli(14_020),
        asi: Volts::from_milli(3300),
        dsi1: true,
        ..SlowInputs::default()
    });
    bench.node.poll(0);
    let expected = [
        Measurement::M0 { accel: [-1000, 0, 980], dsi1: true },
        // 7 sectors of 60 electrical degrees back, 4 pole pairs: -105 degrees.
        Measurement::M1 { speed_sensorless: 2500, position: -10_500, power: 1500 },
        Measurement::M2 { bus_voltage: 4799, bus_current: -1234, rail_6v: 6010, rail_14v: 14_020 },
        Measurement::M3 { temperature: 1900, accel_reference: 1801, reference: 383, asi: 3300 },
        Measurement::M4 { phase_voltage: [4800, 0, -70], pressure: 2500 },
        Measurement::M5 { speed_hall: -4000, dsi2: false },
    ];
    assert_eq!(bench.messages()[2..], expected.map(FromDrive::Measurement));
}

#[test]
fn measurements_saturate_and_the_position_wraps() {
    let mut parameters = Parameters::new();
    parameters.set(number::MOTOR_POLE_PAIRS, 1).unwrap();
    let mut bench = Bench::with_parameters(parameters);
    let mut status = Status { speed_hall: ElectricalSpeed::MAX, power: Watts::MAX, ..Status::default() };
    // Two reports across the wrap of the report's own counter: 2^30 + 2^30 + 1 sectors.
    status.sectors = 1 << 30;
    bench.node.handle_status(status);
    status.sectors = i32::MIN + 1;
    bench.node.handle_status(status);
    bench.messages();
    bench.node.poll(0);
    let position = (((1_i64 << 31) + 1) * 6000) as i32;
    let messages = bench.messages();
    let m1 = Measurement::M1 { speed_sensorless: 0, position, power: i16::MAX };
    assert!(messages.contains(&FromDrive::Measurement(m1)), "{messages:?}");
    let m5 = Measurement::M5 { speed_hall: i16::MAX, dsi2: false };
    assert!(messages.contains(&FromDrive::Measurement(m5)));
}

/// Measurement frames of one broadcast with this report.
fn measured(pole_pairs: i32, status: Status) -> Vec<FromDrive> {
    let mut parameters = Parameters::new();
    parameters.set(number::MOTOR_POLE_PAIRS, pole_pairs).unwrap();
    let mut bench = Bench::with_parameters(parameters);
    bench.node.handle_status(status);
    bench.node.poll(0);
    bench.messages()
}

#[test]
fn speeds_come_back_as_they_were_asked() {
    for pole_pairs in [1, 2, 4, 7, 12, 50] {
        for rpm in [0, 1, 7, 499, 500, 2999, 3999, 4000, 32_767] {
            for rpm in [rpm, -rpm] {
                let status = Status { speed_hall: speed(rpm.into(), pole_pairs.into()), ..Status::default() };
                let m5 = FromDrive::Measurement(Measurement::M5 { speed_hall: rpm, dsi2: false });
                assert!(measured(pole_pairs, status).contains(&m5), "{rpm} rpm, {pole_pairs} pole pairs");
            }
        }
    }
}

#[test]
fn positions_are_rounded_down_on_both_sides_of_zero() {
    // One sector of 7 pole pairs is 8.5714 degrees.
    for (sectors, position) in [(1, 857), (7, 6000), (42, 36_000), (-1, -858), (-7, -6000), (-8, -6858)] {
        let m1 = Measurement::M1 { speed_sensorless: 0, position, power: 0 };
        let messages = measured(7, Status { sectors, ..Status::default() });
        assert!(messages.contains(&FromDrive::Measurement(m1)), "{sectors}: {messages:?}");
    }
}

/// Bits of the longest 29-bit frame with n bytes, from PROTOCOL.md.
fn frame_bits(n: u64) -> u64 {
    67 + 8 * n + (53 + 8 * n) / 4
}

/// Runs a node for `ticks`, polled at these gaps in turn; returns tick and bits of each broadcast.
fn broadcasts(period: i32, tick_rate: u32, gaps: &[u64], ticks: u64) -> Vec<(u64, u64)> {
    let mut parameters = Parameters::new();
    parameters.set(number::AUTOSEND_PERIOD, period).unwrap();
    let board = Board { tick_rate, ..Board::BENCH };
    let mut node = Node::with_parameters(IDENTITY, board, parameters);
    node.handle_status(Status { state: State::Standby, ..Status::default() });
    let start = u64::from(u32::MAX) - 100;
    let mut sent = Vec::new();
    let mut now = start;
    for gap in gaps.iter().cycle() {
        node.poll(now);
        let bits: u64 = std::iter::from_fn(|| node.poll_frame()).map(|f| frame_bits(f.dlc().into())).sum();
        if bits > 0 {
            sent.push((now, bits));
        }
        now += gap;
        if now - start > ticks {
            break;
        }
    }
    sent
}

/// Largest share of the bus in any second.
fn bus_share(sent: &[(u64, u64)], tick_rate: u32) -> f64 {
    let second = u64::from(tick_rate);
    let windows = sent.iter().map(|(from, _)| {
        let within = sent.iter().filter(|(at, _)| (*from..*from + second).contains(at));
        within.map(|(_, bits)| bits).sum::<u64>()
    });
    windows.max().unwrap_or(0) as f64 / 500_000.0
}

#[test]
fn broadcasts_take_at_most_30_per_cent_of_the_bus() {
    assert_eq!(frame_bits(8), 160);
    for tick_rate in [8_000, 10_000, 20_000, 33_333] {
        for period in [1, 2, 5, 8, 9, 10, 20, 50, 1000, 60_000] {
            let sent = broadcasts(period, tick_rate, &[1], u64::from(tick_rate) * 2);
            let share = bus_share(&sent, tick_rate);
            // One broadcast more than the mean may begin in a second.
            let one = 8.0 * 160.0 / 500_000.0;
            assert!(share <= 0.30 + one, "{period} ms at {tick_rate} Hz: {share}");
        }
    }
    let busiest = bus_share(&broadcasts(1, 10_000, &[1], 100_000), 10_000);
    assert!(busiest > 0.29, "the clamp is no tighter than it must be: {busiest}");
    let normal = bus_share(&broadcasts(50, 10_000, &[1], 100_000), 10_000);
    assert!((0.05..0.055).contains(&normal), "{normal}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn late_polls_never_overload_the_bus(period in 1..200_i32, gaps in prop::collection::vec(1..400_u64, 1..20)) {
        let one = 8.0 * 160.0 / 500_000.0;
        let sent = broadcasts(period, 10_000, &gaps, 30_000);
        prop_assert!(bus_share(&sent, 10_000) <= 0.30 + one);
        // Two broadcasts are never closer than the shortest period, 8.534 ms.
        prop_assert!(sent.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 86));
    }
}
