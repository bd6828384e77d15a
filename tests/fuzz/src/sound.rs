//! Recordings with correct check values and any content in their chunks.

use crc::{CRC_32_ISO_HDLC, Crc};
use narx_core::recording::{CONTAINER_VERSION, MAGIC};

static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A file with correct check values and any content.
#[derive(Clone)]
pub(crate) struct Sound {
    pub(crate) file: Vec<u8>,
    checked: Vec<u8>,
}

impl Sound {
    pub(crate) fn begin() -> Self {
        let mut file = MAGIC.to_vec();
        file.push(CONTAINER_VERSION);
        Self { checked: file.clone(), file }
    }

    pub(crate) fn chunk(&mut self, tag: u8, payload: &[u8]) {
        let mut bytes = vec![tag];
        bytes.extend((payload.len() as u16).to_le_bytes());
        bytes.extend(payload);
        self.checked.extend(&bytes);
        self.file.extend(&bytes);
        self.file.extend(CRC32.checksum(&self.checked).to_le_bytes());
    }
}
