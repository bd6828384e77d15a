//! Everything of the core that a small board links, without its peripherals: control tick, background,
//! parameters, broadcasts. It is measured (`cargo xtask sizes`), not run: inputs and outputs are black boxes.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use core::hint::black_box;
    use core::panic::PanicInfo;
    use narx_core::bus::{BusState, Frame};
    use narx_core::device::Queues;
    use narx_core::dictionary::Parameters;
    use narx_core::motor::machine::event::Health;
    use narx_core::motor::{Board, Samples};
    use narx_core::node::{Identity, SlowInputs};

    #[cortex_m_rt::entry]
    fn main() -> ! {
        static mut QUEUES: Queues<'static> = Queues::new();
        let (identity, board): (Identity, Board) = (black_box(Identity::default()), black_box(Board::BENCH));
        let (mut tick, mut background) = QUEUES.power_up(identity, board, Parameters::new());
        let frame: Option<Frame> = background.node().poll_frame();
        loop {
            black_box(tick.step(&black_box(Samples::default())));
            let node = background.node();
            if let Some(frame) = black_box(frame) {
                node.handle_frame(&frame);
            }
            node.handle_bus_state(black_box(BusState::default()));
            node.handle_health(black_box(Health::default()));
            node.handle_inputs(black_box(SlowInputs::default()));
            background.run(black_box(0));
            let node = background.node();
            while let Some(frame) = node.poll_frame().or_else(|| node.poll_bulk_frame()) {
                black_box(frame);
            }
            black_box((node.poll_storage(), node.poll_action(), node.outputs()));
        }
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        loop {}
    }
}
