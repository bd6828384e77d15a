//! Tests of a drive and up to 127 TX-Drivers on one bus of 500 kbit/s.

use crate::bench::node;
use crate::wired::{driver, read};
use narx_core::bus::Frame;
use narx_core::bus::eddycan::{Channels, FromNode, Layout, NmtCommand, PdoKind, Target, ToNode};
use narx_core::bus::narmotion::{Addresses, FromDrive, ToDrive};
use narx_core::commissioning::Mode;
use narx_core::eddycan::Entry;
use narx_core::motor::State;
use narx_sim::can::worst_case_bits;
use narx_sim::presets::preset;
use narx_sim::session::{Session, SessionConfig};
use std::collections::BTreeMap;

const LAYOUT: Layout = Layout { channels: Channels::Single, encoder: false };
const BITRATE: f64 = 500_000.0;

/// A drive in Standby and its master.
fn session() -> Session {
    let preset = preset("ec45-flat-50w-18v").unwrap();
    let config = SessionConfig { trace: false, ..SessionConfig::new(preset.motor, 18.0, Mode::Hall) };
    let mut session = Session::new(&config).unwrap();
    session.run(0.7);
    assert_eq!(session.bench().status().state, State::Standby);
    session
}

/// A drive with `nodes` TX-Drivers that share half of the bus, in Operational from their power-up.
fn half_loaded(nodes: u8) -> Session {
    let mut session = session();
    add(
        &mut session,
        nodes,
        &[(Entry::CanConfig, 1), (Entry::NrOfNodes, nodes.into()), (Entry::UpdateTime, 65_535)],
    );
    session.run(0.1);
    session
}

fn add(session: &mut Session, nodes: u8, values: &[(Entry, u32)]) {
    for id in 1..=nodes {
        session.bench_mut().add_tx_driver(&driver(id, values)).unwrap();
    }
}

/// Frames that pass on the bus within a time, with the end of each in ns.
fn monitored(session: &mut Session, seconds: f64) -> Vec<(u64, Frame)> {
    let end = session.bench().now_ns() + (seconds * 1e9) as u64;
    let mut received = Vec::new();
    while session.bench().now_ns() < end {
        session.step();
        received.extend(std::iter::from_fn(|| session.bench_mut().monitor()).map(|r| (r.time_ns, r.frame)));
    }
    received
}

fn send(session: &mut Session, message: ToNode) {
    session.bench_mut().send(message.encode()).unwrap();
}

/// Numbers of PDOs of a kind by node.
fn pdos(received: &[(u64, Frame)], wanted: PdoKind) -> BTreeMap<u8, u32> {
    let mut found = BTreeMap::new();
    for (_, frame) in received {
        if let Some((node, FromNode::Pdo { kind, .. })) = read(frame, LAYOUT)
            && kind == wanted
        {
            *found.entry(node).or_insert(0) += 1;
        }
    }
    found
}

/// Frames within a whole number of periods, each counted with the largest number of bits that it can have,
/// take half of the bus, within 2 %. Their real share is smaller, because few of the possible stuff bits
/// occur.
#[test]
fn half_of_the_bus_is_half_of_the_bus() {
    for nodes in [1, 2, 10, 127] {
        let mut session = half_loaded(nodes);
        let period = session.bench().tx_drivers()[0].driver().period().unwrap();
        let periods = 1_200_000 / period;
        let window = periods * period * 1000;
        let (from, before) = (session.bench().now_ns(), session.bench().bus_statistics());
        let received = monitored(&mut session, window as f64 * 1e-9 + 1e-3);
        let inside: Vec<(u64, Frame)> =
            received.into_iter().filter(|(at, _)| (from..from + window).contains(at)).collect();
        let found = pdos(&inside, PdoKind::Timer);
        let count: u32 = found.values().sum();
        let bits = f64::from(count) * f64::from(worst_case_bits(false, LAYOUT.length()));
        let share = bits / (BITRATE * window as f64 * 1e-9);
        let load = session.bench().bus_statistics().load_since(&before, window + 1_000_000);
        println!("{nodes} nodes: {share:.4} of the worst case, bus load {load:.3} with the drive");
        assert!((share - 0.5).abs() < 0.5 * 0.02, "{nodes} nodes: {share}");
        assert_eq!(found.len(), usize::from(nodes));
        // A position that the drive's long frames delay is overwritten by the next: one node alone, at 380
        // us, loses 0.5 % in this way.
        let each = periods as u32;
        assert!(
            found.values().all(|count| count.abs_diff(each) <= 1 + each / 100),
            "{nodes} nodes: {found:?}"
        );
        assert!(load < 0.55, "{nodes} nodes: {load}");
        assert_eq!(session.bench().bus_statistics().errors, 0);
    }
}

