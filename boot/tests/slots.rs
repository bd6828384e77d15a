//! Tests of which image the bootloader enters, and what it does to the slots before.

use crate::support::{
    HARDWARE, Hasty, MAP, NEW, OLD, OWNER, PAGE, active, board_with, boot, image, image_by, receive, runs,
    slot, version,
};
use embedded_storage::nor_flash::NorFlashErrorKind;
use narx_boot::sign::SecretKey;
use narx_boot::{Event, Header, HeaderError, ImageError, Outcome, Refused, SlotError, Verdict, Version};
use narx_sim::flash::Tear;

fn event(outcome: &Outcome) -> Option<Event> {
    match outcome {
        Outcome::Run { event, .. } => Some(*event),
        Outcome::Stay(_) => None,
    }
}

/// A candidate runs on trial; confirmed it stays, and not confirmed the one before comes back.
#[test]
fn a_trial_ends_by_confirmation_or_revert() {
    let old = image(OLD, 1000);
    let mut flash = board_with(&old);
    receive(&mut flash, &image(NEW, 1408)).unwrap();
    assert!(slot(&mut flash).condition().unwrap().marked);
    let outcome = boot(&mut flash).unwrap();
    assert_eq!((event(&outcome), runs(Ok(outcome))), (Some(Event::Swapped), Some(NEW)));

    let mut tried = flash.clone();
    assert!(slot(&mut tried).condition().unwrap().trial);
    assert_eq!(event(&boot(&mut tried).unwrap()), Some(Event::Reverted));
    assert_eq!(slot(&mut tried).condition().unwrap().verdict, Some(Verdict::Reverted));
    assert_eq!(runs(boot(&mut tried)), Some(OLD));
    assert_eq!(active(&mut tried, old.len()), old);

    slot(&mut flash).confirm().unwrap();
    for _ in 0..2 {
        let outcome = boot(&mut flash).unwrap();
        assert_eq!((event(&outcome), runs(Ok(outcome))), (Some(Event::Unchanged), Some(NEW)));
    }
}

/// The slot holds the image before while another is on trial: nothing may write there.
#[test]
fn a_trial_keeps_the_slot() {
    let mut flash = board_with(&Hasty::image(OLD, 1000));
    receive(&mut flash, &Hasty::image(NEW, 1000)).unwrap();
    assert_eq!(runs(Hasty::boot(&mut flash)), Some(NEW));
    assert_eq!(receive(&mut flash, &Hasty::image(NEW, 1000)), Err(SlotError::Trial));
    assert_eq!(slot(&mut flash).mark(), Err(SlotError::Trial));
    assert_eq!(runs(Hasty::boot(&mut flash)), Some(OLD));
}

/// The start of a new transfer takes the mark back: nothing is swapped in until the image is marked anew.
#[test]
fn what_begins_takes_the_mark_back() {
    let mut flash = board_with(&Hasty::image(OLD, 1000));
    receive(&mut flash, &Hasty::image(NEW, 1000)).unwrap();
    slot(&mut flash).begin().unwrap();
    assert_eq!(event(&Hasty::boot(&mut flash).unwrap()), Some(Event::Unchanged));
}

#[test]
fn a_board_without_an_image_stays() {
    let mut flash = board_with(&[]);
    assert_eq!(boot(&mut flash), Ok(Outcome::Stay(ImageError::Header(HeaderError::Magic))));
    let mut broken = image(OLD, 1000);
    broken[700] ^= 1;
    let mut flash = board_with(&broken);
    assert_eq!(boot(&mut flash), Ok(Outcome::Stay(ImageError::Signature)));
    // What can be received brings the board back to life, whatever its age.
    let older = version(0, 1, 0, 0);
    receive(&mut flash, &image(older, 1408)).unwrap_err();
    slot(&mut flash).mark().unwrap();
    assert_eq!(runs(boot(&mut flash)), Some(older));
    // Nobody has confirmed it, but there is nothing to go back to.
    assert_eq!(event(&boot(&mut flash).unwrap()), Some(Event::Kept));
}

/// A bit that the flash loses in the swap costs the swap, not the board.
#[test]
fn an_image_that_is_spoiled_on_trial_is_swapped_back() {
    let mut flash = board_with(&image(OLD, 1000));
    receive(&mut flash, &image(NEW, 1000)).unwrap();
    boot(&mut flash).unwrap();
    flash.load(MAP.active.start + 600, &[0; 8]);
    assert_eq!(runs(boot(&mut flash)), Some(OLD));
}

