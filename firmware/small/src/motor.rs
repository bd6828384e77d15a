//! The control tick alone: samples in, PWM out; no parameters, no bus, and no code that builds coefficients.
//! It is measured (`cargo xtask sizes`), not run: inputs and outputs are black boxes.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use core::hint::black_box;
    use core::panic::PanicInfo;
    use narx_core::motor::machine::event::SlowMeasurements;
    use narx_core::motor::{Coefficients, Command, Drive, Event, PwmCommand, Samples};

    #[cortex_m_rt::entry]
    fn main() -> ! {
        static mut COEFFICIENTS: Option<Coefficients> = None;
        let coefficients: &Option<Coefficients> = black_box(COEFFICIENTS);
        if let Some(coefficients) = coefficients {
            let mut drive = Drive::new(*coefficients);
            loop {
                drive.handle_event(Event::Command(black_box(Command::default())));
                drive.handle_event(Event::Slow(black_box(SlowMeasurements::default())));
                black_box(step(&mut drive, &black_box(Samples::default())));
                black_box(drive.state());
            }
        }
        loop {}
    }

    /// The control interrupt.
    #[inline(never)]
    fn step(drive: &mut Drive, samples: &Samples) -> PwmCommand {
        drive.step(samples)
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        loop {}
    }
}
