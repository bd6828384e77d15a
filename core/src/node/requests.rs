//! Execution of the master's frames.

use super::Node;
use super::description::SERVES;
use crate::blind;
use crate::bus::Frame;
use crate::bus::narmotion::{DecodeError, DigitalOutputs, FromDrive, MessageId, ParameterStatus, ToDrive};
use crate::dictionary::number;
use crate::motor::machine::state::State;
use crate::motor::sense::front_end::Equipment;
use crate::scope::SCOPE;

/// A well-formed request that is refused: not answered, but counted in parameter 274.
pub(crate) struct Refused;

impl Node {
    /// Takes a frame from the bus. Only data frames of 8 bytes from the configured master to this drive are
    /// accepted; a malformed or refused frame changes nothing and is counted.
    #[inline(never)]
    pub fn handle_frame(&mut self, frame: &Frame) {
        let message = match self.accept(frame) {
            Ok(Some(message)) => message,
            Ok(None) => return,
            Err(error) => return self.count(error),
        };
        if self.handle(message).is_err() {
            self.count_refused();
        }
    }

    /// Decodes the message, if it is for this drive and from its master; `None` for other traffic.
    fn accept(&mut self, frame: &Frame) -> Result<Option<ToDrive>, DecodeError> {
        let id = MessageId::of(frame)?;
        if id.destination != self.addresses.drive {
            return Ok(None);
        }
        let (id, message) = ToDrive::decode(frame)?;
        if id.source != self.addresses.master {
            self.count_refused();
            return Ok(None);
        }
        if blind::to("message", frame.id().raw() & 0x7FF) {
            return Ok(None);
        }
        Ok(Some(message))
    }

    fn handle(&mut self, message: ToDrive) -> Result<(), Refused> {
        // A motor that starts now would be without control during the reboot.
        if self.pending.reboot {
            return Err(Refused);
        }
        match message {
            #[cfg(feature = "update")]
            ToDrive::RequestWord(word) if self.update.forbids(word.mode) => return Err(Refused),
            ToDrive::RequestWord(word) => self.commands.request(word.mode, &self.parameters),
            ToDrive::MotorCommand { speed } => {
                let speed = self.commands.set_speed(speed, &self.parameters);
                self.send(FromDrive::MotorCommand { speed });
            }
            ToDrive::SetParameter { number, value } => {
                let status = self.write_parameter(number, value);
                if status == ParameterStatus::Done && value == 1 && self.flash.answers_later(number) {
                    return Ok(());
                }
                let value = self.read_parameter(number).unwrap_or(0);
                self.send(FromDrive::Parameter { number, value, status });
            }
            ToDrive::RequestParameter { number } => self.answer_read(number),
            ToDrive::RequestBuildInfo => self.send(FromDrive::BuildInfo {
                number: self.identity.build_number,
                modified: self.identity.source_modified,
                date: self.identity.build_date,
            }),
            ToDrive::RequestDeviceInfo => self.send(FromDrive::DeviceInfo {
                hardware: self.identity.hardware_release,
                software: self.identity.software_release,
                device_number: self.device_number,
                address: self.addresses.drive.into(),
            }),
            ToDrive::Reboot => {
                self.require_stopped()?;
                self.send(FromDrive::Reboot);
                self.flash.hurry();
                self.pending.reboot = true;
            }
            ToDrive::RestoreFactory { serial } => self.restore_factory(serial)?,
            ToDrive::DigitalOutputs(outputs) => self.set_digital(outputs)?,
            ToDrive::DisableHallSupply(disable) => self.disable_hall_supply(disable)?,
            ToDrive::DownloadXml(command) if SERVES => self.serve_description(command),
            ToDrive::DownloadXml(_) => return Err(Refused),
            ToDrive::TriggerScope | ToDrive::DownloadScope if !SCOPE => return Err(Refused),
            ToDrive::TriggerScope => self.scope.trigger(&self.parameters, self.board.tick_rate)?,
            ToDrive::DownloadScope => self.scope.download()?,
            #[cfg(feature = "update")]
            ToDrive::Update(request) => self.handle_update_message(request)?,
        }
        Ok(())
    }

    /// Stores factory values of everything that parameter 256 stores: allowed in every state, in force after
    /// the next reboot. Device number and calibration (category 02, which parameter 258 resets) stay.
    fn restore_factory(&mut self, serial: u16) -> Result<(), Refused> {
        if serial == self.device_number { self.store_factory() } else { Err(Refused) }
    }

    /// Sets the digital lines. A line that commands a shutdown (parameter 270) stays an input, and so does
    /// one that the board cannot drive.
    fn set_digital(&mut self, outputs: DigitalOutputs) -> Result<(), Refused> {
        let taken = match self.parameters.raw(number::SHUTDOWN_INPUT) {
            1 => outputs.enable1,
            2 => outputs.enable2,
            _ => false,
        };
        let driven = outputs.enable1 || outputs.enable2;
        if taken || (driven && !self.has(Equipment::DIGITAL_OUTPUTS)) {
            return Err(Refused);
        }
        self.digital = outputs;
        Ok(())
    }

    /// Switches the hall supply off, or leaves it to parameter 97. Refused while the hall sensors commutate
    /// the motor; a board without a switch cannot switch it off.
    fn disable_hall_supply(&mut self, disable: bool) -> Result<(), Refused> {
        if self.status.state == State::HallClosedLoop || (disable && !self.has(Equipment::HALL_SUPPLY_SWITCH))
        {
            return Err(Refused);
        }
        self.hall_supply_disabled = disable;
        Ok(())
    }

    fn require_stopped(&self) -> Result<(), Refused> {
        if self.is_stopped() { Ok(()) } else { Err(Refused) }
    }

    fn count(&mut self, error: DecodeError) {
        if error.is_malformed() {
            self.counters.malformed = self.counters.malformed.saturating_add(1);
        } else {
            self.count_refused();
        }
    }

    pub(super) fn count_refused(&mut self) {
        self.counters.refused = self.counters.refused.saturating_add(1);
    }
}
