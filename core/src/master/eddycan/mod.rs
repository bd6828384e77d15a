//! Bus master of one TX-Driver: configures the node, commands it, monitors its presence, and reads its
//! positions. A pure state machine: frames and time (microseconds) in, frames out.
//!
//! Call [`TxMaster::handle_frame`] for every frame that arrives, and [`TxMaster::poll_frame`] until it has
//! nothing left, at the latest when [`TxMaster::next_poll`] says.

mod report;
mod requests;

pub use report::{Encoder, Report};
pub use requests::{Answer, Request, RequestError};

use super::NotTaken;
use crate::bus::Frame;
use crate::bus::eddycan::{
    DecodeError, FromNode, Layout, NmtCommand, NodeId, PdoKind, Reading, Target, ToNode,
};
use crate::eddycan::Entry;
use heapless::Deque;
use requests::Requests;

/// Messages without an answer that may wait.
const COMMANDS_MAX: usize = 4;

/// Configuration of a master: its node, and times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Its node-id.
    pub node: NodeId,
    /// Layout of its PDOs; the encoder part follows register 2004h when this master reads or writes that.
    pub layout: Layout,
    /// Longest time until an answer, microseconds; at least 3000.
    pub timeout: u64,
    /// Largest number of times that a request is sent, at least 1.
    pub attempts: u8,
    /// Silence after which the node counts as gone, microseconds.
    pub silence: u64,
}

impl Config {
    /// Defaults: 100 ms for an answer, three attempts, and gone after 5 s: two heartbeats may be lost.
    pub const fn new(node: NodeId, layout: Layout) -> Self {
        Self { node, layout, timeout: 100_000, attempts: 3, silence: 5_000_000 }
    }
}

/// The master.
#[derive(Clone, Debug)]
pub struct TxMaster {
    config: Config,
    commands: Deque<ToNode, COMMANDS_MAX>,
    requests: Requests,
    report: Report,
}

impl TxMaster {
    /// Makes a master that sends nothing until it gets a command or a request.
    pub fn new(config: Config) -> Self {
        Self { config, commands: Deque::new(), requests: Requests::default(), report: Report::default() }
    }

    /// Configuration, with the present layout of the PDOs.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The last messages of the node.
    pub const fn report(&self) -> &Report {
        &self.report
    }

    /// Returns whether a frame of the node was received lately.
    pub fn is_present(&self, now: u64) -> bool {
        self.report.received.is_some_and(|received| now.saturating_sub(received) < self.config.silence)
    }

    /// Commands this node.
    ///
    /// # Errors
    /// Four messages wait for the bus already.
    pub fn command(&mut self, command: NmtCommand) -> Result<(), NotTaken> {
        self.tell(ToNode::Nmt { command, target: Target::Node(self.config.node) })
    }

    /// Commands every node of the bus.
    ///
    /// # Errors
    /// As [`Self::command`].
    pub fn command_all(&mut self, command: NmtCommand) -> Result<(), NotTaken> {
        self.tell(ToNode::Nmt { command, target: Target::All })
    }

    /// Sends a SYNC: every node of the bus samples and sends PDO2.
    ///
    /// # Errors
    /// As [`Self::command`].
    pub fn sync(&mut self) -> Result<(), NotTaken> {
        self.tell(ToNode::Sync)
    }

    /// Asks this node for PDO3.
    ///
    /// # Errors
    /// As [`Self::command`].
    pub fn ask_positions(&mut self) -> Result<(), NotTaken> {
        self.tell(ToNode::RequestPdo { node: self.config.node, bytes: self.config.layout.length() })
    }

    /// Returns whether every command, SYNC and request for PDO3 was taken by [`Self::poll_frame`].
    pub fn has_sent(&self) -> bool {
        self.commands.is_empty()
    }

    /// Reads or writes an entry. Answers come in the order of the requests.
    ///
    /// # Errors
    /// Eight requests whose answers were not taken yet.
    pub fn request(&mut self, request: Request) -> Result<(), NotTaken> {
        self.requests.push(request)
    }

    /// The next answer.
    pub fn poll_answer(&mut self) -> Option<Answer> {
        self.requests.pop()
    }

    /// The last positions, their trigger, and the time of their reception, microseconds.
    pub const fn reading(&self) -> Option<(Reading, PdoKind, u64)> {
        self.report.reading
    }

    /// Takes a frame that arrived at `now`. Only messages of this node are used.
    pub fn handle_frame(&mut self, frame: &Frame, now: u64) {
        let message = match FromNode::decode(frame, self.config.layout) {
            Ok((node, message)) if node == self.config.node => message,
            Ok(_) => return,
            Err(error) => return self.note_malformed(frame, error),
        };
        self.report.note(&message, now);
        if let FromNode::Sdo(answer) = message
            && let Some((entry, value)) = self.requests.take(answer)
        {
            self.report.encoder.note(entry, value);
            if entry == Entry::CanConfig {
                self.config.layout.encoder = value & 2 != 0;
            }
        }
    }

    /// The next frame that is due at `now`: commands before requests.
    pub fn poll_frame(&mut self, now: u64) -> Option<Frame> {
        if let Some(message) = self.commands.pop_front() {
            return Some(message.encode());
        }
        let request = self.requests.poll(now, self.config.timeout, self.config.attempts)?;
        Some(ToNode::Sdo { node: self.config.node, request }.encode())
    }

    /// Latest time of the next poll, if no frame arrives and nothing is requested until then.
    pub fn next_poll(&self, now: u64) -> u64 {
        if self.has_sent() { self.requests.deadline(now, self.config.timeout) } else { now }
    }

    fn tell(&mut self, message: ToNode) -> Result<(), NotTaken> {
        self.commands.push_back(message).map_err(|_| NotTaken::Full)
    }

    /// Counts a frame under an identifier of this node that cannot be decoded: most likely the node has
    /// another layout.
    fn note_malformed(&mut self, frame: &Frame, error: DecodeError) {
        let own = !frame.is_remote() && frame.id().raw() & 0x7F == u32::from(self.config.node.raw());
        if own && matches!(error, DecodeError::Length | DecodeError::Value) {
            self.report.malformed = self.report.malformed.saturating_add(1);
        }
    }
}
