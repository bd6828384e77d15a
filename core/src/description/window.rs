//! Where lines are written to: a piece of them, or only their length.

use core::fmt;

/// Keeps what lies behind the first bytes of a line, as far as there is room; full, it ends the writing.
pub(super) struct Window<'a> {
    skip: usize,
    out: &'a mut [u8],
    written: usize,
}

impl<'a> Window<'a> {
    pub(super) fn new(skip: u16, out: &'a mut [u8]) -> Self {
        Self { skip: skip.into(), out, written: 0 }
    }

    pub(super) const fn written(&self) -> usize {
        self.written
    }
}

impl fmt::Write for Window<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let Some(bytes) = text.as_bytes().get(self.skip..) else {
            self.skip -= text.len();
            return Ok(());
        };
        self.skip = 0;
        let room = self.out.iter_mut().skip(self.written);
        let copied = room.zip(bytes).map(|(place, byte)| *place = *byte).count();
        self.written += copied;
        if copied == bytes.len() { Ok(()) } else { Err(fmt::Error) }
    }
}

/// Counts bytes.
#[derive(Default)]
pub(super) struct Counter(u16);

impl Counter {
    pub(super) const fn bytes(&self) -> u16 {
        self.0
    }
}

impl fmt::Write for Counter {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0 = self.0.saturating_add(text.len() as u16);
        Ok(())
    }
}
