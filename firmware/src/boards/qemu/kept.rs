//! State that outlives a reset: the settings of the adapter, which is a device of its own and whose channel
//! stays open when the drive reboots; and the cause of the reset, for which this machine has no register. It
//! is kept in a page of RAM that no image occupies, whichever version it is.

use super::register::Register;
use narx_core::bus::slcan::{BITRATES, Channel, Settings};
use narx_core::node::ResetCause;

/// Above the settings; RAM that was never written holds something else.
const MARK: u32 = 0x6E61_7200;
const MARK_MASK: u32 = !0xFF;
const TIMESTAMPS: u32 = 1 << 7;
const CHANNEL_SHIFT: u32 = 4;
const BITRATE_MASK: u32 = 0xF;

// SAFETY: a word of RAM that memory.x leaves to this.
const KEPT: Register = unsafe { Register::new(0x203F_F000) };
// SAFETY: another one.
const CAUSE: Register = unsafe { Register::new(0x203F_F004) };
// SAFETY: another one.
const HANGING: Register = unsafe { Register::new(0x203F_F008) };

/// Keeps `settings` for the time after a reset.
pub(super) fn keep(settings: Settings) {
    let channel = match settings.channel {
        Channel::Closed => 0,
        Channel::ListenOnly => 1,
        Channel::Open => 2,
    };
    let timestamps = if settings.timestamps { TIMESTAMPS } else { 0 };
    let bits = MARK | timestamps | channel << CHANNEL_SHIFT | u32::from(settings.bitrate);
    KEPT.write(bits);
}

/// Returns the settings that were kept before the reset, or those of power-up.
pub fn settings() -> Settings {
    let bits = KEPT.read();
    let bitrate = bits & BITRATE_MASK;
    if bits & MARK_MASK != MARK || bitrate as usize >= BITRATES.len() {
        return Settings::default();
    }
    let channel = match bits >> CHANNEL_SHIFT & 0b11 {
        0 => Channel::Closed,
        1 => Channel::ListenOnly,
        _ => Channel::Open,
    };
    Settings { bitrate: bitrate as u8, channel, timestamps: bits & TIMESTAMPS != 0 }
}

/// Above the cause of the next reset.
const CAUSE_MARK: u32 = 0x6E61_7800;
const CAUSES: [ResetCause; 4] =
    [ResetCause::Unknown, ResetCause::Requested, ResetCause::Watchdog, ResetCause::Program];

/// Whoever is about to end the program says why.
pub fn note_cause(cause: ResetCause) {
    let index = CAUSES.iter().position(|known| *known == cause).unwrap_or(0);
    CAUSE.write(CAUSE_MARK | index as u32);
}

/// Returns the cause of the program's start and forgets it: to be called once. Without a note in RAM the
/// machine had no power before.
pub fn take_cause() -> ResetCause {
    let bits = CAUSE.read();
    note_cause(ResetCause::Unknown);
    if bits & MARK_MASK != CAUSE_MARK {
        HANGING.write(0);
        return ResetCause::PowerUp;
    }
    CAUSES.get((bits & !MARK_MASK) as usize).copied().unwrap_or_default()
}

/// From now on milliseconds are counted until [`take_hanging`], also beyond a reset.
pub(super) fn begin_hanging() {
    if HANGING.read() == 0 {
        HANGING.write(1);
    }
}

/// A millisecond has passed.
pub(super) fn count_hanging() {
    let count = HANGING.read();
    if count > 0 {
        HANGING.write(count + 1);
    }
}

/// Milliseconds that something has hung before the reset.
pub fn take_hanging() -> u32 {
    let count = HANGING.read();
    HANGING.write(0);
    count.saturating_sub(1)
}
