//! Tests of the equality of nodes: they are equal if their state and their waiting messages are; a transcript
//! that runs again is compared in this way.

use crate::bench::Bench;
use narx_core::bus::narmotion::{Addresses, MotorMode, RequestWord, ToDrive};
use narx_core::node::Node;
use narx_core::scope::{Block, ScopeReply, State};

fn send(node: &mut Node, message: ToDrive) {
    node.handle_frame(&message.encode(Addresses::FACTORY));
}

fn drain(node: &mut Node) {
    while node.poll_frame().is_some() {}
    while node.poll_event().is_some() {}
}

/// A node with a waiting broadcast, two words and six measurements, that is sending a record of the scope.
fn node() -> Node {
    let mut node = Bench::new().node;
    node.poll(0);
    node.handle_scope(ScopeReply::State(State::Done, 9));
    send(&mut node, ToDrive::DownloadScope);
    node.poll_scope();
    node
}

fn block(words: [u16; 3]) -> ScopeReply {
    ScopeReply::Block(Block { address: 0, words, last: true })
}

#[test]
fn what_waits_tells_nodes_apart() {
    let request = |node: &mut Node, mode| send(node, ToDrive::RequestWord(RequestWord { mode }));
    let less = |node: &mut Node| assert!(node.poll_frame().is_some());
    // After these many frames, the events of one node, and of the other.
    type Happens<'a> = &'a dyn Fn(&mut Node);
    let cases: [(&str, usize, Happens<'_>, Happens<'_>); 8] = [
        ("a set-point", 0, &|node| send(node, ToDrive::MotorCommand { speed: 1 }), &|node| {
            send(node, ToDrive::MotorCommand { speed: 2 });
        }),
        ("requests", 0, &|node| request(node, MotorMode::Standby), &|node| request(node, MotorMode::Fault)),
        ("one request more", 0, &|_| {}, &|node| request(node, MotorMode::Standby)),
        ("answers", 0, &|node| send(node, ToDrive::RequestBuildInfo), &|node| {
            send(node, ToDrive::RequestDeviceInfo);
        }),
        ("a word less", 1, &|_| {}, &less),
        ("a measurement less", 2, &|_| {}, &less),
        ("what the scope does", 0, &|_| {}, &|node| node.handle_scope(ScopeReply::State(State::Idle, 0))),
        ("a block of the scope", 0, &|node| node.handle_scope(block([1, 2, 3])), &|node| {
            node.handle_scope(block([1, 2, 4]));
        }),
    ];
    for (what, frames, one, other) in cases {
        let mut node = node();
        (0..frames).for_each(|_| assert!(node.poll_frame().is_some()));
        let [mut first, mut second, mut third] = [node.clone(), node.clone(), node];
        one(&mut first);
        one(&mut second);
        other(&mut third);
        assert!(first == second, "{what}: the same happened to both");
        assert!(first != third, "{what}");
    }
}

/// A queue does not differ by the messages that have passed through it.
#[test]
fn what_has_passed_leaves_no_trace() {
    let mut node = node();
    drain(&mut node);
    let before = node.clone();
    for _ in 0..5 {
        for message in [ToDrive::RequestBuildInfo, ToDrive::RequestDeviceInfo] {
            send(&mut node, message);
        }
        send(&mut node, ToDrive::RequestWord(RequestWord { mode: MotorMode::Standby }));
        assert!(node != before);
        drain(&mut node);
    }
    assert!(node == before);
    let waits = |node: &mut Node| {
        send(node, ToDrive::RequestDeviceInfo);
        send(node, ToDrive::RequestWord(RequestWord { mode: MotorMode::Fault }));
    };
    let mut fresh = before;
    waits(&mut node);
    waits(&mut fresh);
    assert!(node == fresh, "the same waits, at other places of the queues");
}
