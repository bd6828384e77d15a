//! Several clients on one bus, and time that does not run away.

use super::client::{Connection, FRAMES, FromClient, LINES, PIECES};
use super::hub::Hub;
use super::pace::{Pace, Speed};
use super::tx_drivers;
use narx_core::bus::eddycan::{Channels, NodeId};
use narx_core::bus::narmotion::{Addresses, ToDrive};
use narx_core::bus::slcan::{self, NO, decode_frame, encode_frame};
use narx_core::bus::{Frame, Id};
use narx_core::commissioning::Mode;
use narx_sim::presets::preset;
use narx_sim::random::Random;
use narx_sim::session::SessionConfig;
use narx_sim::tx_driver::TxDriverConfig;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

fn hub() -> Hub {
    hub_with(&[])
}

/// With TX-Drivers of these node-ids beside the drive.
fn hub_with(nodes: &[u8]) -> Hub {
    let preset = preset("ec45-flat-50w-18v").unwrap();
    let config = SessionConfig { trace: false, ..SessionConfig::new(preset.motor, 18.0, Mode::Hall) };
    let mut bench = config.power_up().unwrap().0.without_recording();
    for node in nodes.iter().copied().filter_map(NodeId::new) {
        bench.add_tx_driver(&TxDriverConfig::new(node)).unwrap();
    }
    let mut hub = Hub::new(bench);
    // Beyond power-up, when the drive broadcasts.
    run(&mut hub, 6000);
    hub
}

fn run(hub: &mut Hub, ticks: u32) {
    (0..ticks).for_each(|_| hub.step());
}

/// The far end of a client's connection.
struct Far {
    to: SyncSender<FromClient>,
    from: Receiver<slcan::Line>,
}

impl Far {
    fn new(hub: &mut Hub) -> Self {
        let ((to, incoming), (outgoing, from)) = (sync_channel(PIECES), sync_channel(LINES));
        hub.attach(Connection { name: "client".into(), incoming, outgoing });
        Self { to, from }
    }

    fn open(hub: &mut Hub) -> Self {
        let far = Self::new(hub);
        far.say(b"O\r");
        run(hub, 1);
        assert_eq!(far.replies(), ["\r"]);
        far
    }

    fn say(&self, bytes: &[u8]) {
        self.to.try_send(FromClient::Bytes(bytes.to_vec())).unwrap();
    }

    fn send(&self, frames: impl IntoIterator<Item = Frame>) {
        self.say(&frames.into_iter().flat_map(|frame| encode_frame(&frame, None)).collect::<Vec<u8>>());
    }

    fn replies(&self) -> Vec<String> {
        self.from.try_iter().map(|line| String::from_utf8(line.to_vec()).unwrap()).collect()
    }

    /// Frames that it has received, without answers to its own commands.
    fn received(&self) -> Vec<Frame> {
        self.from.try_iter().filter_map(|line| Some(decode_frame(line.strip_suffix(b"\r")?)?.0)).collect()
    }
}

fn read(number: u16) -> Frame {
    ToDrive::RequestParameter { number }.encode(Addresses::FACTORY)
}

/// Nobody accepts these.
fn other(id: u32, tag: u8) -> Frame {
    Frame::data(Id::extended(id).unwrap(), &[tag]).unwrap()
}

fn is_answer(frame: &Frame) -> bool {
    frame.id() == Id::extended(0x1552_A86E).unwrap()
}

#[test]
fn everybody_but_its_sender_receives_a_frame_and_the_drive_accepts_it() {
    let mut hub = hub();
    let [one, two, closed] = [Far::open(&mut hub), Far::open(&mut hub), Far::new(&mut hub)];
    one.send([read(99)]);
    run(&mut hub, 400);
    let (first, second) = (one.received(), two.received());
    assert_eq!(first.iter().filter(|frame| is_answer(frame)).count(), 1);
    assert!(!first.contains(&read(99)));
    let others: Vec<Frame> = second.iter().copied().filter(|frame| *frame != read(99)).collect();
    assert_eq!(others, first, "the drive's frames");
    assert_eq!(second.len(), first.len() + 1);
    assert!(closed.received().is_empty());
}

