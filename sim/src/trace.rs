//! Record of a run: named signals with units, one row per control tick.

use alloc::vec::Vec;
use core::fmt;

/// Precision with which a signal is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit float: anything measured.
    Single,
    /// 64-bit float: time and counts.
    Double,
}

/// Name, unit and precision of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// Name as in `run.csv`: lower case, words joined by `_`.
    pub name: &'static str,
    /// SI unit or `rpm`; empty for plain numbers.
    pub unit: &'static str,
    /// Precision with which it is kept.
    pub precision: Precision,
}

impl Signal {
    /// A signal of 32 bits.
    pub const fn single(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, precision: Precision::Single }
    }
    /// A signal of 64 bits.
    pub const fn double(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, precision: Precision::Double }
    }
}

/// The values of one signal, a row each.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// 32 bits each.
    Single(Vec<f32>),
    /// 64 bits each.
    Double(Vec<f64>),
}

impl Column {
    /// Number of rows.
    pub const fn len(&self) -> usize {
        match self {
            Self::Single(values) => values.len(),
            Self::Double(values) => values.len(),
        }
    }
    /// Returns whether there is no row.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The value of one row.
    pub fn value(&self, row: usize) -> Option<f64> {
        match self {
            Self::Single(values) => values.get(row).map(|value| f64::from(*value)),
            Self::Double(values) => values.get(row).copied(),
        }
    }
    /// All values in order.
    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).filter_map(|row| self.value(row))
    }
}

/// A table of signals.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    signals: Vec<Signal>,
    columns: Vec<Column>,
}

/// A row has another number of values than the trace has signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowLength {
    /// Values in the row.
    pub given: usize,
    /// Signals in the trace.
    pub expected: usize,
}

impl fmt::Display for RowLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a row of {} values for {} signals", self.given, self.expected)
    }
}

impl core::error::Error for RowLength {}

impl Trace {
    /// An empty trace of these signals.
    pub fn new(signals: &[Signal]) -> Self {
        let column = |signal: &Signal| match signal.precision {
            Precision::Single => Column::Single(Vec::new()),
            Precision::Double => Column::Double(Vec::new()),
        };
        Self { signals: signals.to_vec(), columns: signals.iter().map(column).collect() }
    }

    /// A trace of these columns, as long as each other and of the signals' precision.
    pub(crate) fn of(signals: &[Signal], columns: Vec<Column>) -> Self {
        Self { signals: signals.to_vec(), columns }
    }

    /// Appends a row, one value for each signal in order.
    pub fn push(&mut self, row: &[f64]) -> Result<(), RowLength> {
        if row.len() != self.signals.len() {
            return Err(RowLength { given: row.len(), expected: self.signals.len() });
        }
        for (column, value) in self.columns.iter_mut().zip(row) {
            match column {
                Column::Single(values) => values.push(*value as f32),
                Column::Double(values) => values.push(*value),
            }
        }
        Ok(())
    }

    /// The signals in order.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// The columns in the order of the signals.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The columns in the order of the signals, moved out.
    pub fn into_columns(self) -> Vec<Column> {
        self.columns
    }

    /// The values of the signal with this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        let index = self.signals.iter().position(|signal| signal.name == name)?;
        self.columns.get(index)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Column::len)
    }

    /// Returns whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
