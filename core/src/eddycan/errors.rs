//! Error messages: each code is sent at most once a second, and again if it was lost when the controller went
//! off the bus.

use crate::bus::eddycan::ErrorCode;

/// Least time between two messages of the same code, microseconds.
const QUIET_US: u64 = 1_000_000;

/// Errors that are still to be sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Errors {
    codes: [Message; ErrorCode::ALL.len()],
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Message {
    pending: Pending,
    /// Earliest time at which the code is sent again, microseconds.
    quiet_until: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Pending {
    /// There is nothing to send.
    #[default]
    None,
    /// To be sent when the second after the last message is over.
    Due,
    /// The controller went off the bus within a second of taking the message.
    Lost,
}

impl Errors {
    /// Notes an error; it is dropped if the same one was sent less than a second ago.
    pub(super) fn note(&mut self, code: ErrorCode, now: u64) {
        for (own, message) in ErrorCode::ALL.into_iter().zip(&mut self.codes) {
            if own == code && now >= message.quiet_until {
                message.pending = Pending::Due;
            }
        }
    }

    /// Takes the next error to send.
    pub(super) fn pop(&mut self, now: u64) -> Option<ErrorCode> {
        let mut all = ErrorCode::ALL.into_iter().zip(&mut self.codes);
        let (code, message) =
            all.find(|(_, message)| message.pending == Pending::Due && message.quiet_until <= now)?;
        *message = Message { pending: Pending::None, quiet_until: now.saturating_add(QUIET_US) };
        Some(code)
    }

    /// Notes that the controller has gone off the bus and its frames are dropped. A node's own frames put it
    /// off the bus, so messages that the controller was given within the last second may be among them.
    pub(super) fn lose(&mut self, now: u64) {
        for message in &mut self.codes {
            if message.pending == Pending::None && now < message.quiet_until {
                message.pending = Pending::Lost;
            }
        }
    }

    /// Notes that a frame has arrived: the bus works, so lost messages are sent again. Without a received
    /// frame they are not: a node at a wrong bitrate would go on destroying the frames of others.
    pub(super) fn receive(&mut self) {
        for message in &mut self.codes {
            if message.pending == Pending::Lost {
                message.pending = Pending::Due;
            }
        }
    }

    /// Time after `now` at which the next waiting message becomes due.
    pub(super) fn due_after(&self, now: u64) -> Option<u64> {
        let waiting = self.codes.iter().filter(|message| message.pending == Pending::Due);
        waiting.map(|message| message.quiet_until).filter(|from| *from > now).min()
    }
}
