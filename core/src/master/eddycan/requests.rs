//! Requests that read and write entries: one under way at a time, repeated when no answer comes, and answered
//! once.

use crate::bus::eddycan::{AbortCode, SdoAction, SdoAnswer, SdoOutcome, SdoRequest};
use crate::eddycan::Entry;
use crate::master::NotTaken;
use crate::master::waiting::Waiting;
use core::fmt;

/// Shortest time-out, microseconds: two of the longest frames and an idle bus at 100 kbit/s.
const SHORTEST: u64 = 3000;

/// A request to the node, answered once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Read an entry.
    Read(Entry),
    /// Write an entry.
    Write(Entry, u32),
}

/// A request and its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The request.
    pub request: Request,
    /// The value that was read or written.
    pub result: Result<u32, RequestError>,
}

/// Reason why a request was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestError {
    /// No answer to any attempt. A Stopped node does not answer.
    NoAnswer,
    /// The node refuses, for a reason of Table 10.
    Refused(AbortCode),
    /// The node refuses, for a reason that Table 10 does not list.
    RefusedOtherwise {
        /// The code.
        code: u32,
    },
}

/// Queue of requests: from the call until the answer is taken.
#[derive(Clone, Debug, Default)]
pub(super) struct Requests(Waiting<Request, UnderWay, Answer>);

#[derive(Clone, Copy, Debug)]
struct UnderWay {
    request: Request,
    /// Time of the last transmission, microseconds.
    sent: u64,
    /// Attempts left.
    left: u8,
}

impl Request {
    const fn entry(self) -> Entry {
        match self {
            Self::Read(entry) | Self::Write(entry, _) => entry,
        }
    }

    /// Encodes the message; a write states no size, as in the specification.
    fn encode(self) -> SdoRequest {
        let object = self.entry().object();
        let action = match self {
            Self::Read(_) => SdoAction::Read,
            Self::Write(_, value) => SdoAction::Write { size: None, data: value.to_le_bytes() },
        };
        SdoRequest { index: object.index, subindex: object.subindex.unwrap_or(0), action }
    }

    /// Attempts of this request: one for a reset of the encoder, because a second one would set another
    /// position to 0.
    const fn attempts(self, attempts: u8) -> u8 {
        if matches!(self, Self::Write(Entry::ResetEncoder, _)) { 1 } else { attempts }
    }

    /// Returns whether an answer is about this entry. If the entry has no subindex, nodes may answer with
    /// any.
    fn is_addressed_by(self, answer: SdoAnswer) -> bool {
        let object = self.entry().object();
        answer.index == object.index && object.subindex.is_none_or(|own| own == answer.subindex)
    }
}

impl Requests {
    pub(super) fn push(&mut self, request: Request) -> Result<(), NotTaken> {
        self.0.push(request)
    }

    pub(super) fn pop(&mut self) -> Option<Answer> {
        self.0.pop()
    }

    /// Returns the message to send now: the next request, or a repetition of the one that got no answer.
    pub(super) fn poll(&mut self, now: u64, timeout: u64, attempts: u8) -> Option<SdoRequest> {
        if let Some(under_way) = &mut self.0.current {
            if now < under_way.sent.saturating_add(timeout.max(SHORTEST)) {
                return None;
            }
            if let Some(left) = under_way.left.checked_sub(1) {
                (under_way.left, under_way.sent) = (left, now);
                return Some(under_way.request.encode());
            }
            let request = under_way.request;
            self.0.finish(Answer { request, result: Err(RequestError::NoAnswer) });
        }
        let request = self.0.next()?;
        let left = request.attempts(attempts).saturating_sub(1);
        self.0.current = Some(UnderWay { request, sent: now, left });
        Some(request.encode())
    }

    /// Time of the next message or time-out, microseconds; `u64::MAX` if there is none.
    pub(super) fn deadline(&self, now: u64, timeout: u64) -> u64 {
        match self.0.current {
            Some(under_way) => under_way.sent.saturating_add(timeout.max(SHORTEST)).max(now),
            None if self.0.is_empty() => u64::MAX,
            None => now,
        }
    }

    /// Takes an answer of the node; returns the entry and its value, if the answer completes the request
    /// without an error.
    pub(super) fn take(&mut self, answer: SdoAnswer) -> Option<(Entry, u32)> {
        let request = self.0.current?.request;
        if !request.is_addressed_by(answer) {
            return None;
        }
        let result = match (answer.outcome, request) {
            (SdoOutcome::Value(value), Request::Read(entry)) => Ok(value.number() & mask(entry)),
            (SdoOutcome::Written, Request::Write(_, value)) => Ok(value),
            (SdoOutcome::Aborted { code }, _) => Err(match AbortCode::decode(code) {
                Some(code) => RequestError::Refused(code),
                None => RequestError::RefusedOtherwise { code },
            }),
            // A late answer to an earlier request of the same entry; one of the same kind cannot be
            // distinguished.
            (SdoOutcome::Value(_), Request::Write(..)) | (SdoOutcome::Written, Request::Read(_)) => {
                return None;
            }
        };
        self.0.finish(Answer { request, result });
        result.ok().map(|value| (request.entry(), value))
    }
}

/// Mask of the bits of the entry's type: some nodes answer everything with four bytes.
fn mask(entry: Entry) -> u32 {
    let bits = 8 * u32::from(entry.object().kind.size());
    u32::MAX >> (32 - bits)
}

impl fmt::Display for RequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer => f.write_str("the node does not answer"),
            Self::Refused(code) => code.fmt(f),
            Self::RefusedOtherwise { code } => write!(f, "{code:08X}h"),
        }
    }
}

impl core::error::Error for RequestError {}
