//! The drive's state in bytes.

use super::Drive;
use postcard::ser_flavors::Flavor;

/// Layout of the serialised [`Drive`] and of [`Event`](crate::motor::Event), which recordings contain: rises
/// with every field of theirs, or of a type within them, that is added, removed, moved or changes its type.
pub const LAYOUT_VERSION: u16 = 12;

/// Version of the outputs that the drive gives for its inputs: rises with every change that moves the digest
/// of a drive's recording (`tests/vectors/*.narxrec`).
pub const BEHAVIOUR_VERSION: u16 = 15;

impl Drive {
    /// Hands its serialised state (postcard) to `each` byte by byte, until that declines one. There is this
    /// one way, because all that serialises the state by a way of its own brings another copy of the code for
    /// every field.
    pub fn write_state(&self, each: &mut dyn FnMut(u8) -> bool) {
        // The only error is the one that a declined byte makes.
        let _ = postcard::serialize_with_flavor(self, Bytes(each));
    }
}

struct Bytes<'a>(&'a mut dyn FnMut(u8) -> bool);

impl Flavor for Bytes<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        if (self.0)(byte) { Ok(()) } else { Err(postcard::Error::SerializeBufferFull) }
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}
