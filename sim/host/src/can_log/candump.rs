//! Whole logs of can-utils: cut at line ends, a part for each processor, joined in order.

use super::{CanLog, Frames, LineError, Logged, flag};
use narx_core::bus::candump::{Content, Hex, Line};
use std::thread;

/// Parts are not made smaller than this, bytes: a thread costs as much as some thousand lines.
const PART_MIN: usize = 1 << 18;
/// Of a line that is no frame so many bytes are told.
const TOLD: usize = 200;
const CUT: &str = "the file ends within this line";

impl CanLog {
    /// Reads a whole log: [`feed_candump`](Self::feed_candump), [`end_candump`](Self::end_candump).
    pub fn read_candump(&mut self, text: &[u8], threads: usize) {
        self.feed_candump(text, threads);
        self.end_candump();
    }

    /// Reads the next part of a log, cut anywhere, on as many threads; their number and the cuts change
    /// nothing but the time that it takes.
    pub fn feed_candump(&mut self, text: &[u8], threads: usize) {
        let end = memchr::memrchr(b'\n', text).map_or(0, |at| at + 1);
        let (mut whole, tail) = text.split_at(end);
        if !whole.is_empty() && !self.tail.is_empty() {
            // The line that the part before has begun.
            let (rest, behind) = whole.split_at(memchr::memchr(b'\n', whole).map_or(end, |at| at + 1));
            let mut line = core::mem::take(&mut self.tail);
            line.extend_from_slice(rest);
            self.read_parts(&line, 1);
            whole = behind;
        }
        self.read_parts(whole, threads);
        self.tail.extend_from_slice(tail);
    }

    /// Ends a log. A last line without its end is a frame if it reads as one, unless its neighbours show that
    /// it was cut: it has no direction and the one before has, or fewer bytes than the frame before with its
    /// identifier.
    pub fn end_candump(&mut self) {
        let tail = core::mem::take(&mut self.tail);
        if self.is_cut(&tail) {
            self.lines += 1;
            self.refuse(self.lines, &tail, CUT);
        } else {
            self.read_lines(&tail);
        }
    }

    /// Reads whole lines.
    fn read_parts(&mut self, whole: &[u8], threads: usize) {
        let parts = parts(whole, threads);
        let (config, plans) = (self.config, self.plans.clone());
        let read = |part: &[u8]| {
            let mut log = Self::with(config, plans.clone());
            log.read_lines(part);
            log
        };
        thread::scope(|scope| {
            let mut parts = parts.into_iter();
            let first = parts.next();
            let others: Vec<_> = parts.map(|part| scope.spawn(|| read(part))).collect();
            first.into_iter().for_each(|part| self.read_lines(part));
            for other in others {
                self.append(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            }
        });
        if let Some(last) =
            whole.trim_ascii_end().rsplit(|byte| *byte == b'\n').next().filter(|line| !line.is_empty())
        {
            self.is_directed = is_directed(last);
        }
    }

    fn read_lines(&mut self, part: &[u8]) {
        let mut channel = (String::new(), 0);
        let mut rest = part;
        while !rest.is_empty() {
            let end = memchr::memchr(b'\n', rest).map_or(rest.len(), |at| at + 1);
            let (line, behind) = rest.split_at(end);
            rest = behind;
            self.lines += 1;
            match Line::parse(line) {
                Ok(None) => {}
                Ok(Some(line)) => {
                    // Almost always that of the line before.
                    if channel.0 != line.channel {
                        channel = (line.channel.into(), self.frames.channel(line.channel));
                    }
                    self.push_line(&line, channel.1);
                }
                Err(error) => self.refuse(self.lines, line, error.reason()),
            }
        }
    }

    fn push_line(&mut self, line: &Line<'_>, channel: u16) {
        let received = if line.received { flag::RECEIVED } else { 0 };
        let log = |flags, id, dlc, data| Logged {
            time: line.time,
            channel,
            flags: flags | received,
            id,
            dlc,
            data,
        };
        match line.content {
            Content::Frame(frame) => {
                let extended = if frame.id().is_extended() { flag::EXTENDED } else { 0 };
                let remote = if frame.is_remote() { flag::REMOTE } else { 0 };
                self.push(&log(extended | remote, frame.id().raw(), frame.dlc(), frame.payload()));
            }
            Content::Fd { id, flags, data } => {
                let extended = if id.is_extended() { flag::EXTENDED } else { 0 };
                let switch = if flags & 1 != 0 { flag::BITRATE_SWITCH } else { 0 };
                let passive = if flags & 2 != 0 { flag::ERROR_STATE } else { 0 };
                let (bytes, length) = bytes(data);
                let flags = flag::FD | extended | switch | passive;
                self.push(&log(flags, id.raw(), length, &bytes[..length.into()]));
            }
            Content::Error { class, data } => {
                let (bytes, length) = bytes(data);
                self.push(&log(flag::ERROR | flag::EXTENDED, class, length, &bytes[..length.into()]));
            }
        }
    }

    fn refuse(&mut self, line: usize, text: &[u8], reason: &'static str) {
        let text = text.trim_ascii();
        let text = String::from_utf8_lossy(text.get(..TOLD).unwrap_or(text)).into_owned();
        self.errors.push(LineError { line, text, reason });
    }

    /// Returns whether the last line, which has no end, is incomplete.
    fn is_cut(&self, tail: &[u8]) -> bool {
        let frame = match Line::parse(tail) {
            Ok(Some(Line { content: Content::Frame(frame), .. })) => frame,
            Ok(_) => return false,
            Err(_) => return true,
        };
        if self.is_directed && !is_directed(tail) {
            return true;
        }
        let kind = |flags: u8| flags & (flag::EXTENDED | flag::FD | flag::REMOTE | flag::ERROR);
        let own = (frame.id().raw(), if frame.id().is_extended() { flag::EXTENDED } else { 0 });
        let Frames { id, flags, dlc, .. } = &self.frames;
        let mut rows = id.iter().zip(flags).zip(dlc).rev();
        let last = rows.find(|((id, flags), _)| (**id, kind(**flags)) == own);
        !frame.is_remote() && last.is_some_and(|(_, length)| frame.dlc() < *length)
    }
}

/// Returns whether a line ends with a direction.
fn is_directed(line: &[u8]) -> bool {
    matches!(line.trim_ascii(), [.., b' ', b'R' | b'r' | b'T' | b't'])
}

fn bytes(data: Hex<'_>) -> ([u8; Hex::MAX], u8) {
    let mut bytes = [0; Hex::MAX];
    bytes.iter_mut().zip(data.bytes()).for_each(|(to, byte)| *to = byte);
    (bytes, data.len() as u8)
}

/// The text in parts of about the same length, each with whole lines.
fn parts(mut text: &[u8], threads: usize) -> Vec<&[u8]> {
    let count = (text.len() / PART_MIN).clamp(1, threads.max(1));
    let length = text.len().div_ceil(count);
    let mut parts = Vec::new();
    while !text.is_empty() {
        let near = length.min(text.len()) - 1;
        let end = text[near..].iter().position(|byte| *byte == b'\n').map_or(text.len(), |at| near + at + 1);
        let (part, rest) = text.split_at(end);
        parts.push(part);
        text = rest;
    }
    parts
}
