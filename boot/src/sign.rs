//! Makes images: what a signing tool does, and tests.

use crate::Key;
use crate::image::{HEADER_LENGTH, Header};
use salty::{Keypair, Sha512};

/// The secret half of a key: 32 bytes of which nobody knows anything (RFC 8032, section 5.1.5).
#[derive(Clone, Copy)]
pub struct SecretKey(pub [u8; 32]);

// `PUBLISHED`, by the build script.
include!(concat!(env!("OUT_DIR"), "/secret.rs"));

impl SecretKey {
    /// The secret half of [`crate::key::TEST_ONLY`], which is none.
    pub const TEST_ONLY: Self = Self(PUBLISHED);

    /// Returns the public key, which boards have to know.
    pub fn public(&self) -> Key {
        Key(Keypair::from(&self.0).public.to_bytes())
    }

    /// The header of an image with this body. Its length is made that of the body.
    pub fn sign(&self, header: Header, body: &[u8]) -> [u8; HEADER_LENGTH] {
        let signed = Header { length: body.len() as u32, ..header }.encode();
        let mut hash = Sha512::new();
        hash.update(&signed);
        hash.update(body);
        let signature = Keypair::from(&self.0).sign_prehashed(&hash.finalize(), None).to_bytes();
        let mut bytes = [0; HEADER_LENGTH];
        let all = signed.iter().chain(&signature);
        bytes.iter_mut().zip(all).for_each(|(place, byte)| *place = *byte);
        bytes
    }
}
