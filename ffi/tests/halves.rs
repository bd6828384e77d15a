//! Both halves of a drive in the caller's memory, each on its own thread, for Miri
//! (`cargo +nightly miri test -p narx-ffi`). Miri detects a reference that another one invalidates, and
//! accesses without an order.

use narx::narx_status_t::{self, NARX_ERROR_UNINITIALISED, NARX_NOTHING, NARX_OK};
use narx::*;
use std::mem::MaybeUninit;
use std::ptr;
use std::thread;

/// Ticks to run: several times the room of the queues. Miri runs some hundred a second.
const TICKS: u64 = 150;

/// A pointer that threads share, as an interrupt and a main loop do.
#[derive(Clone, Copy)]
struct Shared(*mut narx_drive_t);

// SAFETY: the header promises that the two halves may run on two threads; this test checks it.
unsafe impl Send for Shared {}

/// A board at rest: 24 V on the bus, no current, rotor in sector 0.
fn at_rest(tick: u64) -> narx_samples_t {
    narx_samples_t {
        tick,
        phase_voltage: [0; 3],
        bus_voltage: 1229,
        bus_current: 2048,
        skew: 0,
        sample_mode: 0,
        current_mode: 0,
        hall: 1,
        lines: 0,
        edge_count: 0,
        edges_lost: 0,
        edges: [narx_edge_t { instant: 0, source: 0, code: 0 }; NARX_EDGES_MAX],
    }
}

fn data(id: u32) -> narx_frame_t {
    narx_frame_t { id, extended: 1, remote: 0, length: 8, data: [0; 8] }
}

/// Runs the tick half; returns the number of ticks without an error.
fn tick_half(Shared(drive): Shared) -> u64 {
    let mut command = MaybeUninit::uninit();
    let step = |tick| unsafe { narx_drive_step(drive, &at_rest(tick), command.as_mut_ptr()) };
    (0..TICKS).map(step).filter(|status| *status == NARX_OK).count() as u64
}

/// Runs the background half; returns the number of frames that came.
fn background_half(Shared(drive): Shared) -> u64 {
    let mut frames = 0;
    let mut frame = MaybeUninit::uninit();
    let mut value = 0;
    for pass in 0..TICKS {
        unsafe {
            // Arms the scope, forces its trigger, reads the record.
            let scope = match pass {
                5 | 30 => Some(0x0AAD_5270),
                90 => Some(0x0AAD_5470),
                _ => None,
            };
            if let Some(id) = scope {
                assert_eq!(narx_drive_handle_frame(drive, &data(id)), NARX_OK);
            }
            // Passes new coefficients to the tick half.
            if pass % 20 == 0 {
                assert_eq!(narx_drive_set_parameter(drive, 99, 100 + pass as i32), NARX_OK);
            }
            assert_eq!(narx_drive_run(drive, pass), NARX_OK);
            assert_eq!(narx_drive_get_parameter(drive, 261, &raw mut value), NARX_OK);
            while poll(narx_drive_poll_frame(drive, frame.as_mut_ptr())) {
                frames += 1;
            }
            while poll(narx_drive_poll_bulk_frame(drive, frame.as_mut_ptr())) {
                frames += 1;
            }
        }
    }
    frames
}

fn poll(status: narx_status_t) -> bool {
    assert!(status == NARX_OK || status == NARX_NOTHING, "{status:?}");
    status == NARX_OK
}

#[test]
fn halves_share_nothing_but_queues() {
    let mut memory = Box::new(MaybeUninit::<narx_drive_t>::uninit());
    let mut scope = Box::new(MaybeUninit::<narx_scope_t>::uninit());
    let drive = memory.as_mut_ptr();
    unsafe {
        assert_eq!(narx_drive_init(drive, size_of::<narx_drive_t>(), ptr::null()), NARX_OK);
        assert_eq!(narx_drive_attach_scope(drive, scope.as_mut_ptr(), narx_scope_size(64)), NARX_OK);
    }
    let shared = Shared(drive);
    let tick = thread::spawn(move || tick_half(shared));
    let frames = background_half(shared);
    assert_eq!(tick.join().expect("no panic"), TICKS);
    assert!(frames > 1, "{frames}");
}

/// Calls the halves in turn, as on a processor whose interrupt comes between any two calls of the main loop.
#[test]
fn halves_take_turns() {
    let mut memory = Box::new(MaybeUninit::<narx_drive_t>::uninit());
    let drive = memory.as_mut_ptr();
    let mut command = MaybeUninit::uninit();
    unsafe {
        // Before a drive is initialised only the mark is read.
        drive.cast::<u32>().write(0);
        assert_eq!(narx_drive_step(drive, &at_rest(0), command.as_mut_ptr()), NARX_ERROR_UNINITIALISED);
        for _reboot in 0..2 {
            assert_eq!(narx_drive_init(drive, size_of::<narx_drive_t>(), ptr::null()), NARX_OK);
            for tick in 0..20 {
                assert_eq!(narx_drive_run(drive, tick), NARX_OK);
                assert_eq!(narx_drive_step(drive, &at_rest(tick), command.as_mut_ptr()), NARX_OK);
            }
        }
    }
}
