//! The check of the board, in place of the drive. Its findings go to the debugger:
//! `probe-rs run --chip STM32G474RE target/thumbv7em-none-eabihf/release/check`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
    use embassy_executor::Spawner;
    use embassy_stm32::Config;
    use embassy_stm32::interrupt;
    use embassy_stm32::interrupt::{InterruptExt, Priority};
    use embassy_time::{Instant, Timer};
    use narx_board::check::{BoardCheck, Given, pwm_rate};
    use narx_board::owned::Owned;
    use narx_board::side::TickSide;
    use narx_core::motor::Lines;
    use narx_core::units::{Amps, Duty, Volts};
    use narx_embassy_stm32::board::BOARD;
    use narx_embassy_stm32::bridge::{self, BRIDGE, Bridge};
    use narx_embassy_stm32::sides::Tick;
    use narx_embassy_stm32::{clock, converter, pins};
    use rtt_target::{rprintln, rtt_init_print};

    /// Readings of a meter, and the largest current. Set `motor` when its shaft is free.
    const GIVEN: Given = Given {
        supply: Volts::from_milli(12_000),
        duty: Duty::from_bits(1_966),
        current_max: Amps::from_milli(2_000),
        motor: false,
    };

    static CHECK: Owned<(BoardCheck, Tick)> = Owned::nothing();
    static TICKS: AtomicU32 = AtomicU32::new(0);
    /// The shunts' zeros are beyond their tolerance: the bridge stays off, and no terminal follows.
    static ZEROS_WRONG: AtomicBool = AtomicBool::new(false);

    #[embassy_executor::main]
    async fn main(_spawner: Spawner) {
        rtt_init_print!();
        let mut config = Config::default();
        clock::set(&mut config.rcc);
        embassy_stm32::init(config);
        bridge::start();
        pins::start();
        converter::start();
        let check = match BoardCheck::new(BOARD, GIVEN) {
            Ok(check) => check,
            Err(error) => {
                rprintln!("{}", error);
                return;
            }
        };
        CHECK.give((check, Tick::default()));
        BRIDGE.give(Bridge::default());
        interrupt::ADC1_2.set_priority(Priority::P1);
        // The interrupt takes what was given to it above.
        unsafe { interrupt::ADC1_2.enable() };
        bridge::run();

        let (ticks, from) = (TICKS.load(Ordering::Relaxed), Instant::now());
        Timer::after_secs(1).await;
        let ticks = TICKS.load(Ordering::Relaxed).wrapping_sub(ticks);
        rprintln!("{}", pwm_rate(&BOARD, ticks, from.elapsed().as_micros() as u32));
        let mut shown = 0;
        loop {
            let (mut found, mut done) = ([None; 16], false);
            CHECK.with(|(check, _)| {
                done = check.is_done();
                found.iter_mut().zip(check.findings()).for_each(|(place, finding)| *place = Some(*finding));
            });
            for finding in found.iter().flatten().skip(shown) {
                rprintln!("{}", finding);
                shown += 1;
            }
            if done {
                if ZEROS_WRONG.load(Ordering::Relaxed) {
                    rprintln!(
                        "FAIL shunt zeros: beyond 0.2 V about 1.71 V: an amplifier without supply, or JP1 open"
                    );
                }
                return;
            }
            Timer::after_millis(10).await;
        }
    }

    #[interrupt]
    fn ADC1_2() {
        CHECK.with(|(check, tick)| {
            if let Some(samples) = tick.samples() {
                ZEROS_WRONG.store(samples.lines.contains(Lines::DRIVER_FAULT), Ordering::Relaxed);
                let command = check.step(&samples);
                tick.apply(&command);
                TICKS.fetch_add(1, Ordering::Relaxed);
            }
        });
    }
}
