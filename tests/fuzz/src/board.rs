//! A small board with slots and its bootloader. The hash itself serves as the signature: other tests check
//! Ed25519, which takes a thousand times as long.

use embedded_storage::nor_flash::ReadNorFlash;
use narx_boot::{
    Board, Failure, HEADER_LENGTH, Header, Map, Outcome, SIGNED_LENGTH, Signatory, Slot, Version,
};
use narx_sim::flash::Sparse;
use narx_sim::internal_flash::InternalFlash;
use salty::Sha512;

const PAGE: usize = 512;
pub(crate) type Flash = InternalFlash<Sparse, PAGE>;

pub(crate) const HARDWARE: u32 = 0x4E61_7278;
/// Four pages for the active image, five for the candidate.
pub(crate) const MAP: Map =
    Map::stacked([PAGE as u32, 4 * PAGE as u32, 5 * PAGE as u32, PAGE as u32, PAGE as u32]);
const CAPACITY: u32 = 12 * PAGE as u32;

#[derive(Clone, Copy, Debug)]
struct Hash;

impl Signatory for Hash {
    fn has_signed(&self, hash: &[u8; 64], signature: &[u8; 64]) -> bool {
        hash == signature
    }
}

pub(crate) fn version(minor: u8) -> Version {
    Version { major: 1, minor, patch: 0, build: 0 }
}

/// Builds a signed image whose body follows from its version.
pub(crate) fn image(hardware: u32, version: Version, words: usize) -> Vec<u8> {
    let body: Vec<u8> = (0..8 * words).map(|at| (at as u8).wrapping_mul(31) ^ version.minor).collect();
    let signed = Header { hardware, version, length: body.len() as u32 }.encode();
    [signed.to_vec(), hash(&signed, &body).to_vec(), body].concat()
}

fn hash(signed: &[u8], body: &[u8]) -> [u8; 64] {
    let mut hash = Sha512::new();
    hash.update(signed);
    hash.update(body);
    hash.finalize()
}

/// A flash without an image.
pub(crate) const fn blank() -> Flash {
    Flash::new(Sparse::new(), CAPACITY, 1)
}

pub(crate) fn slot(flash: &mut Flash) -> Slot<&mut Flash> {
    Slot::new(flash, MAP, HARDWARE).expect("the map fits the flash")
}

/// Runs the bootloader. An image that it enters must be one of the owner's for this board, byte by byte.
pub(crate) fn boot(flash: &mut Flash) -> Result<Outcome, Failure> {
    let outcome = narx_boot::boot(flash, &MAP, &Board { hardware: HARDWARE, key: Hash });
    if let Ok(Outcome::Run { header, .. }) = &outcome {
        let mut active = vec![0; MAP.room() as usize];
        flash.read(MAP.active.start, &mut active).expect("it has its power");
        let length = header.image_length() as usize;
        assert!(length <= active.len() && header.hardware == HARDWARE, "{header:?}");
        assert_eq!(Header::of(&active[..length]), Ok(*header));
        let (head, body) = active[..length].split_at(HEADER_LENGTH);
        let (signed, signature) = head.split_at(SIGNED_LENGTH);
        assert!(signature == hash(signed, body), "it enters what nobody has signed: {header:?}");
    }
    outcome
}

/// Content of the active slot.
pub(crate) fn active(flash: &mut Flash) -> Vec<u8> {
    let mut bytes = vec![0; MAP.room() as usize];
    flash.read(MAP.active.start, &mut bytes).expect("it has its power");
    bytes
}
