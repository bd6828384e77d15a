//! Time on the bus: who sends next, until when, and what comes of it.

use super::bits::{INTERMISSION, WireBits, arbitration_field, frame_bits};
use super::node::{Attachment, Node, NodeIndex, Pending, RECOVERY, Received};
#[cfg(feature = "tx-drivers")]
use alloc::vec::Vec;
use core::fmt;
use narx_core::bus::{BusState, ErrorState, Frame};

/// An error flag with the flags that answer it (at most 6 + 6 bits) and the error delimiter (8).
const ERROR_FRAME: u32 = 12 + 8;
/// Time that an error-passive sender waits beyond the intermission, bits.
const SUSPEND: u32 = 8;
/// Recessive bits that a node off the bus counts as one step of its recovery.
const STEP: u32 = 11;

/// A bus of up to `NODES` controllers, each with queues of `QUEUE` frames either way.
///
/// Time is given in nanoseconds and never runs back. [`advance`](Self::advance) settles everything up to an
/// instant; a frame sent later than that cannot have taken part in what is settled.
#[derive(Clone, Debug)]
pub struct Bus<const NODES: usize, const QUEUE: usize> {
    bitrate: u32,
    /// More than a hundred of them stand on the heap; a board without one has few.
    #[cfg(feature = "tx-drivers")]
    nodes: Vec<Node<QUEUE>>,
    #[cfg(not(feature = "tx-drivers"))]
    nodes: heapless::Vec<Node<QUEUE>, NODES>,
    /// Everything before this instant is settled, ns.
    now: u64,
    /// The bus changes nothing before this instant, ns; 0 if it has to be computed again. In most ticks of a
    /// bench the bus is idle.
    quiet_until: u64,
    /// Earliest start of the next frame, ns.
    free_at: u64,
    ongoing: Option<Transmission>,
    injected: Option<Injected>,
    statistics: BusStatistics,
}

/// Counts of frames and errors on a bus so far, and its busy time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusStatistics {
    /// Frames that arrived.
    pub frames: u64,
    /// Frames destroyed by an error, and sent again unless their node went bus-off.
    pub errors: u64,
    /// Time that frames and error frames occupied the bus, their intermission included, ns.
    pub busy_ns: u64,
}

impl BusStatistics {
    /// Bus load 0..=1 between `earlier` statistics and these, taken `interval_ns` apart.
    pub fn load_since(&self, earlier: &Self, interval_ns: u64) -> f64 {
        if interval_ns == 0 { 0.0 } else { (self.busy_ns - earlier.busy_ns) as f64 / interval_ns as f64 }
    }
}

/// A frame found no place in its node's queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotQueued {
    /// The queue is full.
    Full,
    /// The node is not one of this bus.
    NoSuchNode,
}

impl fmt::Display for NotQueued {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "the node's queue is full",
            Self::NoSuchNode => "no such node on this bus",
        })
    }
}

impl core::error::Error for NotQueued {}

/// Transmission on the wire now. Its senders are marked in the nodes.
#[derive(Clone, Copy, Debug)]
struct Transmission {
    frame: Frame,
    start: u64,
    /// End of the last bit of the frame or error frame, before the intermission, ns.
    end: u64,
    outcome: Outcome,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Arrives,
    /// No other node acknowledges.
    Unacknowledged,
    Destroyed,
}

/// Disturbances to come.
#[derive(Clone, Copy, Debug)]
struct Injected {
    bit: u32,
    frames: u32,
}

impl<const NODES: usize, const QUEUE: usize> Bus<NODES, QUEUE> {
    /// An idle bus at `bitrate` bit/s; 0 counts as 1.
    pub fn new(bitrate: u32) -> Self {
        Self {
            bitrate: bitrate.max(1),
            nodes: Default::default(),
            now: 0,
            quiet_until: 0,
            free_at: 0,
            ongoing: None,
            injected: None,
            statistics: BusStatistics::default(),
        }
    }

    /// Adds a node that runs at the bus's own bitrate; `None` when there is no place left.
    pub fn attach(&mut self) -> Option<NodeIndex> {
        if self.nodes.len() == NODES {
            return None;
        }
        let (index, node) = (NodeIndex(self.nodes.len()), Node::new(self.bitrate));
        #[cfg(feature = "tx-drivers")]
        self.nodes.push(node);
        #[cfg(not(feature = "tx-drivers"))]
        self.nodes.push(node).ok()?;
        Some(index)
    }

    /// Adds the first nodes of a bus, at its own bitrate. Those beyond its places are none of it.
    pub fn attach_first<const N: usize>(&mut self) -> [NodeIndex; N] {
        while self.nodes.len() < N && self.attach().is_some() {}
        core::array::from_fn(NodeIndex)
    }

