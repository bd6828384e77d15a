//! The place where node and storage meet in a loop that polls: one request there, one report back.

use super::{Report, Request, Storage};
use core::cell::Cell;
use core::future::poll_fn;
use core::task::Poll;
use embedded_storage_async::nor_flash::NorFlash;

/// One request and one report. Both sides run in the same loop: nothing here may be touched from an interrupt.
#[derive(Default)]
pub struct Mailbox {
    request: Cell<Option<Request>>,
    report: Cell<Option<Report>>,
}

impl Mailbox {
    /// Empty.
    pub const fn new() -> Self {
        Self { request: Cell::new(None), report: Cell::new(None) }
    }

    /// Hands a request over; one that has not been taken is replaced, which a node never does.
    pub fn ask(&self, request: Request) {
        self.request.set(Some(request));
    }

    /// The report, once there is one.
    pub fn take_report(&self) -> Option<Report> {
        self.report.take()
    }

    /// Serves requests for ever. The future wakes nobody: whoever runs it polls it again.
    pub async fn serve<F: NorFlash>(&self, storage: &mut Storage<F>) -> ! {
        loop {
            let request = poll_fn(|_| self.request.take().map_or(Poll::Pending, Poll::Ready)).await;
            let report = storage.execute(request).await;
            self.report.set(Some(report));
        }
    }
}
