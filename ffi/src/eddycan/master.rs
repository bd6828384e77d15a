//! Master of a TX-Driver.

use super::message::narx_tx_layout_t;
use super::{entry, node};
use crate::frame::narx_frame_t;
use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::bus::eddycan::NmtCommand;
use narx_core::eddycan::{Entry, OBJECTS};
use narx_core::master::eddycan::{Answer, Config, Request, RequestError, TxMaster};

/// 64-bit words of a TX-Driver's master on any processor.
pub const NARX_TX_MASTER_WORDS: usize = 60;

/// The master of one TX-Driver: memory that the caller owns. Its content is private to the library; it may be
/// copied and moved between calls. Calls for one master must not interrupt each other.
#[repr(C)]
pub struct narx_tx_master_t {
    /// Private.
    words: [u64; NARX_TX_MASTER_WORDS],
}

const _: () = handle::assert_fits::<narx_tx_master_t>();

impl Handle for narx_tx_master_t {
    type Object = TxMaster;
    const MARK: u32 = u32::from_be_bytes(*b"nxTM");
}

/// Answer to a request.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_tx_answer_t {
    /// NARX_OK, NARX_ERROR_NO_ANSWER, or NARX_ERROR_ENTRY with the abort code of Table 10 in `value`.
    pub status: narx_status_t,
    /// Value that was read or written.
    pub value: u32,
    /// Entry of the request: a NARX_TX_ENTRY_*.
    pub entry: u8,
    /// Not 0: the request was a write; else a read.
    pub written: u8,
}

/// State of a node, from its last messages.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_tx_node_report_t {
    /// Time of reception of the last positions, microseconds; UINT64_MAX before the first.
    pub at: u64,
    /// The last positions, 2^-27 mm; 0 before the first.
    pub positions: [i32; 2],
    /// Number of boot-up messages.
    pub boots: u32,
    /// Number of error messages.
    pub errors: u32,
    /// Number of the node's frames that cannot be decoded: most likely PDOs of another layout.
    pub malformed: u32,
    /// Encoder, counts; 0 before the first.
    pub encoder: u16,
    /// Code of the last error message; 0 before the first.
    pub last_error: u16,
    /// Not 0: a frame of the node was received within the last 5 s.
    pub present: u8,
    /// State in the last heartbeat; 255 before the first.
    pub state: u8,
}

/// Returns the bytes that a TX-Driver's master needs on this processor: at most sizeof(narx_tx_master_t). Any
/// context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_tx_master_size() -> usize {
    handle::size::<narx_tx_master_t>()
}

/// Makes the master of node `number` (1 to 127) with this layout, in `size` bytes of memory:
/// sizeof(narx_tx_master_t), or narx_tx_master_size() of your own. It sends nothing until it gets a command
/// or a request. It waits 100 ms for an answer, sends a request up to three times, and counts a node as gone
/// after 5 s without a message.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_init(
    master: *mut narx_tx_master_t,
    size: usize,
    number: u8,
    layout: *const narx_tx_layout_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let config = Config::new(node(number)?, pointer::read(layout)?.try_into()?);
        handle::init(master, size, || Ok(TxMaster::new(config)))
    };
    pointer::status(run())
}

/// Takes a frame that arrived at `now`, microseconds. Frames of other nodes are ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_handle_frame(
    master: *mut narx_tx_master_t,
    frame: *const narx_frame_t,
    now: u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::handle_frame(master, frame, |master, frame| master.handle_frame(frame, now)) }
}

/// Writes the next frame that is due at `now`, microseconds, or returns NARX_NOTHING.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_poll_frame(
    master: *mut narx_tx_master_t,
    now: u64,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::poll(master, frame, |master| Some(master.poll_frame(now)?.into())) }
}

/// Writes the latest time of the next poll, microseconds, if no frame arrives and nothing is requested until
/// then; UINT64_MAX for never.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_next_poll(
    master: *mut narx_tx_master_t,
    now: u64,
    at: *mut u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe {
        handle::object(master).and_then(|master| pointer::write(at, master.next_poll(now)))
    })
}

