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
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
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
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
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
                let (bytes, length) = decode(data)?;
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
#[inline]
fn word(text: &[u8]) -> (&[u8], &[u8]) {
    let (word, rest) = text.split_at_checked(first_blank(text)).unwrap_or((text, &[]));
    match rest {
        // Almost always there is one blank.
        [b' ', behind @ ..] if behind.first().is_some_and(u8::is_ascii_graphic) => (word, behind),
        rest => (word, rest.trim_ascii_start()),
    }
}

/// The place of the first blank, or the length.
#[inline]
fn first_blank(text: &[u8]) -> usize {
    let (eights, _) = text.as_chunks();
    let mut begin = 0;
    for eight in eights {
        let bytes = u64::from_le_bytes(*eight);
        // The lowest bit that is left is that of the first byte below 21h; bits above may be borrowed ones.
        let low = bytes.wrapping_sub(each(0x21)) & !bytes & TOPS;
        if low != 0 {
            begin += (low.trailing_zeros() / 8) as usize;
            break;
        }
        begin += 8;
    }
    // From there byte by byte: the last ones are less than eight, and a control character is no blank.
    let rest = text.get(begin..).unwrap_or_default();
    begin + rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len())
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
    const POWERS: [u64; 10] =
        [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000, 1_000_000_000];
    if text.len() > 18 {
        return None;
    }
    let (whole, fraction) = match text.iter().position(|byte| *byte == b'.') {
        Some(point) => text.split_at_checked(point)?,
        None => (text, [].as_slice()),
    };
    let fraction = fraction.get(1..).unwrap_or_default();
    let power = *POWERS.get(fraction.len())?;
    // Two numbers that do not wait for each other.
    let number = decimal(whole)?.wrapping_mul(power).wrapping_add(decimal(fraction)?);
    let exact = !whole.is_empty() && number > 0 && number <= 1 << 53;
    exact.then_some(number as f64 / power as f64)
}

/// The number that up to 18 digits make, eight at a time.
fn decimal(digits: &[u8]) -> Option<u64> {
    let (eights, rest) = digits.as_chunks();
    let mut number = 0_u64;
    for eight in eights {
        number = number.wrapping_mul(100_000_000).wrapping_add(eight_digits(*eight)?);
    }
    for byte in rest {
        let digit @ 0..=9 = byte.wrapping_sub(b'0') else { return None };
        number = number.wrapping_mul(10).wrapping_add(digit.into());
    }
    Some(number)
}

/// This value in each of eight bytes.
const fn each(byte: u8) -> u64 {
    u64::from_le_bytes([byte; 8])
}

/// The highest bit of every byte.
const TOPS: u64 = each(0x80);

/// The number that eight decimal digits make.
fn eight_digits(text: [u8; 8]) -> Option<u64> {
    // A digit is 0 to 9 in its byte: that, and that plus 118, have no highest bit.
    let digits = u64::from_le_bytes(text) ^ each(0x30);
    if (digits | digits.wrapping_add(each(118))) & TOPS != 0 {
        return None;
    }
    // Neighbours are joined: two digits in each of four places, then four in two, then eight.
    let twos = digits.wrapping_mul(10).wrapping_add(digits >> 8) & 0x00FF_00FF_00FF_00FF;
    let fours = twos.wrapping_mul(100).wrapping_add(twos >> 16) & 0x0000_FFFF_0000_FFFF;
    Some(fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xFFFF_FFFF)
}

/// The four bytes that eight hexadecimal digits make.
fn four_bytes(text: [u8; 8]) -> Option<[u8; 4]> {
    let text = u64::from_le_bytes(text);
    // 0 to 9 of a decimal digit, 1 to 6 of a letter, whose bit 6 is set.
    let (digit, letter) = (text ^ each(0x30), (text | each(0x20)) ^ each(0x60));
    let no_digit = digit.wrapping_add(each(118));
    let no_letter = letter.wrapping_add(each(121)) | !letter.wrapping_add(each(127));
    if (text | no_digit & no_letter) & TOPS != 0 {
        return None;
    }
    let halves = (text & each(0x0F)) + (text >> 6 & each(1)) * 9;
    let bytes = (halves << 4 | halves >> 8) & 0x00FF_00FF_00FF_00FF;
    let pairs = (bytes | bytes >> 8) & 0x0000_FFFF_0000_FFFF;
    Some(((pairs | pairs >> 16) as u32).to_le_bytes())
}

#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
fn identifier(digits: &[u8]) -> Option<u32> {
    if let Ok(eight) = <[u8; 8]>::try_from(digits) {
        return four_bytes(eight).map(u32::from_be_bytes);
    }
    let (mut raw, mut all) = (0, 0);
    for byte in digits {
        let value = value(*byte);
        raw = raw << 4 | u32::from(value);
        all |= value;
    }
    (matches!(digits.len(), 1..=8) && all < 16).then_some(raw)
}

/// Decodes up to eight pairs of digits; returns the bytes and their number.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
fn decode(digits: &[u8]) -> Result<([u8; 8], u8), ParseError> {
    if !digits.len().is_multiple_of(2) {
        return Err(ParseError::Data);
    }
    if digits.len() > 16 {
        return Err(ParseError::Length);
    }
    // In a register: bytes that are stored one by one and read at once cost as much as all of their decoding.
    let (mut bytes, mut shift) = (0, 0);
    let (eights, rest) = digits.as_chunks();
    for eight in eights {
        let four = four_bytes(*eight).ok_or(ParseError::Data)?;
        bytes |= u64::from(u32::from_le_bytes(four)) << shift;
        shift += 32;
    }
    for pair in rest.as_chunks().0 {
        let [high, low] = pair.map(digit);
        let byte = high.zip(low).map(|(high, low)| high << 4 | low).ok_or(ParseError::Data)?;
        bytes |= u64::from(byte) << shift;
        shift += 8;
    }
    Ok((bytes.to_le_bytes(), (digits.len() / 2) as u8))
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
