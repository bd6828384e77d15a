//! The control tick alone: samples in, PWM out; no bus, no parameters, no background.

mod coefficients;
mod report;

pub use coefficients::{NARX_COEFFICIENTS_VERSION, narx_coefficients_build, narx_parameter_error_t};
pub use report::{narx_motor_poll_report, narx_motor_report_t};

use crate::blocks::fault::request;
use crate::handle::{self, Handle};
use crate::pointer;
use crate::pwm::{self, narx_pwm_command_t};
use crate::samples::narx_samples_t;
use crate::status::narx_status_t;
use narx_core::motor::machine::event::SlowMeasurements;
use narx_core::motor::{Coefficients, Command, Drive};
use narx_core::units::{Celsius, ElectricalSpeed, Volts};

/// A motor's control: memory that the caller owns. It may be copied and moved between calls.
#[repr(C)]
pub struct narx_motor_t {
    /// Private.
    words: [u64; 190],
}

const _: () = handle::assert_fits::<narx_motor_t>();

impl Handle for narx_motor_t {
    type Object = Drive;
    const MARK: u32 = u32::from_be_bytes(*b"nxMo");
}

/// Makes a control at power-up, in Initialization, in `size` bytes of memory. `coefficients` are those that
/// `narx coefficients` has printed, or narx_coefficients_build has built. They are copied, and not checked.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_motor_init(
    motor: *mut narx_motor_t,
    size: usize,
    coefficients: *const Coefficients,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe {
        handle::init(motor, size, || {
            pointer::read(coefficients).map(|coefficients| Drive::new(*coefficients))
        })
    })
}

/// Runs one control tick: takes the samples of this period and writes the command to apply. Call it from the
/// control interrupt, once a PWM period.
///
/// On an error the command, if `command` is a valid pointer, is coast at duty 0: a caller that ignores the
/// status still turns the bridge off.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_motor_step(
    motor: *mut narx_motor_t,
    samples: *const narx_samples_t,
    command: *mut narx_pwm_command_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { pwm::step(samples, command, || handle::object(motor), Drive::step) }
}

/// Takes a command: `mode` is 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown, `speed` the magnitude of the
/// electrical set-point, Q16 rev/s: rpm x pole pairs / 60 x 65 536. It restarts the command time-out, so
/// repeat it. Standby acknowledges a fault; Drive and Reverse start the motor if Standby was requested
/// before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_motor_handle_command(
    motor: *mut narx_motor_t,
    mode: u8,
    speed: i32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || {
        let command = Command { request: request(mode)?, speed: ElectricalSpeed::from_bits(speed) };
        unsafe { handle::object(motor)? }.handle_command(command);
        Ok(())
    };
    pointer::status(run())
}

/// Takes a set-point alone, Q16 rev/s as in narx_motor_handle_command: the request stays. It restarts the
/// command time-out, too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_motor_handle_set_point(motor: *mut narx_motor_t, speed: i32) -> narx_status_t {
    let speed = ElectricalSpeed::from_bits(speed);
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(motor) }.map(|drive| drive.handle_set_point(speed)))
}

/// Takes a temperature, Q16 degrees Celsius, and a pressure reading, Q16 V, about every 10 ms. Their limits
/// act from the first reading on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_motor_handle_inputs(
    motor: *mut narx_motor_t,
    temperature: i32,
    pressure: i32,
) -> narx_status_t {
    let slow = SlowMeasurements {
        temperature: Celsius::from_bits(temperature),
        pressure: Volts::from_bits(pressure),
    };
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(motor) }.map(|drive| drive.handle_slow(slow)))
}

/// Takes other coefficients, in any state: they hold from the next tick on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_motor_change_coefficients(
    motor: *mut narx_motor_t,
    coefficients: *const Coefficients,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        handle::object(motor)?.change_coefficients(pointer::read(coefficients)?);
        Ok(())
    };
    pointer::status(run())
}

/// The next start finds the wiring of the hall sensors instead of running the motor (`run` is not 0), or runs
/// it again (0). narx_motor_report_t shows the result.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_motor_calibrate_hall(motor: *mut narx_motor_t, run: u8) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(motor) }.map(|drive| drive.calibrate_hall(run != 0)))
}
