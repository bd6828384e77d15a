//! The dictionary: every parameter of the drive with its number, name, unit, scale, range, factory value and
//! access. The rows in `general`, `control` and `own` are the one place where these facts stand;
//! coefficients, node, bindings and documents are made from them.

mod category;
mod control;
mod decimal;
#[cfg(feature = "engineering")]
pub mod engineering;
mod general;
pub mod number;
mod own;
mod parameter;
mod row;
mod values;

pub use category::Category;
pub use decimal::Decimal;
pub use parameter::{Access, Effect, Kind, Parameter};
pub use values::{ParameterError, Parameters};

/// Parameters of the specification: numbers 0 to 121.
pub const PRINTED_COUNT: usize = general::GENERAL.len() + control::CONTROL.len();

/// All parameters.
pub const PARAMETER_COUNT: usize = PRINTED_COUNT + own::OWN.len();

/// Our own parameters are numbered from here.
pub const OWN_FIRST: u16 = 256;

/// The table of all parameters.
#[derive(Clone, Copy, Debug)]
pub struct Dictionary;

impl Dictionary {
    /// Rows whose values are kept over a restart.
    pub(crate) const STORED_COUNT: usize = stored(&row::parameters());

    /// Every row in the order of the numbers.
    pub fn rows() -> impl Iterator<Item = &'static Parameter> {
        ROWS.iter()
    }

    /// The row of a number.
    pub fn row(number: u16) -> Option<&'static Parameter> {
        ROWS.get(Self::index(number)?)
    }

    /// The row with a printed name; case does not matter. None without the feature `names`.
    pub fn find(name: &str) -> Option<&'static Parameter> {
        Self::rows().find(|row| cfg!(feature = "names") && row.name().eq_ignore_ascii_case(name))
    }

    /// Place of a number among the rows.
    pub(crate) fn index(number: u16) -> Option<usize> {
        let (first, place) = match number.checked_sub(OWN_FIRST) {
            None => (usize::from(number), PRINTED_COUNT),
            Some(own) => (usize::from(own) + PRINTED_COUNT, PARAMETER_COUNT),
        };
        (first < place).then_some(first)
    }
}

/// Speed set-point limit (parameters 101 to 104) in force, mechanical rpm, from its raw value and the motor's
/// pole pairs. The factory value is for four pole pairs (Table 2): while it is unchanged, the limit is scaled
/// by 4 / pole pairs (parameter 78).
pub fn speed_limit(number: u16, raw: i32, pole_pairs: i32) -> i32 {
    const FIRST: u16 = number::SPEED_MAX_SL;
    const LAST: u16 = number::SPEED_MIN_HES;
    match number {
        FIRST..=LAST if Dictionary::row(number).is_some_and(|row| row.factory_raw() == raw) => {
            raw.saturating_mul(4) / pole_pairs.max(1)
        }
        _ => raw,
    }
}

pub(crate) static ROWS: [Parameter; PARAMETER_COUNT] = row::parameters();

const fn stored(rows: &[Parameter]) -> usize {
    let (mut count, mut at) = (0, 0);
    while at < rows.len() {
        count += rows[at].is_stored() as usize;
        at += 1;
    }
    count
}
