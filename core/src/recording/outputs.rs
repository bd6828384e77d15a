//! What one tick answered, field by field: the one list from which digests are made and differences are told.

use crate::motor::event::{HallCalibration, HallWiring, Status};
use crate::motor::{Commutation, PwmCommand, Rectification, SampleMode};
use core::fmt;

/// What one tick answered. Displays as one line, `tick 17: duty 1200, rectification 1, ...`, with raw bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outputs {
    /// Number of the tick, from its samples.
    pub tick: u64,
    /// The PWM command.
    pub command: PwmCommand,
    /// The status, if this tick reported one.
    pub status: Option<Status>,
}

/// A field's raw bits in the width that the digest takes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bits {
    U8(u8),
    U16(u16),
    U32(u32),
    U64(u64),
    I16(i16),
    I32(i32),
}

impl From<bool> for Bits {
    fn from(value: bool) -> Self {
        Self::U8(u8::from(value))
    }
}

impl fmt::Display for Bits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::U8(value) => value.fmt(f),
            Self::U16(value) => value.fmt(f),
            Self::U32(value) => value.fmt(f),
            Self::U64(value) => value.fmt(f),
            Self::I16(value) => value.fmt(f),
            Self::I32(value) => value.fmt(f),
        }
    }
}

/// Names of the parts of an answer, which stand before their fields with their letter.
pub(super) const COMMAND: &str = "command";
pub(super) const STATUS: &str = "status";

impl fmt::Display for Outputs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tick {}:", self.tick)?;
        let mut result = Ok(());
        let mut between = " ";
        let mut part = "";
        // As one function that is called for every field: a copy for each would be 7 KB.
        let see: &mut dyn FnMut(&'static str, Bits) = &mut |name, bits| {
            if name == STATUS {
                part = "status.";
            }
            if result.is_ok() && name != COMMAND && name != STATUS {
                result = write!(f, "{between}{part}{name} {bits}");
                between = ", ";
            }
        };
        fields(&self.command, self.status.as_ref(), see);
        result
    }
}

/// Shows every field in the order of the digest.
#[inline]
pub(super) fn fields(command: &PwmCommand, status: Option<&Status>, mut see: impl FnMut(&'static str, Bits)) {
    command_fields(command, &mut see);
    if let Some(status) = status {
        status_fields(status, &mut see);
    }
}

// The structs are taken apart by name, so that a new field cannot be forgotten here.

fn command_fields(command: &PwmCommand, see: &mut impl FnMut(&'static str, Bits)) {
    let PwmCommand { duty, rectification, sample_at, sample_mode, step, commutations } = command;
    see(COMMAND, Bits::U8(b'P'));
    see("duty", Bits::U16(duty.to_bits()));
    see(
        "rectification",
        Bits::U8(match rectification {
            Rectification::Diode => 0,
            Rectification::Synchronous => 1,
        }),
    );
    see("sample_at", Bits::U16(*sample_at));
    see(
        "sample_mode",
        Bits::U8(match sample_mode {
            SampleMode::OffTime => 0,
            SampleMode::OnTime => 1,
        }),
    );
    see("step", Bits::U8(*step as u8));
    see("commutations", Bits::U8(commutations.iter().count() as u8));
    for Commutation { instant, step } in commutations.iter() {
        see("commutation.instant", Bits::U16(instant));
        see("commutation.step", Bits::U8(step as u8));
    }
}

fn status_fields(status: &Status, see: &mut impl FnMut(&'static str, Bits)) {
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
        phase_voltage: [voltage_a, voltage_b, voltage_c],
        duty,
        limiter,
        hall_invalid,
        hall_jumps,
        hall_calibration,
        crossing,
        crossing_margin,
        crossings,
    } = status;
    see(STATUS, Bits::U8(b'S'));
    see("tick", Bits::U64(*tick));
    see("state", Bits::U8(*state as u8));
    see("faults", Bits::U32(faults.bits()));
    see("critical", Bits::U32(critical.bits()));
    see("extended_code", Bits::U16(*extended_code));
    see("command_expired", (*command_expired).into());
    see("refusal", Bits::U8(*refusal as u8));
    see("supply_low", (*supply_low).into());
    see("direction", Bits::U8(*direction as u8));
    see("setpoint", Bits::I32(setpoint.to_bits()));
    see("speed_hall", Bits::I32(speed_hall.to_bits()));
    see("speed_sensorless", Bits::I32(speed_sensorless.to_bits()));
    see("angle", Bits::U16(angle.0));
    see("sectors", Bits::I32(*sectors));
    see("bus_voltage", Bits::I32(bus_voltage.to_bits()));
    see("bus_current", Bits::I32(bus_current.to_bits()));
    see("power", Bits::I32(power.to_bits()));
    see("phase_voltage_a", Bits::I32(voltage_a.to_bits()));
    see("phase_voltage_b", Bits::I32(voltage_b.to_bits()));
    see("phase_voltage_c", Bits::I32(voltage_c.to_bits()));
    see("duty", Bits::U16(duty.to_bits()));
    see("limiter", Bits::U8(*limiter as u8));
    see("hall_invalid", Bits::U16(*hall_invalid));
    see("hall_jumps", Bits::U16(*hall_jumps));
    match hall_calibration {
        HallCalibration::None => see("hall_calibration", Bits::U8(0)),
        HallCalibration::Running => see("hall_calibration", Bits::U8(1)),
        HallCalibration::Done(HallWiring { order, polarity, offset }) => {
            see("hall_calibration", Bits::U8(2));
            see("hall_order", Bits::U8(*order));
            see("hall_polarity", Bits::U8(*polarity));
            see("hall_offset", Bits::I16(*offset));
        }
        HallCalibration::Failed => see("hall_calibration", Bits::U8(3)),
    }
    see("crossing", Bits::U8(*crossing as u8));
    see("crossing_margin", Bits::I16(*crossing_margin));
    see("crossings", Bits::U32(*crossings));
}
