//! Reading and writing parameters.

use super::storage::part_of;
use super::{Node, scale};
use crate::blind;
use crate::bus::narmotion::{FromDrive, ParameterStatus};
use crate::dictionary::{Access, Category, Dictionary, Parameter, ParameterError, number};
use crate::motor::machine::event::{HallCalibration, HallWiring};
use crate::motor::machine::state::State;
use serde::{Deserialize, Serialize};

/// Command parameters: they act on a rising edge.
const ON_RISING_EDGE: [u16; 8] = [
    number::SET_POSITION,
    number::LOG_READ_REQUEST,
    number::LOG_ERASE_REQUEST,
    number::STORE,
    number::STORE_ONCE,
    number::RESET_CALIBRATION,
    number::AUTO_CALIBRATE,
    number::HALL_CALIBRATE,
];

const _: () = assert!(ON_RISING_EDGE.len() <= u8::BITS as usize, "a command more needs a wider `Edges`");

/// Command parameters to which a 0 was written: a rising edge is a written 0, then a written 1. Power-up does
/// not count as a 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Edges(u8);

impl Edges {
    fn bit(number: u16) -> u8 {
        ON_RISING_EDGE.iter().position(|command| *command == number).map_or(0, |place| 1 << place)
    }
    fn arm(&mut self, number: u16) {
        self.0 |= Self::bit(number);
    }
    fn disarm(&mut self, number: u16) {
        self.0 &= !Self::bit(number);
    }
    fn is_armed(self, number: u16) -> bool {
        self.0 & Self::bit(number) != 0
    }
}

impl Node {
    /// The raw value of a parameter as the bus reads it, live ones included; `None` for an unknown number.
    pub fn read_parameter(&self, number: u16) -> Option<i32> {
        if blind::to("parameter", number.into()) && Dictionary::row(number)?.access == Access::ReadOnly {
            // The log's markers read their factory values even with their effect, so they read 0 without it.
            let is_marker = number == number::LOGGING_START || number == number::LOGGING_END;
            return Dictionary::row(number).map(|row| if is_marker { 0 } else { row.factory_raw() });
        }
        let status = &self.status;
        if let Some(value) = self.read_log_parameter(number) {
            return Some(value);
        }
        Some(match number {
            number::SCOPE_SAMPLING_TIME => {
                super::scope::sampling_time(&self.parameters, self.board.tick_rate)
            }
            number::SCOPE_STATE => self.scope.state() as i32,
            number::SCOPE_WORDS => self.scope.words().into(),
            number::SCOPE_ROOM => self.scope.room().into(),
            number::SCOPE_REFUSAL => self.scope.refusal() as i32,
            number::DRIVE_STATE => status.state as i32,
            number::REFUSED_FRAMES => self.counters.refused as i32,
            number::MALFORMED_FRAMES => self.counters.malformed as i32,
            number::START_REFUSAL => status.refusal as i32,
            number::HALL_INVALID => status.hall_invalid.into(),
            number::HALL_JUMPS => status.hall_jumps.into(),
            number::HALL_CALIBRATION_STATE => match status.hall_calibration {
                HallCalibration::None => 0,
                HallCalibration::Running => 1,
                HallCalibration::Done(_) => 2,
                HallCalibration::Failed => 3,
            },
            number::ACTIVE_LIMITER => status.limiter as i32,
            number::CROSSING => status.crossing as i32,
            number::CROSSING_MARGIN => scale::centidegrees(status.crossing_margin),
            number::CROSSINGS => status.crossings as i32,
            number::EXTENDED_FAULT_CODE => status.extended_code.into(),
            number::BUS_STATE => self.link.state.error as i32,
            number::TRANSMIT_ERRORS => self.link.state.transmit_errors.into(),
            number::RECEIVE_ERRORS => self.link.state.receive_errors.into(),
            number::BUS_OFFS => self.link.bus_offs as i32,
            number::TILT => self.motion.tilt().into(),
            number::VIBRATION => self.motion.vibration().into(),
            number::FRAMES_LOST => self.outbox.lost() as i32,
            number::DIAGNOSTICS => self.diagnostics().bits().into(),
            number::REJECTED_PARAMETER => self.rejected.unwrap_or(u16::MAX).into(),
            _ => self.parameters.value(number)?,
        })
    }

