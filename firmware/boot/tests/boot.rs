//! What the bootloader enters, and what it does to the slots before.

mod support;

use narx_boot::{Event, ImageError, Outcome, Verdict};
use support::{MAP, board_with, boot, image, receive, runs, slot, version};

const OLD: narx_boot::Version = version(1, 2, 3, 4);
const NEW: narx_boot::Version = version(1, 3, 0, 5);

fn event(outcome: Outcome) -> Option<Event> {
    match outcome {
        Outcome::Run { event, .. } => Some(event),
        Outcome::Stay(_) => None,
    }
}

/// A candidate runs on trial; confirmed it stays, and not confirmed the one before comes back.
#[test]
fn a_trial_ends_by_confirmation_or_revert() {
    let mut flash = board_with(&image(OLD, 1000));
    receive(&mut flash, &image(NEW, 1408)).expect("received");
    assert!(slot(&mut flash).condition().expect("readable").marked);
    let outcome = boot(&mut flash).expect("boots");
    assert_eq!((event(outcome), runs(Ok(outcome))), (Some(Event::Swapped), Some(NEW)));

    let mut tried = flash.clone();
    assert!(slot(&mut tried).condition().expect("readable").trial);
    assert_eq!(event(boot(&mut tried).expect("boots")), Some(Event::Reverted));
    assert_eq!(slot(&mut tried).condition().expect("readable").verdict, Some(Verdict::Reverted));
    assert_eq!(runs(boot(&mut tried)), Some(OLD));

    slot(&mut flash).confirm().expect("confirmed");
    for _ in 0..2 {
        let outcome = boot(&mut flash).expect("boots");
        assert_eq!((event(outcome), runs(Ok(outcome))), (Some(Event::Unchanged), Some(NEW)));
    }
}

#[test]
fn a_board_without_an_image_stays() {
    let mut flash = board_with(&[]);
    assert!(matches!(boot(&mut flash), Ok(Outcome::Stay(ImageError::Header(_)))));
    let mut broken = image(OLD, 1000);
    broken[700] ^= 1;
    let mut flash = board_with(&broken);
    assert_eq!(boot(&mut flash), Ok(Outcome::Stay(ImageError::Signature)));
    // What can be received brings the board back to life.
    flash.put(MAP.dfu.start, &image(OLD, 1408));
    slot(&mut flash).mark().expect("marked");
    assert_eq!(runs(boot(&mut flash)), Some(OLD));
}
