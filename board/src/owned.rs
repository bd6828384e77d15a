//! Values that an interrupt owns.

use core::cell::RefCell;
use critical_section::Mutex;

/// A place in which `main` leaves something for an interrupt. Nobody else takes it out, so it is never found
/// in use.
pub struct Owned<T>(Mutex<RefCell<Option<T>>>);

impl<T> Owned<T> {
    /// Nothing yet.
    pub const fn nothing() -> Self {
        Self(Mutex::new(RefCell::new(None)))
    }

    /// Leaves `value` for the interrupt.
    pub fn give(&self, value: T) {
        critical_section::with(|section| {
            if let Ok(mut place) = self.0.borrow(section).try_borrow_mut() {
                *place = Some(value);
            }
        });
    }

    /// The interrupt's work with what it owns; nothing happens before it was given.
    #[inline]
    pub fn with(&self, work: impl FnOnce(&mut T)) {
        critical_section::with(|section| {
            if let Ok(mut place) = self.0.borrow(section).try_borrow_mut()
                && let Some(value) = place.as_mut()
            {
                work(value);
            }
        });
    }
}
