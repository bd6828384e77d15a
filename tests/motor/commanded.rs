//! A bench under a master.

use narx_core::master::Master;
use narx_sim::bench::Bench;

/// Runs one tick of a bench that a master commands; the drive's frames are not used.
pub(crate) fn commanded_tick(bench: &mut Bench, master: &mut Master) {
    while let Some(frame) = master.poll_frame(bench.now_ns() / 1000) {
        bench.send(frame).unwrap();
    }
    bench.step();
    while bench.receive().is_some() || bench.monitor().is_some() {}
}