    /// Sets how a node takes part.
    pub fn set_attachment(&mut self, node: NodeIndex, attachment: Attachment) {
        self.quiet_until = 0;
        if let Some(node) = self.nodes.get_mut(node.0) {
            node.attachment = attachment;
        }
    }

    /// Sets a node's bitrate. At another one than the bus's it understands nothing and, until it is error
    /// passive, destroys every frame.
    pub fn set_bitrate(&mut self, node: NodeIndex, bitrate: u32) {
        if let Some(node) = self.nodes.get_mut(node.0) {
            node.bitrate = bitrate;
        }
    }

    /// Disturbs the next `frames` frames at bit `bit` of the wire (0 = start of frame; beyond the end: the
    /// last bit).
    pub fn inject_errors(&mut self, frames: u32, bit: u32) {
        self.injected = (frames > 0).then_some(Injected { bit, frames });
    }

    /// Queues a frame that wants the bus from `now` on, ns. A node sends its frames in the order queued.
    pub fn send(&mut self, node: NodeIndex, frame: Frame, now: u64) -> Result<(), NotQueued> {
        let since = now.max(self.now);
        self.quiet_until = 0;
        let node = self.nodes.get_mut(node.0).ok_or(NotQueued::NoSuchNode)?;
        node.outgoing.push_back(Pending { frame, since }).map_err(|_| NotQueued::Full)
    }

    /// The oldest frame that a node has received. A node does not receive its own.
    pub fn receive(&mut self, node: NodeIndex) -> Option<Received> {
        self.nodes.get_mut(node.0)?.incoming.pop_front()
    }

    /// Settles everything up to `now`, ns.
    #[inline]
    pub fn advance(&mut self, now: u64) {
        if now >= self.quiet_until {
            self.advance_closely(now);
        }
        self.now = self.now.max(now);
    }

    fn advance_closely(&mut self, now: u64) {
        loop {
            if let Some(ongoing) = self.ongoing {
                if ongoing.end > now {
                    break;
                }
                self.ongoing = None;
                self.settle(&ongoing);
            }
            let Some(start) = self.next_start().filter(|start| *start <= now) else { break };
            self.ongoing = self.begin(start);
        }
        self.now = self.now.max(now);
        self.quiet_until = self.next_event().unwrap_or(u64::MAX);
        for node in &mut self.nodes {
            self.quiet_until = self.quiet_until.min(node.recover(now));
        }
    }

    /// Time of the next event that needs no further input, ns: the end of the frame under way, or the start
    /// of the next.
    pub fn next_event(&self) -> Option<u64> {
        self.ongoing.map(|ongoing| ongoing.end).or_else(|| self.next_start())
    }

    /// Returns the counts so far, with the time of the frame under way up to the last
    /// [`advance`](Self::advance) (an intermission counts when its frame ends).
    pub fn statistics(&self) -> BusStatistics {
        let under_way = self.ongoing.map_or(0, |ongoing| self.now.saturating_sub(ongoing.start));
        BusStatistics { busy_ns: self.statistics.busy_ns + under_way, ..self.statistics }
    }

    /// Fault confinement state of a node.
    pub fn error_state(&self, node: NodeIndex) -> Option<ErrorState> {
        self.nodes.get(node.0).map(Node::error_state)
    }

    /// Transmit and receive error counters of a node.
    pub fn error_counters(&self, node: NodeIndex) -> Option<(u16, u16)> {
        self.nodes.get(node.0).map(|node| (node.transmit_errors, node.receive_errors))
    }

    /// Returns the state of a node's controller; error-active for a node that does not exist.
    pub fn state(&self, node: NodeIndex) -> BusState {
        self.nodes.get(node.0).map_or_else(BusState::default, |node| BusState {
            error: node.error_state(),
            transmit_errors: node.transmit_errors,
            receive_errors: node.receive_errors,
        })
    }

    /// Takes back what a node has not sent, but for a frame that is on the wire.
    pub fn discard(&mut self, node: NodeIndex) {
        let ongoing = self.ongoing.is_some();
        if let Some(node) = self.nodes.get_mut(node.0) {
            while node.outgoing.len() > usize::from(ongoing && node.sends) {
                node.outgoing.pop_back();
            }
        }
    }

    /// Frames that a node has lost because nobody took them from its queue.
    pub fn overruns(&self, node: NodeIndex) -> u32 {
        self.nodes.get(node.0).map_or(0, |node| node.overruns)
    }

    /// Frames of a node that still wait for the bus.
    pub fn queued(&self, node: NodeIndex) -> usize {
        self.nodes.get(node.0).map_or(0, |node| node.outgoing.len())
    }

    /// Returns the time that `bits` bits take, ns.
    pub fn duration(&self, bits: u32) -> u64 {
        u64::from(bits) * 1_000_000_000 / u64::from(self.bitrate)
    }
}

