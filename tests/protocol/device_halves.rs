//! The two halves that a shell links: joined by queues alone, they are the drive and the node of the bench.

use narx_core::bus::narmotion::{FromDrive, MotorMode, RequestWord, ToDrive};
use narx_core::device::Queues;
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::{Board, Samples, State};
use narx_core::node::Identity;

/// Codes of a healthy 24 V board at rest: 24 V / 19.531 mV, no current.
fn at_rest(tick: u64) -> Samples {
    Samples { tick, bus_voltage: 1_229, bus_current: 2_048, hall: 0b101, ..Samples::default() }
}

#[test]
fn frames_reach_the_tick_and_reports_reach_the_bus() {
    let mut parameters = Parameters::new();
    parameters.set(number::SENSORLESS_ENABLE, 0).unwrap();
    parameters.set(number::HALL_ENABLE, 1).unwrap();
    let mut queues = Queues::new();
    let (mut tick, mut background) = queues.power_up(Identity::default(), Board::BENCH, parameters);
    let mut frames = Vec::new();
    let mut driven = false;
    for now in 0..20_000 {
        tick.step(&at_rest(now));
        if now == 10_000 {
            let addresses = background.node().addresses();
            let request = ToDrive::RequestWord(RequestWord { mode: MotorMode::Drive });
            background.node().handle_frame(&request.encode(addresses));
        }
        background.run(now);
        driven |= tick.drive().state().is_driving();
        frames.extend(core::iter::from_fn(|| background.node().poll_frame()));
    }
    assert_ne!(tick.drive().state(), State::Initialization, "half a second of boot has passed");
    assert!(driven, "the Drive request was taken");
    assert!(frames.len() > 100, "periodic broadcasts: {}", frames.len());
    assert!(frames.iter().all(|frame| FromDrive::decode(frame).is_ok()));
}

#[test]
fn a_background_that_is_late_loses_no_state_and_stops_no_tick() {
    let mut queues = Queues::new();
    let (mut tick, mut background) = queues.power_up(Identity::default(), Board::BENCH, Parameters::new());
    // Ten seconds without the background: reports pile up, the newest is what counts.
    for now in 0..100_000 {
        tick.step(&at_rest(now));
    }
    background.run(100_000);
    tick.step(&at_rest(100_000));
    background.run(100_001);
    tick.step(&at_rest(100_001));
    background.run(100_002);
    assert_eq!(background.node().status().state, tick.drive().state());
    assert!(background.node().status().tick >= 99_990);
}
