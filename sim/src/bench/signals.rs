//! Trace of a bench: its signals, tick by tick.

use super::Bench;
use crate::plant::Observation;
use crate::trace::{Column, Precision, Signal, Trace};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::mem;
use core::num::NonZeroU32;
use narx_core::dictionary::number;
use narx_core::motor::commutate::commutation::sector_of;
use narx_core::units::{ElectricalAngle, ElectricalSpeed};

/// Electrical degrees of a margin of 1 (u16 turn).
const DEGREES: f64 = 360.0 / 65_536.0;

/// Number of signals.
const COUNT: usize = 28;

/// Origin of a signal's value, by rising cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    /// Motor, supply and duty.
    Motor,
    /// The drive's view, and what follows from the shaft's angle.
    Drive,
    /// All that a plant can tell, [`Plant::observe`](crate::plant::Plant::observe).
    Observed,
}
use Source::{Drive, Motor, Observed};

/// Signals of a bench's trace, and where each comes from: the fixed columns of `run.csv` first.
const TABLE: [(Signal, Source); COUNT] = [
    (Signal::double("time", "s"), Motor),
    (Signal::single("setpoint", "rpm"), Drive),
    (Signal::single("speed", "rpm"), Motor),
    (Signal::single("speed_estimated", "rpm"), Drive),
    (Signal::single("state", ""), Drive),
    (Signal::single("sector", ""), Drive),
    (Signal::single("duty", ""), Motor),
    (Signal::single("current_a", "A"), Motor),
    (Signal::single("current_b", "A"), Motor),
    (Signal::single("current_c", "A"), Motor),
    (Signal::single("bus_current", "A"), Motor),
    (Signal::single("bus_voltage", "V"), Motor),
    (Signal::single("torque", "N m"), Motor),
    (Signal::single("voltage_a", "V"), Observed),
    (Signal::single("voltage_b", "V"), Observed),
    (Signal::single("voltage_c", "V"), Observed),
    (Signal::single("angle", "deg"), Drive),
    (Signal::single("hall", ""), Drive),
    (Signal::single("step", ""), Drive),
    (Signal::single("limiter", ""), Drive),
    (Signal::double("faults", ""), Drive),
    (Signal::double("position", "rad"), Observed),
    (Signal::double("energy_in", "J"), Observed),
    (Signal::double("energy_shaft", "J"), Observed),
    (Signal::single("winding_temperature", "degC"), Drive),
    (Signal::single("peak_current", "A"), Drive),
    (Signal::single("crossing", ""), Drive),
    (Signal::single("crossing_margin", "deg"), Drive),
];

/// Signals of a bench's trace, in the order of its columns.
pub const SIGNALS: [Signal; COUNT] = {
    let mut signals = [TABLE[0].0; COUNT];
    let mut place = 0;
    while place < COUNT {
        signals[place] = TABLE[place].0;
        place += 1;
    }
    signals
};

/// Rows by which columns grow.
const BLOCK: usize = 256;

/// Rows that a bench keeps. A column is beside its signal's place, so that a row is one pass; and all columns
/// have room for the same rows, so that this is checked once a row.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    signals: Vec<Signal>,
    singles: Vec<(usize, Vec<f32>)>,
    doubles: Vec<(usize, Vec<f64>)>,
    /// The dearest source of these signals.
    source: Source,
    rows: usize,
    /// Length of the columns: rows, and room for more.
    room: usize,
    /// One row of this many ticks is kept.
    every: u32,
    /// Ticks to the next row.
    left: u32,
}

impl Kept {
    /// Every signal in every tick.
    pub(super) fn all() -> Self {
        Self::of(0..COUNT, NonZeroU32::MIN)
    }

    /// The signals at these places, in one of `every` ticks.
    fn of(places: impl Iterator<Item = usize>, every: NonZeroU32) -> Self {
        let (signals, singles, doubles) = Default::default();
        let every = every.get();
        let mut kept =
            Self { signals, singles, doubles, source: Motor, rows: 0, room: 0, every, left: every };
        for (place, (signal, source)) in places.filter_map(|place| Some((place, TABLE.get(place)?))) {
            kept.signals.push(*signal);
            kept.source = kept.source.max(*source);
            match signal.precision {
                Precision::Single => kept.singles.push((place, Vec::new())),
                Precision::Double => kept.doubles.push((place, Vec::new())),
            }
        }
        kept
    }

    /// Returns whether the tick that has just ended has a row.
    const fn is_due(&mut self) -> bool {
        self.left -= 1;
        if self.left > 0 {
            return false;
        }
        self.left = self.every;
        true
    }

    fn reserve(&mut self, ticks: u64) {
        let rows = usize::try_from(ticks.div_ceil(self.every.into())).unwrap_or(usize::MAX);
        let rows = rows.saturating_add(BLOCK);
        // Without the memory a column grows as its rows come.
        self.singles.iter_mut().for_each(|(_, column)| drop(column.try_reserve_exact(rows)));
        self.doubles.iter_mut().for_each(|(_, column)| drop(column.try_reserve_exact(rows)));
    }

    #[cold]
    fn make_room(&mut self) {
        self.room += BLOCK;
        self.singles.iter_mut().for_each(|(_, column)| column.resize(self.room, 0.0));
        self.doubles.iter_mut().for_each(|(_, column)| column.resize(self.room, 0.0));
    }