    /// Writes a parameter as the master does: checks number, access, range, parts of the board and state,
    /// then applies the value.
    pub fn write_parameter(&mut self, number: u16, raw: i32) -> ParameterStatus {
        let Some(row) = Dictionary::row(number) else { return ParameterStatus::UnknownNumber };
        if row.access == Access::ReadOnly {
            return ParameterStatus::ReadOnly;
        }
        let slot = (number::LOGGING_SLOT_FIRST..=number::LOGGING_SLOT_LAST).contains(&number);
        if !row.accepts(raw) || (slot && !self.can_log(raw)) {
            return ParameterStatus::OutOfRange;
        }
        if self.lacks(number, raw) {
            return ParameterStatus::NotEquipped;
        }
        if !self.is_allowed_now(row, raw) {
            return ParameterStatus::WrongState;
        }
        if row.command {
            return self.write_command(number, raw != 0);
        }
        self.keep(row, raw);
        if slot || number == number::LOG_PERIOD {
            self.log.restart();
        }
        if matters_to_the_tick(row) {
            self.after_change();
        }
        if row.category == Category::Calibration {
            self.calibrate_inputs();
        }
        ParameterStatus::Done
    }

    /// Returns whether the motor is stopped: Standby, or Fault at standstill. A rotor that no sensor sees
    /// does not count as standing.
    pub(super) fn is_stopped(&self) -> bool {
        match self.status.state {
            State::Standby => true,
            State::Fault => self.status.standstill,
            _ => false,
        }
    }

    /// Requests that the changed set is built, and lets the enables select the mode of the next start.
    pub(super) fn after_change(&mut self) {
        self.pending.coefficients = true;
        if !self.status.state.is_driving() {
            self.commands.select_mode(&self.parameters);
        }
    }

    /// Sets a value that the drive itself knows to be in range.
    pub(super) fn put(&mut self, number: u16, raw: i32) {
        let _ = self.parameters.set(number, raw);
    }

    /// Sets a value that is to be stored.
    fn keep(&mut self, row: &Parameter, raw: i32) {
        let before = self.parameters.value(row.number);
        let was_automatic = self.parameters.raw(number::AUTOMATIC_STORE) != 0;
        self.put(row.number, raw);
        let automatic = was_automatic || self.parameters.raw(number::AUTOMATIC_STORE) != 0;
        self.note_written(row, automatic, before != Some(raw));
    }

    /// Answers a read with PARAMETER, type 2.
    pub(super) fn answer_read(&mut self, number: u16) {
        let (value, status) = match self.read_parameter(number) {
            Some(value) => (value, ParameterStatus::Done),
            None => (0, ParameterStatus::UnknownNumber),
        };
        self.send(FromDrive::Parameter { number, value, status });
    }

    /// Takes the end of a hall calibration: clears its request, and writes its result to parameters 262, 263,
    /// 79, 80.
    pub(super) fn adopt_hall_calibration(&mut self, before: HallCalibration) {
        let now = self.status.hall_calibration;
        if now == before {
            return;
        }
        if let HallCalibration::Done(HallWiring { order, polarity, offset }) = now {
            let found = [
                (number::HALL_ORDER, order.into()),
                (number::HALL_POLARITY, polarity.into()),
                (number::STANDARD_HALL_SEQUENCE, 0),
                (number::HALL_OFFSET_ANGLE, scale::centidegrees(offset)),
            ];
            for (number, raw) in found {
                if let Some(row) = Dictionary::row(number) {
                    self.keep(row, raw);
                }
            }
            self.after_change();
        }
        if matches!(now, HallCalibration::Done(_) | HallCalibration::Failed) {
            self.put(number::HALL_CALIBRATE, 0);
            self.edges.disarm(number::HALL_CALIBRATE);
        }
    }

