//! Hall sensors: codes and time-stamped edges to sector, angle and speed.

use super::error::{SettingError, quantity_within, within};
use super::{Position, factory, speed_of_turns, tick_rate, ticks, turn_of_centidegrees, turns_of_speed};
use crate::dictionary::number;
use crate::motor::clock::Instant;
use crate::motor::gain::Gain;
use crate::motor::rotor::hall::{
    Hall as Station, HallCoefficients, HallDiagnostics, HallEvents, HallWiring, sectors,
};
use crate::motor::sense::samples::{EDGES_MAX, Edge, Samples};
use crate::units::{ElectricalAngle, ElectricalSpeed};
use serde::Serialize;

/// Settings of a [`Hall`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HallSettings {
    /// Ticks a second, 1 000 to 100 000 Hz.
    pub tick_rate: u32,
    /// Offset of the edges beyond their place, -18 000 to 18 000 in 0.01 electrical degree (parameter 80).
    pub offset_cdeg: i32,
    /// No edge for this long means standstill, 1 to 65 535 ms (parameter 113), and no more than 65 535 ticks.
    pub timeout_ms: u32,
    /// Slowest electrical speed that is interpolated between edges, rev/s; below, the middle of the sector
    /// stands for all of it.
    pub interpolation_min: ElectricalSpeed,
    /// Permutation of the lines, 0 to 5 (parameter 262); 0 is A, B, C.
    pub order: u8,
    /// Lines to invert before the permutation, 0 to 7: bit 0 = A, bit 1 = B, bit 2 = C.
    pub polarity: u8,
    /// Edges are time-stamped; else only the level is read, once a tick.
    pub captured: bool,
}

impl Default for HallSettings {
    /// 10 kHz, lines as they are named, the factory's time-out, 1 rev/s, captured edges.
    fn default() -> Self {
        Self {
            tick_rate: 10_000,
            order: 0,
            polarity: 0,
            offset_cdeg: 0,
            timeout_ms: const { factory(number::HALL_PERIOD_TIMEOUT) },
            interpolation_min: ElectricalSpeed::from_bits(1 << 16),
            captured: true,
        }
    }
}

/// Reading of the sensors after a tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct HallReading {
    /// Sector, 0 to 5: sector s spans 30 + 60 s to 90 + 60 s degrees. `None` until the first valid code.
    pub sector: Option<u8>,
    /// Angle and speed at the present boundary, for a [`Commutation`](super::Commutation).
    pub position: Position,
    /// Electrical speed, signed, limited by the time for which the next edge has not come.
    pub speed: ElectricalSpeed,
    /// Events of this tick.
    pub events: HallEvents,
    /// No edge for the time-out: standstill.
    pub stopped: bool,
    /// The rotor seems to have jumped or reversed at speed, or the code stays invalid: torque by this
    /// position could act in any direction.
    pub doubtful: bool,
}

/// Ready-made coefficients of a hall station: those that its settings build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[repr(C)]
pub struct HallReady {
    /// The station's own.
    pub station: HallCoefficients,
    /// Rev/s (raw I16F16) of 2^-32 turn a tick.
    pub speed_of_turns: Gain,
}

/// The hall station: sector, angle and speed. A single glitch is debounced and counted;
/// [`Fault`](super::Fault) decides when glitches are a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hall {
    ready: HallReady,
    now: Instant,
    station: Station,
}

impl Hall {
    /// Builds a station that has not seen the sensors yet.
    ///
    /// # Errors
    /// The setting that is out of range.
    pub fn build(settings: &HallSettings) -> Result<Self, SettingError> {
        let rate = tick_rate(settings.tick_rate)?;
        within("order", settings.order.into(), 0, 5, "")?;
        within("polarity", settings.polarity.into(), 0, 7, "")?;
        within("offset_cdeg", settings.offset_cdeg.into(), -18_000, 18_000, "0.01 degree")?;
        let longest = i64::from(u16::MAX) * 1000 / i64::from(rate);
        within("timeout_ms", settings.timeout_ms.into(), 1, longest, "ms")?;
        let floor = settings.interpolation_min.to_bits();
        quantity_within("interpolation_min", floor, 0, (rate as i32 / 12) << 16, "rev/s")?;
        let wiring = HallWiring { order: settings.order, polarity: settings.polarity, offset: 0 };
        let offset = turn_of_centidegrees(settings.offset_cdeg);
        let station = HallCoefficients {
            sectors: sectors(wiring),
            offset: ElectricalAngle((offset >> 16) as u16),
            timeout: ticks(settings.timeout_ms, rate) << 16,
            interpolation_min: turns_of_speed(rate).apply32(floor).unsigned_abs(),
            captured: settings.captured,
            lost_after: ((rate * 3 + 5_000) / 10_000).clamp(1, u8::MAX.into()) as u8,
        };
        Ok(Self::new(HallReady { station, speed_of_turns: speed_of_turns(rate) }))
    }

    /// A station that has not seen the sensors yet, with ready-made coefficients, which are not checked.
    pub fn new(ready: HallReady) -> Self {
        Self { ready, now: Instant::default(), station: Station::default() }
    }

    /// Its coefficients, for [`new`](Self::new) elsewhere.
    pub const fn ready(&self) -> &HallReady {
        &self.ready
    }

    /// Runs one tick with the lines now (bit 0 = A, bit 1 = B, bit 2 = C) and the edges of the period that
    /// has ended, oldest first; only the first [`EDGES_MAX`] count.
    pub fn step(&mut self, code: u8, edges: &[Edge]) -> HallReading {
        let edges = edges.iter().copied().take(EDGES_MAX).collect();
        let samples = Samples { hall: code, edges, ..Samples::default() };
        self.now = self.now.next();
        let events = self.station.step(&self.ready.station, self.now, &samples);
        let speed = self.station.speed_bounded(self.now);
        HallReading {
            sector: self.station.sector(),
            position: Position { angle: self.station.angle(self.now), speed: self.station.speed() },
            speed: ElectricalSpeed::from_bits(self.ready.speed_of_turns.apply32(speed)),
            events,
            stopped: self.station.stopped(),
            doubtful: self.station.doubtful(&self.ready.station),
        }
    }

    /// Invalid codes and jumps since it was built.
    pub const fn diagnostics(&self) -> HallDiagnostics {
        self.station.diagnostics()
    }
}
