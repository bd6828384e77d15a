//! CAN frames as lines of text on a serial port: the protocol of Lawicel's CAN232 adapter, which python-can,
//! Linux' `slcand` and most cheap adapters speak.
//!
//! ```text
//!   t1232AABB\r      data frame, 11-bit identifier 123h, 2 bytes     r1232\r      remote frame of the same
//!   T0AAD52028...\r  data frame, 29-bit identifier                   R0AAD52028\r remote frame of the same
//!   S6 O L C         bitrate, open, listen only, close               F V N Z1     flags, version, serial number, time stamps
//!   \r               the adapter's yes                               \a           its no
//! ```
//!
//! [`Command`] is a line of the host, [`encode_frame`] and [`decode_frame`] are frames in either direction,
//! [`Lines`] cuts a stream of bytes, and [`Adapter`] is the adapter itself without its serial port and its
//! bus.

use super::{Frame, Id};
use heapless::Vec;

/// Characters of a line at most, with time stamp and end.
pub const LINE_MAX: usize = 31;
/// Bit rates of `S0` to `S8`, bit/s.
pub const BITRATES: [u32; 9] =
    [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];
/// Time stamps count milliseconds below this.
pub const TIMESTAMP_MODULUS: u64 = 60_000;

/// The end of every line but a refusal.
pub const YES: u8 = b'\r';
/// A refusal.
pub const NO: u8 = 0x07;

/// A line, its end included.
pub type Line = Vec<u8, LINE_MAX>;

/// Command of a host to its adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// An empty line, by which hosts clear what was typed before.
    Nothing,
    /// `S0` to `S8`: index into [`BITRATES`].
    Bitrate(u8),
    /// `O`.
    Open,
    /// `L`: open, but send nothing.
    ListenOnly,
    /// `C`.
    Close,
    /// `t`, `T`, `r`, `R`.
    Send(Frame),
    /// `F`: what has gone wrong since the last time.
    Flags,
    /// `V`.
    Version,
    /// `N`.
    SerialNumber,
    /// `Z0`, `Z1`: whether received frames carry the time.
    Timestamps(bool),
}

impl Command {
    /// Reads a line without its end; `None` if it is not a command.
    pub fn decode(line: &[u8]) -> Option<Self> {
        Some(match line {
            [] => Self::Nothing,
            [b'S', digit @ b'0'..=b'8'] => Self::Bitrate(digit - b'0'),
            b"O" => Self::Open,
            b"L" => Self::ListenOnly,
            b"C" => Self::Close,
            b"F" => Self::Flags,
            b"V" => Self::Version,
            b"N" => Self::SerialNumber,
            b"Z0" => Self::Timestamps(false),
            b"Z1" => Self::Timestamps(true),
            _ => match decode_frame(line)? {
                (frame, None) => Self::Send(frame),
                (_, Some(_)) => return None,
            },
        })
    }

    /// The line, its end included.
    pub fn encode(&self) -> Line {
        let text: &[u8] = match self {
            Self::Nothing => b"",
            Self::Bitrate(index) => return line(&[b'S', b'0' + (*index).min(8)]),
            Self::Open => b"O",
            Self::ListenOnly => b"L",
            Self::Close => b"C",
            Self::Send(frame) => return encode_frame(frame, None),
            Self::Flags => b"F",
            Self::Version => b"V",
            Self::SerialNumber => b"N",
            Self::Timestamps(false) => b"Z0",
            Self::Timestamps(true) => b"Z1",
        };
        line(text)
    }
}

/// A frame as a line, its end included; `timestamp` in ms.
pub fn encode_frame(frame: &Frame, timestamp: Option<u16>) -> Line {
    let mut text = Line::new();
    let id = frame.id();
    let (kind, digits) = match (id.is_extended(), frame.is_remote()) {
        (false, false) => (b't', 3),
        (true, false) => (b'T', 8),
        (false, true) => (b'r', 3),
        (true, true) => (b'R', 8),
    };
    // The longest of them, a full frame with its time, is what `Line` has room for.
    let _ = text.push(kind);
    push_hexadecimal(&mut text, id.raw(), digits);
    push_hexadecimal(&mut text, frame.dlc().into(), 1);
    for byte in frame.payload() {
        push_hexadecimal(&mut text, (*byte).into(), 2);
    }
    if let Some(milliseconds) = timestamp {
        push_hexadecimal(&mut text, milliseconds.into(), 4);
    }
    let _ = text.push(YES);
    text
}

/// A frame from a line without its end, and its time in ms if it carries one; `None` if the line is not a
/// frame.
pub fn decode_frame(text: &[u8]) -> Option<(Frame, Option<u16>)> {
    let (kind, rest) = text.split_first()?;
    let digits = if kind.is_ascii_lowercase() { 3 } else { 8 };
    let (id, rest) = rest.split_at_checked(digits)?;
    let number = hexadecimal(id)?;
    let id = if digits == 3 { Id::standard(number as u16) } else { Id::extended(number) }?;
    let (length, rest) = rest.split_first()?;
    let dlc = hexadecimal(&[*length])?;
    let (frame, rest) = match kind {
        b'r' | b'R' => (Frame::remote(id, dlc as u8)?, rest),
        b't' | b'T' => {
            let (text, rest) = rest.split_at_checked(2 * dlc as usize)?;
            let mut data = Vec::<u8, 8>::new();
            for pair in text.chunks(2) {
                data.push(hexadecimal(pair)? as u8).ok()?;
            }
            (Frame::data(id, &data)?, rest)
        }
        _ => return None,
    };
    match rest.len() {
        0 => Some((frame, None)),
        4 => Some((frame, Some(hexadecimal(rest)? as u16))),
        _ => None,
    }
}

