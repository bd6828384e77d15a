//! A simulated motor for C programs: `narx.h` and `bench.h` in one library, because a program cannot link two
//! Rust libraries. There is one bench, and only one thread may use it.
#![cfg_attr(target_os = "none", no_std)]

use core::cell::UnsafeCell;
use narx::{narx_commutation_t, narx_pwm_command_t, narx_samples_t};
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::dictionary::Parameters;
use narx_core::motor::{Commutation, PwmCommand};
use narx_core::units::Duty;
use narx_sim::plant::{Plant, PlantConfig};
use narx_sim::presets::preset;

/// Motor on the bench.
const MOTOR: &str = "bly172s-24v";

struct Bench {
    plant: Plant,
    parameters: Parameters,
}

struct Place(UnsafeCell<Option<Bench>>);

// SAFETY: only one thread uses it, as the head of this file requires.
unsafe impl Sync for Place {}

static BENCH: Place = Place(UnsafeCell::new(None));

fn bench() -> Option<&'static mut Bench> {
    // SAFETY: only one thread uses it, and no call calls another.
    unsafe { (*BENCH.0.get()).as_mut() }
}

/// Puts the motor on the bench, with sensors (`sensorless` 0) or without. Returns 0 on success, another
/// number if the motor cannot be commissioned.
#[unsafe(no_mangle)]
pub extern "C" fn bench_init(sensorless: i32) -> i32 {
    let Some(preset) = preset(MOTOR) else { return 1 };
    let supply = preset.data.nominal_voltage;
    let plate = Nameplate {
        motor: preset.motor.figures(),
        rated_current: preset.data.rated_current,
        supply,
        open_loop_speed: None,
    };
    let mode = if sensorless != 0 { Mode::Sensorless } else { Mode::Hall };
    let Ok(commissioning) = plate.commission(mode) else { return 2 };
    let config = PlantConfig { angle_deg: 77.0, ..PlantConfig::new(preset.motor, supply) };
    let bench = Bench { plant: Plant::new(&config), parameters: commissioning.parameters };
    // SAFETY: as in `bench`.
    unsafe { *BENCH.0.get() = Some(bench) };
    0
}

/// Reads a parameter that commissioning has changed: number `index` of them, from 0. Returns 1 and writes its
/// number and raw value; returns 0 after the last.
///
/// # Safety
/// `number` and `value` are writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bench_parameter(index: u32, number: *mut u16, value: *mut i32) -> i32 {
    let found = bench().and_then(|bench| {
        bench.parameters.iter().filter(|(row, raw)| *raw != row.factory_raw()).nth(index as usize)
    });
    let Some((row, raw)) = found else { return 0 };
    // SAFETY: the caller's promise.
    unsafe {
        number.write(row.number);
        value.write(raw);
    }
    1
}

/// Samples of this period.
///
/// # Safety
/// `samples` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bench_sample(samples: *mut narx_samples_t) {
    if let Some(bench) = bench() {
        // SAFETY: the caller's promise.
        unsafe { samples.write((&bench.plant.sample()).into()) };
    }
}

/// Applies the command that answers them, and ends the period.
///
/// # Safety
/// `command` is readable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bench_finish(command: *const narx_pwm_command_t) {
    if let Some(bench) = bench() {
        // SAFETY: the caller's promise.
        bench.plant.finish_period(&from_c(unsafe { &*command }));
    }
}

/// True speed of the shaft, mechanical rpm.
#[unsafe(no_mangle)]
pub extern "C" fn bench_rpm() -> f64 {
    bench().map_or(0.0, |bench| bench.plant.observe().speed * 60.0 / core::f64::consts::TAU)
}

fn from_c(command: &narx_pwm_command_t) -> PwmCommand {
    let mut converted = PwmCommand {
        duty: Duty::from_bits(command.duty),
        rectification: command.rectification,
        sample_at: command.sample_at,
        sample_mode: command.sample_mode,
        step: command.step,
        ..PwmCommand::default()
    };
    for narx_commutation_t { instant, step } in
        command.commutations.iter().take(command.commutation_count.into())
    {
        converted.commutations.push(Commutation { instant: *instant, step: *step });
    }
    converted
}
