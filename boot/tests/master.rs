//! A whole update between a master and a drive, with frames that are lost.

use crate::support::{HARDWARE, Hasty, NEW, OLD, active, board_with, version};
use crate::wire::Wire;
use narx_boot::hardware;
use narx_core::bus::narmotion::update::{UpdateCode, UpdateState};
use narx_core::master::{Image, UpdateError, UpdateStage};

fn wire(bytes: Vec<u8>) -> Wire {
    let mut wire = Wire::new(board_with(&Hasty::image(OLD, 1000)), bytes);
    (0..100).for_each(|_| wire.step());
    wire
}

#[test]
fn an_image_arrives_whatever_is_lost() {
    for loss in [0, 5, 50, 200] {
        let image = Hasty::image(NEW, 1528);
        let mut wire = wire(image.clone());
        wire.loss = loss;
        wire.begin();
        assert_eq!(wire.finish(60), Some(Ok(())), "{loss} of 1000 frames lost");
        let flash = wire.drive.server.slot().flash();
        assert!(active(flash, image.len()) == image);
        // Without a loss nothing is sent twice.
        let once = image.len().div_ceil(6);
        assert!(if loss == 0 { wire.blocks == once } else { wire.blocks < 8 * once }, "{}", wire.blocks);
    }
}

/// Stages come in their order, and each ends with all of its bytes.
#[test]
fn progress_is_told() {
    let mut wire = wire(Hasty::image(NEW, 1528));
    wire.begin();
    let mut stages = vec![];
    while let Some(progress) = wire.master.update_progress() {
        assert!(progress.done <= progress.total && progress.total == 2040);
        if stages.last() != Some(&progress.stage) {
            stages.push(progress.stage);
        }
        wire.step();
    }
    use UpdateStage::{Asking, Erasing, Restarting, Sending, Verifying};
    assert_eq!(stages, [Asking, Erasing, Sending, Verifying, Restarting]);
    assert_eq!(wire.master.poll_update(), Some(Ok(())));
}

/// Images that are refused because of what the drive says before a byte is sent.
#[test]
fn an_image_that_cannot_be_is_not_sent() {
    let older = version(1, 2, 3, 3);
    let bytes = Hasty::image(NEW, 1000);
    let cases = [
        (
            Image::new(hardware::QEMU, NEW.into(), &bytes),
            UpdateError::Hardware { image: hardware::QEMU, drive: HARDWARE },
        ),
        (Image::new(HARDWARE, NEW.into(), &[0; 2049]), UpdateError::TooLong { length: 2049, room: 2048 }),
        (
            Image::new(HARDWARE, older.into(), &bytes),
            UpdateError::Older { image: older.into(), running: OLD.into() },
        ),
    ];
    for (image, error) in cases {
        let mut wire = wire(bytes.clone());
        wire.master.update(image).unwrap();
        assert_eq!(wire.finish(2), Some(Err(error)));
        assert_eq!((wire.blocks, wire.drive.server.slot().flash().steps()), (0, 0));
    }
}

#[test]
fn a_refusal_of_the_drive_is_the_end() {
    // An image that the bootloader does not believe: the drive runs the old one, and the master receives why.
    let mut bytes = Hasty::image(NEW, 1000);
    bytes[1000] ^= 1;
    let mut refused = wire(bytes);
    refused.begin();
    assert_eq!(refused.finish(10), Some(Err(UpdateError::Refused(UpdateCode::Signature))));
    // A drive that drives.
    let mut driving = wire(Hasty::image(NEW, 1000));
    driving.drive.set_state(narx_core::motor::State::HallClosedLoop);
    driving.begin();
    assert_eq!(driving.finish(2), Some(Err(UpdateError::Refused(UpdateCode::WrongState))));
}

