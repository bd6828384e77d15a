//! The node between a master and the scope: what it passes on, and what it knows before the scope has answered.

use crate::bench::Bench;
use narx_core::bus::narmotion::{ParameterStatus, ToDrive};
use narx_core::dictionary::number;
use narx_core::scope::{Report, Request, State};

/// To arm and to force are one message: the second one of two does not overtake the first.
#[test]
fn nothing_is_forced_before_the_scope_is_armed() {
    let mut bench = Bench::new();
    bench.write(number::SCOPE_CHANNELS, 1);
    bench.send(ToDrive::TriggerScope);
    bench.send(ToDrive::TriggerScope);
    assert_eq!(bench.refused(), 1);
    assert!(matches!(bench.node.poll_scope(), Some(Request::Arm(_))));
    bench.node.handle_scope(Report::State(State::Armed, 0));
    bench.send(ToDrive::TriggerScope);
    assert_eq!((bench.node.poll_scope(), bench.node.poll_scope()), (Some(Request::Force), None));
    assert_eq!(bench.refused(), 1);
}

/// Parameter 25 is of what would be recorded: inputs are those of every tick, whatever the prescaler.
#[test]
fn the_sampling_time_of_inputs_is_a_tick() {
    let mut bench = Bench::new();
    bench.write(number::SCOPE_CHANNELS, 1);
    bench.write(number::SCOPE_PRESCALER, 10);
    assert_eq!(bench.read(number::SCOPE_SAMPLING_TIME), (1000, ParameterStatus::Done));
    bench.write(number::SCOPE_INPUTS, 1);
    assert_eq!(bench.read(number::SCOPE_SAMPLING_TIME), (100, ParameterStatus::Done));
}
