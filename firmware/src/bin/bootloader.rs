//! The bootloader of the emulated board: swaps, reverts and verifies in the slots, and enters the image that
//! is signed. It says what it does, and stays where there is no such image.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hprintln;
    use narx_boot::{Board, Outcome, boot, hardware, key};
    use narx_firmware::boards::qemu::slots::{self, MAP, Slots};

    /// Whoever has the emulator may have his program run in it.
    const BOARD: Board = Board { hardware: hardware::QEMU, key: key::TEST_ONLY };

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
