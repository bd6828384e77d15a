//! Report of a motor's control.

use super::narx_motor_t;
use crate::handle;
use crate::status::narx_status_t;
use narx_core::motor::machine::event::{HallCalibration, HallWiring, Status};
use narx_core::motor::{Drive, State};

/// Report of a motor's control as of the last step. Speeds are electrical, Q16 rev/s, positive forward.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_motor_report_t {
    /// Tick of this report.
    pub tick: u64,
    /// Faults that are present or latched: FAULT_WORD of PROTOCOL.md.
    pub faults: u32,
    /// Latched critical faults.
    pub critical: u32,
    /// Set-point after its limits and its ramp.
    pub setpoint: i32,
    /// Speed by the hall sensors.
    pub speed_hall: i32,
    /// Speed by the back-EMF; in open loop that of the field.
    pub speed_sensorless: i32,
    /// Sectors turned since power-up: 6 an electrical revolution.
    pub sectors: i32,
    /// Bus voltage, Q16 V.
    pub bus_voltage: i32,
    /// Mean bus current, Q16 A.
    pub bus_current: i32,
    /// Electrical input power, Q16 W.
    pub power: i32,
    /// Terminal voltages, Q16 V.
    pub phase_voltage: [i32; 3],
    /// Zero crossings accepted since power-up, wrapping.
    pub crossings: u32,
    /// Extended code of the first critical fault (PROTOCOL.md), 0 without one.
    pub extended_code: u16,
    /// Electrical angle that the commutation uses, 65 536 a turn.
    pub angle: u16,
    /// Applied duty, U1F15.
    pub duty: u16,
    /// Times that the hall sensors lost their code, saturating.
    pub hall_invalid: u16,
    /// Hall changes between sectors that are not neighbours, saturating.
    pub hall_jumps: u16,
    /// Distance of the last accepted crossing behind its prediction, 65 536 an electrical turn.
    pub crossing_margin: i16,
    /// Result of the hall calibration, if `calibration` is 2: angle by which the edges lie beyond their
    /// place, 65 536 a turn.
    pub hall_offset: i16,
    /// Permutation of the lines (parameter 262), if `calibration` is 2.
    pub hall_order: u8,
    /// Lines to invert (parameter 263), if `calibration` is 2.
    pub hall_polarity: u8,
    /// Hall calibration: 0 none, 1 running, 2 done, 3 failed.
    pub calibration: u8,
    /// State.
    pub state: State,
    /// Commanded direction: 0 forward, 1 reverse.
    pub direction: u8,
    /// Reason why the last start was refused: 0 it was not, 1 no mode is enabled, 4 Standby was not requested
    /// since the last stop.
    pub refusal: u8,
    /// The limit that bounds the duty: the numbers of parameter 280.
    pub limiter: u8,
    /// Outcome of the last step's zero crossing: the numbers of parameter 287.
    pub crossing: u8,
    /// 1: no command for the time-out.
    pub command_expired: u8,
    /// 1: the bus is below 18 V, which is no fault.
    pub supply_low: u8,
    /// 1: the rotor is known to stand.
    pub standstill: u8,
    /// 1: nothing shows the rotor now; it may turn while `sectors` stands.
    pub unseen: u8,
}

/// Writes the report of the last step if one is due, or returns NARX_NOTHING: one is due every millisecond,
/// and when the state or the faults change.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_motor_poll_report(
    motor: *mut narx_motor_t,
    report: *mut narx_motor_report_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::poll(motor, report, |drive: &mut Drive| drive.poll_status().map(Into::into)) }
}

impl From<Status> for narx_motor_report_t {
    fn from(status: Status) -> Self {
        let (calibration, wiring) = match status.hall_calibration {
            HallCalibration::None => (0, HallWiring::default()),
            HallCalibration::Running => (1, HallWiring::default()),
            HallCalibration::Done(wiring) => (2, wiring),
            HallCalibration::Failed => (3, HallWiring::default()),
        };
        Self {
            tick: status.tick,
            faults: status.faults.bits(),
            critical: status.critical.bits(),
            setpoint: status.setpoint.to_bits(),
            speed_hall: status.speed_hall.to_bits(),
            speed_sensorless: status.speed_sensorless.to_bits(),
            sectors: status.sectors,
            bus_voltage: status.bus_voltage.to_bits(),
            bus_current: status.bus_current.to_bits(),
            power: status.power.to_bits(),
            phase_voltage: status.phase_voltage.map(|voltage| voltage.to_bits()),
            crossings: status.crossings,
            extended_code: status.extended_code,
            angle: status.angle.0,
            duty: status.duty.to_bits(),
            hall_invalid: status.hall_invalid,
            hall_jumps: status.hall_jumps,
            crossing_margin: status.crossing_margin,
            hall_offset: wiring.offset,
            hall_order: wiring.order,
            hall_polarity: wiring.polarity,
            calibration,
            state: status.state,
            direction: (status.direction.sign() < 0).into(),
            refusal: status.refusal as u8,
            limiter: status.limiter as u8,
            crossing: status.crossing as u8,
            command_expired: status.command_expired.into(),
            supply_low: status.supply_low.into(),
            standstill: status.standstill.into(),
            unseen: status.unseen.into(),
        }
    }
}
