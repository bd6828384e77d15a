//! Trace of a bench: its signals, tick by tick.

use super::Bench;
use crate::plant::{Observation, Plant, ShaftState};
use crate::trace::{Column, Precision, Signal, Trace};
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::cell::OnceCell;
use core::mem;
use core::num::NonZeroU32;
use narx_core::dictionary::number;
use narx_core::motor::Drive;
use narx_core::motor::commutate::commutation::sector_of;
use narx_core::units::{ElectricalAngle, ElectricalSpeed};

/// Electrical degrees of a margin of 1 (u16 turn).
const DEGREES: f64 = 360.0 / 65_536.0;

/// Number of signals.
const COUNT: usize = 28;
/// Computes a signal's value.
type Value = fn(&Tick<'_>) -> f64;

/// Signals of a bench's trace, and how each is computed: the fixed columns of `run.csv` first.
const TABLE: [(Signal, Value); COUNT] = [
    (Signal::double("time", "s"), |tick| tick.plant.time()),
    (Signal::single("setpoint", "rpm"), |tick| tick.bench.rpm(tick.bench.status().setpoint)),
    (Signal::single("speed", "rpm"), |tick| tick.shaft().speed * 60.0 / core::f64::consts::TAU),
    (Signal::single("speed_estimated", "rpm"), |tick| tick.bench.rpm(tick.bench.estimated())),
    (Signal::single("state", ""), |tick| f64::from(tick.drive().state() as u8)),
    (Signal::single("sector", ""), |tick| {
        f64::from(sector_of(ElectricalAngle((tick.turn() * 65_536.0) as u16)))
    }),
    (Signal::single("duty", ""), |tick| f64::from(tick.bench.command.duty.to_bits()) / 32_768.0),
    (Signal::single("current_a", "A"), |tick| tick.plant.current()[0]),
    (Signal::single("current_b", "A"), |tick| tick.plant.current()[1]),
    (Signal::single("current_c", "A"), |tick| tick.plant.current()[2]),
    (Signal::single("bus_current", "A"), |tick| tick.plant.bus_current()),
    (Signal::single("bus_voltage", "V"), |tick| tick.plant.bus_voltage()),
    (Signal::single("torque", "N m"), |tick| tick.plant.torque()),
    (Signal::single("voltage_a", "V"), |tick| tick.seen().terminal[0]),
    (Signal::single("voltage_b", "V"), |tick| tick.seen().terminal[1]),
    (Signal::single("voltage_c", "V"), |tick| tick.seen().terminal[2]),
    (Signal::single("angle", "deg"), |tick| tick.turn() * 360.0),
    (Signal::single("hall", ""), |tick| f64::from(tick.bench.hall)),
    (Signal::single("step", ""), |tick| f64::from(tick.bench.command.step as u8)),
    (Signal::single("limiter", ""), |tick| f64::from(tick.drive().limiter() as u8)),
    (Signal::double("faults", ""), |tick| f64::from(tick.bench.status().faults.bits())),
    (Signal::double("position", "rad"), |tick| tick.seen().angle),
    (Signal::double("energy_in", "J"), |tick| tick.seen().ledger.source),
    (Signal::double("energy_shaft", "J"), |tick| tick.seen().ledger.shaft),
    (Signal::single("winding_temperature", "degC"), |tick| tick.plant.winding_temperature()),
    (Signal::single("peak_current", "A"), |tick| tick.plant.peak_current()),
    (Signal::single("crossing", ""), |tick| f64::from(tick.drive().crossing().0 as u8)),
    (Signal::single("crossing_margin", "deg"), |tick| f64::from(tick.drive().crossing().1) * DEGREES),
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

/// A control tick that has ended. What several signals share is computed once, and only if one of them is
/// kept.
struct Tick<'a> {
    bench: &'a Bench,
    plant: &'a Plant,
    shaft: OnceCell<ShaftState>,
    seen: OnceCell<Observation>,
}

impl<'a> Tick<'a> {
    fn new(bench: &'a Bench) -> Self {
        Self { bench, plant: &bench.plant, shaft: OnceCell::new(), seen: OnceCell::new() }
    }

    fn drive(&self) -> &Drive {
        self.bench.device.drive()
    }

    fn shaft(&self) -> &ShaftState {
        self.shaft.get_or_init(|| self.plant.shaft())
    }

    fn seen(&self) -> &Observation {
        self.seen.get_or_init(|| self.plant.observe())
    }

    /// Electrical angle, turns from 0 to 1.
    fn turn(&self) -> f64 {
        let turns = self.shaft().electrical_turns;
        turns - libm::floor(turns)
    }
}

/// Rows by which columns grow.
const BLOCK: usize = 256;

/// Rows that a bench keeps. A column is beside the function that fills it, so that a row is one pass; and all
/// columns have room for the same rows, so that this is checked once a row.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    signals: Vec<Signal>,
    singles: Vec<(Value, Vec<f32>)>,
    doubles: Vec<(Value, Vec<f64>)>,
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
        Self::of(TABLE.into_iter(), NonZeroU32::MIN)
    }

    /// These signals, in one of `every` ticks.
    fn of(columns: impl Iterator<Item = (Signal, Value)>, every: NonZeroU32) -> Self {
        let (signals, singles, doubles) = Default::default();
        let every = every.get();
        let mut kept = Self { signals, singles, doubles, rows: 0, room: 0, every, left: every };
        for (signal, value) in columns {
            kept.signals.push(signal);
            match signal.precision {
                Precision::Single => kept.singles.push((value, Vec::new())),
                Precision::Double => kept.doubles.push((value, Vec::new())),
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

    fn push(&mut self, tick: &Tick<'_>) {
        if self.rows == self.room {
            self.make_room();
        }
        for (value, column) in &mut self.singles {
            if let Some(place) = column.get_mut(self.rows) {
                *place = value(tick) as f32;
            }
        }
        for (value, column) in &mut self.doubles {
            if let Some(place) = column.get_mut(self.rows) {
                *place = value(tick);
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
        let columns = places.iter().filter_map(|place| TABLE.get(*place).copied());
        self.kept = Some(Box::new(Kept::of(columns, every)));
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
        let tick = Tick::new(self);
        TABLE.map(|(_, value)| value(&tick))
    }

    fn rpm(&self, speed: ElectricalSpeed) -> f64 {
        f64::from(speed.to_bits()) / 65_536.0 * 60.0 / self.pole_pairs
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
            kept.push(&Tick::new(self));
        }
        self.kept = Some(kept);
    }
}
