//! Rows as they are written in the source, and their conversion to [`Parameter`]s at compile time: each
//! distinct number of the ranges and factory values is stored once, and a byte gives its place.

use super::category::Category;
use super::parameter::{Access, Effect, Kind, Parameter};
use super::{OWN_FIRST, PARAMETER_COUNT, PRINTED_COUNT, control, general, own};

/// A row as it is written in the source: its range and factory value as the 32 bits that go over the wire.
#[derive(Clone, Copy)]
pub(super) struct Row {
    parameter: Parameter,
    min: i32,
    max: i32,
    default: i32,
}

/// Place of a number in [`NUMBERS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place(u8);

impl Place {
    /// The number.
    #[inline(never)]
    pub(super) const fn number(self) -> i32 {
        let place = self.0 as usize;
        if place < NUMBERS.len() { NUMBERS[place] } else { 0 }
    }

    /// Place of `number`.
    const fn of(number: i32) -> Self {
        let mut place = 0;
        while DISTINCT.0[place] != number {
            place += 1;
        }
        assert!(place <= u8::MAX as usize);
        Self(place as u8)
    }
}

/// The rows of all files in one table, which takes less code than three.
const ROWS: [Row; PARAMETER_COUNT] = {
    let mut rows = [general::GENERAL[0]; PARAMETER_COUNT];
    let mut at = 0;
    while at < PARAMETER_COUNT {
        rows[at] = if at < general::GENERAL.len() {
            general::GENERAL[at]
        } else if at < PRINTED_COUNT {
            control::CONTROL[at - general::GENERAL.len()]
        } else {
            own::OWN[at - PRINTED_COUNT]
        };
        at += 1;
    }
    rows
};

const _: () = {
    let mut at = 0;
    while at < PARAMETER_COUNT {
        let number = if at < PRINTED_COUNT { at } else { at - PRINTED_COUNT + OWN_FIRST as usize };
        assert!(
            ROWS[at].parameter.number as usize == number,
            "rows stand in the order of their numbers without gaps: 0 to 121, then from 256 on"
        );
        at += 1;
    }
};

/// Every distinct number of the rows.
static NUMBERS: [i32; DISTINCT.1] = {
    let mut numbers = [0; DISTINCT.1];
    let mut at = 0;
    while at < numbers.len() {
        numbers[at] = DISTINCT.0[at];
        at += 1;
    }
    numbers
};

/// Every distinct number of the rows, and their count.
const DISTINCT: ([i32; 3 * PARAMETER_COUNT], usize) = {
    let (mut numbers, mut count) = ([0; 3 * PARAMETER_COUNT], 0);
    let mut at = 0;
    while at < 3 * PARAMETER_COUNT {
        let Row { min, max, default, .. } = ROWS[at / 3];
        let number = [min, max, default][at % 3];
        let mut place = 0;
        while place < count && numbers[place] != number {
            place += 1;
        }
        numbers[place] = number;
        count += (place == count) as usize;
        at += 1;
    }
    (numbers, count)
};

/// Every parameter in the order of the numbers.
pub(super) const fn parameters() -> [Parameter; PARAMETER_COUNT] {
    let mut parameters = [ROWS[0].parameter; PARAMETER_COUNT];
    let mut at = 0;
    while at < PARAMETER_COUNT {
        let Row { parameter, min, max, default } = ROWS[at];
        parameters[at] =
            Parameter { min: Place::of(min), max: Place::of(max), default: Place::of(default), ..parameter };
        at += 1;
    }
    parameters
}

#[cfg_attr(
    not(feature = "description"),
    allow(unused_variables, reason = "texts that this build leaves out")
)]
impl Row {
    pub(super) const fn new(number: u16, name: &'static str, category: Category, kind: Kind) -> Self {
        let unknown = Place(0);
        let parameter = Parameter {
            min: unknown,
            max: unknown,
            default: unknown,
            #[cfg(feature = "names")]
            name,
            #[cfg(feature = "names")]
            unit: "-",
            #[cfg(feature = "description")]
            description: "",
            number,
            category,
            kind,
            exponent: 0,
            access: category.access(),
            command: false,
            effect: Effect::Immediately,
        };
        Self { parameter, min: 0, max: 0, default: 0 }
    }
    pub(super) const fn in_unit(mut self, unit: &'static str, exponent: i8) -> Self {
        self.parameter.exponent = exponent;
        #[cfg(feature = "names")]
        {
            self.parameter.unit = unit;
        }
        self
    }
    pub(super) const fn range(self, min: i64, max: i64) -> Self {
        let kind = self.parameter.kind;
        Self { min: kind.narrow(min), max: kind.narrow(max), ..self }
    }
    pub(super) const fn factory(self, default: i64) -> Self {
        Self { default: self.parameter.kind.narrow(default), ..self }
    }
    pub(super) const fn read_only(mut self) -> Self {
        self.parameter.access = Access::ReadOnly;
        self
    }
    pub(super) const fn command(mut self) -> Self {
        self.parameter.command = true;
        self
    }
    pub(super) const fn at_next_start(mut self) -> Self {
        self.parameter.effect = Effect::NextStart;
        self
    }
    pub(super) const fn after_reboot(mut self) -> Self {
        self.parameter.effect = Effect::Reboot;
        self
    }
    #[cfg_attr(
        not(feature = "description"),
        allow(unused_mut, reason = "the text that this build leaves out")
    )]
    pub(super) const fn about(mut self, description: &'static str) -> Self {
        #[cfg(feature = "description")]
        {
            self.parameter.description = description;
        }
        self
    }
}
