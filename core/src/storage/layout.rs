//! Layout of the flash.
//!
//! ```text
//!  0                                              95 %                                            100 %
//!  |                     log                      | label | map | label | map |  kept free        |
//!  |  records of one program page each, a ring    |    primary    |    mirror   |                 |
//! ```
//!
//! All borders are subsectors, the smallest unit of erasing. A log erase gets its range from [`Layout::log`]
//! and cannot reach beyond it.

use core::ops::Range;

/// Share of the log, per cent (section 8.4.5).
const LOG_SHARE: u64 = 95;
/// Most subsectors of one map: 256 KiB in pieces of 4 KiB. More would wear less, but take longer to search at
/// every boot.
const MAP_MAX: u32 = 64;
/// Fewest subsectors of one map: one to write and one to move to.
const MAP_MIN: u32 = 2;

/// The regions of one flash, in bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The log: the first 95 %.
    pub log: Range<u32>,
    /// The parameters.
    pub primary: Copy,
    /// The parameters once more.
    pub mirror: Copy,
}

/// One copy of the parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Copy {
    /// Label: states that a map of this layout follows.
    pub label: Range<u32>,
    /// The map.
    pub map: Range<u32>,
}

impl Layout {
    /// The layout of a flash of `capacity` bytes with subsectors of `subsector` bytes; `None` if it is too
    /// small.
    pub fn of(capacity: u32, subsector: u32) -> Option<Self> {
        let subsectors = capacity.checked_div(subsector)?;
        let log = (u64::from(subsectors) * LOG_SHARE / 100) as u32;
        let map = ((subsectors - log) / 2).saturating_sub(1).min(MAP_MAX);
        if map < MAP_MIN {
            return None;
        }
        let copy = |first: u32| Copy {
            label: first * subsector..(first + 1) * subsector,
            map: (first + 1) * subsector..(first + 1 + map) * subsector,
        };
        Some(Self { log: 0..log * subsector, primary: copy(log), mirror: copy(log + 1 + map) })
    }
}

/// Bytes of a serial NOR flash by its JEDEC identification (manufacturer, type, size code); `None` for a code
/// that no such flash has, such as all ones or zeros without an answer.
///
/// Up to 256 Mbit the code is the exponent of 2; the codes of larger sizes continue from 20h.
pub const fn capacity(identification: [u8; 3]) -> Option<u32> {
    let [maker, _, code] = identification;
    match code {
        _ if maker == 0 || maker == 0xFF => None,
        0x10..=0x19 => Some(1 << code),
        0x20..=0x22 => Some(1 << (code - 0x20 + 26)),
        _ => None,
    }
}
