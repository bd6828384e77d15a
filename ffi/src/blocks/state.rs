//! The state machine: one of eight states from requests and conditions (Table 7).

use super::fault::request;
use super::{init, init_ready, narx_setting_error_t, narx_state_settings_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::blocks::{StateMachine, StateSettings};
use narx_core::motor::machine::MachineCoefficients;
use narx_core::motor::machine::state::{State, TRANSITIONS, Transition};
use narx_core::motor::machine::{Command, Inputs};
use narx_core::units::ElectricalSpeed;

/// A state machine: memory that the caller owns. It may be copied and moved between calls.
#[repr(C)]
pub struct narx_state_machine_t {
    /// Private.
    words: [u64; 12],
}

const _: () = handle::assert_fits::<narx_state_machine_t>();

impl Handle for narx_state_machine_t {
    type Object = StateMachine;
    const MARK: u32 = u32::from_be_bytes(*b"nxSt");
}

/// Inputs of the state machine in one tick; a flag is set if it is not 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_state_inputs_t {
    /// A critical fault is present.
    pub critical: u8,
    /// Self-tests or parameter store failed.
    pub unhealthy: u8,
    /// None of the latched faults' causes is present.
    pub causes_gone: u8,
    /// Estimated speed is 0, as the running mode judges it.
    pub stopped: u8,
    /// A hall calibration has a result.
    pub calibrated: u8,
    /// A working controller can be built from the present parameters.
    pub parameters_fit: u8,
}

/// A change of state.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_change_t {
    /// State before: a narx_state_t.
    pub from: u8,
    /// State after.
    pub to: u8,
    /// Not 0: the change fired because of the command time-out.
    pub timed_out: u8,
}

/// Present state of the machine.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_state_report_t {
    /// Ticks in the present state, saturating.
    pub age: u32,
    /// A narx_state_t.
    pub state: u8,
    /// Direction of this start: 0 forward, 1 reverse.
    pub direction: u8,
    /// Reason why the last start was refused: 0 it was not, 1 no mode is enabled, 2 parameters, 4 Standby was
    /// not requested since the last stop.
    pub refusal: u8,
    /// Not 0: this tick turns the bridge on unless a condition prevents the start.
    pub starting: u8,
}

/// Writes the drive's factory values at 10 kHz, with hall sensors, as a start for your own settings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_state_settings_default(settings: *mut narx_state_settings_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { pointer::write(settings, StateSettings::default().into()) })
}

/// Makes a machine in Initialization. Returns NARX_ERROR_SETTING if it cannot be built from the settings;
/// `error`, which may be NULL, then names the setting.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_state_init(
    machine: *mut narx_state_machine_t,
    size: usize,
    settings: *const narx_state_settings_t,
    error: *mut narx_setting_error_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init(machine, size, settings, error, StateMachine::build) }
}

/// Makes a machine in Initialization from ready-made coefficients: what narx has computed on the desk from
/// such settings as narx_state_init takes. They are not checked. It takes a few hundred bytes of flash where
/// narx_state_init takes thousands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_state_init_ready(
    machine: *mut narx_state_machine_t,
    size: usize,
    ready: *const MachineCoefficients,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init_ready(machine, size, ready, |ready| StateMachine::new(*ready)) }
}

/// Takes a command: `mode` is 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown, `speed` the electrical set-point,
/// Q16 rev/s. It restarts the command time-out. Standby acknowledges a fault; Drive and Reverse start the
/// motor if Standby was requested before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_state_handle_command(
    machine: *mut narx_state_machine_t,
    mode: u8,
    speed: i32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || {
        let command = Command { request: request(mode)?, speed: ElectricalSpeed::from_bits(speed) };
        unsafe { handle::object(machine)? }.handle_command(command);
        Ok(())
    };
    pointer::status(run())
}

/// Runs one tick: time passes, and at most one transition fires. Returns NARX_OK and writes the transition to
/// `change`, or returns NARX_NOTHING.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_state_step(
    machine: *mut narx_state_machine_t,
    inputs: *const narx_state_inputs_t,
    change: *mut narx_change_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(change)?;
        let fired = handle::object(machine)?.step(&pointer::read(inputs)?.into()).ok_or(NARX_NOTHING)?;
        let (from, to) = (fired.row.from as u8, fired.row.to as u8);
        pointer::write(change, narx_change_t { from, to, timed_out: fired.timed_out.into() })
    };
    pointer::status(run())
}

/// Writes the present state of the machine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_state_report(
    machine: *mut narx_state_machine_t,
    report: *mut narx_state_report_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe {
        handle::object(machine).and_then(|machine| {
            let told = narx_state_report_t {
                age: machine.age(),
                state: machine.state() as u8,
                direction: (machine.direction().sign() < 0).into(),
                refusal: machine.refusal() as u8,
                starting: machine.starting().into(),
            };
            pointer::write(report, told)
        })
    })
}

/// Returns the state with this number.
pub(super) fn state(number: u8) -> Result<State, narx_status_t> {
    State::ALL.get(usize::from(number)).copied().ok_or(NARX_ERROR_ARGUMENT)
}

/// Returns the row of the transition table between two states.
pub(super) fn row(from: State, to: State) -> Result<&'static Transition, narx_status_t> {
    TRANSITIONS.iter().find(|row| row.from == from && row.to == to).ok_or(NARX_ERROR_ARGUMENT)
}

impl From<&narx_state_inputs_t> for Inputs {
    fn from(inputs: &narx_state_inputs_t) -> Self {
        Self {
            critical: inputs.critical != 0,
            unhealthy: inputs.unhealthy != 0,
            causes_gone: inputs.causes_gone != 0,
            stopped: inputs.stopped != 0,
            calibrated: inputs.calibrated != 0,
            parameters_fit: inputs.parameters_fit != 0,
        }
    }
}