    fn push(&mut self, row: &[f64; COUNT]) {
        if self.rows == self.room {
            self.make_room();
        }
        for (place, column) in &mut self.singles {
            if let (Some(kept), Some(value)) = (column.get_mut(self.rows), row.get(*place)) {
                *kept = *value as f32;
            }
        }
        for (place, column) in &mut self.doubles {
            if let (Some(kept), Some(value)) = (column.get_mut(self.rows), row.get(*place)) {
                *kept = *value;
            }
        }
        self.rows += 1;
    }

    /// Returns the rows so far, and has none afterwards.
    fn take(&mut self) -> Trace {
        let rows = mem::take(&mut self.rows);
        self.room = 0;
        self.singles.iter_mut().for_each(|(_, column)| column.truncate(rows));
        self.doubles.iter_mut().for_each(|(_, column)| column.truncate(rows));
        let mut singles = self.singles.iter_mut().map(|(_, column)| Column::Single(mem::take(column)));
        let mut doubles = self.doubles.iter_mut().map(|(_, column)| Column::Double(mem::take(column)));
        let columns = self.signals.iter().filter_map(|signal| match signal.precision {
            Precision::Single => singles.next(),
            Precision::Double => doubles.next(),
        });
        Trace::of(&self.signals, columns.collect())
    }
}

impl Bench {
    /// Keeps rows of all signals from now on, or forgets those so far and keeps none.
    pub fn set_trace(&mut self, keep: bool) {
        let kept = self.kept.take();
        self.kept = keep.then(|| kept.unwrap_or_else(|| Box::new(Kept::all())));
    }

    /// Keeps a row of one in `every` ticks from now on, with the signals at these places of [`SIGNALS`];
    /// forgets the rows so far. The fewer signals, the faster: what none of them needs is not computed.
    /// False, and nothing changes, if there is no such place.
    #[must_use]
    pub fn set_trace_of(&mut self, places: &[usize], every: NonZeroU32) -> bool {
        if places.iter().any(|place| *place >= COUNT) {
            return false;
        }
        self.kept = Some(Box::new(Kept::of(places.iter().copied(), every)));
        true
    }

    /// Makes room for the rows of so many ticks, so that those kept are not moved as others come. Without
    /// the memory for it they are moved.
    pub fn reserve_trace(&mut self, ticks: u64) {
        if let Some(kept) = &mut self.kept {
            kept.reserve(ticks);
        }
    }

    /// The rows so far; empty if the bench keeps none.
    pub fn trace(&self) -> Trace {
        self.kept.clone().map_or_else(|| Trace::new(&SIGNALS), |mut kept| kept.take())
    }

    /// The rows since the last call, or since power-up; empty if the bench keeps none.
    pub fn take_trace(&mut self) -> Trace {
        self.kept.as_mut().map_or_else(|| Trace::new(&SIGNALS), |kept| kept.take())
    }

    /// The present value of every signal, in the order of [`SIGNALS`].
    pub fn values(&self) -> [f64; COUNT] {
        self.row(Observed)
    }

    /// The values at the end of a tick; 0 for those of a dearer source than `source`.
    #[inline]
    fn row(&self, source: Source) -> [f64; COUNT] {
        let plant = &self.plant;
        let shaft = plant.shaft();
        let turn =
            if source >= Drive { shaft.electrical_turns - libm::floor(shaft.electrical_turns) } else { 0.0 };
        let drive = |value: fn(&Self) -> f64| if source >= Drive { value(self) } else { 0.0 };
        let seen = (source >= Observed).then(|| plant.observe());
        let seen = |value: fn(&Observation) -> f64| seen.as_ref().map_or(0.0, value);
        let [current_a, current_b, current_c] = plant.current();
        [
            plant.time(),
            drive(|bench| bench.rpm(bench.status().setpoint)),
            shaft.speed * 60.0 / core::f64::consts::TAU,
            drive(|bench| bench.rpm(bench.estimated())),
            drive(|bench| f64::from(bench.device.drive().state() as u8)),
            f64::from(sector_of(ElectricalAngle((turn * 65_536.0) as u16))),
            f64::from(self.command.duty.to_bits()) / 32_768.0,
            current_a,
            current_b,
            current_c,
            plant.bus_current(),
            plant.bus_voltage(),
            plant.torque(),
            seen(|seen| seen.terminal[0]),
            seen(|seen| seen.terminal[1]),
            seen(|seen| seen.terminal[2]),
            turn * 360.0,
            drive(|bench| f64::from(bench.hall)),
            drive(|bench| f64::from(bench.command.step as u8)),
            drive(|bench| f64::from(bench.device.drive().limiter() as u8)),
            drive(|bench| f64::from(bench.status().faults.bits())),
            seen(|seen| seen.angle),
            seen(|seen| seen.ledger.source),
            seen(|seen| seen.ledger.shaft),
            drive(|bench| bench.plant.winding_temperature()),
            drive(|bench| bench.plant.peak_current()),
            drive(|bench| f64::from(bench.device.drive().crossing().0 as u8)),
            drive(|bench| f64::from(bench.device.drive().crossing().1) * DEGREES),
        ]
    }

    fn rpm(&self, speed: ElectricalSpeed) -> f64 {
        f64::from(speed.to_bits()) * self.rpm_per_bit
    }

    /// Speed that the drive estimates, of hall sensors or back-EMF.
    fn estimated(&self) -> ElectricalSpeed {
        let status = self.status();
        let is_hall = self.node().parameters().raw(number::HALL_ENABLE) == 1;
        if is_hall { status.speed_hall } else { status.speed_sensorless }
    }

    pub(super) fn keep(&mut self) {
        // Taken out, because the values are the bench's.
        let Some(mut kept) = self.kept.take() else { return };
        if kept.is_due() {
            kept.push(&self.row(kept.source));
        }
        self.kept = Some(kept);
    }
}
