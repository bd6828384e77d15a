//! The digest of a drive's outputs, defined byte for byte so that every language can repeat it.

use crate::motor::event::{HallCalibration, HallWiring, Status};
use crate::motor::{Commutation, PwmCommand, Rectification, SampleMode};
use core::fmt;
use crc::{CRC_64_XZ, Crc};

static CRC64: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// CRC-64/XZ over the outputs of all ticks in order: every PWM command, and after it the status if that tick
/// reported one. Each begins with a letter (`P`, `S`), then its fields in the order of their declaration, little
/// endian, nothing between them: `bool` and enumerations one byte (numbered from 0 in the order of declaration
/// where the declaration gives no number), quantities their raw bits, an enumeration's contents right after it. A
/// command's commutations are their count, then instant and step of each.
#[derive(Clone)]
pub struct Digest {
    crc: crc::Digest<'static, u64>,
}

impl Default for Digest {
    fn default() -> Self {
        Self { crc: CRC64.digest() }
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Digest({:016x})", self.value())
    }
}

impl Digest {
    /// Takes in what one tick answered.
    pub fn update(&mut self, command: &PwmCommand, status: Option<&Status>) {
        self.command(command);
        if let Some(status) = status {
            self.status(status);
        }
    }

    /// The digest so far.
    pub fn value(&self) -> u64 {
        self.crc.clone().finalize()
    }

    // The structs are taken apart by name, so that a new field cannot be forgotten here.

    fn command(&mut self, command: &PwmCommand) {
        let PwmCommand { duty, rectification, sample_at, sample_mode, step, commutations } = command;
        self.u8(b'P');
        self.u16(duty.to_bits());
        self.u8(match rectification {
            Rectification::Diode => 0,
            Rectification::Synchronous => 1,
        });
        self.u16(*sample_at);
        self.u8(match sample_mode {
            SampleMode::OffTime => 0,
            SampleMode::OnTime => 1,
        });
        self.u8(*step as u8);
        self.u8(commutations.iter().count() as u8);
        for Commutation { instant, step } in commutations.iter() {
            self.u16(instant);
            self.u8(step as u8);
        }
    }

    fn status(&mut self, status: &Status) {
        let Status {
            tick,
            state,
            faults,
            critical,
            extended_code,
            command_expired,
            refusal,
            supply_low,
            direction,
            setpoint,
            speed_hall,
            speed_sensorless,
            angle,
            sectors,
            bus_voltage,
            bus_current,
            power,
            phase_voltage,
            duty,
            limiter,
            hall_invalid,
            hall_jumps,
            hall_calibration,
            crossing,
            crossing_margin,
            crossings,
        } = status;
        self.u8(b'S');
        self.crc.update(&tick.to_le_bytes());
        self.u8(*state as u8);
        self.u32(faults.bits());
        self.u32(critical.bits());
        self.u16(*extended_code);
        self.u8(u8::from(*command_expired));
        self.u8(*refusal as u8);
        self.u8(u8::from(*supply_low));
        self.u8(*direction as u8);
        for speed in [setpoint, speed_hall, speed_sensorless] {
            self.i32(speed.to_bits());
        }
        self.u16(angle.0);
        self.i32(*sectors);
        self.i32(bus_voltage.to_bits());
        self.i32(bus_current.to_bits());
        self.i32(power.to_bits());
        for voltage in phase_voltage {
            self.i32(voltage.to_bits());
        }
        self.u16(duty.to_bits());
        self.u8(*limiter as u8);
        self.u16(*hall_invalid);
        self.u16(*hall_jumps);
        self.hall_calibration(hall_calibration);
        self.u8(*crossing as u8);
        self.crc.update(&crossing_margin.to_le_bytes());
        self.u32(*crossings);
    }

    fn hall_calibration(&mut self, calibration: &HallCalibration) {
        match calibration {
            HallCalibration::None => self.u8(0),
            HallCalibration::Running => self.u8(1),
            HallCalibration::Done(HallWiring { order, polarity, offset }) => {
                self.u8(2);
                self.u8(*order);
                self.u8(*polarity);
                self.crc.update(&offset.to_le_bytes());
            }
            HallCalibration::Failed => self.u8(3),
        }
    }

    fn u8(&mut self, value: u8) {
        self.crc.update(&[value]);
    }

    fn u16(&mut self, value: u16) {
        self.crc.update(&value.to_le_bytes());
    }

    fn u32(&mut self, value: u32) {
        self.crc.update(&value.to_le_bytes());
    }

    fn i32(&mut self, value: i32) {
        self.crc.update(&value.to_le_bytes());
    }
}
