//! What outlives a reset: the adapter is a device of its own, and its channel stays open when the drive reboots.

use core::sync::atomic::{AtomicU32, Ordering};
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
