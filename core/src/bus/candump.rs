//! Lines of a log as `candump -L` of can-utils writes them, which python-can and most analysers read and
//! write, too.
//!
//! ```text
//!  (1436509052.249713) can0 1A2#DEADBEEF           11-bit identifier
//!  (1436509052.249713) can0 0AAD5202#0000000100    29 bits: more than three digits
//!  (1436509052.249713) can0 1A2#R8                 remote frame for 8 bytes
//!  (1436509052.249713) can0 1A2##3DEADBEEF         CAN FD, with its flags
//!  (1436509052.249713) can0 20000088#00040000      error frame: bit 29 of the identifier
//!  (1436509052.249713) can0 1A2#DEADBEEF R         with its direction, R or T
//! ```

use super::{Frame, Id};
use core::fmt;

/// One line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<'a> {
    /// Time as it was stamped, s: since 1970, or since something else.
    pub time: f64,
    /// Interface on which it was received.
    pub channel: &'a str,
    /// Received, not sent, by the logging node; true where the line has no direction.
    pub received: bool,
    /// The frame or error that was logged.
    pub content: Content<'a>,
}

/// Content of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Content<'a> {
    /// A classic frame.
    Frame(Frame),
    /// A CAN FD frame.
    Fd {
        /// The identifier.
        id: Id,
        /// Bit 0: bit-rate switch; bit 1: error state indicator.
        flags: u8,
        /// Its bytes, up to 64.
        data: Hex<'a>,
    },
    /// An error that the adapter has seen.
    Error {
        /// Its class: bits 28..0 as in `linux/can/error.h`.
        class: u32,
        /// Details of the error, as the adapter reports them.
        data: Hex<'a>,
    },
}

/// Bytes as pairs of hexadecimal digits, up to 64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hex<'a>(&'a [u8]);

/// Reason why a line is not a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParseError {
    /// Not a time in parentheses, a channel, a frame and perhaps a direction, with blanks between them.
    Shape,
    /// The time is no finite number.
    Time,
    /// The channel is no text.
    Channel,
    /// Nothing divides the identifier from the data.
    Separator,
    /// The identifier is not 1 to 8 hexadecimal digits, or too large for 11 bits.
    Identifier,
    /// The data are no pairs of hexadecimal digits.
    Data,
    /// More data than such a frame can have.
    Length,
}

/// Marks an error frame in an identifier.
const ERROR: u32 = 1 << 29;
/// Digits of an 11-bit identifier.
const STANDARD_DIGITS: usize = 3;

impl<'a> Line<'a> {
    /// Parses a line; `None` if it is blank. A line end is accepted.
    ///
    /// # Errors
    /// The first part of the line that breaks the format.
    pub fn parse(line: &'a [u8]) -> Result<Option<Self>, ParseError> {
        let line = line.trim_ascii();
        if line.is_empty() {
            return Ok(None);
        }
        let (stamp, rest) = word(line);
        let (channel, rest) = word(rest);
        let (frame, rest) = word(rest);
        let received = match rest {
            [] | [b'R' | b'r'] => true,
            [b'T' | b't'] => false,
            _ => return Err(ParseError::Shape),
        };
        let [b'(', stamp @ .., b')'] = stamp else { return Err(ParseError::Shape) };
        if frame.is_empty() {
            return Err(ParseError::Shape);
        }
        let time = seconds(stamp).ok_or(ParseError::Time)?;
        let channel = str::from_utf8(channel).map_err(|_| ParseError::Channel)?;
        Ok(Some(Self { time, channel, received, content: Content::parse(frame)? }))
    }
}

impl<'a> Content<'a> {
    fn parse(text: &'a [u8]) -> Result<Self, ParseError> {
        let divided = text.iter().position(|byte| *byte == b'#').and_then(|at| text.split_at_checked(at));
        let Some((digits, [_, data @ ..])) = divided else { return Err(ParseError::Separator) };
        let raw = identifier(digits).ok_or(ParseError::Identifier)?;
        if digits.len() > STANDARD_DIGITS && raw & ERROR != 0 {
            return Ok(Self::Error { class: raw & (ERROR - 1), data: Hex::parse(data, 8)? });
        }
        let id = if digits.len() > STANDARD_DIGITS {
            // Bits above the 29 are flags of the logging tool.
            Id::extended_masked(raw)
        } else {
            Id::standard(raw as u16).ok_or(ParseError::Identifier)?
        };
        match data {
            [b'#', flags, data @ ..] => {
                let flags = digit(*flags).ok_or(ParseError::Data)?;
                Ok(Self::Fd { id, flags, data: Hex::parse(data, Hex::MAX)? })
            }
            [b'R' | b'r'] => Ok(Self::Frame(Frame::remote_clamped(id, 0))),
            [b'R' | b'r', dlc @ b'0'..=b'9'] => {
                Frame::remote(id, dlc - b'0').map(Self::Frame).ok_or(ParseError::Length)
            }
            data => {
                let mut bytes = [0; 8];
                let length = decode(data, &mut bytes)?;
                Ok(Self::Frame(Frame::short(id, bytes, length)))
            }
        }
    }
}

impl<'a> Hex<'a> {
    /// Largest number of bytes.
    pub const MAX: usize = 64;