#[test]
fn a_more_urgent_frame_of_another_client_overtakes() {
    let mut hub = hub();
    let [slow, quick, third] = [(); 3].map(|()| Far::open(&mut hub));
    slow.send((0..20).map(|tag| other(0x1FFF_FFFF, tag)));
    run(&mut hub, 10);
    quick.send([other(0x100, 0)]);
    run(&mut hub, 200);
    let received: Vec<Frame> = third.received().into_iter().filter(|frame| frame.dlc() == 1).collect();
    assert_eq!(received.len(), 21);
    let place = received.iter().position(|frame| *frame == other(0x100, 0)).unwrap();
    // 1 ms has passed when it comes: five short frames at most are gone, and two are in the controller.
    assert!(place <= 7, "{place}");
    let tags: Vec<u8> =
        received.iter().filter(|frame| **frame != other(0x100, 0)).map(|frame| frame.payload()[0]).collect();
    assert!(tags.iter().copied().eq(0..20), "each client's frames stay in their order");
}

#[test]
fn of_equal_identifiers_the_older_frame_goes_first() {
    let mut hub = hub();
    let [one, two, third] = [(); 3].map(|()| Far::open(&mut hub));
    one.send((0..10).map(|tag| other(0x123, tag)));
    two.send((100..110).map(|tag| other(0x123, tag)));
    run(&mut hub, 300);
    let tags: Vec<u8> =
        third.received().iter().filter(|frame| frame.dlc() == 1).map(|frame| frame.payload()[0]).collect();
    assert_eq!(tags.len(), 20);
    let last = |range: std::ops::Range<u8>| tags.iter().rposition(|tag| range.contains(tag)).unwrap();
    assert!(last(0..10).abs_diff(last(100..110)) <= 5, "neither waits for all of the other: {tags:?}");
}

#[test]
fn a_client_that_never_reads_loses_lines_and_is_told_while_the_others_receive_all() {
    let mut hub = hub();
    let [deaf, other] = [(); 2].map(|()| Far::open(&mut hub));
    let mut answers = 0;
    let rounds = LINES / 24 + 50;
    for _ in 0..rounds {
        other.send((0..12).map(read));
        run(&mut hub, 85);
        answers += other.received().iter().filter(|frame| is_answer(frame)).count();
    }
    assert_eq!(answers, 12 * rounds);
    assert_eq!(deaf.from.try_iter().count(), LINES);
    deaf.say(b"F\rF\r");
    run(&mut hub, 1);
    assert_eq!(deaf.replies(), ["F08\r", "F00\r"]);
    other.say(b"F\r");
    run(&mut hub, 1);
    assert_eq!(other.replies()[0], "F00\r");
}

#[test]
fn what_the_bus_cannot_take_is_refused() {
    let mut hub = hub();
    let [eager, other_one] = [(); 2].map(|()| Far::open(&mut hub));
    let frames: Vec<Frame> = (0..500).map(|tag: u32| other(0x1FFF_FFFF, tag as u8)).collect();
    let (mut yes, mut no, mut received) = (0, 0, 0);
    for frames in frames.chunks(40) {
        eager.send(frames.iter().copied());
        run(&mut hub, 12);
        received += other_one.received().iter().filter(|frame| frame.dlc() == 1).count();
        for reply in eager.replies() {
            yes += usize::from(reply == "\r");
            no += usize::from(reply.as_bytes() == [NO]);
        }
    }
    run(&mut hub, 2000);
    received += other_one.received().iter().filter(|frame| frame.dlc() == 1).count();
    assert_eq!(yes + no, 500);
    assert!(no > 0 && yes >= FRAMES, "{yes} accepted, {no} refused");
    assert_eq!(received, yes, "what was accepted is sent");
}

