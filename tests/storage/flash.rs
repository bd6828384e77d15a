//! Tests that the simulated flash behaves as a NOR flash.

use crate::support::{blank, now};
use embedded_storage_async::nor_flash::{NorFlash, ReadNorFlash};
use narx_sim::flash::{FlashError, KBYTE_512, MBYTE_256, Tear, Timing};

fn read<const N: usize>(chip: &mut crate::support::Chip, at: u32) -> [u8; N] {
    let mut bytes = [0; N];
    now(chip.read(at, &mut bytes)).unwrap();
    bytes
}

#[test]
fn programs_clear_bits_and_erases_set_them() {
    let mut chip = blank(KBYTE_512);
    assert_eq!(read(&mut chip, 100), [0xFF; 4]);
    now(chip.write(100, &[0xF0, 0x12])).unwrap();
    now(chip.write(100, &[0x3C])).unwrap();
    assert_eq!(read(&mut chip, 99), [0xFF, 0x30, 0x12, 0xFF]);
    assert_eq!(chip.counts().lost_bits, 2, "bits 2 and 3 stay 0");
    now(chip.erase(0, 4096)).unwrap();
    assert_eq!(read(&mut chip, 100), [0xFF; 4]);
    assert_eq!(
        (now(chip.erase(100, 4096)), now(chip.erase(0, 1 << 20))),
        (Err(FlashError::Range), Err(FlashError::Range))
    );
    assert_eq!(now(chip.write((512 << 10) - 1, &[0, 0])), Err(FlashError::Range));
}

#[test]
fn time_is_that_of_pages_subsectors_and_sectors() {
    let Timing { command, byte, program, subsector, sector } = Timing::TYPICAL;
    let mut chip = blank(MBYTE_256);
    now(chip.write(200, &[0; 100])).unwrap();
    assert_eq!(chip.take_busy(), 2 * (command + program) + 100 * byte, "a page border lies between");
    now(chip.erase(0x1_0000 - 4096, 0x2_0000)).unwrap();
    assert_eq!(chip.take_busy(), 2 * command + subsector + sector);
    assert_eq!(chip.counts().erases, 17);
    // The far end needs addresses of 32 bits.
    now(chip.write((256 << 20) - 2, &[1, 2])).unwrap();
    assert_eq!(read(&mut chip, (256 << 20) - 2), [1, 2]);
}

#[test]
fn a_cut_strikes_where_it_is_told() {
    for (tear, third) in [(Tear::Nothing, Some(0xFF)), (Tear::Partial, None), (Tear::Garbage, None)] {
        let mut chip = blank(KBYTE_512);
        chip.cut_after(2, tear);
        assert_eq!(now(chip.write(0, &[0, 1, 2, 3])), Err(FlashError::PowerLost));
        assert_eq!(now(chip.read(0, &mut [0])), Err(FlashError::PowerLost));
        assert!(chip.is_off());
        chip.restore_power();
        let bytes: [u8; 5] = read(&mut chip, 0);
        assert_eq!((bytes[0], bytes[1], bytes[4]), (0, 1, 0xFF), "{tear:?}");
        assert!(third.is_none_or(|third| bytes[2] == third));
        assert!(tear != Tear::Partial || bytes[2] & 2 == 2, "what is to stay 1 stays: {:x}", bytes[2]);
    }
}
