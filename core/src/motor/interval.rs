//! Time between two places of the rotor, and the speed that it means.

/// One tick in the units of intervals and ages: 1/65 536 tick.
pub const TICK: u32 = 1 << 16;

/// One sixth of a turn as a u32 angle: a sector.
pub(super) const SIXTH: u32 = u32::MAX / 6;
/// One twelfth of a turn: half a sector.
pub(super) const TWELFTH: u32 = u32::MAX / 12;

/// `sixths / 6` turns in `time` (1/65 536 tick), 2^-32 turn a tick: a 32-bit division with 16 significant
/// bits.
#[inline]
pub(super) fn speed_of(sixths: u8, time: u32) -> i32 {
    let turned = if sixths >= 6 { u32::MAX } else { SIXTH.wrapping_mul(sixths.into()) };
    // From 8 ticks on nothing saturates, and the divisor has 16 bits, the highest of which says that it is
    // not 0.
    if time >= 8 * TICK {
        let scale = 16 - time.leading_zeros();
        return ((turned / ((time >> scale) | (1 << 15))) << (16 - scale)) as i32;
    }
    let scale = 16_u32.saturating_sub(time.leading_zeros());
    let quotient = turned / (time >> scale).max(1);
    let speed =
        if scale >= 16 { quotient >> (scale - 16) } else { quotient.saturating_mul(1 << (16 - scale)) };
    speed.min(i32::MAX as u32 / 2) as i32
}

/// `speed x age / tick`, u32 turn.
pub(super) const fn part_of(speed: i32, age: i32) -> u32 {
    ((speed as i64 * age as i64) >> 16) as u32
}

/// `part / whole` in 1/65 536, 0..=65 536, by a 32-bit division.
pub(super) fn fraction(part: i32, whole: i32) -> i32 {
    let (part, whole) = (part.max(0) as u32, whole.max(1) as u32);
    let scale = 16_u32.saturating_sub(whole.leading_zeros());
    (((part >> scale).min(0xFFFF) << 16) / (whole >> scale).max(1)).min(1 << 16) as i32
}
