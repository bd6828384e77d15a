//! What outlives a reset: the adapter is a device of its own, and its channel stays open when the drive reboots; and why there was a reset,
//! for which this machine has no register.

use core::sync::atomic::{AtomicU32, Ordering};
use narx_core::node::ResetCause;
use narx_sim::can::slcan::{BITRATES, Channel, Settings};

/// Above the settings; RAM that was never written holds something else.
const MARK: u32 = 0x6E61_7200;
const MARK_MASK: u32 = !0xFF;
const TIMESTAMPS: u32 = 1 << 7;
const CHANNEL_SHIFT: u32 = 4;
const BITRATE_MASK: u32 = 0xF;

/// Start-up leaves this section as it is.
// SAFETY: every bit pattern is a number.
#[unsafe(link_section = ".uninit.KEPT")]
static KEPT: AtomicU32 = AtomicU32::new(0);

/// Keeps `settings` for the time after a reset.
pub(super) fn keep(settings: Settings) {
    let channel = match settings.channel {
        Channel::Closed => 0,
        Channel::ListenOnly => 1,
        Channel::Open => 2,
    };
    let timestamps = if settings.timestamps { TIMESTAMPS } else { 0 };
    let bits = MARK | timestamps | channel << CHANNEL_SHIFT | u32::from(settings.bitrate);
    KEPT.store(bits, Ordering::Relaxed);
}

/// What was kept before the reset, or the settings of power-up.
pub fn settings() -> Settings {
    let bits = KEPT.load(Ordering::Relaxed);
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

// SAFETY: every bit pattern is a number.
#[unsafe(link_section = ".uninit.CAUSE")]
static CAUSE: AtomicU32 = AtomicU32::new(0);
// SAFETY: every bit pattern is a number.
#[unsafe(link_section = ".uninit.HANGING")]
static HANGING: AtomicU32 = AtomicU32::new(0);

/// Whoever is about to end the program says why.
pub fn note_cause(cause: ResetCause) {
    let index = CAUSES.iter().position(|known| *known == cause).unwrap_or(0);
    CAUSE.store(CAUSE_MARK | index as u32, Ordering::Relaxed);
}

/// Why the program started; asked once. Without a note in RAM it had no power before.
pub fn take_cause() -> ResetCause {
    let bits = CAUSE.load(Ordering::Relaxed);
    note_cause(ResetCause::Unknown);
    if bits & MARK_MASK != CAUSE_MARK {
        return ResetCause::PowerUp;
    }
    CAUSES.get((bits & !MARK_MASK) as usize).copied().unwrap_or_default()
}

/// From now on milliseconds are counted until [`take_hanging`], also beyond a reset.
pub(super) fn begin_hanging() {
    let _ = HANGING.compare_exchange(0, 1, Ordering::Relaxed, Ordering::Relaxed);
}

/// A millisecond has passed.
pub(super) fn count_hanging() {
    let count = HANGING.load(Ordering::Relaxed);
    if count > 0 {
        HANGING.store(count + 1, Ordering::Relaxed);
    }
}

/// Milliseconds that something has hung before the reset.
pub fn take_hanging() -> u32 {
    HANGING.swap(0, Ordering::Relaxed).saturating_sub(1)
}
