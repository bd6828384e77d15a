//! Tests of TX-Drivers that run together at every bitrate, and of one with another bitrate than the rest.

use crate::bench::{BITRATES, node};
use crate::wired::{Wired, driver, read};
use narx_core::bus::eddycan::{
    Bitrate, Channels, FromNode, Layout, NmtCommand, NmtState, PdoKind, SdoAction, SdoOutcome, SdoRequest,
    ToNode,
};
use narx_core::eddycan::Entry;
use narx_sim::can::ErrorState;

const LAYOUT: Layout = Layout { channels: Channels::Single, encoder: false };

fn index(bitrate: Bitrate) -> (Entry, u32) {
    (Entry::BitrateIndex, bitrate as u32)
}

/// Runs the bus; returns the messages with the nodes that sent them.
fn sent(wired: &mut Wired, milliseconds: u64) -> Vec<(u8, FromNode)> {
    wired.run(milliseconds).iter().filter_map(|received| read(&received.frame, LAYOUT)).collect()
}

#[test]
fn all_five_run_among_themselves() {
    for (bitrate, _) in BITRATES {
        let mut wired = Wired::new(bitrate);
        [5, 9, 100].into_iter().for_each(|id| wired.add(&driver(id, &[index(bitrate)])));
        let boots = sent(&mut wired, 20);
        let boot = FromNode::Heartbeat(NmtState::BootUp);
        assert_eq!(boots, [(5, boot), (9, boot), (100, boot)], "{bitrate:?}");
        let request = SdoRequest { index: 0x2001, subindex: 0, action: SdoAction::Read };
        wired.send(ToNode::Sdo { node: node(9), request });
        let answers = sent(&mut wired, 20);
        assert!(
            matches!(answers[..], [(9, FromNode::Sdo(answer))]
                if matches!(answer.outcome, SdoOutcome::Value(value) if value.number() == bitrate as u32)),
            "{bitrate:?}: {answers:?}"
        );
        wired.command(NmtCommand::Start);
        wired.send(ToNode::Sync);
        let positions = sent(&mut wired, 20);
        let nodes: Vec<u8> = positions.iter().map(|(node, _)| *node).collect();
        assert_eq!(nodes, [5, 9, 100], "{bitrate:?}");
        assert!(
            positions.iter().all(|(_, message)| matches!(message, FromNode::Pdo { kind: PdoKind::Sync, .. }))
        );
        assert_eq!(wired.bus.statistics().errors, 0, "{bitrate:?}");
    }
}

/// A node with a wrong bitrate destroys the frames of others, receives nothing, and its own frames never
/// arrive. Its error counters take it off the bus, and the others recover.
#[test]
fn a_wrong_bitrate_makes_error_frames_and_not_silence() {
    for wrong in [Bitrate::K50, Bitrate::K250, Bitrate::M1] {
        let mut wired = Wired::new(Bitrate::K500);
        [5, 9].into_iter().for_each(|id| wired.add(&driver(id, &[])));
        wired.run(10);
        wired.add(&driver(7, &[index(wrong)]));
        let foreign = wired.device(2).place();
        // Its boot-up message is destroyed on the wire, which adds 8 to the counter each time, until it is
        // off the bus.
        let received = sent(&mut wired, 2);
        assert!(received.iter().all(|(node, _)| *node != 7), "{wrong:?}: {received:?}");
        assert!(wired.bus.statistics().errors >= 16, "{wrong:?}: {:?}", wired.bus.statistics());
        let mut worst = ErrorState::Active;
        for _ in 0..40 {
            wired.run(1);
            if wired.bus.error_state(foreign) == Some(ErrorState::BusOff) {
                worst = ErrorState::BusOff;
            }
        }
        assert_eq!(worst, ErrorState::BusOff, "{wrong:?}");
        // Back on the bus it only listens, and its error flags destroy frames of others until it is error
        // passive.
        let before = wired.bus.statistics().errors;
        wired.command(NmtCommand::Start);
        let other = wired.device(0).place();
        let mut suffered = false;
        for _ in 0..200 {
            wired.run(1);
            suffered |= wired.bus.error_state(other) != Some(ErrorState::Active);
        }
        let errors = wired.bus.statistics().errors - before;
        assert!((32..=256).contains(&errors), "{wrong:?}: {errors}");
        assert_eq!(wired.bus.error_state(foreign), Some(ErrorState::Passive), "{wrong:?}");
        let states: Vec<NmtState> =
            wired.drivers.devices().iter().map(|device| device.driver().state()).collect();
        assert_eq!(
            states,
            [NmtState::Operational, NmtState::Operational, NmtState::PreOperational],
            "{wrong:?}: it has not received the start"
        );
        // The others had errors, and work again.
        assert!(suffered, "{wrong:?}");
        wired.send(ToNode::Sync);
        let nodes: Vec<u8> = sent(&mut wired, 20).iter().map(|(node, _)| *node).collect();
        assert_eq!(nodes, [5, 9], "{wrong:?}");
    }
}

