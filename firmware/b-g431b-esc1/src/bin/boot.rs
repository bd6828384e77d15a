//! The bootloader of the B-G431B-ESC1: swaps, reverts and verifies in the flash, and enters the image that
//! its owner has signed. It has no CAN: the application receives.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_rt::entry;
    use narx_b_g431b_esc1::chip::memory::Region;
    use narx_b_g431b_esc1::chip::{self, reset};
    use narx_b_g431b_esc1::flash_map::{HARDWARE, MAP, SIZE, START};
    use narx_boot::{Board, Outcome, boot, key};

    const BOARD: Board = Board { hardware: HARDWARE, key: key::chosen() };

    #[entry]
    fn main() -> ! {
        // From reset on no output of TIM1 is on, and the gate drivers pull their inputs down.
        chip::start_for_boot();
        match boot(&mut Region::new(0..SIZE), &MAP, &BOARD) {
            Ok(Outcome::Run { .. }) => reset::enter(START + MAP.entry()),
            Ok(Outcome::Stay(_)) | Err(_) => chip::stay(),
        }
    }
}