    fn parse(digits: &'a [u8], bytes_max: usize) -> Result<Self, ParseError> {
        if !digits.len().is_multiple_of(2) || !digits.iter().all(u8::is_ascii_hexdigit) {
            return Err(ParseError::Data);
        }
        if digits.len() > 2 * bytes_max { Err(ParseError::Length) } else { Ok(Self(digits)) }
    }

    /// Number of bytes.
    pub const fn len(&self) -> usize {
        self.0.len() / 2
    }

    /// Returns whether there are no bytes.
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The bytes.
    pub fn bytes(&self) -> impl Iterator<Item = u8> + use<'a> {
        self.0.chunks_exact(2).map_while(|pair| match pair {
            [high, low] => Some(digit(*high)? << 4 | digit(*low)?),
            _ => None,
        })
    }
}

/// A frame as a line without its end. `time_ns` is rounded down to microseconds.
pub const fn line<'a>(time_ns: u64, channel: &'a str, frame: &'a Frame) -> impl fmt::Display + use<'a> {
    Written { time_ns, channel, frame }
}

struct Written<'a> {
    time_ns: u64,
    channel: &'a str,
    frame: &'a Frame,
}

impl fmt::Display for Written<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { time_ns, channel, frame } = self;
        let micros = time_ns / 1_000;
        // The number of digits tells 11-bit identifiers from 29-bit ones.
        write!(f, "({}.{:06}) {channel} {}#", micros / 1_000_000, micros % 1_000_000, frame.id())?;
        if frame.is_remote() {
            write!(f, "R{}", frame.dlc())?;
        }
        frame.payload().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

/// The first word, and what follows the blanks after it.
fn word(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    let (word, rest) = text.split_at_checked(end).unwrap_or((text, &[]));
    (word, rest.trim_ascii_start())
}

/// Parses a time, s, rounded to the nearest `f64`.
fn seconds(text: &[u8]) -> Option<f64> {
    plain_seconds(text).or_else(|| {
        let time: f64 = str::from_utf8(text).ok()?.parse().ok()?;
        time.is_finite().then_some(time)
    })
}

/// Parses digits with or without a point, up to 2^53 when the point is removed: one division of two exact
/// numbers then rounds once, and correctly.
fn plain_seconds(text: &[u8]) -> Option<f64> {
    const POWERS: [f64; 10] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];
    if text.len() > 18 {
        return None;
    }
    let mut number = 0_u64;
    let mut decimals = None;
    for byte in text {
        match byte.wrapping_sub(b'0') {
            digit @ 0..=9 => {
                number = number.wrapping_mul(10).wrapping_add(digit.into());
                decimals = decimals.map(|decimals: usize| decimals + 1);
            }
            _ if *byte == b'.' && decimals.is_none() && number > 0 => decimals = Some(0),
            _ => return None,
        }
    }
    let exact = number > 0 && number <= 1 << 53;
    exact.then_some(number as f64 / POWERS.get(decimals.unwrap_or(0))?)
}

fn identifier(digits: &[u8]) -> Option<u32> {
    let (mut raw, mut all) = (0, 0);
    for byte in digits {
        let value = value(*byte);
        raw = raw << 4 | u32::from(value);
        all |= value;
    }
    (matches!(digits.len(), 1..=8) && all < 16).then_some(raw)
}

/// Decodes pairs of digits into `bytes`; returns their number.
fn decode(digits: &[u8], bytes: &mut [u8; 8]) -> Result<u8, ParseError> {
    let pairs = digits.chunks_exact(2);
    if !pairs.remainder().is_empty() {
        return Err(ParseError::Data);
    }
    if pairs.len() > bytes.len() {
        return Err(ParseError::Length);
    }
    let mut all = 0;
    for (byte, pair) in bytes.iter_mut().zip(pairs) {
        if let &[high, low] = pair {
            let (high, low) = (value(high), value(low));
            all |= high | low;
            *byte = high << 4 | low;
        }
    }
    if all < 16 { Ok((digits.len() / 2) as u8) } else { Err(ParseError::Data) }
}

/// The value of a hexadecimal digit.
fn digit(byte: u8) -> Option<u8> {
    Some(value(byte)).filter(|value| *value < 16)
}

/// The value of a hexadecimal digit, or [`NONE`], so that several digits can be checked at once.
fn value(byte: u8) -> u8 {
    DIGITS.get(usize::from(byte)).copied().unwrap_or(NONE)
}

const NONE: u8 = 0xFF;

/// A table is faster than three comparisons, and logs are long.
static DIGITS: [u8; 256] = {
    let mut values = [NONE; 256];
    let mut value = 0;
    while value < 16 {
        values[b"0123456789ABCDEF"[value] as usize] = value as u8;
        values[b"0123456789abcdef"[value] as usize] = value as u8;
        value += 1;
    }
    values
};

impl ParseError {
    /// Description of the error.
    pub const fn reason(self) -> &'static str {
        match self {
            Self::Shape => "not \"(time) channel identifier#data\", with R or T behind it or not",
            Self::Time => "the time is not a finite number",
            Self::Channel => "the channel is not UTF-8",
            Self::Separator => "no # between identifier and data",
            Self::Identifier => "the identifier is not 1 to 3 hexadecimal digits up to 7FF, or 4 to 8",
            Self::Data => "the data are not pairs of hexadecimal digits",
            Self::Length => "more than 8 data bytes, or 64 of CAN FD",
        }
    }
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.reason())
    }
}

impl core::error::Error for ParseError {}
