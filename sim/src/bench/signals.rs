//! Trace of a bench: its signals, tick by tick.

use super::Bench;
use crate::plant::Observation;
use crate::trace::{Signal, Trace};
use narx_core::dictionary::number;
use narx_core::motor::PwmCommand;
use narx_core::motor::commutate::commutation::sector_of;
use narx_core::units::{ElectricalAngle, ElectricalSpeed};

/// Electrical degrees of a margin of 1 (u16 turn).
const DEGREES: f64 = 360.0 / 65_536.0;

/// Signals of a bench's trace: the fixed columns of `run.csv` first.
pub const SIGNALS: [Signal; 28] = [
    Signal::double("time", "s"),
    Signal::single("setpoint", "rpm"),
    Signal::single("speed", "rpm"),
    Signal::single("speed_estimated", "rpm"),
    Signal::single("state", ""),
    Signal::single("sector", ""),
    Signal::single("duty", ""),
    Signal::single("current_a", "A"),
    Signal::single("current_b", "A"),
    Signal::single("current_c", "A"),
    Signal::single("bus_current", "A"),
    Signal::single("bus_voltage", "V"),
    Signal::single("torque", "N m"),
    Signal::single("voltage_a", "V"),
    Signal::single("voltage_b", "V"),
    Signal::single("voltage_c", "V"),
    Signal::single("angle", "deg"),
    Signal::single("hall", ""),
    Signal::single("step", ""),
    Signal::single("limiter", ""),
    Signal::double("faults", ""),
    Signal::double("position", "rad"),
    Signal::double("energy_in", "J"),
    Signal::double("energy_shaft", "J"),
    Signal::single("winding_temperature", "degC"),
    Signal::single("peak_current", "A"),
    Signal::single("crossing", ""),
    Signal::single("crossing_margin", "deg"),
];

impl Bench {
    /// Keeps rows from now on, or forgets those so far and keeps none.
    pub fn set_trace(&mut self, keep: bool) {
        let kept = self.trace.take();
        self.trace = keep.then(|| kept.unwrap_or_else(|| Trace::new(&SIGNALS)));
    }

    /// One row per tick so far; empty if the bench keeps none.
    pub fn trace(&self) -> Trace {
        self.trace.clone().unwrap_or_else(|| Trace::new(&SIGNALS))
    }

    /// The rows since the last call, or since power-up; empty if the bench keeps none.
    pub fn take_trace(&mut self) -> Trace {
        let empty = Trace::new(&SIGNALS);
        self.trace.as_mut().map_or_else(|| empty.clone(), |trace| core::mem::replace(trace, empty.clone()))
    }

    /// The present value of every signal, in the order of [`SIGNALS`].
    pub fn values(&self) -> [f64; SIGNALS.len()] {
        self.row(&self.plant.observe(), &self.command, self.hall)
    }

    fn rpm(&self, speed: ElectricalSpeed) -> f64 {
        f64::from(speed.to_bits()) / 65_536.0 * 60.0 / self.pole_pairs
    }

    pub(super) fn keep(&mut self) {
        if self.trace.is_none() {
            return;
        }
        let row = self.values();
        if let Some(trace) = &mut self.trace {
            // As many values as signals: both stand in this file.
            let _ = trace.push(&row);
        }
    }

    fn row(&self, seen: &Observation, command: &PwmCommand, hall: u8) -> [f64; SIGNALS.len()] {
        let status = self.node().status();
        let (crossing, margin, _) = self.device.drive().crossing();
        let turns = seen.electrical_turns - libm::floor(seen.electrical_turns);
        let estimated = if self.node().parameters().raw(number::HALL_ENABLE) == 1 {
            status.speed_hall
        } else {
            status.speed_sensorless
        };
        [
            seen.time,
            self.rpm(status.setpoint),
            seen.speed * 60.0 / core::f64::consts::TAU,
            self.rpm(estimated),
            f64::from(self.device.drive().state() as u8),
            f64::from(sector_of(ElectricalAngle((turns * 65_536.0) as u16))),
            f64::from(command.duty.to_bits()) / 32_768.0,
            seen.current[0],
            seen.current[1],
            seen.current[2],
            seen.bus_current,
            seen.bus_voltage,
            seen.torque,
            seen.terminal[0],
            seen.terminal[1],
            seen.terminal[2],
            turns * 360.0,
            f64::from(hall),
            f64::from(command.step as u8),
            f64::from(self.device.drive().limiter() as u8),
            f64::from(status.faults.bits()),
            seen.angle,
            seen.ledger.source,
            seen.ledger.shaft,
            seen.winding_temperature,
            seen.peak_current,
            f64::from(crossing as u8),
            f64::from(margin) * DEGREES,
        ]
    }
}