/// Commands the node, or with `all` not 0 every node of the bus: 1 start, 2 stop, 128 pre-operational, 129
/// reset. Returns NARX_ERROR_FULL while four messages wait for the bus, NARX_ERROR_FIELD for another command.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_command(
    master: *mut narx_tx_master_t,
    command: u8,
    all: u8,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = |master: &mut TxMaster| {
        let command = NmtCommand::decode(command).ok_or(NARX_ERROR_FIELD)?;
        let taken = if all == 0 { master.command(command) } else { master.command_all(command) };
        Ok(taken?)
    };
    unsafe { handle::call(master, run) }
}

/// Sends a SYNC: every node of the bus samples and sends PDO2. Returns NARX_ERROR_FULL while four messages
/// wait for the bus.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_sync(master: *mut narx_tx_master_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::call(master, |master| Ok(master.sync()?)) }
}

/// Asks the node for PDO3. Returns NARX_ERROR_FULL while four messages wait for the bus.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_ask_positions(master: *mut narx_tx_master_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::call(master, |master| Ok(master.ask_positions()?)) }
}

/// Requests the value of an entry (NARX_TX_ENTRY_*). Answers come in the order of the requests. Returns
/// NARX_ERROR_FULL while there are eight requests whose answers were not taken.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_read(master: *mut narx_tx_master_t, number: u8) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::call(master, |master| Ok(master.request(Request::Read(entry(number)?))?)) }
}

/// Requests to write an entry (NARX_TX_ENTRY_*). Order and errors are those of narx_tx_master_read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_write(
    master: *mut narx_tx_master_t,
    number: u8,
    value: u32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::call(master, |master| Ok(master.request(Request::Write(entry(number)?, value))?)) }
}

/// Writes the next answer, or returns NARX_NOTHING.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_poll_answer(
    master: *mut narx_tx_master_t,
    answer: *mut narx_tx_answer_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::poll(master, answer, |master| Some(master.poll_answer()?.into())) }
}

/// Writes the state of the node as known at `now`, microseconds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_master_report(
    master: *mut narx_tx_master_t,
    now: u64,
    report: *mut narx_tx_node_report_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe {
        handle::object(master).and_then(|master| pointer::write(report, self::report(master, now)))
    })
}

fn report(master: &TxMaster, now: u64) -> narx_tx_node_report_t {
    let report = master.report();
    let reading = master.reading();
    let (positions, encoder) = reading.map_or(([0; 2], 0), |(reading, ..)| {
        (reading.positions.map(|position| position.raw()), reading.encoder)
    });
    narx_tx_node_report_t {
        at: reading.map_or(u64::MAX, |(.., at)| at),
        positions,
        boots: report.boots,
        errors: report.errors,
        malformed: report.malformed,
        encoder,
        last_error: report.last_error.unwrap_or(0),
        present: master.is_present(now).into(),
        state: report.state.map_or(u8::MAX, |state| state as u8),
    }
}

impl From<Answer> for narx_tx_answer_t {
    fn from(Answer { request, result }: Answer) -> Self {
        let (entry, written) = match request {
            Request::Read(entry) => (entry, 0),
            Request::Write(entry, _) => (entry, 1),
        };
        let (status, value) = match result {
            Ok(value) => (NARX_OK, value),
            Err(RequestError::NoAnswer) => (NARX_ERROR_NO_ANSWER, 0),
            Err(RequestError::Refused(code)) => (NARX_ERROR_ENTRY, code as u32),
            Err(RequestError::RefusedOtherwise { code }) => (NARX_ERROR_ENTRY, code),
        };
        Self { status, value, entry: entry as u8, written }
    }
}

const _: () = assert!(
    Entry::FirmwareVersion as usize + 1 == OBJECTS.len(),
    "an entry's number is its place in OBJECTS, and FirmwareVersion is the last"
);
