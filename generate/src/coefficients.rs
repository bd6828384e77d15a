//! Coefficients of an example in C: `ffi/examples/coefficients.h`, as `narx coefficients` prints them.

use crate::Made;
use narx_core::initialiser;
use narx_core::motor::{Board, Coefficients};
use narx_sim::commissioning::{Mode, Nameplate};
use narx_sim::presets::preset;
use std::path::Path;

const PATH: &str = "ffi/examples/coefficients.h";
/// Motor of the example, on its nominal voltage, with hall sensors.
const MOTOR: &str = "bly172s-24v";

/// Makes the file.
///
/// # Errors
/// Fails if the motor cannot be commissioned.
pub fn make(_: &Path) -> Result<Made, String> {
    let preset = preset(MOTOR).ok_or_else(|| format!("there is no preset {MOTOR}"))?;
    let plate = Nameplate {
        motor: preset.motor,
        rated_current: preset.data.rated_current,
        supply: preset.data.nominal_voltage,
        open_loop_speed: None,
    };
    let commissioning = plate.commission(Mode::Hall).map_err(|error| error.to_string())?;
    let coefficients =
        Coefficients::build(&commissioning.parameters, &Board::BENCH).map_err(|error| error.to_string())?;
    let mut text = String::new();
    initialiser::header(&mut text, "coefficients", &coefficients).map_err(|error| error.to_string())?;
    Ok(Made { summary: format!("coefficients of {MOTOR}"), files: vec![(PATH.into(), text)] })
}
