//! One client of the bus: its slcan adapter, between its bytes and the frames that it sends and receives.

use narx_core::bus::Frame;
use narx_core::bus::slcan::{self, Adapter, NO};
use narx_sim::bench::BITRATE;
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError};

/// Pieces that wait between a reader and the simulation: then the reader waits, and with it whoever writes
/// that much.
pub(super) const PIECES: usize = 4;
/// Bytes of a piece at most.
pub(super) const PIECE: usize = 1024;
/// Lines that wait for a client that does not read: five seconds of a full bus, longer than any download but
/// that of a log.
pub(super) const LINES: usize = 16_384;
/// Frames that wait for the bus.
pub(super) const FRAMES: usize = 256;
/// Bytes of a client that are looked at in a control tick, so that rubbish costs the others no time: a serial
/// line of 10 Mbit/s.
const BYTES_A_TICK: usize = 100;
/// Bytes that a writer puts together at most.
const BATCH: usize = 4096;

/// Input from a client.
#[derive(Debug)]
pub(super) enum FromClient {
    /// Of any length, cut anywhere.
    Bytes(Vec<u8>),
    /// The way stays, and whoever was at its other end has left: pseudo-terminals alone have that.
    #[cfg_attr(not(unix), allow(dead_code, reason = "no pseudo-terminals"))]
    HungUp,
}

/// The near end of the way to a client. It ends when its sender is gone.
#[derive(Debug)]
pub(super) struct Connection {
    /// For people.
    pub(super) name: String,
    pub(super) incoming: Receiver<FromClient>,
    pub(super) outgoing: SyncSender<slcan::Line>,
}

/// Numbers of lines and frames that did not fit and were dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Dropped {
    /// Lines to the client: it does not read.
    pub(super) lines: u64,
    /// Frames from it: the bus does not take so many.
    pub(super) frames: u64,
}

/// A frame that waits for the bus.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    frame: Frame,
    /// Which of all clients' frames it is: of equal ones the older goes first.
    order: u64,
}

/// A client.
pub(super) struct Client {
    connection: Connection,
    adapter: Adapter,
    unread: VecDeque<u8>,
    waiting: VecDeque<Waiting>,
    dropped: Dropped,
    is_gone: bool,
}

impl Client {
    pub(super) fn new(connection: Connection) -> Self {
        let (unread, waiting) = (VecDeque::new(), VecDeque::new());
        Self {
            connection,
            adapter: Adapter::default(),
            unread,
            waiting,
            dropped: Dropped::default(),
            is_gone: false,
        }
    }

    /// Takes what has come of its bytes, answers it, and keeps its frames. `order` counts frames of all
    /// clients.
    pub(super) fn listen(&mut self, order: &mut u64) {
        for _ in 0..BYTES_A_TICK {
            if self.unread.is_empty() && !self.take() {
                return;
            }
            let Some(byte) = self.unread.pop_front() else { return };
            let Some(mut answer) = self.adapter.handle_byte(byte) else { continue };
            if let Some(frame) = answer.frame.filter(|_| self.is_on_bus()) {
                if self.waiting.len() < FRAMES {
                    *order += 1;
                    self.waiting.push_back(Waiting { frame, order: *order });
                } else {
                    self.dropped.frames += 1;
                    self.adapter.note_lost();
                    answer.reply.clear();
                    // One of 31.
                    let _ = answer.reply.push(NO);
                }
            }
            self.say(answer.reply);
        }
    }

    /// The next piece of its bytes; false if there is none.
    fn take(&mut self) -> bool {
        match self.connection.incoming.try_recv() {
            Ok(FromClient::Bytes(bytes)) => self.unread.extend(bytes),
            // The next one finds the adapter as after power-up.
            Ok(FromClient::HungUp) => self.adapter = Adapter::default(),
            Err(TryRecvError::Empty) => return false,
            Err(TryRecvError::Disconnected) => {
                self.is_gone = true;
                return false;
            }
        }
        true
    }

    /// Returns the keys by which its next frame competes for the bus: identifier, then age.
    pub(super) fn wants(&self) -> Option<(u32, u64)> {
        self.waiting.front().map(|next| (narx_sim::can::arbitration_field(&next.frame), next.order))
    }

    /// Its next frame.
    pub(super) fn next(&mut self) -> Option<Frame> {
        self.waiting.pop_front().map(|next| next.frame)
    }

    /// A frame has passed on the bus, at `time_ms` of the drive's time.
    pub(super) fn receive(&mut self, frame: &Frame, time_ms: u64) {
        if let Some(line) = self.adapter.handle_frame(frame, time_ms).filter(|_| self.is_on_bus()) {
            self.say(line);
        }
    }

    /// It has left, and all that it said is sent.
    pub(super) fn is_finished(&self) -> bool {
        self.is_gone && self.waiting.is_empty()
    }

    pub(super) fn name(&self) -> &str {
        &self.connection.name
    }

    pub(super) const fn dropped(&self) -> Dropped {
        self.dropped
    }

    fn say(&mut self, line: slcan::Line) {
        // Without its writer it has left, and will be seen to have.
        if let Err(TrySendError::Full(_)) = self.connection.outgoing.try_send(line) {
            self.dropped.lines += 1;
            self.adapter.note_lost();
        }
    }

    /// At another bit rate it receives nothing, and what it says is noise that nobody receives.
    fn is_on_bus(&self) -> bool {
        self.adapter.bitrate() == BITRATE
    }
}

/// Reads until the other end is closed, or the simulation is.
pub(super) fn read_all(mut from: impl Read, to: &SyncSender<FromClient>) {
    let mut piece = [0; PIECE];
    loop {
        match from.read(&mut piece) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Ok(0) | Err(_) => return,
            Ok(length) => {
                if to.send(FromClient::Bytes(piece[..length].to_vec())).is_err() {
                    return;
                }
            }
        }
    }
}

/// Writes every line, as many at once as wait.
///
/// # Errors
/// The other end is closed.
pub(super) fn write_all(mut to: impl Write, from: &Receiver<slcan::Line>) -> std::io::Result<()> {
    let mut batch = Vec::with_capacity(BATCH + slcan::LINE_MAX);
    while let Ok(line) = from.recv() {
        batch.clear();
        batch.extend_from_slice(&line);
        while batch.len() < BATCH
            && let Ok(line) = from.try_recv()
        {
            batch.extend_from_slice(&line);
        }
        to.write_all(&batch)?;
    }
    Ok(())
}