/// A bit that is lost before the swap is over, wherever a power cut has left it, in what was moved already:
/// both images are there, and it is swapped back.
#[test]
fn an_image_that_is_spoiled_in_the_swap_is_swapped_back() {
    let mut marked = board_with(&Hasty::image(OLD, 1496));
    receive(&mut marked, &Hasty::image(NEW, 1496)).unwrap();
    let mut seen = Vec::new();
    for step in (0..600).step_by(20) {
        let mut flash = marked.clone();
        flash.cut_after(step, Tear::Nothing);
        let cut = Hasty::boot(&mut flash).is_err();
        flash.restore_power();
        // The last page of an image is the first that is moved.
        let end = active(&mut flash, 2008);
        let moved = end[1999..] == Hasty::image(NEW, 1496)[1999..];
        if cut && moved {
            flash.load(MAP.active.start + 2000, &[0; 8]);
            let outcome = Hasty::boot(&mut flash).unwrap();
            seen.push((event(&outcome), runs(Ok(outcome))));
        }
    }
    assert!(seen.len() > 5, "{seen:?}");
    assert!(seen.iter().all(|it| *it == (Some(Event::Reverted), Some(OLD))), "{seen:?}");
}

/// Candidates that must not run, whoever has marked them: the running image stays, and is told why.
#[test]
fn a_bad_candidate_is_never_swapped_in() {
    let good = image(NEW, 1000);
    let with = |at: usize, bytes: &[u8]| {
        let mut image = good.clone();
        image[at..at + bytes.len()].copy_from_slice(bytes);
        image
    };
    let body = good.len() as u32 - 512;
    let cases: [(&str, Vec<u8>, Refused); 11] = [
        ("nothing", vec![], Refused::NoImage),
        ("other bytes", vec![0; 600], Refused::NoImage),
        ("another format", with(8, &[0, 2]), Refused::NoImage),
        ("no body", with(24, &0_u32.to_be_bytes()), Refused::NoImage),
        ("half a word more", with(24, &(body + 4).to_be_bytes()), Refused::NoImage),
        ("longer than the slot", with(24, &(4 * PAGE as u32).to_be_bytes()), Refused::TooLong),
        ("shorter than signed", with(24, &(body - 8).to_be_bytes()), Refused::Signature),
        ("cut off", good[..900].to_vec(), Refused::Signature),
        ("another key", image_by(&SecretKey([8; 32]), HARDWARE, NEW, 1000), Refused::Signature),
        ("another board", image_by(&OWNER, HARDWARE ^ 1, NEW, 1000), Refused::Hardware),
        ("older by a build", image(Version { build: OLD.build - 1, ..OLD }, 1000), Refused::Older),
    ];
    for (what, bytes, kind) in cases {
        let mut flash = board_with(&image(OLD, 1000));
        flash.load(MAP.dfu.start, &bytes);
        slot(&mut flash).mark().unwrap();
        let outcome = boot(&mut flash).unwrap();
        let Some(Event::Refused(error)) = event(&outcome) else { panic!("{what}: {outcome:?}") };
        assert_eq!((error.kind(), runs(Ok(outcome))), (kind, Some(OLD)), "{what}");
        assert_eq!(slot(&mut flash).condition().unwrap().verdict, Some(Verdict::Refused(kind)), "{what}");
        assert_eq!(event(&boot(&mut flash).unwrap()), Some(Event::Unchanged), "{what}: forgotten");
    }
}

/// An update is accepted with the running version, as a repair, or with a higher one, whichever of its
/// numbers is higher.
#[test]
fn versions_that_may_follow() {
    let higher = [OLD, version(1, 2, 3, 5), version(1, 2, 4, 0), version(1, 3, 0, 0), version(2, 0, 0, 0)];
    for version in higher {
        let mut flash = board_with(&Hasty::image(OLD, 1000));
        receive(&mut flash, &Hasty::image(version, 1000)).unwrap();
        assert_eq!(event(&Hasty::boot(&mut flash).unwrap()), Some(Event::Swapped), "{version}");
    }
}

/// The application says before the reset what the bootloader would say after it.
#[test]
fn the_application_refuses_what_it_can() {
    let cases = [
        (image_by(&OWNER, HARDWARE ^ 1, NEW, 1000), ImageError::Hardware(HARDWARE ^ 1)),
        (image(version(1, 2, 2, 9), 1000), ImageError::Older(version(1, 2, 2, 9))),
        (vec![0xFF; 600], ImageError::Header(HeaderError::Magic)),
        (image(NEW, 1000)[..1000].to_vec(), ImageError::TooLong(1512)),
    ];
    for (bytes, error) in cases {
        let mut flash = board_with(&image(OLD, 1000));
        assert_eq!(receive(&mut flash, &bytes), Err(SlotError::Image(error)));
        assert!(!slot(&mut flash).condition().unwrap().marked);
    }
}

/// Every bit of a small image, in header, signature and body.
#[test]
fn every_bit_of_an_image_counts() {
    let good = Hasty::image(NEW, 64);
    for bit in 0..good.len() * 8 {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let mut flash = board_with(&bytes);
        assert!(matches!(Hasty::boot(&mut flash), Ok(Outcome::Stay(_))), "bit {bit}");
    }
    assert_eq!(runs(Hasty::boot(&mut board_with(&good))), Some(NEW));
}