/// Longest time from a request of the host to the drive's answer, for parameters and set-points in turn, ms.
fn worst_answer(session: &mut Session, requests: u32, mut meanwhile: impl FnMut(&mut Session)) -> f64 {
    let mut worst = 0;
    for request in 0..requests {
        // Each request at another phase of the nodes' period.
        monitored(session, 0.0173);
        meanwhile(session);
        let read = request % 2 == 0;
        let message = match read {
            true => ToDrive::RequestParameter { number: 99 },
            false => ToDrive::MotorCommand { speed: 1500 },
        };
        let sent = session.bench().now_ns();
        session.bench_mut().send(message.encode(Addresses::FACTORY)).unwrap();
        let answered =
            monitored(session, 0.06).into_iter().find(|(_, frame)| match FromDrive::decode(frame) {
                Ok((_, FromDrive::Parameter { number: 99, .. })) => read,
                Ok((_, FromDrive::MotorCommand { speed })) => !read && speed > 0,
                _ => false,
            });
        worst = worst.max(answered.unwrap().0 - sent);
    }
    worst as f64 * 1e-6
}

/// Longest time from one STATUS_WORD to the next, ms; the drive sends one every 50 ms.
fn longest_silence(session: &mut Session) -> f64 {
    let received = monitored(session, 2.0);
    let words = received
        .iter()
        .filter(|(_, frame)| matches!(FromDrive::decode(frame), Ok((_, FromDrive::Status(_)))));
    let times: Vec<u64> = words.map(|(at, _)| *at).collect();
    assert!(times.len() > 30, "{}", times.len());
    times.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap() as f64 * 1e-6
}

/// The drive keeps answering beside 127 nodes: every PDO1 wins against the drive's 29-bit identifiers, but
/// they come one by one and leave half of the bus. Only a SYNC of all nodes fills the bus at once with its
/// answers.
#[test]
fn the_drive_keeps_answering() {
    let alone = worst_answer(&mut session(), 40, |_| ());
    let mut shared = half_loaded(127);
    let half = worst_answer(&mut shared, 40, |_| ());
    let silence = longest_silence(&mut shared);
    let burst = worst_answer(&mut shared, 10, |session| send(session, ToNode::Sync));
    println!(
        "worst answer: {alone:.2} ms alone, {half:.2} ms beside 127 nodes, {burst:.2} ms after their SYNC"
    );
    println!("status words: at most {silence:.2} ms apart beside 127 nodes");
    assert!(silence <= 55.0, "{silence} ms");
    // The answer waits for all broadcasts of the drive itself.
    assert!(alone < 3.0, "{alone} ms");
    assert!(half <= 5.0, "{half} ms");
    assert!(burst <= 50.0, "{burst} ms");
    assert_eq!(shared.bench().status().state, State::Standby);
    assert_eq!(shared.bench().status().faults.bits(), 0);
    assert_eq!(shared.bench().overruns(), 0);
}

/// A bus has room for as many TX-Drivers as there are node-ids. A further one is refused, and so is one with
/// an invalid sensor; neither takes a place.
#[test]
fn a_bus_has_room_for_127() {
    let mut session = session();
    let mut wrong = driver(1, &[]);
    wrong.sensors[0].range = 20.0;
    let refused = session.bench_mut().add_tx_driver(&wrong).unwrap_err();
    assert_eq!(refused.to_string(), "measuring range 20 mm: must be from 0.01 to 15.9 mm");
    add(&mut session, 127, &[]);
    let refused = session.bench_mut().add_tx_driver(&driver(1, &[])).unwrap_err();
    assert_eq!(refused.to_string(), "the bus has no place left for another node");
    assert_eq!(session.bench().tx_drivers().len(), 127);
}