#[test]
fn a_drive_that_is_gone_is_no_answer() {
    for (after, error) in [
        (0, UpdateError::NoAnswer),
        (40, UpdateError::Silent),
        (100, UpdateError::Silent),
        (300, UpdateError::Silent),
    ] {
        let mut wire = wire(Hasty::image(NEW, 1528));
        wire.begin();
        (0..after).for_each(|_| wire.step());
        wire.loss = 1000;
        // As long as a bootloader may take to copy two images.
        assert_eq!(wire.finish(70), Some(Err(error)), "after {after} ms");
    }
}

/// Milliseconds of an update of 2040 bytes.
fn duration() -> u64 {
    let mut wire = wire(Hasty::image(NEW, 1528));
    let start = wire.now;
    wire.begin();
    assert_eq!(wire.finish(60), Some(Ok(())));
    (wire.now - start) / 10
}

/// Once in every millisecond of an update, all of its stages among them: its questions wait meanwhile, and
/// are all answered then.
#[test]
fn a_drive_that_is_busy_for_a_while_is_no_failure() {
    for (after, busy) in (0..duration()).flat_map(|after| [(after, 500), (after, 1_900)]) {
        let image = Hasty::image(NEW, 1528);
        let mut wire = wire(image.clone());
        wire.begin();
        (0..after).for_each(|_| wire.step());
        wire.busy_until = wire.now + 10 * busy;
        assert_eq!(wire.finish(70), Some(Ok(())), "busy after {after} ms for {busy}");
        assert!(active(wire.drive.server.slot().flash(), image.len()) == image);
    }
}

/// Every question is asked several times before the first one is answered, and each is answered: no answer
/// from before is taken for a later question's, least of all for a drive that has not restarted, since a
/// second restart would bring the old image back.
#[test]
fn a_bus_that_takes_its_time_is_no_failure() {
    for milliseconds in [90, 110, 350, 700] {
        let mut wire = wire(Hasty::image(NEW, 1528));
        wire.latency = 10 * milliseconds;
        wire.begin();
        assert_eq!(wire.finish(120), Some(Ok(())), "{milliseconds} ms");
    }
}

/// Whatever it was about, and however often it was asked: a few seconds, but for a bootloader that copies.
#[test]
fn a_drive_that_is_gone_is_told_within_seconds() {
    for after in 0..duration() {
        let mut wire = wire(Hasty::image(NEW, 1528));
        wire.begin();
        (0..after).for_each(|_| wire.step());
        let stage = wire.master.update_progress().unwrap().stage;
        wire.loss = 1000;
        let start = wire.now;
        let end = wire.finish(70);
        let seconds = (wire.now - start) as f64 / 10_000.0;
        let bound = if stage == UpdateStage::Restarting { 61.0 } else { 5.2 };
        assert!(matches!(end, Some(Err(UpdateError::NoAnswer | UpdateError::Silent))), "{after} ms: {end:?}");
        assert!((1.9..bound).contains(&seconds), "{stage:?}, after {after} ms: {seconds} s");
    }
}

/// The drive restarts in the middle: it has forgotten the image, and runs what it ran.
#[test]
fn a_restart_on_the_way_is_told() {
    let mut wire = wire(Hasty::image(NEW, 1528));
    wire.begin();
    while wire.master.update_progress().unwrap().stage != UpdateStage::Sending {
        wire.step();
    }
    wire.drive.reboot();
    assert_eq!(wire.finish(5), Some(Err(UpdateError::Forgotten)));
    // And it takes the image all the same.
    wire.begin();
    assert_eq!(wire.finish(10), Some(Ok(())));
}

#[test]
fn an_abort_reaches_the_drive() {
    let mut wire = wire(Hasty::image(NEW, 1528));
    wire.begin();
    (0..100).for_each(|_| wire.step());
    wire.master.abort_update();
    assert_eq!(wire.finish(1), Some(Err(UpdateError::Aborted)));
    wire.drive.tell(narx_core::bus::narmotion::update::UpdateRequest::Status);
    let status = wire.drive.ask(narx_core::bus::narmotion::update::UpdateRequest::Status);
    assert_eq!((status.state, status.code), (UpdateState::Idle, UpdateCode::Aborted));
}
