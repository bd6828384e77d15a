//! Counts the instructions of every `Drive::step` in recordings: `count FILE...`, under `-icount shift=7`.
//!
//! Prints `vector STEM TICKS TOTAL WORST` for every file, then `state NUMBER TICKS TOTAL WORST` for every state (Table 6)
//! over all files, and `bracket N`, what the measurement cost itself and was taken off. A tick counts for the state in which
//! it ends. Steps that answer anything else than what was recorded are not counted: cheaper must mean the same bits.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
use narx_firmware::boards::qemu::{ARGUMENTS_MAX, RECORDING_MAX, semihosting};

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    static mut ARGUMENTS: [u8; ARGUMENTS_MAX] = [0; ARGUMENTS_MAX];
    static mut RECORDING: [u8; RECORDING_MAX] = [0; RECORDING_MAX];
    semihosting::exit(image::run(semihosting::arguments(ARGUMENTS), RECORDING))
}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_semihosting::hprintln;
    use narx_core::motor::{Drive, Event, PwmCommand, Samples, Status};
    use narx_core::recording::{Recording, ReplayError, Replayable, replay_with};
    use narx_firmware::boards::qemu::instructions::{self, Sum};
    use narx_firmware::boards::qemu::{semihosting, stem};
    use serde::Deserialize;

    /// States of the drive (Table 6).
    const STATES: usize = 8;

    /// Counts all files; false if one could not be.
    pub(crate) fn run<'a>(arguments: impl Iterator<Item = &'a str>, buffer: &mut [u8]) -> bool {
        let Some(mut peripherals) = cortex_m::Peripherals::take() else { return false };
        let bracket = instructions::start(&mut peripherals.SYST);
        let mut states = [Sum::default(); STATES];
        let mut success = true;
        for path in arguments {
            let stem = stem(path);
            match semihosting::read_file(path, buffer) {
                Ok(bytes) => match count(bytes, bracket, &mut states) {
                    Ok((sum, true)) => hprintln!("vector {} {}", stem, sum),
                    Ok((_, false)) => {
                        hprintln!("{} error the outputs are not the recorded ones", stem);
                        success = false;
                    }
                    Err(error) => {
                        hprintln!("{} error {}", stem, error);
                        success = false;
                    }
                },
                Err(error) => {
                    hprintln!("{} error {} {}", stem, path, error);
                    success = false;
                }
            }
        }
        for (number, sum) in states.iter().enumerate().filter(|(_, sum)| sum.ticks > 0) {
            hprintln!("state {} {}", number, sum);
        }
        hprintln!("bracket {}", bracket);
        success
    }

    fn count(bytes: &[u8], bracket: u32, states: &mut [Sum; STATES]) -> Result<(Sum, bool), ReplayError> {
        let mut sum = Sum::default();
        let outcome = replay_with::<Metered>(&Recording::open(bytes)?, |metered, _, _| {
            let instructions = metered.instructions.saturating_sub(bracket);
            sum.add(instructions);
            if let Some(state) = states.get_mut(metered.drive.state() as usize) {
                state.add(instructions);
            }
        })?;
        Ok((sum, outcome.is_identical()))
    }

    /// A drive whose steps are counted.
    #[derive(Deserialize)]
    struct Metered {
        drive: Drive,
        /// Of the last step, the measurement's own included.
        #[serde(skip)]
        instructions: u32,
    }

    impl Replayable for Metered {
        fn handle_event(&mut self, event: Event) {
            self.drive.handle_event(event);
        }

        fn step(&mut self, samples: &Samples) -> PwmCommand {
            let (command, instructions) = instructions::count(|| step(&mut self.drive, samples));
            self.instructions = instructions;
            command
        }

        fn poll_status(&mut self) -> Option<Status> {
            self.drive.poll_status()
        }
    }

    /// The step as one call, as an interrupt would make it.
    #[inline(never)]
    fn step(drive: &mut Drive, samples: &Samples) -> PwmCommand {
        drive.step(samples)
    }
}