/// Cuts a stream of bytes into lines.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    line: Line,
    too_long: bool,
}

impl Lines {
    /// Takes a byte. At the end of a line that is its text without the end, or `None` inside if it was too
    /// long to be one.
    pub fn push(&mut self, byte: u8) -> Option<Option<Line>> {
        if byte != YES {
            self.too_long |= self.line.push(byte).is_err();
            return None;
        }
        let line = core::mem::take(&mut self.line);
        Some(if core::mem::take(&mut self.too_long) { None } else { Some(line) })
    }
}

/// Participation of an adapter in the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Neither receives nor is received.
    #[default]
    Closed,
    /// Receives.
    ListenOnly,
    /// Receives and sends.
    Open,
}

/// Settings of an adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Index into [`BITRATES`].
    pub bitrate: u8,
    /// Participation in the bus.
    pub channel: Channel,
    /// Received frames carry the time.
    pub timestamps: bool,
}

impl Default for Settings {
    /// Closed, at the 500 kbit/s of the drive (Table 2), for hosts that do not say which.
    fn default() -> Self {
        Self { bitrate: 6, channel: Channel::Closed, timestamps: false }
    }
}

/// Result of a line from the host.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// For the host.
    pub reply: Line,
    /// For the bus.
    pub frame: Option<Frame>,
}

/// The adapter between a serial port and a bus.
#[derive(Clone, Debug, Default)]
pub struct Adapter {
    settings: Settings,
    lines: Lines,
    lost: bool,
}

impl Adapter {
    /// An adapter that is set already.
    pub fn with_settings(settings: Settings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// Returns the present settings.
    pub const fn settings(&self) -> Settings {
        self.settings
    }

    /// Bit rate, bit/s.
    pub fn bitrate(&self) -> u32 {
        BITRATES.get(usize::from(self.settings.bitrate)).copied().unwrap_or(0)
    }

    /// Takes a byte from the host. The end of a line has an answer.
    pub fn handle_byte(&mut self, byte: u8) -> Option<Answer> {
        let line = self.lines.push(byte)?;
        let command = line.as_deref().and_then(Command::decode);
        Some(command.and_then(|command| self.handle(command)).unwrap_or_else(|| {
            let mut reply = Line::new();
            let _ = reply.push(NO);
            Answer { reply, frame: None }
        }))
    }

    /// A frame that came over the bus at `time_ms` since any start, for the host; `None` while closed.
    pub fn handle_frame(&self, frame: &Frame, time_ms: u64) -> Option<Line> {
        let time = self.settings.timestamps.then_some((time_ms % TIMESTAMP_MODULUS) as u16);
        (self.settings.channel != Channel::Closed).then(|| encode_frame(frame, time))
    }

    /// A frame was lost on its way to the host: the next flags say so.
    pub fn note_lost(&mut self) {
        self.lost = true;
    }

    fn handle(&mut self, command: Command) -> Option<Answer> {
        let closed = self.settings.channel == Channel::Closed;
        let mut answer = Answer { reply: line(b""), frame: None };
        match command {
            Command::Nothing => {}
            // Hosts open what is open.
            Command::Open => self.settings.channel = Channel::Open,
            Command::ListenOnly => self.settings.channel = Channel::ListenOnly,
            Command::Close => self.settings.channel = Channel::Closed,
            Command::Bitrate(index) if closed => self.settings.bitrate = index,
            Command::Timestamps(on) if closed => self.settings.timestamps = on,
            Command::Send(frame) if self.settings.channel == Channel::Open => answer.frame = Some(frame),
            // Bit 3 is data overrun.
            Command::Flags if !closed => {
                answer.reply = line(if core::mem::take(&mut self.lost) { b"F08" } else { b"F00" });
            }
            Command::Version => answer.reply = line(b"V1010"),
            Command::SerialNumber => answer.reply = line(b"NNARX"),
            Command::Bitrate(_) | Command::Timestamps(_) | Command::Send(_) | Command::Flags => return None,
        }
        Some(answer)
    }
}

/// `text` with the end of a line.
fn line(text: &[u8]) -> Line {
    let mut line = Line::new();
    // A few characters, all written in this file.
    let _ = line.extend_from_slice(text);
    let _ = line.push(YES);
    line
}

fn push_hexadecimal(text: &mut Line, value: u32, digits: u32) {
    for place in (0..digits).rev() {
        let digit = (value >> (4 * place) & 0xF) as u8;
        // See `encode_frame`.
        let _ = text.push(if digit < 10 { b'0' + digit } else { b'A' - 10 + digit });
    }
}

/// Up to 8 digits of either case.
fn hexadecimal(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |value, digit| Some(value << 4 | (*digit as char).to_digit(16)?))
}
