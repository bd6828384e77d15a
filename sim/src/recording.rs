//! A recording in memory that grows as needed.

use alloc::vec::Vec;
use core::convert::Infallible;
use narx_core::recording::Sink;

/// The bytes of a recording so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordingBuffer(pub Vec<u8>);

impl Sink for RecordingBuffer {
    type Error = Infallible;
    fn write(&mut self, bytes: &[u8]) -> Result<(), Infallible> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }
}
