//! Fault logic: measurements and conditions to a qualified, latched fault word (Table 9).

use super::state::{narx_change_t, row, state};
use super::{init, init_ready, narx_fault_settings_t, narx_setting_error_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::blocks::{Fault, FaultSettings};
use narx_core::motor::guard::protection::Evidence;
use narx_core::motor::guard::protection::ProtectionCoefficients;
use narx_core::motor::machine::event::{Health, SlowMeasurements};
use narx_core::motor::machine::{Change, RunRequest};
use narx_core::motor::rotor::hall::HallEvents;
use narx_core::motor::sense::measurement::Measured;
use narx_core::motor::{Cause, FaultWord, Lines};
use narx_core::units::{Amps, Celsius, Volts};

/// Fault logic: memory that the caller owns. It may be copied and moved between calls.
#[repr(C)]
pub struct narx_fault_t {
    /// Private.
    words: [u64; 29],
}

const _: () = handle::assert_fits::<narx_fault_t>();

impl Handle for narx_fault_t {
    type Object = Fault;
    const MARK: u32 = u32::from_be_bytes(*b"nxFa");
}

/// Inputs of the fault logic in one tick. Quantities are Q16; a flag is set if it is not 0. All zeros
/// describe a board at rest without a supply.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_evidence_t {
    /// Bus voltage.
    pub bus_voltage: i32,
    /// Mean DC-link current of this tick.
    pub bus_current: i32,
    /// Mean DC-link current after a first-order filter of 64 ticks.
    pub bus_current_filtered: i32,
    /// Temperature of the power stage.
    pub temperature: i32,
    /// Pressure reading, V.
    pub pressure: i32,
    /// Electrical speed, magnitude, rev/s.
    pub speed: i32,
    /// Faults of a parameter store: NARX_FAULT_STORE_*.
    pub store_faults: u32,
    /// Failure of sensorless control: NARX_CAUSE_SENSORLESS_STALL, _DESYNCHRONISATION or _WRONG_LOCK; 0
    /// without one.
    pub sensorless: u16,
    /// Digital inputs: sum of NARX_LINE_*.
    pub lines: u8,
    /// The master's request: 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown.
    pub request: u8,
    /// A self-test has failed.
    pub self_test_failed: u8,
    /// The hall code is 000 or 111.
    pub hall_invalid: u8,
    /// The hall sensors have jumped over a sector.
    pub hall_jump: u8,
    /// Sectors that the hall sensors have turned in this tick, signed.
    pub hall_sectors: i8,
    /// No hall edge came for the hall time-out.
    pub hall_stopped: u8,
    /// The hall closed loop is running: its sensors are checked for plausibility.
    pub hall_driving: u8,
    /// The bridge is on, or a start is about to turn it on.
    pub driving: u8,
    /// Sign of the torque that was applied in the last tick: 1 forward, -1 reverse, 0 none.
    pub torque: i8,
    /// A phase is open.
    pub open_phase: u8,
}

/// Outputs of the fault logic.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_faults_t {
    /// Faults that are present or latched: sum of NARX_FAULT_*.
    pub word: u32,
    /// Latched faults.
    pub critical: u32,
    /// Extended code of the first critical fault, a NARX_CAUSE_*; 0 without one.
    pub cause: u16,
    /// Not 0: a critical fault is present; the bridge must be switched off.
    pub present: u8,
    /// Not 0: none of the latched causes is present any more.
    pub causes_gone: u8,
}

/// Writes the drive's factory values at 10 kHz, as a start for your own settings; no speed counts as too
/// high.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_fault_settings_default(settings: *mut narx_fault_settings_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { pointer::write(settings, FaultSettings::default().into()) })
}

/// Makes a fault logic without a fault. Returns NARX_ERROR_SETTING if it cannot be built from the settings;
/// `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_fault_init(
    fault: *mut narx_fault_t,
    size: usize,
    settings: *const narx_fault_settings_t,
    error: *mut narx_setting_error_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init(fault, size, settings, error, Fault::build) }
}

