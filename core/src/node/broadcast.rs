//! Broadcasts of the drive: status, faults, measurements.

use super::{Node, scale};
use crate::bus::narmotion::{ControlMode, FromDrive, Measurement, MotorMode, StatusWord, Words};
use crate::dictionary::{Parameters, number};
use crate::motor::commutate::commutation::Direction;
use crate::motor::machine::event::Status;
use crate::motor::machine::state::State;
use crate::motor::sense::front_end::{Board, Equipment};
use crate::units::{Amps, Celsius, Volts, quotient};
use serde::{Deserialize, Serialize};

/// Frames of one broadcast: STATUS_WORD, FAULT_WORD and six measurements.
const PERIODIC_FRAMES: u64 = 8;
/// Longest 29-bit frame with 8 bytes and its gap, stuff bits included: 67 + 8n + floor((53 + 8n) / 4) at n
/// = 8.
const FRAME_BITS_MAX: u64 = 160;
/// Bits per second on the bus (Table 2).
const BIT_RATE: u64 = 500_000;
/// Share of the bus that the broadcasts may take, per cent.
const SHARE_MAX: u64 = 30;
/// Shortest broadcast period, microseconds, rounded up: 8534.
const PERIOD_MIN_US: u64 =
    (PERIODIC_FRAMES * FRAME_BITS_MAX * 100 * 1_000_000).div_ceil(BIT_RATE * SHARE_MAX);

/// The broadcast timer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Autosend {
    /// Tick of the last broadcast.
    last: Option<u64>,
}

impl Autosend {
    /// Makes the next broadcast due at once.
    pub(super) fn restart(&mut self) {
        self.last = None;
    }

    /// Returns whether a broadcast is due at tick `now`; if so, the next period begins. A late poll shortens
    /// the next period, but never makes up for missed ones.
    pub(super) fn is_due(&mut self, now: u64, parameters: &Parameters, board: &Board) -> bool {
        let period = period(parameters, board);
        let Some(last) = self.last else {
            self.last = Some(now);
            return true;
        };
        let age = now.saturating_sub(last);
        if age < period {
            return false;
        }
        let in_step = last.saturating_add(period);
        // Two broadcasts closer than the shortest period would take more than their share of the bus.
        let late = now.saturating_sub(in_step);
        self.last = Some(if late < period - shortest(board).min(period) { in_step } else { now });
        true
    }
}

/// Broadcast period in ticks: parameter 111, at least the shortest one.
fn period(parameters: &Parameters, board: &Board) -> u64 {
    let milliseconds = parameters.raw(number::AUTOSEND_PERIOD).unsigned_abs();
    let ticks = quotient(i64::from(milliseconds) * i64::from(board.tick_rate), 1000) as u64;
    ticks.max(shortest(board)).max(1)
}

/// Shortest broadcast period in ticks.
fn shortest(board: &Board) -> u64 {
    quotient(PERIOD_MIN_US as i64 * i64::from(board.tick_rate) + 999_999, 1_000_000) as u64
}

impl Node {
    /// Queues a broadcast: status and fault words always, measurements unless the command time-out has
    /// expired.
    pub(super) fn broadcast(&mut self) {
        self.outbox.discard_words();
        self.send(FromDrive::Status(self.status_word()));
        self.forget_log_end();
        self.send(FromDrive::Faults(self.status.faults));
        self.outbox.discard_measurements();
        if self.status.command_expired {
            return;
        }
        for measurement in self.measurements() {
            self.outbox.push_measurement(FromDrive::Measurement(measurement));
        }
    }

    /// Queues FAULT_WORD at every change, and CRITICAL_FAULT at every new critical fault.
    pub(super) fn announce_faults(&mut self, before: &Status) {
        let status = self.status;
        if !before.critical.contains(status.critical) {
            self.send(FromDrive::CriticalFault { faults: status.critical, code: status.extended_code });
        }
        if before.faults != status.faults {
            self.send(FromDrive::Faults(status.faults));
        }
    }