/// Bits of an image with a real signature: some of a large image, and all of two bytes of each half of the
/// signature.
#[test]
fn no_bit_of_a_signature_is_spare() {
    // It fills the slot.
    let good = image(NEW, 1536);
    assert_eq!((good.len() as u32, runs(boot(&mut board_with(&good)))), (MAP.room(), Some(NEW)));
    let signature = (448..512).step_by(16).flat_map(|byte| (0..8).map(move |bit| byte * 8 + bit));
    // The last bits of both halves, which arithmetic could lose.
    let last = [480 * 8 - 1, 480 * 8 - 2, 512 * 8 - 1, 512 * 8 - 2, 512 * 8 - 3, 512 * 8 - 4];
    for bit in signature.chain(last).chain((0..good.len() * 8).step_by(997)) {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(matches!(boot(&mut board_with(&bytes)), Ok(Outcome::Stay(_))), "bit {bit}");
    }
}

#[test]
fn a_header_says_what_it_was_made_of() {
    let header = Header { hardware: 0x1234_5678, version: version(255, 1, 65535, 2), length: 8 };
    let bytes = OWNER.sign(header, &[0; 8]);
    assert_eq!(Header::decode(&bytes), Ok(header));
    assert_eq!(&bytes[..8], b"NARXIMG\0");
    assert_eq!(header.version.to_string(), "255.1.65535+2");
    assert_eq!("255.1.65535+2".parse(), Ok(header.version));
    for text in ["", "1", "1.2", "1.2.3.4", "256.0.0", "1.2.-3", "1.2.3+65536", "1.2.3+", " 1.2.3", "a.b.c"] {
        assert!(text.parse::<Version>().is_err(), "{text:?}");
    }
}

/// From one word to what 32 bits count, header included.
#[test]
fn lengths_that_a_body_can_have() {
    let with = |length| {
        let mut bytes = [0; 512];
        let signed = Header { hardware: HARDWARE, version: OLD, length }.encode();
        bytes[..signed.len()].copy_from_slice(&signed);
        Header::decode(&bytes).map(|header| header.length)
    };
    let most = u32::MAX - 519;
    for length in [8, 16, 1 << 20, most] {
        assert_eq!(with(length), Ok(length));
    }
    for length in [0, 4, 12, most + 4, most + 8, u32::MAX] {
        assert_eq!(with(length), Err(HeaderError::Length(length)));
    }
}

/// The first number that is not known is told.
#[test]
fn other_formats_are_named() {
    let mut bytes = image(NEW, 8);
    bytes[8..10].copy_from_slice(&0x0203_u16.to_be_bytes());
    assert_eq!(Header::of(&bytes), Err(HeaderError::Format(0x0203)));
}

/// A file is an image if it is as long as it says.
#[test]
fn a_file_is_a_whole_image() {
    let file = image(NEW, 1000);
    let wanted = file.len() as u32;
    assert_eq!(Header::of(&file).map(|header| (header.version, header.image_length())), Ok((NEW, wanted)));
    let longer = [file.as_slice(), &[0; 8]].concat();
    for (file, wanted) in [(&file[..511], 512), (&file[..1504], wanted), (&longer, wanted)] {
        assert_eq!(Header::of(file), Err(HeaderError::File { length: file.len(), wanted }));
    }
}

/// The verdict is a word of the state pages' end: its code, and that inverted in every other byte. Written by
/// halves it says nothing.
#[test]
fn a_verdict_that_was_cut_off_says_nothing() {
    let at = MAP.state.end - 8;
    for (word, expected) in [
        ([4, 0xFB, 0xFB, 0xFB, 0xFB, 0xFB, 0xFB, 0xFB], Some(Verdict::Refused(Refused::Signature))),
        ([4, 0xFB, 0xFB, 0xFB, 0xFB, 0xFB, 0xFB, 0xFF], None),
        ([4, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF], None),
        // Nothing that a bootloader of this version says.
        ([6, 0xF9, 0xF9, 0xF9, 0xF9, 0xF9, 0xF9, 0xF9], None),
    ] {
        let mut flash = board_with(&image(OLD, 1000));
        flash.load(at, &word);
        assert_eq!(slot(&mut flash).condition().unwrap().verdict, expected, "{word:x?}");
    }
}

/// The slot has as many pages as an image has room for, though its flash goes on behind them: one more is the
/// swap's, and no part of any image.
#[test]
fn nothing_is_written_beyond_the_slot() {
    let mut flash = board_with(&image(OLD, 1000));
    let room = MAP.room();
    let beyond = Err(SlotError::Flash(NorFlashErrorKind::OutOfBounds));
    let mut slot = slot(&mut flash);
    let before = slot.flash().clone();
    for offset in [room, room + PAGE as u32, u32::MAX - 7] {
        assert_eq!(slot.erase(offset), beyond, "{offset}");
        assert_eq!(slot.write(offset, &[0; 8]), beyond, "{offset}");
        assert_eq!(slot.read(offset, &mut [0; 8]), beyond, "{offset}");
    }
    assert_eq!(slot.write(room - 8, &[0; 16]), beyond, "half of it");
    assert_eq!(slot.flash().steps(), before.steps(), "nothing was done");
    assert_eq!((slot.erase(room - PAGE as u32), slot.write(room - 8, &[0; 8])), (Ok(()), Ok(())));
}