/// Makes a fault logic without a fault from ready-made coefficients: what narx has computed on the desk from
/// such settings as narx_fault_init takes. They are not checked. It takes a few hundred bytes of flash where
/// narx_fault_init takes thousands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_fault_init_ready(
    fault: *mut narx_fault_t,
    size: usize,
    ready: *const ProtectionCoefficients,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init_ready(fault, size, ready, |ready| Fault::new(*ready)) }
}

/// Runs one tick. A critical fault latches.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_fault_step(
    fault: *mut narx_fault_t,
    evidence: *const narx_evidence_t,
    faults: *mut narx_faults_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(faults)?;
        let fault = handle::object(fault)?;
        let present = fault.step(&Evidence::try_from(pointer::read(evidence)?)?);
        let told = narx_faults_t {
            word: fault.word().bits(),
            critical: fault.critical().bits(),
            cause: fault.code(),
            present: present.into(),
            causes_gone: fault.causes_gone().into(),
        };
        pointer::write(faults, told)
    };
    pointer::status(run())
}

/// Follows a state change of the state machine beside it (narx_state_step): a time-out and a failed boot are
/// latched, leaving Fault acknowledges, and the plausibility checks of the sensors start anew in every driven
/// episode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_fault_handle_change(
    fault: *mut narx_fault_t,
    change: *const narx_change_t,
    evidence: *const narx_evidence_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let change = pointer::read(change)?;
        let row = row(state(change.from)?, state(change.to)?)?;
        let evidence = Evidence::try_from(pointer::read(evidence)?)?;
        handle::object(fault)?.handle_change(&Change { row, timed_out: change.timed_out != 0 }, &evidence);
        Ok(())
    };
    pointer::status(run())
}

/// Clears the latched faults if none of their causes is present any more; else returns NARX_ERROR_WRONG_STATE
/// and does nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_fault_acknowledge(fault: *mut narx_fault_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || match unsafe { handle::object(fault)? }.acknowledge() {
        true => Ok(()),
        false => Err(NARX_ERROR_WRONG_STATE),
    };
    pointer::status(run())
}

/// Causes that sensorless control can fail with.
const SENSORLESS: [Cause; 3] = [Cause::SensorlessStall, Cause::Desynchronisation, Cause::WrongLock];

impl TryFrom<&narx_evidence_t> for Evidence {
    type Error = narx_status_t;

    fn try_from(evidence: &narx_evidence_t) -> Result<Self, narx_status_t> {
        let sensorless = match evidence.sensorless {
            0 => None,
            code => {
                let cause = SENSORLESS.into_iter().find(|cause| *cause as u16 == code);
                Some(cause.ok_or(NARX_ERROR_ARGUMENT)?)
            }
        };
        Ok(Self {
            measured: Measured {
                bus_voltage: Volts::from_bits(evidence.bus_voltage),
                bus_current: Amps::from_bits(evidence.bus_current),
                bus_current_filtered: Amps::from_bits(evidence.bus_current_filtered),
            },
            slow: SlowMeasurements {
                temperature: Celsius::from_bits(evidence.temperature),
                pressure: Volts::from_bits(evidence.pressure),
            },
            lines: Lines::from_bits_retain(evidence.lines),
            health: Health {
                store_faults: FaultWord::from_bits_truncate(evidence.store_faults) & FaultWord::STORE,
                self_test_failed: evidence.self_test_failed != 0,
            },
            request: request(evidence.request)?,
            hall: HallEvents {
                invalid: evidence.hall_invalid != 0,
                jump: evidence.hall_jump != 0,
                sectors: evidence.hall_sectors,
            },
            hall_stopped: evidence.hall_stopped != 0,
            speed: evidence.speed,
            hall_driving: evidence.hall_driving != 0,
            driving: evidence.driving != 0,
            torque: evidence.torque != 0,
            torque_sign: evidence.torque.signum(),
            open_phase: evidence.open_phase != 0,
            sensorless,
        })
    }
}

/// Returns the request with this motor mode.
pub(crate) fn request(number: u8) -> Result<RunRequest, narx_status_t> {
    match number {
        0 => Ok(RunRequest::Standby),
        1 => Ok(RunRequest::Drive),
        2 => Ok(RunRequest::Reverse),
        3 => Ok(RunRequest::Shutdown),
        _ => Err(NARX_ERROR_ARGUMENT),
    }
}
