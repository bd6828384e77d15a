//! Images, a board, and what happens to its flash.

use embedded_storage::nor_flash::ReadNorFlash;
use narx_boot::sign::SecretKey;
use narx_boot::{
    Board, Failure, HEADER_LENGTH, Header, Map, Outcome, Signatory, Slot, SlotError, Version, hardware,
};
use narx_sim::flash::Sparse;
use narx_sim::internal_flash::InternalFlash;

/// Small pages, so that a whole update has few operations.
pub(crate) const PAGE: usize = 512;
pub(crate) type Flash = InternalFlash<Sparse, PAGE>;

/// Whose images the board takes.
pub(crate) const OWNER: SecretKey = SecretKey([7; 32]);
/// The board.
pub(crate) const HARDWARE: u32 = hardware::B_G431B_ESC1;
/// Four pages that run, five for the candidate.
pub(crate) const MAP: Map =
    Map::stacked([PAGE as u32, 4 * PAGE as u32, 5 * PAGE as u32, PAGE as u32, PAGE as u32]);
const CAPACITY: u32 = 12 * PAGE as u32;

pub(crate) const OLD: Version = version(1, 2, 3, 4);
pub(crate) const NEW: Version = version(1, 3, 0, 5);

/// Runs the bootloader of the board.
pub(crate) fn boot(flash: &mut Flash) -> Result<Outcome, Failure> {
    narx_boot::boot(flash, &MAP, &Board { hardware: HARDWARE, key: OWNER.public() })
}

pub(crate) fn slot(flash: &mut Flash) -> Slot<&mut Flash> {
    Slot::new(flash, MAP, HARDWARE).unwrap()
}

pub(crate) const fn version(major: u8, minor: u8, patch: u16, build: u16) -> Version {
    Version { major, minor, patch, build }
}

/// An image of the owner's for the board.
pub(crate) fn image(version: Version, body: usize) -> Vec<u8> {
    image_by(&OWNER, HARDWARE, version, body)
}

pub(crate) fn image_by(key: &SecretKey, hardware: u32, version: Version, body: usize) -> Vec<u8> {
    let body = program(version, body);
    let mut image = key.sign(Header { hardware, version, length: 0 }, &body).to_vec();
    assert_eq!(image.len(), HEADER_LENGTH);
    image.extend(body);
    image
}

/// A program, another one for each version.
pub(crate) fn program(version: Version, length: usize) -> Vec<u8> {
    (0..length).map(|at| (at as u8).wrapping_mul(31) ^ version.minor ^ version.patch as u8).collect()
}

/// The board as it leaves the factory: this image runs.
pub(crate) fn board_with(image: &[u8]) -> Flash {
    let mut flash = Flash::new(Sparse::new(), CAPACITY, 1);
    flash.load(MAP.active.start, image);
    flash
}

/// Does what an application does with an image that it receives: all of an update but the bus.
pub(crate) fn receive(flash: &mut Flash, image: &[u8]) -> Result<(), SlotError> {
    let mut slot = slot(flash);
    slot.begin()?;
    for offset in (0..image.len() as u32).step_by(PAGE) {
        slot.erase(offset)?;
    }
    for (piece, offset) in image.chunks(96).zip((0..).step_by(96)) {
        slot.write(offset, piece)?;
    }
    slot.inspect(image.len() as u32)?;
    slot.mark()
}

/// Reads the first `length` bytes of the slot of the image that runs.
pub(crate) fn active(flash: &mut Flash, length: usize) -> Vec<u8> {
    let mut bytes = vec![0; length];
    flash.read(MAP.active.start, &mut bytes).unwrap();
    bytes
}

/// Version that a boot enters.
pub(crate) fn runs(outcome: Result<Outcome, Failure>) -> Option<Version> {
    match outcome {
        Ok(Outcome::Run { header, .. }) => Some(header.version),
        _ => None,
    }
}

/// Signs by the hash itself: for tests of everything but Ed25519, of which each signature takes a
/// millisecond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hasty;

impl Signatory for Hasty {
    fn has_signed(&self, hash: &[u8; 64], signature: &[u8; 64]) -> bool {
        hash == signature
    }
}

impl Hasty {
    pub(crate) fn image(version: Version, body: usize) -> Vec<u8> {
        let body = program(version, body);
        let length = body.len() as u32;
        let signed = Header { hardware: HARDWARE, version, length }.encode();
        let mut hash = salty::Sha512::new();
        hash.update(&signed);
        hash.update(&body);
        [signed.to_vec(), hash.finalize().to_vec(), body].concat()
    }

    pub(crate) fn boot(flash: &mut Flash) -> Result<Outcome, Failure> {
        narx_boot::boot(flash, &MAP, &Board { hardware: HARDWARE, key: Self })
    }
}