/// After a SYNC all nodes sample at one instant and send one after the other, in the order of their node-ids.
#[test]
fn a_sync_of_127_nodes() {
    let mut session = session();
    add(&mut session, 127, &[]);
    let boots = monitored(&mut session, 0.05);
    assert_eq!(
        boots.iter().filter(|(_, frame)| frame.id().raw() > 0x700 && !frame.id().is_extended()).count(),
        127
    );
    send(&mut session, ToNode::Nmt { command: NmtCommand::Start, target: Target::All });
    monitored(&mut session, 0.005);
    let sent = session.bench().now_ns();
    send(&mut session, ToNode::Sync);
    let received = monitored(&mut session, 0.05);
    let answers: Vec<(u64, u8)> = received
        .iter()
        .filter_map(|(at, frame)| match read(frame, LAYOUT)? {
            (node, FromNode::Pdo { kind: PdoKind::Sync, .. }) => Some((*at, node)),
            _ => None,
        })
        .collect();
    assert!(answers.iter().map(|(_, node)| *node).eq(1..=127), "{answers:?}");
    let last = (answers[126].0 - sent) as f64 * 1e-6;
    println!("127 answers in {last:.2} ms");
    // 127 frames of 82 to 95 bits at 2 us, and the frames of the drive that win against some of them.
    assert!((20.0..30.0).contains(&last), "{last} ms");
    assert_eq!(session.bench().bus_statistics().errors, 0);
}

/// A remote frame requests the position of one node, and no other answers; 127 of them are all answered.
#[test]
fn remote_frames_ask_node_by_node() {
    let mut session = session();
    add(&mut session, 127, &[(Entry::CanConfig, 1)]);
    monitored(&mut session, 0.05);
    for id in [1, 64, 127] {
        send(&mut session, ToNode::RequestPdo { node: node(id), bytes: 4 });
        let found = pdos(&monitored(&mut session, 0.005), PdoKind::Remote);
        assert_eq!(found, BTreeMap::from([(id, 1)]));
    }
    let mut received = Vec::new();
    for id in 1..=127 {
        send(&mut session, ToNode::RequestPdo { node: node(id), bytes: 4 });
        received.extend(monitored(&mut session, 0.000_5));
    }
    received.extend(monitored(&mut session, 0.05));
    let found = pdos(&received, PdoKind::Remote);
    assert_eq!(found.len(), 127);
    assert!(found.values().all(|count| *count == 1));
}

/// While the motor runs, the TX-Drivers send the positions of its shaft, and the drive is not affected.
#[test]
fn a_running_motor_is_measured() {
    let mut session = session();
    add(&mut session, 2, &[(Entry::CanConfig, 1), (Entry::UpdateTime, 1)]);
    session.start(1500);
    session.run(1.0);
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    let mut frames = 0;
    for (_, frame) in monitored(&mut session, 0.2) {
        if let Some((1, FromNode::Pdo { reading, .. })) = read(&frame, LAYOUT) {
            let position = f64::from(reading.positions[0].raw()) / 134_217_728.0;
            (low, high) = (low.min(position), high.max(position));
            frames += 1;
        }
    }
    assert!((199..=201).contains(&frames), "one every millisecond: {frames}");
    // 20 um cos(angle) + 5 um cos(2 angle) lies between -15 um and 25 um; five revolutions, forty samples
    // each, noise of 0.1 um.
    let (bottom, top) = (1e3 * (low - 1.0), 1e3 * (high - 1.0));
    assert!((top - 25.0).abs() < 0.8, "{top} um");
    assert!((bottom + 15.0).abs() < 0.8, "{bottom} um");
    assert_eq!(session.bench().status().faults.bits(), 0);
}

/// Equal configurations give equal frames, and another seed other noise. A bench without drivers is not
/// affected by the feature.
#[test]
fn the_same_bits_every_time() {
    let run = |seed| {
        let preset = preset("ec45-flat-50w-18v").unwrap();
        let config =
            SessionConfig { seed, trace: false, ..SessionConfig::new(preset.motor, 18.0, Mode::Hall) };
        let mut session = Session::new(&config).unwrap();
        add(&mut session, 3, &[(Entry::CanConfig, 1), (Entry::UpdateTime, 5)]);
        session.start(1500);
        let received = monitored(&mut session, 1.0);
        (received, session.bench().digest())
    };
    let first = run(1);
    assert_eq!(first, run(1));
    assert_ne!(first.0, run(2).0);
}
