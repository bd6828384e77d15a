//! Verification of images: signed by their owner, and for this board.

use crate::image::{HEADER_LENGTH, Header, HeaderError, SIGNATURE_LENGTH, SIGNED_LENGTH};
use crate::key::Key;
use core::fmt;
use core::ops::Range;
use embedded_storage::nor_flash::{NorFlashError, NorFlashErrorKind, ReadNorFlash};
use salty::{PublicKey, Sha512, Signature};

/// Owner who signs images, as seen by those who verify them.
pub trait Signatory {
    /// Returns whether this is the owner's signature of an image with this SHA-512.
    fn has_signed(&self, hash: &[u8; 64], signature: &[u8; SIGNATURE_LENGTH]) -> bool;
}

/// Which images a board takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board<S = Key> {
    /// Its hardware id.
    pub hardware: u32,
    /// Whose signature it believes.
    pub key: S,
}

/// Reason why an image is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageError {
    /// It has no header.
    Header(HeaderError),
    /// It is for other hardware.
    Hardware(u32),
    /// It is longer than the slot; bytes, header included.
    TooLong(u32),
    /// The signature does not verify: the image was altered, or another key signed it.
    Signature,
    /// It is older than the image that runs.
    Older(crate::Version),
}

/// The kind of an [`ImageError`], as it is kept in the state pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Refused {
    /// It has no header.
    NoImage = 1,
    /// It is for other hardware.
    Hardware = 2,
    /// It is longer than the slot.
    TooLong = 3,
    /// The signature does not verify: the image was altered, or another key signed it.
    Signature = 4,
    /// It is older than the image that runs.
    Older = 5,
}

impl Refused {
    /// The kind with this number.
    pub(crate) fn of(code: u8) -> Option<Self> {
        [Self::NoImage, Self::Hardware, Self::TooLong, Self::Signature, Self::Older]
            .into_iter()
            .find(|kind| *kind as u8 == code)
    }
}

impl ImageError {
    /// Without the details.
    pub const fn kind(self) -> Refused {
        match self {
            Self::Header(_) => Refused::NoImage,
            Self::Hardware(_) => Refused::Hardware,
            Self::TooLong(_) => Refused::TooLong,
            Self::Signature => Refused::Signature,
            Self::Older(_) => Refused::Older,
        }
    }
}

/// Bytes that are read and hashed at once.
const CHUNK: usize = 256;

impl<S: Signatory> Board<S> {
    /// Reads and verifies the image at the beginning of `slot`, signature and all. In pieces, because the
    /// flash of a board need not be mapped into its memory: Ed25519ph hashes the image once.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn verify<F: ReadNorFlash>(
        &self,
        flash: &mut F,
        slot: Range<u32>,
    ) -> Result<Result<Header, ImageError>, NorFlashErrorKind> {
        let mut bytes = [0; HEADER_LENGTH];
        flash.read(slot.start, &mut bytes).map_err(|error| error.kind())?;
        let header = match inspect(&bytes, self.hardware, slot.end - slot.start) {
            Ok(header) => header,
            Err(error) => return Ok(Err(error)),
        };
        let (signed, signature) = split(&bytes);
        let mut hash = Sha512::new();
        hash.update(signed);
        let mut chunk = [0; CHUNK];
        let end = slot.start + header.image_length();
        let mut at = slot.start + HEADER_LENGTH as u32;
        while at < end {
            let length = chunk.len().min((end - at) as usize);
            let Some(part) = chunk.get_mut(..length) else { break };
            flash.read(at, part).map_err(|error| error.kind())?;
            hash.update(part);
            at += length as u32;
        }
        Ok(if self.key.has_signed(&hash.finalize(), signature) {
            Ok(header)
        } else {
            Err(ImageError::Signature)
        })
    }
}

/// Decodes a header and checks that its image is for this hardware and not longer than `room`, bytes. Does
/// not verify the signature.
///
/// # Errors
/// The header is invalid, for other hardware, or its image is too long.
pub(crate) fn inspect(bytes: &[u8; HEADER_LENGTH], hardware: u32, room: u32) -> Result<Header, ImageError> {
    let header = Header::decode(bytes).map_err(ImageError::Header)?;
    if header.hardware != hardware {
        return Err(ImageError::Hardware(header.hardware));
    }
    if header.image_length() > room {
        return Err(ImageError::TooLong(header.image_length()));
    }
    Ok(header)
}

impl Signatory for Key {
    fn has_signed(&self, hash: &[u8; 64], signature: &[u8; SIGNATURE_LENGTH]) -> bool {
        let Ok(key) = PublicKey::try_from(&self.0) else { return false };
        key.verify_prehashed(hash, &Signature::from(signature), None).is_ok()
    }
}

fn split(bytes: &[u8; HEADER_LENGTH]) -> (&[u8], &[u8; SIGNATURE_LENGTH]) {
    match bytes.split_last_chunk::<SIGNATURE_LENGTH>() {
        Some((signed, signature)) => (signed, signature),
        None => (&[], &[0; SIGNATURE_LENGTH]),
    }
}

const _: () = assert!(SIGNED_LENGTH + SIGNATURE_LENGTH == HEADER_LENGTH);

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Header(error) => error.fmt(f),
            Self::Hardware(id) => write!(f, "for hardware {id:08X}h"),
            Self::TooLong(length) => write!(f, "{length} bytes do not fit the slot"),
            Self::Signature => f.write_str("the signature is not that of its bytes by the board's key"),
            Self::Older(version) => write!(f, "version {version} is older than the one that runs"),
        }
    }
}

impl core::error::Error for ImageError {}
