//! Coefficients as constants in C: of an example, as `narx coefficients` prints them
//! (`ffi/examples/coefficients.h`), and of each block, for the tests (`tests/c/ready.h`).

use crate::Made;
use narx_core::blocks::{
    Commutation, CommutationSettings, Fault, FaultSettings, Hall, HallSettings, Pi, PiSettings, Ramp,
    RampSettings, SettingError, StateMachine, StateSettings, ZeroCrossing, ZeroCrossingSettings,
};
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::initialiser::{self, define};
use narx_core::motor::gain::Gain;
use narx_core::motor::{Board, Coefficients};
use narx_sim::presets::preset;
use std::path::Path;

const EXAMPLE: &str = "ffi/examples/coefficients.h";
const READY: &str = "tests/c/ready.h";
/// Motor of the example, on its nominal voltage, with hall sensors.
const MOTOR: &str = "bly172s-24v";

/// Makes both files.
///
/// # Errors
/// Fails if the motor cannot be commissioned.
pub fn make(_: &Path) -> Result<Made, String> {
    let preset = preset(MOTOR).ok_or_else(|| format!("there is no preset {MOTOR}"))?;
    let plate = Nameplate {
        motor: preset.motor.figures(),
        rated_current: preset.data.rated_current,
        supply: preset.data.nominal_voltage,
        open_loop_speed: None,
    };
    let commissioning = plate.commission(Mode::Hall).map_err(|error| error.to_string())?;
    let coefficients =
        Coefficients::build(&commissioning.parameters, &Board::BENCH).map_err(|error| error.to_string())?;
    let mut text = String::new();
    initialiser::header(&mut text, "coefficients", &coefficients).map_err(|error| error.to_string())?;
    let ready = ready().map_err(|error| error.to_string())?;
    let files = vec![(EXAMPLE.into(), text), (READY.into(), ready)];
    Ok(Made { summary: format!("coefficients of {MOTOR} and of 7 blocks"), files })
}

/// Renders the coefficients of each block, for the settings in `tests/c/blocks.c`.
fn ready() -> Result<String, SettingError> {
    let pi = PiSettings {
        proportional: Gain::new(16_384, 15).unwrap_or_default(),
        integral: Gain::new(5 << 24, 24).unwrap_or_default(),
        step_rate: 1000,
        minimum: 0,
        maximum: 6 << 16,
    };
    let ramp = RampSettings { rate: 100 << 16, step_rate: 1000 };
    let commutation = CommutationSettings { advance_cdeg: 500, earliest: 8192 };
    let mut text =
        String::from("/* Ready-made coefficients, as narx prints them, of the settings in blocks.c. */\n\n");
    let to = &mut text;
    // Writing into a string cannot fail.
    let _ = define(to, "narx_pi_ready_t", "pi_ready", Pi::build(&pi)?.ready());
    let _ = define(to, "narx_ramp_ready_t", "ramp_ready", Ramp::build(&ramp)?.ready());
    let _ = define(
        to,
        "narx_commutator_coefficients_t",
        "commutation_ready",
        Commutation::build(&commutation)?.ready(),
    );
    let hall = Hall::build(&HallSettings::default())?;
    let _ = define(to, "narx_hall_ready_t", "hall_ready", hall.ready());
    let detector = ZeroCrossing::build(&ZeroCrossingSettings::default())?;
    let _ = define(to, "narx_zero_crossing_ready_t", "zero_crossing_ready", detector.ready());
    let fault = Fault::build(&FaultSettings::default())?;
    let _ = define(to, "narx_protection_coefficients_t", "fault_ready", fault.ready());
    let machine = StateMachine::build(&StateSettings::default())?;
    let _ = define(to, "narx_machine_coefficients_t", "state_ready", machine.ready());
    Ok(text)
}
