//! The bootloader of the emulated board: swaps, reverts and verifies in the slots, and enters the image that is signed. It says what it does, and stays
//! where there is no such image.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hprintln;
    use narx_boot::{Board, Outcome, boot, key};
    use narx_firmware::boards::qemu::slots::{self, HARDWARE, MAP, Slots};

    const BOARD: Board = Board { hardware: HARDWARE, key: key::chosen() };

    #[entry]
    fn main() -> ! {
        match boot(&mut Slots::new(), &MAP, &BOARD) {
            Ok(outcome) => {
                hprintln!("bootloader: {}", outcome);
                if let Outcome::Run { .. } = outcome {
                    slots::enter();
                }
            }
            Err(failure) => hprintln!("bootloader: {:?}", failure),
        }
        loop {
            cortex_m::asm::wfi();
        }
    }
}