/// A written bitrate takes effect after the reset; then the node is lost to the others, which keep the old
/// one.
#[test]
fn a_node_that_was_given_another_bitrate_leaves_the_others() {
    let mut wired = Wired::new(Bitrate::K500);
    [5, 9].into_iter().for_each(|id| wired.add(&driver(id, &[])));
    wired.run(10);
    let action = SdoAction::Write { size: None, data: [Bitrate::K250 as u8, 0, 0, 0] };
    wired.send(ToNode::Sdo { node: node(5), request: SdoRequest { index: 0x2001, subindex: 0, action } });
    let answered = sent(&mut wired, 10);
    assert!(matches!(answered[..], [(5, FromNode::Sdo(answer))] if answer.outcome == SdoOutcome::Written));
    assert_eq!(wired.bus.statistics().errors, 0);
    wired.command(NmtCommand::Reset);
    let boots = sent(&mut wired, 300);
    assert!(boots.iter().all(|(node, _)| *node == 9), "{boots:?}");
    assert!(wired.bus.statistics().errors > 0);
    assert_eq!(wired.device(0).driver().bitrate(), Bitrate::K250);
}

/// A node that a neighbour at another bitrate drives off the bus reports this, at any phase of the traffic.
/// Its message is often the very frame that is destroyed until the controller is off; it is sent again. The
/// neighbour does not send its own again, because no node would receive it.
#[test]
fn a_victim_tells_of_it_at_every_phase() {
    let cases = [(1, 1), (1, 10), (3, 3), (3, 10)]
        .into_iter()
        .flat_map(|case| (0..20).map(move |phase| (case, phase)));
    for ((update, pause), phase) in cases {
        let case = format!("update {update} ms, phase {phase}, a SYNC every {pause} ms");
        let mut wired = Wired::new(Bitrate::K500);
        wired.add(&driver(5, &[(Entry::UpdateTime, update)]));
        wired.run(10);
        wired.command(NmtCommand::Start);
        wired.run(20);
        for _ in 0..phase {
            wired.tick();
        }
        wired.add(&driver(7, &[index(Bitrate::K250)]));
        let victim = wired.device(0).place();
        let (mut suffered, mut told) = (false, Vec::new());
        for millisecond in 0..2000 {
            if millisecond % pause == 0 {
                wired.send(ToNode::Sync);
            }
            for received in wired.run(1) {
                let message = read(&received.frame, LAYOUT);
                assert!(!matches!(message, Some((7, _))), "{case}: {message:?}");
                if let Some((5, FromNode::Error { code })) = message {
                    told.push((received.time_ns / 1_000_000, code));
                }
            }
            suffered |= wired.bus.error_state(victim) != Some(ErrorState::Active);
        }
        assert_eq!(suffered, !told.is_empty(), "{case}");
        assert!(told.iter().all(|(_, code)| *code == 0x8120), "{case}: {told:?}");
        assert!(told.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 990), "{case}: {told:?}");
        // After that there are no more errors.
        let before = wired.bus.statistics().errors;
        wired.run(100);
        assert_eq!(wired.bus.statistics().errors, before, "{case}");
    }
}