/// A client that sends rubbish changes nothing of what another one receives: neither a bit nor a millisecond.
#[test]
fn rubbish_disturbs_nobody() {
    let listen = |shouts: bool| {
        let mut hub = hub();
        let listener = Far::new(&mut hub);
        listener.say(b"Z1\rO\r");
        let shouter = Far::new(&mut hub);
        shouter.say(b"O\r");
        run(&mut hub, 1);
        let mut random = Random::new(1);
        let mut received = Vec::new();
        for tick in 0..10_000 {
            if shouts {
                let bytes: Vec<u8> = (0..64).map(|_| random.bits() as u8).collect();
                // It is not waited for.
                let _ = shouter.to.try_send(FromClient::Bytes(bytes));
            }
            if tick % 100 == 0 {
                listener.say(&encode_frame(&read(99), None));
            }
            hub.step();
            received.extend(listener.from.try_iter());
        }
        received
    };
    let (quiet, loud) = (listen(false), listen(true));
    assert!(quiet.len() > 200, "{}", quiet.len());
    assert_eq!(quiet, loud);
}

#[test]
fn what_a_client_said_before_it_left_is_sent_and_then_it_is_forgotten() {
    let mut hub = hub();
    let [one, two] = [(); 2].map(|()| Far::open(&mut hub));
    one.send((0..10).map(|tag| other(0x123, tag)));
    drop(one);
    run(&mut hub, 100);
    assert_eq!(two.received().iter().filter(|frame| frame.dlc() == 1).count(), 10);
    let news = hub.take_news();
    assert_eq!(
        news.last().map(String::as_str),
        Some("client left: 0 lines to it and 0 frames of it dropped")
    );
}

#[test]
fn a_line_that_hangs_up_closes_its_channel() {
    let mut hub = hub();
    let terminal = Far::open(&mut hub);
    terminal.say(b"T12");
    terminal.to.send(FromClient::HungUp).unwrap();
    run(&mut hub, 1000);
    assert!(terminal.received().is_empty());
    terminal.say(b"S6\rO\r");
    run(&mut hub, 1000);
    assert!(!terminal.received().is_empty());
}

#[test]
fn at_another_bit_rate_one_neither_receives_nor_is_received() {
    let mut hub = hub();
    let [one, two] = [Far::new(&mut hub), Far::open(&mut hub)];
    one.say(b"S5\rO\r");
    one.send([read(99)]);
    run(&mut hub, 1000);
    assert_eq!(one.replies(), ["\r"; 3]);
    let received = two.received();
    assert!(!received.is_empty() && !received.iter().any(|frame| *frame == read(99) || is_answer(frame)));
}

/// Each answers for itself, with 11 bits beside the drive's 29.
#[test]
fn tx_drivers_answer_beside_the_drive() {
    let mut hub = hub_with(&[2, 5]);
    let client = Far::open(&mut hub);
    // Node 2 reads its node-id, node 5 is started and asked for its position by a remote frame; nobody is
    // node 3.
    client.say(b"t60284000200000000000\rt60384000200000000000\rt00020105\rr3854\r");
    client.send([read(99)]);
    run(&mut hub, 100);
    let received = client.received();
    // A position is more urgent than an answer.
    let answers: Vec<&Frame> = received.iter().filter(|frame| !frame.id().is_extended()).collect();
    let ids: Vec<u32> = answers.iter().map(|frame| frame.id().raw()).collect();
    assert_eq!(ids, [0x385, 0x582]);
    assert_eq!(answers[1].payload(), [0x4F, 0, 0x20, 0, 2, 0, 0, 0]);
    // 1 mm and 25 um at most of run-out.
    let position = i32::from_le_bytes(answers[0].payload().try_into().unwrap());
    assert!((f64::from(position) / 134_217_728.0 - 1.0).abs() < 0.03, "{position}");
    assert!(received.iter().any(is_answer));
}

#[test]
fn node_ids_are_different_and_from_1_to_127() {
    let read = |list| {
        let drivers = tx_drivers::parse(list)?;
        let numbers = drivers.iter().map(|driver| (driver.configuration.node().raw(), driver.channels));
        Ok::<Vec<(u8, Channels)>, &str>(numbers.collect())
    };
    assert_eq!(read("2"), Ok(vec![(2, Channels::Single)]));
    assert_eq!(
        read("127, 1:dual,64"),
        Ok(vec![(127, Channels::Single), (1, Channels::Dual), (64, Channels::Single)])
    );
    for list in
        ["", "0", "128", "2,2", "2,2:dual", "2,", "two", "-1", "2:", "2:single", ":dual", "2:dual:dual"]
    {
        assert!(read(list).unwrap_err().starts_with("must be different node-ids"), "{list}");
    }
}

