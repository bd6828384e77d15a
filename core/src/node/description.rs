//! XML_DOWNLOAD_REQUEST: the description's length, and its text.

use super::Node;
use crate::bus::Frame;
use crate::bus::narmotion::{FromDrive, XmlCommand};
use crate::description::{Cursor, Document, Measure};
use serde::{Deserialize, Serialize};

/// True if this build has a description to serve.
pub(super) const SERVES: bool = cfg!(feature = "description");
/// Lines measured in one poll, so that a request for the length never holds up the background.
const LINES_A_POLL: usize = 4;
/// Bytes in a frame of data: three words.
const BYTES: usize = 6;

/// State of the length and of the download.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Download {
    length: Length,
    /// Requests for the length that wait for their answer.
    asked: u8,
    stream: Option<Stream>,
}

/// Length and check value of the document, as far as they are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Length {
    /// Measured for the lines before `line`.
    Before {
        line: u16,
        measure: Measure,
    },
    Known {
        words: u16,
        check: u32,
    },
}

/// A download under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Stream {
    cursor: Cursor,
    /// Address of the next word.
    address: u16,
}

impl Default for Length {
    fn default() -> Self {
        Self::Before { line: 0, measure: Measure::default() }
    }
}

impl Node {
    /// Takes the request. A request for the length ends a download; a start begins from the first word,
    /// whatever was sent before.
    pub(super) fn serve_description(&mut self, command: XmlCommand) {
        self.download.stream = match command {
            XmlCommand::Start => Some(Stream::default()),
            XmlCommand::Length => None,
        };
        if command == XmlCommand::Length {
            self.download.asked = self.download.asked.saturating_add(1);
            self.answer_length();
        }
    }

    /// Continues to measure the document while a request for its length waits.
    pub(super) fn measure_description(&mut self) {
        if !SERVES || self.download.asked == 0 {
            return;
        }
        let document = self.document();
        for _ in 0..LINES_A_POLL {
            let Length::Before { line, mut measure } = self.download.length else { break };
            self.download.length = if document.measure_line(line, &mut measure) {
                Length::Before { line: line + 1, measure }
            } else {
                // A test ensures that there are no more than 65 535 words.
                let words = measure.words().min(u16::MAX.into()) as u16;
                Length::Known { words, check: measure.check() }
            };
        }
        self.answer_length();
    }

    /// Returns the next frame of a download. The last frame is filled up with zeros, and an odd last byte
    /// with a line feed.
    pub(super) fn next_of_description(&mut self) -> Option<Frame> {
        let Stream { mut cursor, address } = self.download.stream.filter(|_| SERVES)?;
        let mut text = [0; BYTES];
        let length = self.document().read(&mut cursor, &mut text);
        if length % 2 == 1
            && let Some(odd) = text.get_mut(length)
        {
            *odd = b'\n';
        }
        let next = Stream { cursor, address: address.wrapping_add(BYTES as u16 / 2) };
        self.download.stream = (length == BYTES).then_some(next);
        let [a, b, c, d, e, f] = text;
        let data = [[a, b], [c, d], [e, f]].map(u16::from_be_bytes);
        (length > 0).then(|| FromDrive::XmlData { address, data }.encode(self.addresses))
    }

    fn answer_length(&mut self) {
        if let Length::Known { words, check } = self.download.length {
            for _ in 0..core::mem::take(&mut self.download.asked) {
                self.send(FromDrive::XmlLength { words, check });
            }
        }
    }

    const fn document(&self) -> Document {
        Document { identity: self.identity, addresses: self.addresses, tick_rate: self.board.tick_rate }
    }
}
