//! Slow inputs, bus state and outputs: data that the main loop exchanges with the drive besides frames.

use crate::bus_state::narx_bus_state_t;
use crate::device::{background, narx_drive_t};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::node::{Action, Outputs, SlowInputs};
use narx_core::units::{Celsius, Volts};

/// Readings of the board besides the tick's samples, before calibration. Volts and degrees Celsius in Q16:
/// 65 536 is 1 (narx_q16_from_milli).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_slow_inputs_t {
    /// Sensor on the power board.
    pub ambient_temperature: i32,
    /// External sensor, if there is one (parameter 8).
    pub external_temperature: i32,
    /// Pressure input after its amplifier.
    pub pressure: i32,
    /// Outputs of the accelerometer along X, Y, Z: 0.5 V a g about its zero-g level.
    pub accel: [i32; 3],
    /// 1.8 V reference of the accelerometer.
    pub accel_reference: i32,
    /// 0.383 VREF.
    pub reference: i32,
    /// 6 V rail.
    pub rail_6v: i32,
    /// 14 V rail of the gate drivers.
    pub rail_14v: i32,
    /// Analog signal input.
    pub asi: i32,
    /// Not 0: DSIO1 reads high.
    pub dsi1: u8,
    /// Not 0: DSIO2 reads high.
    pub dsi2: u8,
}

/// Levels to apply to the board: 0 or 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_outputs_t {
    /// 1: DSIO1 is an output; 0: an input.
    pub dsio1_enable: u8,
    /// Level of DSIO1.
    pub dsio1_level: u8,
    /// 1: DSIO2 is an output; 0: an input.
    pub dsio2_enable: u8,
    /// Level of DSIO2.
    pub dsio2_level: u8,
    /// Switch for the supply of the hall sensors.
    pub hall_supply: u8,
}

/// Takes a reading of the slow inputs, about every 10 ms. Temperature and pressure limits act from the first
/// reading on. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_handle_inputs(
    drive: *mut narx_drive_t,
    inputs: *const narx_slow_inputs_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let inputs = SlowInputs::from(pointer::read(inputs)?);
        background(drive)?.node().handle_inputs(inputs);
        Ok(())
    };
    pointer::status(run())
}

/// Takes the state of the CAN controller, as often as the board reads it (parameters 293 to 296). Off the bus
/// no frame is handed out, and frames that wait are dropped; drop those that wait in the controller, too.
/// Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_handle_bus_state(
    drive: *mut narx_drive_t,
    state: *const narx_bus_state_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let state = pointer::read(state)?.try_into()?;
        background(drive)?.node().handle_bus_state(state);
        Ok(())
    };
    pointer::status(run())
}

/// Writes the levels that the board's lines must have now. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_outputs(
    drive: *mut narx_drive_t,
    outputs: *mut narx_outputs_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let told = background(drive)?.node().outputs();
        pointer::write(outputs, told.into())
    };
    pointer::status(run())
}

/// Returns NARX_OK, once, when the master has requested a reboot and the acknowledgement was polled: reset
/// the processor, or call narx_drive_init. Returns NARX_NOTHING otherwise. Background half.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_drive_take_reboot(drive: *mut narx_drive_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || match unsafe { background(drive)? }.node().poll_action() {
        Some(Action::Reboot) => Ok(()),
        None => Err(NARX_NOTHING),
    };
    pointer::status(run())
}

impl From<&narx_slow_inputs_t> for SlowInputs {
    fn from(inputs: &narx_slow_inputs_t) -> Self {
        Self {
            ambient_temperature: Celsius::from_bits(inputs.ambient_temperature),
            external_temperature: Celsius::from_bits(inputs.external_temperature),
            pressure: Volts::from_bits(inputs.pressure),
            accel: inputs.accel.map(Volts::from_bits),
            accel_reference: Volts::from_bits(inputs.accel_reference),
            reference: Volts::from_bits(inputs.reference),
            rail_6v: Volts::from_bits(inputs.rail_6v),
            rail_14v: Volts::from_bits(inputs.rail_14v),
            asi: Volts::from_bits(inputs.asi),
            dsi1: inputs.dsi1 != 0,
            dsi2: inputs.dsi2 != 0,
        }
    }
}

impl From<Outputs> for narx_outputs_t {
    fn from(Outputs { digital, hall_supply }: Outputs) -> Self {
        Self {
            dsio1_enable: digital.enable1.into(),
            dsio1_level: digital.value1.into(),
            dsio2_enable: digital.enable2.into(),
            dsio2_level: digital.value2.into(),
            hall_supply: hall_supply.into(),
        }
    }
}
