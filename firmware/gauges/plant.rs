//! Counts the instructions of the simulated motor and power stage, under `-icount shift=7`.
//!
//! The drive of the `qemu` image boots, starts and runs at 2000 rpm. Prints `plant coasting TICKS TOTAL
//! WORST` for the periods with the bridge off, and `plant driving ...` for the others.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    static mut QUEUES: narx_core::device::Queues<'static> = narx_core::device::Queues::new();
    narx_firmware::boards::qemu::semihosting::exit(image::run(QUEUES).is_some())
}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_semihosting::hprintln;
    use narx_core::commissioning::{Mode, Nameplate};
    use narx_core::device::Queues;
    use narx_core::master::{Config, Master};
    use narx_core::node::Identity;
    use narx_firmware::boards::qemu::{MOTOR, instructions};
    use narx_sim::plant::{Plant, PlantConfig};
    use narx_sim::presets::preset;

    /// Boot takes the first half second, ticks.
    const START: u64 = 6_000;
    const END: u64 = 12_000;
    const TICK_US: u64 = 100;

    /// `None` if the drive cannot be made.
    pub(crate) fn run(queues: &mut Queues) -> Option<()> {
        let mut peripherals = cortex_m::Peripherals::take()?;
        let bracket = instructions::start(&mut peripherals.SYST);
        let preset = preset(MOTOR)?;
        let supply = preset.data.nominal_voltage;
        let rated_current = preset.data.rated_current;
        let plate = Nameplate { motor: preset.motor.figures(), rated_current, supply, open_loop_speed: None };
        let parameters = plate.commission(Mode::Hall).ok()?.parameters;
        let config = PlantConfig::new(preset.motor, supply);
        let (mut tick, mut background) = queues.power_up(Identity::default(), config.board, parameters);
        let addresses = background.node().addresses();
        let mut master = Master::new(Config { addresses, ..Config::default() });
        master.stop();
        let mut plant = Plant::new(&config);
        let (mut coasting, mut driving) = (instructions::Sum::default(), instructions::Sum::default());
        for now in 0..END {
            if now == START {
                master.start(2000);
            }
            while let Some(frame) = master.poll_frame(now * TICK_US) {
                background.node().handle_frame(&frame);
            }
            let (samples, first) = instructions::count(|| plant.sample());
            let command = tick.step(&samples);
            let ((), second) = instructions::count(|| plant.finish_period(&command));
            background.run(now);
            while background.node().poll_frame().is_some() {}
            let sum = if tick.drive().state().is_driving() { &mut driving } else { &mut coasting };
            sum.add((first + second).saturating_sub(2 * bracket));
        }
        hprintln!("plant coasting {}", coasting);
        hprintln!("plant driving {}", driving);
        Some(())
    }
}
