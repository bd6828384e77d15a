//! The TX-Driver in the caller's memory.

use super::message::narx_tx_layout_t;
use crate::bus_state::narx_bus_state_t;
use crate::frame::narx_frame_t;
use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::bus::eddycan::{Channels, Position};
use narx_core::eddycan::{Configuration, MeasuringRange, STORED, Sample, TxDriver, Variant};

/// Values that a TX-Driver keeps over a restart: those of the entries NARX_TX_ENTRY_NODE_ID to
/// _ENCODER_RESOLUTION, in their order.
pub const NARX_TX_VALUES: usize = 12;

const _: () = assert!(NARX_TX_VALUES == STORED, "set NARX_TX_VALUES to the core's STORED");

/// 64-bit words of a TX-Driver on any processor.
pub const NARX_TX_DRIVER_WORDS: usize = 56;

/// A TX-Driver: memory that the caller owns. Its content is private to the library; it may be copied and
/// moved between calls. Calls for one TX-Driver must not interrupt each other.
#[repr(C)]
pub struct narx_tx_driver_t {
    /// Private.
    words: [u64; NARX_TX_DRIVER_WORDS],
}

const _: () = handle::assert_fits::<narx_tx_driver_t>();

impl Handle for narx_tx_driver_t {
    type Object = TxDriver;
    const MARK: u32 = u32::from_be_bytes(*b"nxTD");
}

/// Hardware and firmware of a TX-Driver. Positions in 2^-27 mm.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_tx_variant_t {
    /// Number of sensors: 1 or 2.
    pub channels: u8,
    /// Release of the firmware, major in the high byte (2100h).
    pub firmware: u16,
    /// Rate at which narx_tx_driver_handle_sample is called, Hz.
    pub sample_rate: u32,
    /// Start of each sensor's measuring range.
    pub range_start: [i32; 2],
    /// End of each sensor's measuring range, beyond its start.
    pub range_end: [i32; 2],
}

/// State of a TX-Driver that its board needs.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_tx_driver_report_t {
    /// Bit rate for the CAN controller, bit/s.
    pub bits_per_second: u32,
    /// The node-id in force.
    pub node: u8,
    /// NMT state: 4 Stopped, 5 Operational, 127 Pre-Operational.
    pub state: u8,
    /// Layout of its PDOs.
    pub layout: narx_tx_layout_t,
    /// Levels of the two switching outputs.
    pub outputs: [u8; 2],
}

/// Returns the bytes that a TX-Driver needs on this processor: at most sizeof(narx_tx_driver_t). Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_tx_driver_size() -> usize {
    handle::size::<narx_tx_driver_t>()
}

/// Makes a TX-Driver at power-up in `size` bytes of memory: sizeof(narx_tx_driver_t), or
/// narx_tx_driver_size() of your own. `values` are the NARX_TX_VALUES values that were stored, or NULL for
/// factory state. Returns NARX_ERROR_VARIANT if there is no such driver, NARX_ERROR_OUT_OF_RANGE for a stored
/// value outside the range of its entry.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_init(
    driver: *mut narx_tx_driver_t,
    size: usize,
    variant: *const narx_tx_variant_t,
    values: *const u32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let variant = pointer::read(variant)?.try_into()?;
        let configuration = if values.is_null() {
            Configuration::new()
        } else {
            let values: [u32; STORED] = *pointer::read(values.cast())?;
            values.try_into().map_err(|_| NARX_ERROR_OUT_OF_RANGE)?
        };
        handle::init(driver, size, || Ok(TxDriver::new(variant, configuration)))
    };
    pointer::status(run())
}

/// Takes a frame that arrived at `now`, microseconds. A frame for another node or of another protocol changes
/// nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_handle_frame(
    driver: *mut narx_tx_driver_t,
    frame: *const narx_frame_t,
    now: u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::handle_frame(driver, frame, |driver, frame| driver.handle_frame(frame, now)) }
}