    /// Returns whether the present state allows a write, by the row's access and by special rules.
    fn is_allowed_now(&self, row: &Parameter, raw: i32) -> bool {
        let input = |number| match number {
            1 => self.digital.enable1,
            2 => self.digital.enable2,
            _ => false,
        };
        let special = match row.number {
            // The sensors that commutate the motor keep their supply.
            number::HALL_SUPPLY_ENABLE => raw != 0 || self.status.state != State::HallClosedLoop,
            // A line that is an output cannot command a shutdown.
            number::SHUTDOWN_INPUT => !input(raw),
            // The bridge must be off and the next start not yet begun.
            number::HALL_CALIBRATE | number::AUTO_CALIBRATE => self.status.state == State::Standby,
            number::LOG_ERASE_REQUEST => !self.status.state.is_driving(),
            _ => true,
        };
        special && (row.access == Access::Live || self.is_stopped())
    }

    fn write_command(&mut self, number: u16, level: bool) -> ParameterStatus {
        if !level {
            if number == number::HALL_CALIBRATE && self.parameters.raw(number) != 0 {
                self.pending.calibrate = Some(false);
            }
            if number == number::LOG_READ_REQUEST {
                self.abort_download();
            }
            self.edges.arm(number);
            self.put(number, 0);
            return ParameterStatus::Done;
        }
        if self.flash.answers_later(number) {
            // A repeated 1 comes from a master that has waited long: the first answer is for both.
            return if self.edges.is_armed(number) {
                ParameterStatus::Storage
            } else {
                ParameterStatus::Done
            };
        }
        if self.edges.is_armed(number) {
            let status = self.run_command(number);
            if status != ParameterStatus::Done {
                return status;
            }
            self.edges.disarm(number);
        }
        self.put(number, 1);
        ParameterStatus::Done
    }

    fn run_command(&mut self, number: u16) -> ParameterStatus {
        match number {
            _ if blind::to("parameter", number.into()) => {}
            number::SET_POSITION => {
                let wanted = self.parameters.raw(number::POSITION_CALIBRATION);
                self.position_offset = wanted.wrapping_sub(self.raw_position());
                self.position_lost = self.status.unseen;
            }
            number::RESET_CALIBRATION => self.reset_calibration(),
            number::AUTO_CALIBRATE => {
                return match self.parameters.raw(number::NOMINAL_SUPPLY) {
                    0 => ParameterStatus::OutOfRange,
                    nominal => self
                        .auto_calibrate(nominal)
                        .map_or(ParameterStatus::OutOfRange, |()| ParameterStatus::Done),
                };
            }
            number::HALL_CALIBRATE => self.pending.calibrate = Some(true),
            number::STORE | number::STORE_ONCE => return self.begin_store(part_of(number), number),
            number::LOG_READ_REQUEST => return self.begin_download(),
            number::LOG_ERASE_REQUEST => return self.begin_erase(),
            _ => {}
        }
        ParameterStatus::Done
    }

    fn reset_calibration(&mut self) {
        let rows = Dictionary::rows().filter(|row| row.category == Category::Calibration && !row.command);
        for row in rows {
            self.put(row.number, row.factory_raw());
        }
        self.position_offset = 0;
        self.after_change();
        self.calibrate_inputs();
    }

    /// Calibrates bus current and voltage: with the bridge off the current is 0, and the voltage is the
    /// `nominal` supply (parameter 266). Measured values contain the present offsets.
    fn auto_calibrate(&mut self, nominal: i32) -> Result<(), ParameterError> {
        let current = self.parameters.raw(number::HV_CURRENT_OFFSET);
        let voltage = self.parameters.raw(number::HV_VOLTAGE_OFFSET);
        let current_error = self.status.bus_current.scaled(1000);
        let voltage_error = self.status.bus_voltage.scaled(1000).saturating_sub(nominal);
        self.parameters.set(number::HV_CURRENT_OFFSET, current.saturating_sub(current_error))?;
        if let Err(error) =
            self.parameters.set(number::HV_VOLTAGE_OFFSET, voltage.saturating_sub(voltage_error))
        {
            // Both offsets change, or none.
            self.put(number::HV_CURRENT_OFFSET, current);
            return Err(error);
        }
        self.after_change();
        Ok(())
    }
}

/// Returns whether the tick's coefficients depend on a parameter of this row.
fn matters_to_the_tick(row: &Parameter) -> bool {
    matches!(
        row.category,
        Category::Calibration
            | Category::Machine
            | Category::Control
            | Category::CommandSaturation
            | Category::Limitation
            | Category::Timing
    )
}
