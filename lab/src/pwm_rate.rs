//! PWM rate of an experiment: its argument, and its place in the names of files and in commands.

use clap::Args;
use narx_core::motor::Board;
use narx_sim::session::parse_board;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Argument of every experiment that runs at any PWM rate.
// The structs that contain it already have a group of this name.
#[derive(Args, Clone, Debug)]
#[group(skip)]
pub struct PwmRate {
    /// PWM frequency, Hz; every period has one control tick
    #[arg(long, allow_hyphen_values = true, default_value = "10000")]
    pub pwm_rate: String,
}

impl PwmRate {
    /// Returns the bench's board at this rate.
    ///
    /// # Errors
    /// Fails with one line if the board cannot have the rate.
    pub fn board(&self) -> Result<Board, String> {
        parse_board(&self.pwm_rate).map_err(|error| format!("--pwm-rate {}: {error}", self.pwm_rate))
    }

    /// Runs an experiment on that board; it answers whether its goals are met. Exit code 1 if they are not,
    /// or if it could not run, with a line about the reason.
    pub(crate) fn run(&self, experiment: impl FnOnce(&Board) -> Result<bool, String>) -> ExitCode {
        match self.board().and_then(|board| experiment(&board)) {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::FAILURE,
            Err(reason) => {
                eprintln!("{reason}");
                ExitCode::FAILURE
            }
        }
    }
}

/// Default rate, Hz: files that say nothing were measured at it.
pub(crate) const fn default() -> u32 {
    Board::BENCH.tick_rate
}

/// Returns the rate as an argument to append to a command; nothing at the default rate.
pub(crate) fn argument(board: &Board) -> String {
    if board.tick_rate == default() { String::new() } else { format!(" --pwm-rate {}", board.tick_rate) }
}

/// Returns the path of a file with results at this rate: `quality.json`, at 20 kHz `quality-20kHz.json`.
pub(crate) fn file(path: &Path, board: &Board) -> PathBuf {
    if board.tick_rate == default() {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{}kHz.{extension}", kilohertz(board)))
}

/// The rate in kHz.
pub(crate) fn kilohertz(board: &Board) -> f64 {
    f64::from(board.tick_rate) / 1e3
}

/// Duration of a control tick, s.
pub(crate) fn tick(board: &Board) -> f64 {
    1.0 / f64::from(board.tick_rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_commands_name_every_rate_but_the_default() {
        let named = |rate: &str| {
            let board = PwmRate { pwm_rate: rate.into() }.board().unwrap();
            (file(Path::new("evidence/starts.json"), &board), argument(&board))
        };
        assert_eq!(named("10000"), ("evidence/starts.json".into(), String::new()));
        assert_eq!(named("20000"), ("evidence/starts-20kHz.json".into(), " --pwm-rate 20000".into()));
        assert_eq!(named("12500"), ("evidence/starts-12.5kHz.json".into(), " --pwm-rate 12500".into()));
    }

    #[test]
    fn a_rate_that_the_board_cannot_have_is_refused_in_one_line() {
        for rate in ["7999", "50001", "-1", "1e4", "fast", ""] {
            let refused = PwmRate { pwm_rate: rate.into() }.board().unwrap_err();
            assert_eq!(refused, format!("--pwm-rate {rate}: must be a whole number from 8000 to 50000 Hz"));
        }
    }
}
