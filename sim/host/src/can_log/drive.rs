//! Messages of the drive: the tables of core, a column for each field.

use super::column::{Signal, Table, Values};
use super::name::message_name;
use narx_core::bus::narmotion::{Field, MESSAGES, Meaning, Message, MessageKind, Words};
use narx_core::dictionary::Dictionary;
use narx_core::dictionary::engineering;

/// Whose messages count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ends {
    /// Address of the drive; `None` for any.
    pub slave: Option<u8>,
    /// Address of its master; `None` for any.
    pub monitor: Option<u8>,
}

/// Conversion of a field to a value of a column.
enum Cell {
    /// Raw number divided by this power of ten.
    Divided(f64),
    /// Raw number times this power of ten.
    Multiplied(f64),
    /// The value of the parameter whose number stands in word 0.
    Parameter,
}

/// Decoding plans of all messages.
pub(super) struct Plans {
    ends: Ends,
    plans: Vec<Vec<(Field, Cell)>>,
    /// The message of the lowest eleven bits of an identifier, which are type and opcode.
    places: Vec<u8>,
}

const NO_MESSAGE: u8 = u8::MAX;

/// An empty table for every message, in the order of core's.
pub(super) fn tables() -> impl Iterator<Item = Table> {
    MESSAGES.iter().map(|message| {
        let columns = message.fields().map(|field| (signal(&field), values(&field)));
        Table::new(message_name(message), message.kind == MessageKind::SlaveTx, columns)
    })
}

impl Plans {
    pub(super) fn new(ends: Ends) -> Self {
        let mut places = vec![NO_MESSAGE; 1 << 11];
        for (at, message) in MESSAGES.iter().enumerate() {
            let low = usize::from(message.kind as u8) << 9 | usize::from(message.opcode.raw());
            places[low] = at as u8;
        }
        Self { ends, plans: MESSAGES.iter().map(plan).collect(), places }
    }

    /// The place of the message with this 29-bit identifier, if it goes from one of the ends to the other.
    pub(super) fn place(&self, id: u32) -> Option<usize> {
        let place = self.places[(id & 0x7FF) as usize];
        let (source, destination) = ((id >> 19) as u8, (id >> 11) as u8);
        let from_drive = id >> 9 & 3 == MessageKind::SlaveTx as u32;
        let (drive, master) = if from_drive { (source, destination) } else { (destination, source) };
        let Ends { slave, monitor } = self.ends;
        let between =
            slave.is_none_or(|slave| slave == drive) && monitor.is_none_or(|monitor| monitor == master);
        (place != NO_MESSAGE && between).then_some(place.into())
    }

    /// Adds a row to the table of a message.
    pub(super) fn push(&self, place: usize, table: &mut Table, time: f64, data: [u8; 8]) {
        let [a, b, c, d, e, f, g, h] = data;
        let words = Words([[a, b], [c, d], [e, f], [g, h]].map(u16::from_be_bytes));
        table.time.push(time);
        for (values, (field, cell)) in table.columns.iter_mut().zip(&self.plans[place]) {
            let raw = field.raw(words);
            match values {
                Values::Quantity(values) => values.push(cell.quantity(raw, words)),
                Values::Number(values) => values.push(raw),
                Values::Code(values) => values.push(raw as u16),
                Values::Flag(values) => values.push(raw != 0),
                Values::Faults(values) => values.push(raw as u32),
            }
        }
    }
}

fn plan(message: &Message) -> Vec<(Field, Cell)> {
    message.fields().map(|field| (field, Cell::of(&field))).collect()
}

impl Cell {
    fn of(field: &Field) -> Self {
        let power = (0..field.exponent.unsigned_abs()).fold(1.0, |power, _| power * 10.0);
        match field.meaning {
            Meaning::ParameterValue => Self::Parameter,
            _ if field.exponent < 0 => Self::Divided(power),
            _ => Self::Multiplied(power),
        }
    }

    fn quantity(&self, raw: i64, words: Words) -> f64 {
        match self {
            // A power of ten is exact, one below 1 would not be: so this rounds once.
            Self::Divided(power) => raw as f64 / power,
            Self::Multiplied(power) => raw as f64 * power,
            Self::Parameter => {
                let Words([number, ..]) = words;
                let row = Dictionary::row(number);
                row.map_or(raw as f64, |row| engineering::to_unit(row, row.kind.widen(raw as i32)))
            }
        }
    }
}

fn signal(field: &Field) -> Signal {
    let names: &[(u16, &'static str)] = match field.meaning {
        Meaning::Named(names) => names.values,
        _ => &[],
    };
    Signal { name: field.name, unit: if field.unit == "-" { "" } else { field.unit }, names: names.to_vec() }
}

fn values(field: &Field) -> Values {
    match field.meaning {
        Meaning::Faults => Values::Faults(Vec::new()),
        // A whole word that should be 0 or 1 can be anything, and stays what it is.
        Meaning::Named(_) if field.bits == 1 => Values::Flag(Vec::new()),
        Meaning::Named(_) => Values::Code(Vec::new()),
        Meaning::ParameterValue => Values::Quantity(Vec::new()),
        Meaning::Number if field.unit != "-" || field.exponent != 0 => Values::Quantity(Vec::new()),
        Meaning::Number | Meaning::ParameterNumber => Values::Number(Vec::new()),
    }
}
