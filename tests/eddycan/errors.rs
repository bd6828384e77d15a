//! Tests of error messages: their causes, and their largest rate.

use crate::bench::{Bench, frame};
use narx_core::bus::eddycan::{Channels, NmtState, ToNode};
use narx_core::bus::{BusState, ErrorState, Frame};
use narx_core::eddycan::Entry;

fn bus(error: ErrorState) -> BusState {
    BusState { error, ..BusState::default() }
}

fn passive() -> Frame {
    frame(0x81, &[0x20, 0x81])
}

#[test]
fn error_passive_is_told_when_it_is_entered() {
    let mut bench = Bench::new(Channels::Single, &[]);
    bench.driver.handle_bus_state(bus(ErrorState::Active));
    assert_eq!(bench.poll(), []);
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    assert_eq!(bench.poll(), [passive()]);
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    assert_eq!(bench.wait(10_000_000), []);
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    assert_eq!(bench.poll(), [], "it has not been left");
    bench.driver.handle_bus_state(bus(ErrorState::BusOff));
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    assert_eq!(bench.poll(), [], "that is the way back");
    bench.driver.handle_bus_state(bus(ErrorState::Active));
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    assert_eq!(bench.poll(), [passive()]);
}

/// A node whose controller changes to and fro at the threshold sends each code at most once a second.
#[test]
fn each_code_once_a_second() {
    let mut bench = Bench::new(Channels::Single, &[]);
    let mut told = [0; 2];
    for _ in 0..10_000 {
        bench.driver.handle_bus_state(bus(ErrorState::Passive));
        bench.driver.handle_bus_state(bus(ErrorState::Active));
        bench.give(&frame(0, &[0x55, 1]));
        for frame in bench.wait(1000) {
            assert_eq!(frame.dlc(), 2);
            told[usize::from(frame.payload() == [0x00, 0x82])] += 1;
        }
    }
    assert_eq!(told, [10, 10]);
}

#[test]
fn the_node_is_silent_off_the_bus_and_begins_with_the_present() {
    let values = [(Entry::UpdateTime, 10), (Entry::CanConfig, 4)];
    let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &values);
    bench.send(ToNode::Sync);
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    bench.driver.handle_bus_state(bus(ErrorState::BusOff));
    bench.driver.poll(bench.now);
    for _ in 0..500 {
        assert_eq!(bench.wait(10_000), []);
    }
    bench.driver.handle_bus_state(bus(ErrorState::Active));
    // The error is reported late, because no node could receive it; positions and heartbeats would be out of
    // date.
    assert_eq!(bench.frames(), [passive()]);
    let frames = bench.wait(10_000);
    assert_eq!(frames.iter().map(|frame| frame.id().raw()).collect::<Vec<_>>(), [0x181]);
}

#[test]
fn a_message_that_was_lost_with_the_bus_is_told_again_once_others_are_received() {
    let mut bench = Bench::new(Channels::Single, &[]);
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    assert_eq!(bench.poll(), [passive()]);
    // The controller drops the frame that it holds.
    bench.driver.handle_bus_state(bus(ErrorState::BusOff));
    assert_eq!(bench.wait(5000), []);
    bench.driver.handle_bus_state(bus(ErrorState::Active));
    assert_eq!(bench.wait(10_000_000), [], "nobody is received");
    bench.give(&frame(0x80, &[]));
    assert_eq!(bench.frames(), [passive()]);
    // The message has arrived now; it is not sent again the next time off the bus.
    assert_eq!(bench.wait(2_000_000), []);
    bench.driver.handle_bus_state(bus(ErrorState::BusOff));
    bench.driver.handle_bus_state(bus(ErrorState::Active));
    bench.give(&frame(0x80, &[]));
    assert_eq!(bench.wait(2_000_000), []);
}

#[test]
fn what_is_told_again_keeps_its_second() {
    let mut bench = Bench::new(Channels::Single, &[]);
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    assert_eq!(bench.poll(), [passive()]);
    let told = bench.now;
    bench.driver.handle_bus_state(bus(ErrorState::BusOff));
    bench.wait(3000);
    bench.driver.handle_bus_state(bus(ErrorState::Active));
    bench.give(&frame(0x80, &[]));
    // A controller that becomes passive again meanwhile adds no message.
    bench.driver.handle_bus_state(bus(ErrorState::Passive));
    assert_eq!(bench.frames(), []);
    assert_eq!(bench.driver.next_poll(), told + 1_000_000);
    bench.driver.poll(told + 999_999);
    assert_eq!(bench.driver.poll_frame(), None);
    bench.driver.poll(told + 1_000_000);
    assert!(bench.driver.next_poll() > told + 1_000_000, "a shell that cannot send yet does not spin");
    assert_eq!(bench.driver.poll_frame(), Some(passive()));
    assert_eq!(bench.driver.poll_frame(), None);
}

#[test]
fn the_boot_up_waits_for_the_bus() {
    let variant = crate::bench::variant(Channels::Single);
    let mut driver = narx_core::eddycan::TxDriver::new(variant, crate::bench::configured(&[]));
    driver.handle_bus_state(bus(ErrorState::BusOff));
    driver.poll(0);
    assert_eq!(driver.poll_frame(), None);
    driver.handle_bus_state(bus(ErrorState::Active));
    assert_eq!(driver.poll_frame(), Some(frame(0x701, &[0])));
}

#[test]
fn a_store_that_fails_is_told_and_tried_again_by_the_next_write() {
    let generic = frame(0x81, &[0x00, 0x10]);
    for state in [NmtState::PreOperational, NmtState::Operational, NmtState::Stopped] {
        let mut bench = Bench::new(Channels::Single, &[]);
        bench.put(Entry::UpdateTime, 50);
        assert!(bench.driver.poll_store().is_some());
        bench.enter(state);
        bench.driver.handle_store(false);
        assert_eq!(bench.frames(), [generic], "{state:?}");
        assert_eq!(bench.driver.configuration().get(Entry::UpdateTime), 50, "it acts all the same");
        bench.wait(5_000_000);
        assert_eq!(bench.driver.poll_store(), None, "not by itself");
        bench.enter(NmtState::PreOperational);
        bench.put(Entry::UpdateTime, 50);
        let stored = bench.driver.poll_store().expect("the same value again is a wish to store it");
        assert_eq!(stored.get(Entry::UpdateTime), 50);
        bench.driver.handle_store(true);
        bench.put(Entry::UpdateTime, 50);
        bench.wait(5_000_000);
        assert_eq!(bench.driver.poll_store(), None, "now it is stored");
    }
}

/// A shell that cannot read its memory starts with factory values and reports an error.
#[test]
fn a_memory_that_cannot_be_read_is_told() {
    let mut bench = Bench::new(Channels::Single, &[]);
    bench.driver.handle_store(false);
    assert_eq!(bench.poll(), [frame(0x81, &[0x00, 0x10])]);
}
