//! A register of the machine.

use core::ptr::NonNull;

/// A 32-bit register.
#[derive(Clone, Copy, Debug)]
pub(super) struct Register(NonNull<u32>);

// SAFETY: reading and writing a register is one access of the bus; who shares one knows what its bits mean.
unsafe impl Send for Register {}

impl Register {
    /// The register at `address`.
    ///
    /// # Safety
    /// There is a 32-bit register of a peripheral, or a word that nothing else has, which may be read and
    /// written at any time.
    pub(super) const unsafe fn new(address: usize) -> Self {
        // SAFETY: a peripheral does not stand at 0.
        Self(unsafe { NonNull::new_unchecked(address as *mut u32) })
    }

    pub(super) fn read(self) -> u32 {
        // SAFETY: `new` was promised a register.
        unsafe { self.0.read_volatile() }
    }

    pub(super) fn write(self, value: u32) {
        // SAFETY: as above.
        unsafe { self.0.write_volatile(value) }
    }
}
