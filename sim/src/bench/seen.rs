//! The recorder's look at what goes between the halves of the device.

use narx_core::device::Tap;
use narx_core::motor::{Event, Status};

/// Event and report of one control tick.
#[derive(Default)]
pub(super) struct Seen {
    pub(super) event: Option<Event>,
    pub(super) status: Option<Status>,
}

impl Tap for Seen {
    fn see_event(&mut self, event: &Event) {
        self.event = Some(event.clone());
    }

    fn see_status(&mut self, status: &Status) {
        self.status = Some(*status);
    }
}
