//! Replays recordings on the emulated board: `replay [--ticks N] FILE...`.
//!
//! Prints for every file `STEM TICKS DIGEST RECORDED`; with `--ticks`, of its first N ticks, `STEM TICKS
//! DIGEST - ` and the last tick's outputs; `STEM error MESSAGE` for one that cannot be replayed, and then
//! ends with exit code 1.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
use narx_firmware::boards::qemu::{ARGUMENTS_MAX, semihosting};

/// Bytes of a recording that it can hold: 10^6 ticks are 4.3 MB.
#[cfg(target_os = "none")]
const RECORDING_MAX: usize = 12 << 20;

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
    use narx_core::recording::{ReplayError, replay_any, replay_any_until};
    use narx_firmware::boards::qemu::{semihosting, stem};

    /// Replays every file; false if one could not be.
    pub(crate) fn run<'a>(arguments: impl Iterator<Item = &'a str>, buffer: &mut [u8]) -> bool {
        let mut arguments = arguments.peekable();
        let mut ticks = None;
        if arguments.next_if_eq(&"--ticks").is_some() {
            ticks = arguments.next().and_then(|number| number.parse().ok());
            if ticks.is_none() {
                hprintln!("--ticks wants a number");
                return false;
            }
        }
        let mut success = true;
        for path in arguments {
            let stem = stem(path);
            match semihosting::read_file(path, buffer) {
                Ok(bytes) => {
                    if let Err(error) = print_outcome(stem, bytes, ticks) {
                        hprintln!("{} error {}", stem, error);
                        success = false;
                    }
                }
                Err(error) => {
                    hprintln!("{} error {} {}", stem, path, error);
                    success = false;
                }
            }
        }
        success
    }

    fn print_outcome(stem: &str, bytes: &[u8], ticks: Option<u64>) -> Result<(), ReplayError> {
        let Some(ticks) = ticks else {
            let outcome = replay_any(bytes)?;
            hprintln!("{} {} {:016x} {:016x}", stem, outcome.ticks, outcome.digest, outcome.recorded_digest);
            return Ok(());
        };
        let prefix = replay_any_until(bytes, ticks)?;
        match prefix.last {
            Some(outputs) => hprintln!("{} {} {:016x} - {}", stem, prefix.ticks, prefix.digest, outputs),
            None => hprintln!("{} {} {:016x} -", stem, prefix.ticks, prefix.digest),
        }
        Ok(())
    }
}