/// Takes a sample, at the variant's rate: positions in 2^-27 mm (the second is ignored on a driver with one
/// channel), and the encoder's free-running counter, four counts to a period.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_handle_sample(
    driver: *mut narx_tx_driver_t,
    position_1: i32,
    position_2: i32,
    counter: u16,
) -> narx_status_t {
    let positions = [position_1, position_2].map(Position::from_raw);
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(
        unsafe { handle::object(driver) }.map(|driver| driver.handle_sample(Sample { positions, counter })),
    )
}

/// Takes the state of the CAN controller, as often as the board reads it. Off the bus no frame is handed out,
/// and positions and answers that wait are dropped; drop the frames that wait in the controller, too. An
/// error message among them is sent again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_handle_bus_state(
    driver: *mut narx_tx_driver_t,
    state: *const narx_bus_state_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let state = pointer::read(state)?.try_into()?;
        handle::object(driver)?.handle_bus_state(state);
        Ok(())
    };
    pointer::status(run())
}

/// Advances time to `now`, microseconds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_poll(driver: *mut narx_tx_driver_t, now: u64) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(driver) }.map(|driver| driver.poll(now)))
}

/// Writes the latest time of the next poll, microseconds, if nothing is handled until then; UINT64_MAX for
/// never.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_next_poll(
    driver: *mut narx_tx_driver_t,
    at: *mut u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe {
        handle::object(driver).and_then(|driver| pointer::write(at, driver.next_poll()))
    })
}

/// Writes the next frame to send, or returns NARX_NOTHING.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_poll_frame(
    driver: *mut narx_tx_driver_t,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::poll(driver, frame, |driver| Some(driver.poll_frame()?.into())) }
}

/// Writes the NARX_TX_VALUES values to store, or returns NARX_NOTHING. It hands out nothing more until
/// narx_tx_driver_handle_store was called with the result.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_poll_store(
    driver: *mut narx_tx_driver_t,
    values: *mut u32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe {
        handle::poll(driver, values.cast::<[u32; STORED]>(), |driver| Some(driver.poll_store()?.into()))
    }
}

/// Takes the result of storing the values of narx_tx_driver_poll_store: not 0 if they are stored. A board
/// that could not read its memory at power-up passes 0, too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_handle_store(
    driver: *mut narx_tx_driver_t,
    done: u8,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(driver) }.map(|driver| driver.handle_store(done != 0)))
}

/// Returns NARX_OK, once, when the board must restart the driver now: call narx_tx_driver_init with the
/// stored values. Returns NARX_NOTHING otherwise.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_take_reset(driver: *mut narx_tx_driver_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(
        unsafe { handle::object(driver) }
            .and_then(|driver| if driver.take_reset() { Ok(()) } else { Err(NARX_NOTHING) }),
    )
}

/// Writes the state that the board needs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_driver_report(
    driver: *mut narx_tx_driver_t,
    report: *mut narx_tx_driver_report_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe {
        handle::object(driver).and_then(|driver| {
            let told = narx_tx_driver_report_t {
                bits_per_second: driver.bitrate().bits_per_second(),
                node: driver.node().raw(),
                state: driver.state() as u8,
                layout: driver.layout().into(),
                outputs: driver.outputs().map(u8::from),
            };
            pointer::write(report, told)
        })
    })
}

impl TryFrom<&narx_tx_variant_t> for Variant {
    type Error = narx_status_t;

    fn try_from(variant: &narx_tx_variant_t) -> Result<Self, narx_status_t> {
        let &narx_tx_variant_t { channels, firmware, sample_rate, range_start, range_end } = variant;
        let [start1, start2] = range_start.map(Position::from_raw);
        let [end1, end2] = range_end.map(Position::from_raw);
        let first = MeasuringRange::new(start1, end1).ok_or(NARX_ERROR_VARIANT)?;
        let (channels, second) = match channels {
            // The second range is ignored.
            1 => (Channels::Single, first),
            2 => (Channels::Dual, MeasuringRange::new(start2, end2).ok_or(NARX_ERROR_VARIANT)?),
            _ => return Err(NARX_ERROR_VARIANT),
        };
        if sample_rate == 0 {
            return Err(NARX_ERROR_VARIANT);
        }
        Ok(Self { channels, ranges: [first, second], sample_rate, firmware })
    }
}