const MS: u64 = 1_000_000;

/// A simulation that does at once whatever it may, its bus busy for this share of the time; ticks of 100 us.
struct Simulated {
    pace: Pace,
    clock: Duration,
    time: u64,
    busy: u64,
    share: f64,
}

impl Simulated {
    fn new(speed: f64, share: f64) -> Self {
        Self { pace: Pace::new(Speed::Times(speed)), clock: Duration::ZERO, time: 0, busy: 0, share }
    }

    /// Nothing happens for so long, then the simulation is let loose; simulated and busy time that passed,
    /// ns.
    fn after(&mut self, pause: Duration) -> (u64, u64) {
        self.clock += pause;
        let limits = self.pace.limits(self.clock, self.time, self.busy);
        let before = (self.time, self.busy);
        while self.time < limits.time && self.busy < limits.busy {
            self.time += 100_000;
            self.busy += (1e5 * self.share) as u64;
        }
        (self.time - before.0, self.busy - before.1)
    }
}

#[test]
fn simulated_time_does_not_drift() {
    for speed in [0.1, 1.0, 7.0] {
        let mut simulated = Simulated::new(speed, 1.0);
        // Sleeps that last a little longer than they should, for ten minutes.
        for step in 0..560_000 {
            simulated.after(Duration::from_nanos(1_050_000 + step % 7 * 10_000));
        }
        let target = simulated.clock.as_nanos() as f64 * speed;
        assert!(
            (simulated.time as f64 - target).abs() < 2e6 * speed.max(1.0),
            "{speed}: {} of {target}",
            simulated.time
        );
    }
}

#[test]
fn after_a_stall_it_catches_up_at_twice_the_speed_and_no_faster() {
    let mut simulated = Simulated::new(1.0, 0.1);
    (0..1000).for_each(|_| _ = simulated.after(Duration::from_millis(1)));
    let (passed, _) = simulated.after(Duration::from_secs(2));
    assert!(passed <= 10 * MS + 100_000, "{passed}");
    for _ in 0..1900 {
        let (passed, _) = simulated.after(Duration::from_millis(1));
        assert!((1_900_000..=2_100_000).contains(&passed), "{passed}");
    }
    (0..200).for_each(|_| _ = simulated.after(Duration::from_millis(1)));
    assert_eq!(simulated.pace.behind_ns(simulated.time), 0);
    assert_eq!(simulated.after(Duration::from_millis(1)).0, MS);
}

/// Frames come as fast as a real bus could bring them, whatever is to be made up for.
#[test]
fn a_full_bus_is_not_caught_up_faster_than_a_bus() {
    let mut simulated = Simulated::new(1.0, 1.0);
    (0..1000).for_each(|_| _ = simulated.after(Duration::from_millis(1)));
    let mut busy = simulated.after(Duration::from_secs(2)).1;
    for step in 1..=1000 {
        busy += simulated.after(Duration::from_millis(1)).1;
        assert!(busy <= step * MS + 5 * MS + 100_000, "{busy} ns of frames in {step} ms");
    }
    assert!(simulated.pace.behind_ns(simulated.time) > 1900 * MS);
    // Once the bus has room, it is made up for.
    simulated.share = 0.2;
    (0..2100).for_each(|_| _ = simulated.after(Duration::from_millis(1)));
    assert_eq!(simulated.pace.behind_ns(simulated.time), 0);
}

#[test]
fn what_lies_too_far_back_is_let_go() {
    let mut simulated = Simulated::new(1.0, 0.1);
    simulated.after(Duration::from_secs(3600));
    assert!(simulated.pace.behind_ns(simulated.time) <= 10_000 * MS);
}

#[test]
fn without_a_pace_nothing_holds_it_back() {
    let limits = Pace::new(Speed::Unbound).limits(Duration::ZERO, 5, 5);
    assert_eq!((limits.time, limits.busy), (u64::MAX, u64::MAX));
}
