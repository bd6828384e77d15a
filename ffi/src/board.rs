//! Constants of the board that the control core needs.

use crate::pointer;
use crate::status::narx_status_t;
use narx_core::motor::{Board, Channel, Equipment, FrontEnd};

/// One channel of the converter: value = (code - zero) * micro_per_code / 1 000 000.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_channel_t {
    /// Nominal code at 0 V or 0 A, 0 to 4095.
    pub zero: u16,
    /// Micro-units (uV or uA) of one code; positive.
    pub micro_per_code: i32,
}

/// Constants of a board.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_board_t {
    /// Control ticks, and PWM periods, per second (Hz): 1 000 to 100 000.
    pub tick_rate: u32,
    /// First instant of a period at which a new step can act, in 1/65 536 of the period: the sample is taken
    /// and narx_drive_step has returned.
    pub earliest: u16,
    /// Time for which both switches of a leg stay off between one and the other, ns.
    pub dead_time_ns: u16,
    /// Resistance of the two switches that conduct in a step, milliohm; the drive computes its losses from it
    /// (output power, Table 1).
    pub bridge_milliohm: u16,
    /// Not 0: the hall lines have time-stamping input captures.
    pub hall_capture: u8,
    /// Not 0: back-EMF comparators with time-stamping input captures watch the floating phase.
    pub comparator_capture: u8,
    /// Parts that the board has; the drive refuses a parameter value that needs another one. Sum of 1
    /// external temperature sensor, 2 switch for the supply of the hall sensors, 4 DSIO1 and DSIO2 as inputs,
    /// 8 as outputs, 16 accelerometer, 32 pressure input, 64 memory of the log.
    pub equipment: u8,
    /// Bus voltage, uV per code.
    pub bus_voltage: narx_channel_t,
    /// Terminal voltages of the three phases against ground, uV per code.
    pub phase_voltage: narx_channel_t,
    /// DC-link current, uA per code; positive from the supply into the bridge.
    pub bus_current: narx_channel_t,
}

/// Writes the default board, as a start for your own: 10 kHz, a tick that takes at most 12.5 us, 500 ns dead
/// time, 12-bit converters to 80 V and +-16.4 A.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_board_default(board: *mut narx_board_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { pointer::write(board, Board::BENCH.into()) })
}

impl From<narx_channel_t> for Channel {
    fn from(channel: narx_channel_t) -> Self {
        Self { zero: channel.zero, micro_per_code: channel.micro_per_code }
    }
}

impl From<Channel> for narx_channel_t {
    fn from(Channel { zero, micro_per_code }: Channel) -> Self {
        Self { zero, micro_per_code }
    }
}

impl From<&narx_board_t> for Board {
    fn from(board: &narx_board_t) -> Self {
        Self {
            tick_rate: board.tick_rate,
            earliest: board.earliest,
            dead_time_ns: board.dead_time_ns,
            bridge_milliohm: board.bridge_milliohm,
            hall_capture: board.hall_capture != 0,
            comparator_capture: board.comparator_capture != 0,
            equipment: Equipment::from_bits_truncate(board.equipment),
            front_end: FrontEnd {
                bus_voltage: board.bus_voltage.into(),
                phase_voltage: board.phase_voltage.into(),
                bus_current: board.bus_current.into(),
            },
        }
    }
}

impl From<Board> for narx_board_t {
    fn from(
        Board {
            tick_rate,
            earliest,
            dead_time_ns,
            bridge_milliohm,
            hall_capture,
            comparator_capture,
            equipment,
            front_end,
        }: Board,
    ) -> Self {
        let FrontEnd { bus_voltage, phase_voltage, bus_current } = front_end;
        Self {
            tick_rate,
            earliest,
            dead_time_ns,
            bridge_milliohm,
            hall_capture: hall_capture.into(),
            comparator_capture: comparator_capture.into(),
            equipment: equipment.bits(),
            bus_voltage: bus_voltage.into(),
            phase_voltage: phase_voltage.into(),
            bus_current: bus_current.into(),
        }
    }
}
