//! Hall sensors: sector, angle and speed from lines and edges.

use super::{init, init_ready, narx_hall_settings_t, narx_setting_error_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::samples::{NARX_EDGES_MAX, convert_edges, narx_edge_t};
use crate::status::narx_status_t::{self, *};
use heapless::Vec;
use narx_core::blocks::{Hall, HallReading, HallReady, HallSettings};

/// A hall station: memory that the caller owns. It may be copied and moved between calls.
#[repr(C)]
pub struct narx_hall_t {
    /// Private.
    words: [u64; 15],
}

const _: () = handle::assert_fits::<narx_hall_t>();

impl Handle for narx_hall_t {
    type Object = Hall;
    const MARK: u32 = u32::from_be_bytes(*b"nxHa");
}

/// Reading of the sensors after a tick.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_hall_reading_t {
    /// Electrical angle at the present period's boundary, 2^32 a turn; for narx_commutation_step.
    pub angle: u32,
    /// Speed, 2^-32 turn a tick, signed; for narx_commutation_step.
    pub turn_speed: i32,
    /// Electrical speed, Q16 rev/s, signed, limited by the time for which the next edge has not come.
    pub speed: i32,
    /// Sector, 0 to 5: sector s spans 30 + 60 s to 90 + 60 s degrees; 255 until the first valid code.
    pub sector: u8,
    /// Sectors turned in this tick, signed.
    pub sectors: i8,
    /// Not 0: the present code is 000 or 111.
    pub invalid: u8,
    /// Not 0: a sector was jumped over in this tick.
    pub jump: u8,
    /// Not 0: no edge came for the time-out: standstill.
    pub stopped: u8,
    /// Not 0: the position is doubtful; torque by this position could act in any direction.
    pub doubtful: u8,
}

/// Writes default settings, as a start for your own: 10 kHz, lines in the order A, B, C, the factory's
/// time-out, interpolation from 1 rev/s, captured edges.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_hall_settings_default(settings: *mut narx_hall_settings_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { pointer::write(settings, HallSettings::default().into()) })
}

/// Makes a station that has not seen the sensors yet. Returns NARX_ERROR_SETTING if it cannot be built from
/// the settings; `error`, which may be NULL, then names the setting.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_hall_init(
    hall: *mut narx_hall_t,
    size: usize,
    settings: *const narx_hall_settings_t,
    error: *mut narx_setting_error_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init(hall, size, settings, error, Hall::build) }
}

/// Makes a station that has not seen the sensors yet from ready-made coefficients: what narx has computed on
/// the desk from such settings as narx_hall_init takes. They are not checked. It takes a few hundred bytes of
/// flash where narx_hall_init takes thousands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_hall_init_ready(
    hall: *mut narx_hall_t,
    size: usize,
    ready: *const HallReady,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init_ready(hall, size, ready, |ready| Hall::new(*ready)) }
}

/// Runs one tick with the lines now (bit 0 = A, bit 1 = B, bit 2 = C) and the `count` edges of the period
/// that has ended, oldest first, at most NARX_EDGES_MAX; `edge` may be NULL if `count` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_hall_step(
    hall: *mut narx_hall_t,
    code: u8,
    edge: *const narx_edge_t,
    count: usize,
    reading: *mut narx_hall_reading_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(reading)?;
        let hall = handle::object(hall)?;
        let mut captured = Vec::new();
        match count {
            0 => {}
            1..=NARX_EDGES_MAX => convert_edges(pointer::slice(edge, count)?, &mut captured)?,
            _ => return Err(NARX_ERROR_SAMPLES),
        }
        pointer::write(reading, hall.step(code & 7, &captured).into())
    };
    pointer::status(run())
}

impl From<HallReading> for narx_hall_reading_t {
    fn from(HallReading { sector, position, speed, events, stopped, doubtful }: HallReading) -> Self {
        Self {
            angle: position.angle,
            turn_speed: position.speed,
            speed: speed.to_bits(),
            sector: sector.unwrap_or(u8::MAX),
            sectors: events.sectors,
            invalid: events.invalid.into(),
            jump: events.jump.into(),
            stopped: stopped.into(),
            doubtful: doubtful.into(),
        }
    }
}
