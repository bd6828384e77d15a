//! Tests of stored values, and of those that take effect only after a restart.

use crate::bench::{Bench, configured, frame, node};
use narx_core::bus::eddycan::{Bitrate, Channels, FromNode, NmtCommand, NmtState, SdoValue, Target, ToNode};
use narx_core::eddycan::Entry;

const RESET: ToNode = ToNode::Nmt { command: NmtCommand::Reset, target: Target::All };

#[test]
fn node_id_and_bitrate_act_after_a_restart_and_read_as_stored() {
    let mut bench = Bench::new(Channels::Single, &[]);
    bench.put(Entry::NodeId, 42);
    bench.put(Entry::BitrateIndex, 0);
    assert_eq!(bench.read(0x2000, 0), crate::bench::value(SdoValue::byte(42)), "still answers as node 1");
    assert_eq!(bench.read(0x2001, 0), crate::bench::value(SdoValue::byte(0)));
    assert_eq!((bench.driver.node(), bench.driver.bitrate()), (node(1), Bitrate::K500));
    bench.send(RESET);
    let stored = bench.driver.poll_store().unwrap();
    bench.driver.handle_store(true);
    assert!(bench.driver.take_reset());
    bench.restart(stored, Channels::Single);
    assert_eq!((bench.driver.node(), bench.driver.bitrate()), (node(42), Bitrate::K50));
    assert_eq!(bench.frames(), [frame(0x700 + 42, &[0])]);
}

/// The period of a PDO1 at 65535 is computed for the present bitrate, not for the written one.
#[test]
fn the_period_is_of_the_bitrate_in_force() {
    let mut bench = Bench::new(Channels::Single, &[(Entry::UpdateTime, 65_535)]);
    let before = bench.driver.period();
    bench.put(Entry::BitrateIndex, 4);
    assert_eq!(bench.driver.period(), before);
    bench.put(Entry::NrOfNodes, 3);
    assert_eq!(bench.driver.period(), before.map(|period| 3 * period));
}

#[test]
fn what_was_written_before_a_reset_is_stored_before_the_restart() {
    let mut bench = Bench::new(Channels::Single, &[]);
    bench.put(Entry::UpdateTime, 1);
    assert_eq!(bench.driver.poll_store().unwrap(), configured(&[(Entry::UpdateTime, 1)]));
    bench.put(Entry::UpdateTime, 2);
    assert_eq!(bench.driver.poll_store(), None, "one is under way");
    bench.send(RESET);
    assert!(!bench.driver.take_reset());
    bench.driver.handle_store(true);
    assert!(!bench.driver.take_reset());
    // The minimum time between stores does not delay a restart.
    assert_eq!(bench.driver.poll_store().unwrap(), configured(&[(Entry::UpdateTime, 2)]));
    assert!(!bench.driver.take_reset());
    bench.driver.handle_store(true);
    assert!(bench.driver.take_reset());
    assert!(!bench.driver.take_reset(), "said once");
}

#[test]
fn a_memory_that_never_answers_delays_a_restart_by_a_second() {
    let mut bench = Bench::new(Channels::Single, &[]);
    bench.put(Entry::UpdateTime, 1);
    assert!(bench.driver.poll_store().is_some());
    bench.send(RESET);
    bench.wait(999_999);
    assert!(!bench.driver.take_reset());
    bench.wait(1);
    assert!(bench.driver.take_reset());
}

/// A node that is about to restart neither takes nor sends messages.
#[test]
fn between_reset_and_restart_there_is_silence() {
    let values = [(Entry::UpdateTime, 1), (Entry::CanConfig, 4)];
    let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &values);
    bench.send(ToNode::Sync);
    bench.send(RESET);
    let before = bench.driver.clone();
    bench.send(ToNode::Sync);
    bench.send(ToNode::Nmt { command: NmtCommand::Stop, target: Target::All });
    assert_eq!(bench.driver, before);
    for _ in 0..10 {
        assert_eq!(bench.wait(1_000_000), []);
    }
}

/// The first write is stored at once, those of the next second together, and none is lost.
#[test]
fn stores_are_a_second_apart() {
    let mut bench = Bench::new(Channels::Single, &[]);
    let mut stores = Vec::new();
    for round in 1..=100_u32 {
        bench.put(Entry::UpdateTime, round);
        if let Some(stored) = bench.driver.poll_store() {
            stores.push((bench.now, stored.get(Entry::UpdateTime)));
            bench.driver.handle_store(true);
        }
        bench.wait(100_000);
    }
    assert_eq!(stores.len(), 10);
    assert!(stores.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 1_000_000));
    assert_eq!(stores[0].1, 1);
    bench.wait(1_000_000);
    assert_eq!(bench.driver.poll_store().unwrap().get(Entry::UpdateTime), 100);
}

#[test]
fn a_write_of_the_same_value_stores_nothing() {
    let mut bench = Bench::new(Channels::Single, &[]);
    bench.put(Entry::NrOfNodes, 1);
    bench.wait(5_000_000);
    assert_eq!(bench.driver.poll_store(), None);
}

/// Writing a value again while it is being stored causes no further store.
#[test]
fn a_write_of_the_same_value_while_it_is_stored_stores_nothing_more() {
    for (again, stores) in [(7, 0), (8, 1)] {
        let mut bench = Bench::new(Channels::Single, &[]);
        bench.put(Entry::UpdateTime, 7);
        assert_eq!(bench.driver.poll_store(), Some(configured(&[(Entry::UpdateTime, 7)])));
        bench.put(Entry::UpdateTime, again);
        bench.driver.handle_store(true);
        bench.wait(5_000_000);
        assert_eq!(std::iter::from_fn(|| bench.driver.poll_store()).count(), stores, "{again}");
    }
}

#[test]
fn a_reset_by_name_is_for_that_node() {
    let mut bench = Bench::new(Channels::Single, &[]);
    for (target, meant) in [(Target::Node(node(2)), false), (Target::Node(node(1)), true)] {
        bench.send(ToNode::Nmt { command: NmtCommand::Reset, target });
        assert_eq!(bench.driver.take_reset(), meant);
    }
    assert_eq!(bench.messages(), Vec::<FromNode>::new());
}
