//! Tests of the two halves that a shell links: joined by queues alone, they behave as the drive and the node
//! of the bench.

use narx_core::bus::narmotion::{FromDrive, MotorMode, RequestWord, ToDrive};
use narx_core::device::{Background, Queues};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::{Board, Samples, State};
use narx_core::node::Identity;
use narx_core::scope::{Memory, State as ScopeState};

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
    // Ten seconds without the background: reports pile up, and only the newest counts.
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

/// The scope's requests and blocks pass between the halves, however rarely the background runs.
#[test]
fn a_scope_works_between_the_halves() {
    for (words, pause) in [(64, 1), (64, 40), (0, 1)] {
        let mut memory = Memory::<[u16; 64]>::new();
        let mut queues = Queues::new();
        let (mut tick, mut background) =
            queues.power_up(Identity::default(), Board::BENCH, Parameters::new());
        if words > 0 {
            background.attach_scope(&mut memory);
        }
        // As many samples of three signals as 64 words hold.
        background.node().write_parameter(number::SCOPE_SAMPLES, 21);
        let (mut record, mut states) = (Vec::new(), Vec::new());
        for now in 0..20_000 {
            tick.step(&at_rest(now));
            if !now.is_multiple_of(pause) {
                continue;
            }
            let addresses = background.node().addresses();
            let request = match now {
                4_000 | 8_000 => Some(ToDrive::TriggerScope),
                12_000 => Some(ToDrive::DownloadScope),
                _ => None,
            };
            if let Some(request) = request {
                background.node().handle_frame(&request.encode(addresses));
            }
            background.run(now);
            if now % 4_000 == 2_000 {
                states.push(background.node().read_parameter(number::SCOPE_STATE).unwrap());
            }
            while background.node().poll_frame().is_some() {}
            while let Some(frame) = background.node().poll_bulk_frame() {
                let FromDrive::ScopeData { address, data } = FromDrive::decode(&frame).unwrap().1 else {
                    panic!("{frame:?}")
                };
                assert_eq!(usize::from(address), record.len());
                record.extend(data);
            }
        }
        let refused = background.node().read_parameter(number::REFUSED_FRAMES).unwrap();
        if words == 0 {
            assert_eq!(
                (states, record.len(), refused),
                (vec![0; 5], 0, 3),
                "without memory nothing is armed"
            );
        } else {
            // 21 samples of three signals; the last block is filled up.
            assert_eq!((states, record.len(), refused), (vec![0, 1, 3, 3, 3], 63, 0));
        }
    }
}

/// With a background that is faster than the tick, which has room for one order, the next order waits, and
/// none is lost.
#[test]
fn orders_wait_for_the_tick() {
    let mut memory = Memory::<[u16; 64]>::new();
    let mut queues = Queues::new();
    let (mut tick, mut background) = queues.power_up(Identity::default(), Board::BENCH, Parameters::new());
    background.attach_scope(&mut memory);
    background.node().write_parameter(number::SCOPE_SAMPLES, 21);
    let state = |background: &mut Background<'_, '_>| {
        background.node().read_parameter(number::SCOPE_STATE).map(|raw| raw == ScopeState::Done as i32)
    };
    // The first arms, the second forces.
    for _ in 0..2 {
        let addresses = background.node().addresses();
        background.node().handle_frame(&ToDrive::TriggerScope.encode(addresses));
        (0..3).for_each(|_| background.run(0));
    }
    assert_eq!(background.node().read_parameter(number::REFUSED_FRAMES), Some(0));
    for now in 0..4_000 {
        assert_eq!(state(&mut background), Some(false), "at {now}");
        tick.step(&at_rest(now));
        background.run(now);
        if state(&mut background) == Some(true) {
            return;
        }
    }
    panic!("it was forced");
}