/// One frame after the other.
impl<const NODES: usize, const QUEUE: usize> Bus<NODES, QUEUE> {
    /// Time at which the next frame starts. It is never before the instant up to which the bus is settled.
    fn next_start(&self) -> Option<u64> {
        let ready = self.nodes.iter().filter_map(Node::ready_at).min()?;
        Some(ready.max(self.free_at).max(self.now))
    }

    /// Arbitration at `start` among all whose frame is ready by then, and what becomes of the winner.
    fn begin(&mut self, start: u64) -> Option<Transmission> {
        for node in &mut self.nodes {
            node.recover(start);
        }
        let ready = |node: &Node<QUEUE>| {
            let frame = node.outgoing.front()?.frame;
            (node.ready_at()? <= start).then_some(frame)
        };
        let frame = self.nodes.iter().filter_map(ready).min_by_key(arbitration_field)?;
        let idle = start.saturating_sub(self.free_at) / self.duration(STEP).max(1);
        for node in &mut self.nodes {
            node.watch_idle(idle.min(RECOVERY.into()) as u32);
        }

        // Nodes with one identifier all win; unless their frames are equal, the first difference ends them.
        let mut rival = None;
        for node in &mut self.nodes {
            let own = ready(node).filter(|own| arbitration_field(own) == arbitration_field(&frame));
            node.sends = own.is_some();
            // The winner itself is among them, and most often alone.
            let other = own.filter(|own| *own != frame);
            rival = rival.or(other.and_then(|own| first_difference(&frame, &own)));
        }

        let disturbed = [rival, self.foreign_bitrate(), self.take_injected()];
        let length = frame_bits(&frame) - INTERMISSION;
        let (bits, outcome) = match disturbed.into_iter().flatten().min() {
            Some(bit) => (bit.min(length - 1) + 1 + ERROR_FRAME, Outcome::Destroyed),
            // The error flag takes the place of acknowledge delimiter and end of frame, 8 bits.
            None if !self.acknowledged() => (length - 8 + ERROR_FRAME, Outcome::Unacknowledged),
            None => (length, Outcome::Arrives),
        };
        Some(Transmission { frame, start, end: start + self.duration(bits), outcome })
    }

    /// Books the end of a transmission.
    fn settle(&mut self, ended: &Transmission) {
        self.free_at = ended.end + self.duration(INTERMISSION);
        self.statistics.busy_ns += self.free_at - ended.start;
        let arrived = ended.outcome == Outcome::Arrives;
        let count = if arrived { &mut self.statistics.frames } else { &mut self.statistics.errors };
        *count += 1;

        let [suspended, recovered] =
            [SUSPEND, RECOVERY * STEP].map(|bits| self.free_at + self.duration(bits));
        let (free_at, step) = (self.free_at, self.duration(STEP));
        for node in &mut self.nodes {
            node.watch_end(|steps| free_at + u64::from(steps) * step);
        }
        let sender = NodeIndex(self.nodes.iter().position(|node| node.sends).unwrap_or(NODES));
        let received = Received { frame: ended.frame, time_ns: ended.end, sender };
        for node in &mut self.nodes {
            match (node.sends, ended.outcome) {
                (true, Outcome::Arrives) => node.count_sent(),
                (true, outcome) => node.count_transmit_error(outcome == Outcome::Unacknowledged, recovered),
                (false, _) if !node.is_listener() => {}
                (false, Outcome::Destroyed) => node.count_receive_error(),
                (false, _) if node.bitrate != self.bitrate => node.count_receive_error(),
                (false, Outcome::Arrives) => node.receive(received),
                (false, Outcome::Unacknowledged) => {}
            }
            if node.sends && node.error_state() == ErrorState::Passive {
                node.held_until = suspended;
            }
        }
    }

    /// Bit at which a node at a wrong bitrate destroys the frame: a sender at once, a listener with the
    /// active error flag that it sends for six equal bits.
    fn foreign_bitrate(&self) -> Option<u32> {
        let foreign = self.nodes.iter().filter(|node| node.bitrate != self.bitrate);
        foreign
            .filter_map(|node| match node.sends {
                true => Some(0),
                false => (node.is_sender() && node.error_state() == ErrorState::Active).then_some(6),
            })
            .min()
    }

    fn take_injected(&mut self) -> Option<u32> {
        let injected = self.injected?;
        self.injected = (injected.frames > 1).then_some(Injected { frames: injected.frames - 1, ..injected });
        Some(injected.bit)
    }

    fn acknowledged(&self) -> bool {
        let mut others = self.nodes.iter().filter(|node| !node.sends);
        others.any(|node| node.is_sender() && node.bitrate == self.bitrate)
    }
}

/// The first bit of the wire in which two frames differ.
fn first_difference(one: &Frame, other: &Frame) -> Option<u32> {
    let [one, other] = [one, other].map(|frame| WireBits::new(frame).on_wire());
    one.zip(other).position(|(a, b)| a != b).map(|bit| bit as u32)
}
