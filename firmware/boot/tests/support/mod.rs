//! A flash as microcontrollers have it, images, and boards.
#![allow(dead_code, reason = "every test takes what it needs")]

pub(crate) mod flash;

use flash::Internal;
use narx_boot::sign::SecretKey;
use narx_boot::{Board, Failure, HEADER_LENGTH, Header, Map, Outcome, Slot, Version};

/// Whose images the board takes.
pub(crate) const OWNER: SecretKey = SecretKey([7; 32]);
/// The board.
pub(crate) const HARDWARE: u32 = 0x4E58_0001;
/// Four pages that run, five for the candidate.
pub(crate) const MAP: Map = Map::stacked([flash::PAGE, 4 * flash::PAGE, 5 * flash::PAGE, flash::PAGE, 0]);

/// What the bootloader of the board does.
pub(crate) fn boot(flash: &mut Internal) -> Result<Outcome, Failure> {
    narx_boot::boot(flash, &MAP, &Board { hardware: HARDWARE, key: OWNER.public() })
}

pub(crate) fn slot(flash: &mut Internal) -> Slot<&mut Internal> {
    Slot::new(flash, MAP, HARDWARE).expect("the map fits")
}

pub(crate) const fn version(major: u8, minor: u8, patch: u16, build: u16) -> Version {
    Version { major, minor, patch, build }
}

/// An image of the owner's for the board, whose body tells its version in every byte.
pub(crate) fn image(version: Version, body: usize) -> Vec<u8> {
    image_by(&OWNER, HARDWARE, version, body)
}

pub(crate) fn image_by(key: &SecretKey, hardware: u32, version: Version, body: usize) -> Vec<u8> {
    let byte = |at: usize| (at as u8).wrapping_mul(31) ^ version.minor ^ version.patch as u8;
    let body: Vec<u8> = (0..body).map(byte).collect();
    let mut image = key.sign(Header { hardware, version, length: 0 }, &body).to_vec();
    assert_eq!(image.len(), HEADER_LENGTH);
    image.extend(body);
    image
}

/// The board as it leaves the factory: this image runs.
pub(crate) fn board_with(image: &[u8]) -> Internal {
    let mut flash = Internal::new();
    flash.put(MAP.active.start, image);
    flash
}

/// What an application does with an image that it receives: all of an update but the bus.
pub(crate) fn receive(flash: &mut Internal, image: &[u8]) -> Result<(), narx_boot::SlotError> {
    let mut slot = slot(flash);
    slot.begin()?;
    for offset in (0..image.len() as u32).step_by(flash::PAGE as usize) {
        slot.erase(offset)?;
    }
    for (piece, offset) in image.chunks(192).zip((0..).step_by(192)) {
        slot.write(offset, piece)?;
    }
    slot.inspect(image.len() as u32)?;
    slot.mark()
}

/// Version that runs after a boot.
pub(crate) fn runs(outcome: Result<Outcome, Failure>) -> Option<Version> {
    match outcome {
        Ok(Outcome::Run { header, .. }) => Some(header.version),
        _ => None,
    }
}
