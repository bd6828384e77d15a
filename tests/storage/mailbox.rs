//! Tests of the mailbox between a node and its storage, in a loop that polls.

use crate::support::{Chip, now, set, small};
use core::pin::pin;
use core::task::{Context, Waker};
use narx_core::storage::{CodeFlash, FlashReply, FlashTask, Mailbox, Part, Storage};
use narx_sim::flash::Sparse;
use narx_sim::internal_flash::InternalFlash;

/// Runs several passes of a background loop in which a storage is served.
fn serve(mailbox: &Mailbox, storage: &mut Storage<Chip>) {
    let mut serving = pin!(mailbox.serve(storage));
    for _ in 0..3 {
        assert!(serving.as_mut().poll(&mut Context::from_waker(Waker::noop())).is_pending());
    }
}

#[test]
fn a_request_gets_its_report_once() {
    let (mailbox, mut storage) = (Mailbox::new(), Storage::new(small(&set(1))));
    serve(&mailbox, &mut storage);
    assert_eq!(mailbox.take_report(), None, "nobody has asked");
    for request in [FlashTask::Open, FlashTask::Store(set(2), Part::Set), FlashTask::Read(0)] {
        mailbox.ask(request.clone());
        assert_eq!(mailbox.take_report(), None, "it has not been served");
        serve(&mailbox, &mut storage);
        let report = mailbox.take_report().expect("a report");
        let same = now(storage.execute(request));
        assert_eq!(core::mem::discriminant(&report), core::mem::discriminant(&same));
        assert_eq!(mailbox.take_report(), None, "it was taken");
    }
    mailbox.ask(FlashTask::Open);
    serve(&mailbox, &mut storage);
    let Some(FlashReply::Opened(opened)) = mailbox.take_report() else { panic!() };
    assert_eq!(opened.parameters.value(narx_core::dictionary::number::SPEED_RATE).unwrap(), 1002);
}

/// A storage without waiting goes on by one step of a request in every pass.
#[test]
fn the_codes_own_flash_is_served_in_steps() {
    let mailbox = Mailbox::new();
    let mut storage = CodeFlash::new(InternalFlash::<Sparse>::new(Sparse::new(), 8192, 1));
    for (request, passes) in
        [(FlashTask::Open, 2), (FlashTask::Store(set(3), Part::Set), 3), (FlashTask::Open, 2)]
    {
        mailbox.ask(request);
        for pass in 1..=passes {
            assert_eq!(mailbox.take_report(), None, "{pass}");
            mailbox.serve_step(&mut storage);
        }
        match mailbox.take_report() {
            Some(FlashReply::Opened(opened)) => assert!(opened.log.records == 0),
            Some(FlashReply::Stored { done, .. }) => assert!(done),
            other => panic!("{other:?}"),
        }
        mailbox.serve_step(&mut storage);
        assert_eq!(mailbox.take_report(), None, "it was taken");
    }
}
