//! Recordings of worlds: conformance vectors that were not selected by hand.

use super::mishap::Mishap;
use super::world::{TROUBLE, World};
use narx_core::master::Request;
use narx_core::motor::State;

/// Length of a recording: a mishap and the time after it, s.
const WINDOW: f64 = 0.05;
/// Number of mishaps from one window to the next while the drive rests, as it does for most of a world's
/// time.
const EVERY: usize = 10;

/// A recording, and the state that it begins in.
#[derive(Clone, Debug)]
pub struct Window {
    /// Recording as a file.
    pub recording: Vec<u8>,
    /// State that was reported last before it.
    pub state: State,
}

/// Makes the windows of one world, about fifteen.
pub fn windows(seed: u64) -> Vec<Window> {
    let mut world = World::new(seed, false);
    let mut windows = Vec::new();
    let mut mishaps = 0;
    while world.time() < TROUBLE {
        let Ok(mishap) = world.next() else { break };
        mishaps += 1;
        let state = world.bench.status().state;
        if !state.is_driving() && mishaps % EVERY != 0 {
            world.happen(mishap);
            continue;
        }
        world.bench.begin_recording();
        world.happen(mishap);
        // Broken invariants are reported elsewhere.
        if world.run(WINDOW).is_err() {
            break;
        }
        let recording = world.bench.end_recording();
        // A drive that has restarted has no recording.
        if !recording.is_empty() {
            windows.push(Window { recording, state });
        }
    }
    windows
}

/// Makes a recording of a world from power-up on, `ticks` long, in which nothing restarts the drive. If
/// something does, the next world is tried.
pub fn long(first: u64, ticks: u64) -> Vec<u8> {
    (first..)
        .find_map(|seed| {
            let mut world = World::new(seed, false);
            world.bench.begin_recording();
            while world.ticks < ticks {
                match world.next().ok()? {
                    Mishap::Cut(..) | Mishap::Chip(_) | Mishap::Request(Request::Reboot) => {}
                    mishap => world.happen(mishap),
                }
            }
            let recording = world.bench.end_recording();
            (!recording.is_empty()).then_some(recording)
        })
        .unwrap_or_default()
}
