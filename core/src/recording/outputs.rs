//! Answer of one tick, field by field: digests and reports of differences are made from this one list.

use crate::motor::machine::event::{HallCalibration, HallWiring, Status};
use crate::motor::{Commutation, PwmCommand, Rectification, SampleMode};
use core::fmt;

/// Answer of one tick. Displays as one line, `tick 17: duty 1200, rectification 1, ...`, with raw bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outputs {
    /// Number of the tick, from its samples.
    pub tick: u64,
    /// The PWM command.
    pub command: PwmCommand,
    /// The status, if this tick reported one.
    pub status: Option<Status>,
}

/// Raw bits of a field, and the number of their bytes that the digest takes. Signed values are sign-extended;
/// values of eight bytes are unsigned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bits {
    pub(super) value: i64,
    pub(super) bytes: u32,
}

macro_rules! bits {
    ($($from:ty)*) => {
        $(impl From<$from> for Bits {
            fn from(value: $from) -> Self {
                Self { value: value as i64, bytes: size_of::<$from>() as u32 }
            }
        })*
    };
}

bits!(bool u8 u16 u32 u64 i16 i32);

impl fmt::Display for Bits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.bytes == 8 { (self.value as u64).fmt(f) } else { self.value.fmt(f) }
    }
}

/// Visitor that is called for every field. It is one function, because code that is copied for every field,
/// in every list, does not fit into a web page's module.
pub(super) type See<'a> = &'a mut dyn FnMut(&'static str, Bits);

/// Names of the two parts of an answer. Each part begins with its name and letter; its fields follow.
pub(super) const COMMAND: &str = "command";
pub(super) const STATUS: &str = "status";

impl fmt::Display for Outputs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tick {}:", self.tick)?;
        let mut result = Ok(());
        let mut between = " ";
        let mut part = "";
        let see: See<'_> = &mut |name, bits| {
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

/// Calls `see` for every field in the order of the digest.
pub(super) fn fields(command: &PwmCommand, status: Option<&Status>, see: See<'_>) {
    command_fields(command, see);
    if let Some(status) = status {
        status_fields(status, see);
    }
}

// The structs are taken apart by name, so that a new field cannot be forgotten here.

fn command_fields(command: &PwmCommand, see: See<'_>) {
    let PwmCommand { duty, rectification, sample_at, sample_mode, step, commutations } = command;
    see(COMMAND, b'P'.into());
    see("duty", duty.to_bits().into());
    see(
        "rectification",
        Bits::from(match rectification {
            Rectification::Diode => 0_u8,
            Rectification::Synchronous => 1,
        }),
    );
    see("sample_at", (*sample_at).into());
    see(
        "sample_mode",
        Bits::from(match sample_mode {
            SampleMode::OffTime => 0_u8,
            SampleMode::OnTime => 1,
        }),
    );
    see("step", Bits::from(*step as u8));
    see("commutations", Bits::from(commutations.iter().count() as u8));
    for Commutation { instant, step } in commutations.iter() {
        see("commutation.instant", instant.into());
        see("commutation.step", Bits::from(step as u8));
    }
}

fn status_fields(status: &Status, see: See<'_>) {
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
        standstill,
        unseen,
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
    see(STATUS, b'S'.into());
    see("tick", (*tick).into());
    see("state", Bits::from(*state as u8));
    see("faults", faults.bits().into());
    see("critical", critical.bits().into());
    see("extended_code", (*extended_code).into());
    see("command_expired", (*command_expired).into());
    see("refusal", Bits::from(*refusal as u8));
    see("supply_low", (*supply_low).into());
    see("direction", Bits::from(*direction as u8));
    see("setpoint", setpoint.to_bits().into());
    see("speed_hall", speed_hall.to_bits().into());
    see("speed_sensorless", speed_sensorless.to_bits().into());
    see("angle", angle.0.into());
    see("sectors", (*sectors).into());
    see("standstill", (*standstill).into());
    see("unseen", (*unseen).into());
    see("bus_voltage", bus_voltage.to_bits().into());
    see("bus_current", bus_current.to_bits().into());
    see("power", power.to_bits().into());
    see("phase_voltage_a", voltage_a.to_bits().into());
    see("phase_voltage_b", voltage_b.to_bits().into());
    see("phase_voltage_c", voltage_c.to_bits().into());
    see("duty", duty.to_bits().into());
    see("limiter", Bits::from(*limiter as u8));
    see("hall_invalid", (*hall_invalid).into());
    see("hall_jumps", (*hall_jumps).into());
    match hall_calibration {
        HallCalibration::None => see("hall_calibration", 0_u8.into()),
        HallCalibration::Running => see("hall_calibration", 1_u8.into()),
        HallCalibration::Done(HallWiring { order, polarity, offset }) => {
            see("hall_calibration", 2_u8.into());
            see("hall_order", (*order).into());
            see("hall_polarity", (*polarity).into());
            see("hall_offset", (*offset).into());
        }
        HallCalibration::Failed => see("hall_calibration", 3_u8.into()),
    }
    see("crossing", Bits::from(*crossing as u8));
    see("crossing_margin", (*crossing_margin).into());
    see("crossings", (*crossings).into());
}
