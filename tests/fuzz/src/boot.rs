//! Target: the bootloader with any slots and state pages, swaps that are cut off anywhere, and headers of
//! files.

use crate::board::{Flash, HARDWARE, MAP, blank, boot, image, slot, version};
use crate::program::Program;
use narx_boot::{Event, HEADER_LENGTH, Header, Outcome, SIGNED_LENGTH};
use narx_sim::flash::Tear;

/// Runs an input. First byte even: a file. Odd: steps that change the flash, then two boots.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    if program.byte().is_multiple_of(2) {
        file(program.0);
        return;
    }
    let mut life = Life { flash: blank(), tampered: false, booted: false, running: false };
    while !program.is_over() {
        life.handle(&mut program);
    }
    let [first, second] = [life.boot(), life.boot()];
    if life.tampered {
        return;
    }
    match (first, second) {
        // The running image stays; a trial that was not confirmed ends, and the image that replaces it was
        // verified, too.
        (Outcome::Run { header, event }, Outcome::Run { header: after, event: next }) => {
            let reverts = event == Event::Swapped && next == Event::Reverted;
            assert!(reverts || header == after, "{header:?} {event:?}, then {after:?} {next:?}");
        }
        (Outcome::Stay(before), Outcome::Stay(after)) => assert_eq!(before, after),
        (first, second) => panic!("{first:?}, then {second:?}"),
    }
}

struct Life {
    flash: Flash,
    /// The flash was changed in a way in which neither the bootloader nor an application changes it: the
    /// bootloader may then stay, but never enter an image that is not signed.
    tampered: bool,
    /// True after the first run of the bootloader.
    booted: bool,
    /// An application runs: the last boot was not cut off, and entered an image.
    running: bool,
}

/// Checks that a header is decoded to the same again after its signed part was encoded.
fn file(bytes: &[u8]) {
    let Some((head, _)) = bytes.split_first_chunk::<HEADER_LENGTH>() else {
        Header::of(bytes).expect_err("shorter than a header");
        return;
    };
    let whole = Header::of(bytes);
    match Header::decode(head) {
        Ok(header) => {
            let mut again = *head;
            again[..SIGNED_LENGTH].copy_from_slice(&header.encode());
            assert_eq!(Header::decode(&again), Ok(header));
            assert_eq!(whole.is_ok(), bytes.len() == header.image_length() as usize);
        }
        Err(error) => assert_eq!(whole, Err(error)),
    }
}

impl Life {
    fn handle(&mut self, program: &mut Program<'_>) {
        let what = program.byte();
        let slots = [MAP.active.start, MAP.dfu.start, MAP.dfu.start + 512];
        match what % 8 {
            // A valid image, or one for another board.
            0 | 1 => {
                let (minor, words) = (program.byte(), program.byte());
                let hardware = if what & 0x80 != 0 { HARDWARE + 1 } else { HARDWARE };
                let image = image(hardware, version(minor), usize::from(words % 192) + 1);
                // A factory loads images before the first boot; later only the bootloader may.
                self.tampered |= self.booted;
                self.flash.load(slots[usize::from(what >> 3) % 3], &image);
            }
            2 => {
                let (at, length) = (program.word(), program.byte() % 32);
                let at = MAP.active.start + u32::from(at) % (MAP.parameters.start - MAP.active.start);
                self.tampered = true;
                self.flash.load(at, program.take(length.into()));
            }
            // State pages: words as a swap writes them, and others.
            3 => {
                let (from, count, byte) = (program.byte(), program.byte(), program.byte());
                let (from, count) = (u32::from(from % 64), usize::from(count % 64));
                let at = MAP.state.start + from * 8;
                let room = (MAP.state.end - at) as usize;
                self.tampered = true;
                self.flash.load(at, &vec![byte; (8 * count).min(room)]);
            }
            4 if self.running => {
                let mut slot = slot(&mut self.flash);
                let _ = match what >> 3 & 3 {
                    0 => slot.begin(),
                    1 | 2 => slot.mark(),
                    _ => slot.confirm(),
                };
            }
            5 if self.running => {
                let page = u32::from(program.word());
                let _ = slot(&mut self.flash).erase(page);
            }
            4..=6 => drop(self.boot()),
            // A boot that a power cut ends.
            _ => {
                let tear = [Tear::Nothing, Tear::Partial, Tear::Garbage][usize::from(what >> 3) % 3];
                self.booted = true;
                self.flash.cut_after(program.word().into(), tear);
                self.running =
                    boot(&mut self.flash).is_ok_and(|outcome| matches!(outcome, Outcome::Run { .. }));
                self.flash.restore_power();
            }
        }
    }

    /// Boots without a power cut. Once an image has run, an image must run after every boot.
    fn boot(&mut self) -> Outcome {
        let outcome = boot(&mut self.flash).expect("it has its power");
        let runs = matches!(outcome, Outcome::Run { .. });
        assert!(runs || !self.running || self.tampered, "{outcome:?} after what ran");
        (self.running, self.booted) = (runs, true);
        outcome
    }
}
