//! The form of an image: a header of 512 bytes, behind it the program as it stands in the flash.
//!
//! ```text
//!    0  8 bytes  magic "NARXIMG" and a zero
//!    8  u16      format: 1
//!   10  u16      0
//!   12  u32      hardware id
//!   16  u8, u8   major and minor version
//!   18  u16      patch level
//!   20  u16      build number
//!   22  u16      0
//!   24  u32      length of the body, bytes: a multiple of 8, at least 8
//!   28  420      0
//!  448  64       signature: Ed25519ph (RFC 8032, section 5.1, no context) of bytes 0 to 447 and the body
//!  512  length   the body, vector table first
//! ```
//!
//! Numbers are big endian, as on the bus. A vector table is aligned to 512 bytes where the image is.

use crate::Version;
use core::fmt;

/// Bytes before the body.
pub const HEADER_LENGTH: usize = 512;
/// Bytes of the header that are signed.
pub const SIGNED_LENGTH: usize = HEADER_LENGTH - SIGNATURE_LENGTH;
/// Bytes of a signature.
pub const SIGNATURE_LENGTH: usize = 64;

/// Words of the header that mean something.
const WORDS: usize = 7;
const MAGIC: [u32; 2] = [u32::from_be_bytes(*b"NARX"), u32::from_be_bytes(*b"IMG\0")];
const FORMAT: u32 = 1;
/// Flashes program as many bytes at once, or fewer.
pub const BODY_ALIGNMENT: u32 = 8;
/// The whole image is counted in 32 bits.
const LENGTH_MAX: u32 = u32::MAX - HEADER_LENGTH as u32;

/// Content of an image's header. It can be trusted once the signature is verified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// The board that it is for.
    pub hardware: u32,
    /// Its version.
    pub version: Version,
    /// Length of the body, bytes.
    pub length: u32,
}

/// Reason why 512 bytes are no header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeaderError {
    /// It does not begin with the magic.
    Magic,
    /// A format that this version does not know.
    Format(u16),
    /// A length of 0, or not a multiple of 8, or an image beyond 32 bits.
    Length(u32),
    /// A file that is not as long as its header says.
    File {
        /// Length of the file, bytes.
        length: usize,
        /// Length that it should have, bytes: header and body, or that of the header alone if the file is
        /// shorter than a header.
        wanted: u32,
    },
}

impl Header {
    /// Length of the whole image, bytes.
    pub const fn image_length(&self) -> u32 {
        self.length.saturating_add(HEADER_LENGTH as u32)
    }

    /// Reads the header of an image in a file, which must hold exactly that image.
    ///
    /// # Errors
    /// The file is not an image, or not exactly one.
    pub fn of(file: &[u8]) -> Result<Self, HeaderError> {
        let short = HeaderError::File { length: file.len(), wanted: HEADER_LENGTH as u32 };
        let header = Self::decode(file.first_chunk().ok_or(short)?)?;
        let wanted = header.image_length();
        if file.len() == wanted as usize {
            Ok(header)
        } else {
            Err(HeaderError::File { length: file.len(), wanted })
        }
    }

    /// Decodes the header in the first bytes of an image.
    ///
    /// # Errors
    /// Reason why they are not a header.
    pub fn decode(bytes: &[u8; HEADER_LENGTH]) -> Result<Self, HeaderError> {
        let mut words = [0; WORDS];
        for (word, bytes) in words.iter_mut().zip(bytes.as_chunks().0) {
            *word = u32::from_be_bytes(*bytes);
        }
        let [magic0, magic1, format, hardware, version, build, length] = words;
        if [magic0, magic1] != MAGIC {
            return Err(HeaderError::Magic);
        }
        if format != FORMAT << 16 {
            return Err(HeaderError::Format((format >> 16) as u16));
        }
        if length == 0 || !length.is_multiple_of(BODY_ALIGNMENT) || length > LENGTH_MAX {
            return Err(HeaderError::Length(length));
        }
        let [major, minor, ..] = version.to_be_bytes();
        let version = Version { major, minor, patch: version as u16, build: (build >> 16) as u16 };
        Ok(Self { hardware, version, length })
    }

    /// The signed part of a header.
    pub fn encode(&self) -> [u8; SIGNED_LENGTH] {
        let [magic0, magic1] = MAGIC;
        let Version { major, minor, patch, build } = self.version;
        let version = u32::from(major) << 24 | u32::from(minor) << 16 | u32::from(patch);
        let build = u32::from(build) << 16;
        let words = [magic0, magic1, FORMAT << 16, self.hardware, version, build, self.length];
        let mut bytes = [0; SIGNED_LENGTH];
        let fields = words.into_iter().flat_map(u32::to_be_bytes);
        bytes.iter_mut().zip(fields).for_each(|(place, byte)| *place = byte);
        bytes
    }
}

impl fmt::Display for HeaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { length, wanted } => {
                write!(f, "the file has {length} bytes; the image needs {wanted}")
            }
            Self::Magic => f.write_str("not an image: it does not begin with NARXIMG"),
            Self::Format(format) => write!(f, "format {format}, only {FORMAT} is known"),
            Self::Length(length) => {
                write!(
                    f,
                    "a body of {length} bytes: not a multiple of {BODY_ALIGNMENT} from {BODY_ALIGNMENT} on"
                )
            }
        }
    }
}

impl core::error::Error for HeaderError {}
