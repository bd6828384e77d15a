//! Tables of decoded messages: a column for each signal, a row for each message.

/// Name and unit of a column, and the names of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Name as the tables of the protocol have it.
    pub name: &'static str,
    /// Unit; empty for plain numbers.
    pub unit: &'static str,
    /// Names of the values that have one.
    pub names: Vec<(u16, &'static str)>,
}

/// The values of one signal.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Quantities in their unit; NaN where a message does not carry it.
    Quantity(Vec<f64>),
    /// Plain numbers.
    Number(Vec<i64>),
    /// Values with names.
    Code(Vec<u16>),
    /// Yes or no.
    Flag(Vec<bool>),
    /// Bits of the fault word.
    Faults(Vec<u32>),
}

/// One value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A quantity in its unit.
    Quantity(f64),
    /// A plain number.
    Number(i64),
    /// A value with a name.
    Code(u16),
}

/// Every message of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the message, as the CAN database or Table 3 of the eddyCAN specification has it.
    pub name: String,
    /// A device sends it, or else its master.
    pub from_device: bool,
    /// Time of each message, s.
    pub time: Vec<f64>,
    /// The signals.
    pub signals: Vec<Signal>,
    /// Their values, in the order of the signals.
    pub columns: Vec<Values>,
}

impl Values {
    /// Appends a value of its own kind; of another kind nothing.
    pub(super) fn push(&mut self, value: Value) {
        match (self, value) {
            (Self::Quantity(values), Value::Quantity(value)) => values.push(value),
            (Self::Number(values), Value::Number(value)) => values.push(value),
            (Self::Code(values), Value::Code(value)) => values.push(value),
            _ => debug_assert!(false, "a value of another kind"),
        }
    }

    fn append(&mut self, other: Self) {
        match (self, other) {
            (Self::Quantity(values), Self::Quantity(mut others)) => values.append(&mut others),
            (Self::Number(values), Self::Number(mut others)) => values.append(&mut others),
            (Self::Code(values), Self::Code(mut others)) => values.append(&mut others),
            (Self::Flag(values), Self::Flag(mut others)) => values.append(&mut others),
            (Self::Faults(values), Self::Faults(mut others)) => values.append(&mut others),
            _ => debug_assert!(false, "values of another kind"),
        }
    }
}

impl Table {
    pub(super) fn new(
        name: String,
        from_device: bool,
        columns: impl IntoIterator<Item = (Signal, Values)>,
    ) -> Self {
        let (signals, columns) = columns.into_iter().unzip();
        Self { name, from_device, time: Vec::new(), signals, columns }
    }

    pub(super) fn append(&mut self, mut other: Self) {
        self.time.append(&mut other.time);
        self.columns.iter_mut().zip(other.columns).for_each(|(values, others)| values.append(others));
    }
}
