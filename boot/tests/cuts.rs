//! The power fails in every step of an update, and again while the board recovers: it always boots a verified
//! image, the old or the new one, whole. Signatures are hashes here (`Hasty`): that they are looked at is
//! `slots.rs`'s business.

use crate::support::{Flash, Hasty, MAP, NEW, OLD, active, board_with, receive, runs, slot};
use embedded_storage::nor_flash::ReadNorFlash;
use narx_sim::flash::Tear;
use narx_sim::random::Random;

/// A board's life from the first frame to the new image, confirmed or not. Ends early when the power fails.
fn live(flash: &mut Flash, new: &[u8], confirms: bool) -> Option<()> {
    receive(flash, new).ok()?;
    Hasty::boot(flash).ok()?;
    if confirms {
        slot(flash).confirm().ok()?;
    }
    Hasty::boot(flash).ok().map(drop)
}

struct Images {
    old: Vec<u8>,
    new: Vec<u8>,
}

impl Images {
    /// The power is back: what runs is one of the two, and every byte of it.
    fn check(&self, flash: &mut Flash, what: &str) {
        let version = runs(Hasty::boot(flash));
        let image = match version {
            Some(OLD) => &self.old,
            Some(NEW) => &self.new,
            other => panic!("{what}: runs {other:?}"),
        };
        assert!(active(flash, image.len()) == *image, "{what}: not all of {version:?}");
    }
}

fn survive(tear: Tear, confirms: bool) {
    let images = Images { old: Hasty::image(OLD, 1320), new: Hasty::image(NEW, 1528) };
    let fresh = board_with(&images.old);
    let mut whole = fresh.clone();
    live(&mut whole, &images.new, confirms).unwrap();
    let steps = whole.steps();
    // Receiving alone are 4 pages and 255 words, and a swap copies 8 pages.
    assert!(steps > 4 + 255 + 8 * 65, "{steps}");
    let mut random = Random::new(steps);
    for step in 0..steps {
        let what = format!("cut in step {step} of {steps}, {tear:?}");
        let mut flash = fresh.clone();
        flash.cut_after(step, tear);
        assert_eq!(live(&mut flash, &images.new, confirms), None, "{what}");
        flash.restore_power();
        let mut again = flash.clone();
        images.check(&mut flash, &what);
        // A second cut while it recovers; none if it recovers in fewer steps.
        let second = random.bits() % 600;
        again.cut_after(second, [Tear::Nothing, Tear::Partial, Tear::Garbage][random.bits() as usize % 3]);
        let _ = Hasty::boot(&mut again);
        again.restore_power();
        images.check(&mut again, &format!("{what}, then in step {second}"));
        // And it is a board like any other: a trial may have to end before.
        if step % 64 == 0 {
            images.check(&mut again, &what);
            receive(&mut again, &images.new).unwrap();
            assert_eq!(runs(Hasty::boot(&mut again)), Some(NEW), "{what}");
        }
    }
}

#[test]
fn cuts_that_leave_what_was_there() {
    survive(Tear::Nothing, true);
}

#[test]
fn cuts_that_leave_a_part() {
    survive(Tear::Partial, true);
}

#[test]
fn cuts_that_leave_garbage() {
    survive(Tear::Garbage, true);
}

#[test]
fn cuts_of_a_revert_that_leave_what_was_there() {
    survive(Tear::Nothing, false);
}

#[test]
fn cuts_of_a_revert_that_leave_a_part() {
    survive(Tear::Partial, false);
}

#[test]
fn cuts_of_a_revert_that_leave_garbage() {
    survive(Tear::Garbage, false);
}

/// An image that is on its way was not marked: whatever has come of it, the bootloader does not look at it.
#[test]
fn a_transfer_that_is_cut_off_is_no_candidate() {
    let images = Images { old: Hasty::image(OLD, 1320), new: Hasty::image(NEW, 1528) };
    for step in (0..258).step_by(7) {
        let mut flash = board_with(&images.old);
        flash.cut_after(step, Tear::Nothing);
        receive(&mut flash, &images.new).unwrap_err();
        flash.restore_power();
        assert!(!slot(&mut flash).condition().unwrap().marked);
        assert_eq!(runs(Hasty::boot(&mut flash)), Some(OLD), "{step}");
        assert_eq!(flash.steps(), step + 1, "nothing was moved");
    }
}

/// In the midst of a swap nothing is on trial: that begins when its last page has been moved.
#[test]
fn a_swap_that_is_cut_off_is_no_trial() {
    let images = Images { old: Hasty::image(OLD, 1320), new: Hasty::image(NEW, 1528) };
    let mut marked = board_with(&images.old);
    receive(&mut marked, &images.new).unwrap();
    let mut whole = marked.clone();
    assert_eq!(runs(Hasty::boot(&mut whole)), Some(NEW));
    assert!(slot(&mut whole).condition().unwrap().trial);
    for step in 0..whole.steps() - marked.steps() {
        let mut flash = marked.clone();
        flash.cut_after(step, Tear::Nothing);
        let _ = Hasty::boot(&mut flash);
        flash.restore_power();
        assert!(!slot(&mut flash).condition().unwrap().trial, "{step}");
    }
}

/// A confirmation says first that the swap no longer counts: cut off behind that, the image is no longer on
/// trial, and stays.
#[test]
fn a_confirmation_that_has_begun_is_one() {
    let images = Images { old: Hasty::image(OLD, 1320), new: Hasty::image(NEW, 1528) };
    let mut trial = board_with(&images.old);
    receive(&mut trial, &images.new).unwrap();
    assert_eq!(runs(Hasty::boot(&mut trial)), Some(NEW));
    for (words, is_trial, stays) in [(0, true, OLD), (1, false, NEW)] {
        let mut flash = trial.clone();
        flash.cut_after(words, Tear::Nothing);
        slot(&mut flash).confirm().unwrap_err();
        flash.restore_power();
        assert_eq!(slot(&mut flash).condition().unwrap().trial, is_trial, "{words}");
        let slots = MAP.dfu.start as usize..MAP.dfu.end as usize;
        assert!(all(&mut flash)[slots.clone()] == all(&mut trial)[slots], "nothing else was written");
        assert_eq!(runs(Hasty::boot(&mut flash)), Some(stays), "{words}");
    }
}

fn all(flash: &mut Flash) -> Vec<u8> {
    let mut bytes = vec![0; flash.capacity()];
    flash.read(0, &mut bytes).unwrap();
    bytes
}
