//! Texts that a bootloader writes, where it has a line to write on, and that a tool prints about a file.

use crate::support::{HARDWARE, version};
use narx_boot::{Event, Header, HeaderError, ImageError, MapError, NoVersion, Outcome};

#[test]
fn outcomes() {
    let header = Header { hardware: HARDWARE, version: version(1, 2, 3, 4), length: 8 };
    let runs = |event| Outcome::Run { header, event }.to_string();
    let cases = [
        (Event::Unchanged, "version 1.2.3+4"),
        (Event::Swapped, "candidate swapped in, on trial; version 1.2.3+4"),
        (Event::Reverted, "candidate not confirmed, swapped back; version 1.2.3+4"),
        (
            Event::Refused(ImageError::Hardware(0x4E58_0001)),
            "candidate refused: for hardware 4E580001h; version 1.2.3+4",
        ),
        (Event::Kept, "candidate not confirmed, and nothing to go back to; version 1.2.3+4"),
    ];
    for (event, text) in cases {
        assert_eq!(runs(event), text);
    }
    let stays = Outcome::Stay(ImageError::Header(HeaderError::Magic));
    assert_eq!(stays.to_string(), "no image to run: not an image: it does not begin with NARXIMG");
}

/// Each names the thing and its value.
#[test]
fn errors() {
    let cases: [(&dyn std::error::Error, &str); 13] = [
        (&ImageError::TooLong(1512), "1512 bytes do not fit the slot"),
        (&ImageError::Signature, "the signature is not that of its bytes by the board's key"),
        (&ImageError::Older(version(1, 0, 0, 7)), "version 1.0.0+7 is older than the one that runs"),
        (&HeaderError::File { length: 3, wanted: 512 }, "the file has 3 bytes; the image needs 512"),
        (&HeaderError::Format(2), "format 2, only 1 is known"),
        (&HeaderError::Length(12), "a body of 12 bytes: not a multiple of 8 from 8 on"),
        (&HeaderError::Magic, "not an image: it does not begin with NARXIMG"),
        (&MapError::Capacity, "the map ends behind the flash"),
        (&MapError::Dfu, "dfu is not one page longer than active"),
        (&MapError::State, "no room for the progress of a swap"),
        (&MapError::WriteSize, "the flash does not program 8 to 32 bytes at once"),
        (
            &MapError::Range,
            "a range that is empty, not of whole pages, or begins before the one before it ends",
        ),
        (&NoVersion, "not MAJOR.MINOR.PATCH or MAJOR.MINOR.PATCH+BUILD, up to 255.255.65535+65535"),
    ];
    for (error, text) in cases {
        assert_eq!(error.to_string(), text);
    }
}