    /// Queues an answer, a status or a fault word.
    pub(super) fn send(&mut self, message: FromDrive) {
        self.outbox.push(message);
    }

    /// Mechanical position, 0.01 degrees, without its calibration: resolution one sector.
    pub(super) fn raw_position(&self) -> i32 {
        scale::mechanical_position(self.sectors, self.pole_pairs())
    }

    pub(super) fn pole_pairs(&self) -> i32 {
        self.parameters.raw(number::MOTOR_POLE_PAIRS)
    }

    /// STATUS_WORD (Table 8).
    pub(super) fn status_word(&self) -> StatusWord {
        let status = &self.status;
        let control = match status.state {
            State::Initialization | State::Standby | State::Fault => ControlMode::Off,
            State::RotorLock | State::OpenLoop => ControlMode::OpenLoop,
            State::SensorlessClosedLoop | State::SensorlessAutoRestart => ControlMode::Sensorless,
            State::HallClosedLoop => ControlMode::Hall,
        };
        let mode = match (status.state, status.direction) {
            (State::Initialization | State::Standby, _) => MotorMode::Standby,
            (State::Fault, _) => MotorMode::Fault,
            (_, Direction::Forward) => MotorMode::Drive,
            (_, Direction::Reverse) => MotorMode::Reverse,
        };
        let log = self.log_status();
        StatusWord {
            mode,
            control,
            logging: log.state,
            memory_full: log.full,
            memory_erased: log.erased,
            read_enable: log.read_enable,
            erase_enable: log.erase_enable,
        }
    }

    /// The words of MEASUREMENT_0 to 5.
    pub(super) fn measurement_words(&self) -> [Words; 6] {
        self.measurements().map(Measurement::encode)
    }

    fn measurements(&self) -> [Measurement; 6] {
        let Self { status, parameters, .. } = self;
        let inputs = self.inputs.unwrap_or_default();
        let slow = inputs.calibrated(parameters);
        let accel =
            if self.has(Equipment::ACCELEROMETER) { inputs.calibrated_accel(parameters) } else { [0; 3] };
        let [phase_a, phase_b, phase_c] = status.phase_voltage;
        [
            Measurement::M0 { accel, dsi1: inputs.dsi1 },
            Measurement::M1 {
                speed_sensorless: scale::mechanical_rpm(status.speed_sensorless, self.pole_pairs()),
                position: self.raw_position().wrapping_add(self.position_offset),
                power: scale::saturate16(status.power.scaled(10).into()),
            },
            Measurement::M2 {
                bus_voltage: centivolts(status.bus_voltage),
                bus_current: milliamps(status.bus_current),
                rail_6v: millivolts(inputs.rail_6v),
                rail_14v: millivolts(inputs.rail_14v),
            },
            Measurement::M3 {
                temperature: decidegrees(slow.temperature),
                accel_reference: millivolts(inputs.accel_reference),
                reference: millivolts(inputs.reference),
                asi: millivolts(inputs.asi),
            },
            Measurement::M4 {
                phase_voltage: [phase_a, phase_b, phase_c].map(centivolts),
                pressure: millivolts(inputs.scaled_pressure(parameters)),
            },
            Measurement::M5 {
                speed_hall: scale::mechanical_rpm(status.speed_hall, self.pole_pairs()),
                dsi2: inputs.dsi2,
            },
        ]
    }
}

fn centivolts(value: Volts) -> i16 {
    scale::saturate16(value.scaled(100).into())
}

fn millivolts(value: Volts) -> i16 {
    scale::saturate16(value.scaled(1000).into())
}

fn milliamps(value: Amps) -> i16 {
    scale::saturate16(value.scaled(1000).into())
}

fn decidegrees(value: Celsius) -> i16 {
    scale::saturate16(value.scaled(10).into())
}
