//! Tests of parameters that the drive alone writes: facts of the board, and observations of the control tick.

use crate::bench::{Bench, IDENTITY};
use crate::wired::Wired;
use narx_core::bus::narmotion::ParameterStatus::Done;
use narx_core::dictionary::number;
use narx_core::motor::machine::event::{Limiter, Status};
use narx_core::motor::machine::state::State;
use narx_core::motor::rotor::zero_crossing::Why;
use narx_core::motor::sense::front_end::Board;
use narx_core::node::{Identity, Node, ResetCause, SelfTests};
use narx_sim::plant::{Injection, Input};

#[test]
fn facts_of_the_board_and_of_the_firmware() {
    let mut bench = Bench::new();
    bench.node = Node::new(Identity { source_modified: true, ..IDENTITY }, Board::BENCH);
    bench.node.handle_reset_cause(ResetCause::Watchdog);
    bench.node.handle_self_tests(SelfTests::RAM | SelfTests::TICK);
    for (number, value) in [
        (number::HARDWARE_RELEASE, 3),
        (number::BUILD_NUMBER, 42),
        (number::SOFTWARE_RELEASE, 0x0102),
        (number::SOURCE_MODIFIED, 1),
        (number::LOGGING_START, 0xAA55),
        (number::LOGGING_END, 0x55AA),
        (number::RESET_CAUSE, 4),
        (number::FAILED_SELF_TESTS, 0b1_0001),
    ] {
        assert_eq!(bench.read(number), (value, Done), "parameter {number}");
    }
}

#[test]
fn what_the_tick_reports_of_zero_crossings() {
    let mut bench = Bench::new();
    bench.node.handle_status(Status {
        state: State::SensorlessClosedLoop,
        crossing: Why::DemagLate,
        // 45 degrees early.
        crossing_margin: -8192,
        crossings: 70_000,
        ..Status::default()
    });
    bench.messages();
    for (number, value) in [
        (number::CROSSING, Why::DemagLate as i32),
        (number::CROSSING_MARGIN, -4500),
        (number::CROSSINGS, 70_000),
    ] {
        assert_eq!(bench.read(number), (value, Done), "parameter {number}");
    }
}

/// Wrong hall sensors, and the limit that bounds the motor meanwhile, can be read over the bus.
#[test]
fn what_the_tick_sees_of_the_hall_sensors() {
    let mut wired = Wired::turning();
    let healthy = [number::HALL_INVALID, number::HALL_JUMPS].map(|number| wired.read(number));
    assert_eq!(wired.read(number::ACTIVE_LIMITER), Limiter::Speed as i32);
    wired.bench.plant_mut().inject(Injection::HallGlitches(1000.0));
    wired.run(0.5);
    let jumps = wired.read(number::HALL_JUMPS);
    wired.put(Input::HallSupply, 3.0);
    wired.run(0.5);
    let invalid = wired.read(number::HALL_INVALID);
    assert!(jumps > healthy[1] && invalid > healthy[0], "{healthy:?}, then {invalid} and {jumps}");
    assert_eq!(wired.read(number::ACTIVE_LIMITER), Limiter::Off as i32);
}
