//! Mailbox between node and storage in a loop that polls: one request there, one report back.

use super::{FlashReply, FlashTask, Storage};
use core::cell::RefCell;
use core::future::poll_fn;
use core::task::Poll;
use embedded_storage_async::nor_flash::NorFlash;

/// One place for a request and then for its report. Both sides run in the same loop: no interrupt may use it.
#[derive(Default)]
pub struct Mailbox(RefCell<Letter>);

#[derive(Default)]
#[allow(clippy::large_enum_variant, reason = "one of them exists, and there is no heap")]
enum Letter {
    #[default]
    Nothing,
    Task(FlashTask),
    Reply(FlashReply),
}

impl Mailbox {
    /// An empty mailbox.
    pub const fn new() -> Self {
        Self(RefCell::new(Letter::Nothing))
    }

    /// Hands over a request. It replaces a request or report that has not been taken; a node never does that.
    pub fn ask(&self, request: FlashTask) {
        self.put(Letter::Task(request));
    }

    /// The report, once there is one.
    pub fn take_report(&self) -> Option<FlashReply> {
        match self.take(|letter| matches!(letter, Letter::Reply(_)))? {
            Letter::Reply(report) => Some(report),
            _ => None,
        }
    }

    /// Serves requests for ever. The future calls no waker: the caller must poll it again.
    pub async fn serve<F: NorFlash>(&self, storage: &mut Storage<F>) -> ! {
        loop {
            let request = poll_fn(|_| self.take_request().map_or(Poll::Pending, Poll::Ready)).await;
            let report = storage.execute(request).await;
            self.put(Letter::Reply(report));
        }
    }

    /// Takes a request, if one waits, and continues the request under way by one step. Call it in every pass
    /// of a loop.
    #[cfg(feature = "code-flash")]
    pub fn serve_step<F: embedded_storage::nor_flash::NorFlash>(&self, storage: &mut super::CodeFlash<F>) {
        if let Some(request) = self.take_request() {
            storage.begin(request);
        }
        if let Some(report) = storage.step() {
            self.put(Letter::Reply(report));
        }
    }

    fn take_request(&self) -> Option<FlashTask> {
        match self.take(|letter| matches!(letter, Letter::Task(_)))? {
            Letter::Task(request) => Some(request),
            _ => None,
        }
    }

    // No borrow outlasts these two functions, so none is ever refused.

    fn put(&self, letter: Letter) {
        if let Ok(mut place) = self.0.try_borrow_mut() {
            *place = letter;
        }
    }

    fn take(&self, wanted: impl Fn(&Letter) -> bool) -> Option<Letter> {
        let mut place = self.0.try_borrow_mut().ok()?;
        wanted(&place).then(|| core::mem::take(&mut *place))
    }
}
