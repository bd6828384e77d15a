//! Measures how much stack the calls of a shell take: `stack FILE...`.
//!
//! Prints `bytes stack_WHAT N`, the most that one call took:
//!
//! * `drive`: every event and step of the recordings;
//! * `tick`: a control tick with its scope, of the virtual drive's motor that boots, starts and runs;
//! * `background`, `node`: the background's pass, and a frame that comes or goes, while a master reads all
//!   parameters, stores them, logs, arms the scope, and downloads scope and description;
//! * `storage`: a poll of the flash's task, and `bytes storage_task N` its size;
//! * `master`: whatever that master is called for.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
use narx_firmware::boards::qemu::{ARGUMENTS_MAX, RECORDING_MAX, semihosting};

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    static mut ARGUMENTS: [u8; ARGUMENTS_MAX] = [0; ARGUMENTS_MAX];
    static mut RECORDING: [u8; RECORDING_MAX] = [0; RECORDING_MAX];
    static mut QUEUES: narx_core::device::Queues<'static> = narx_core::device::Queues::new();
    static mut SCOPE: narx_core::scope::Memory<[u16; narx_core::scope::WORDS]> =
        narx_core::scope::Memory::new();
    static mut MAILBOX: narx_core::storage::Mailbox = narx_core::storage::Mailbox::new();
    let done = image::replay_all(semihosting::arguments(ARGUMENTS), RECORDING)
        && image::run(QUEUES, SCOPE, MAILBOX).is_some();
    semihosting::exit(done)
}

#[cfg(target_os = "none")]
mod image {
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};
    use cortex_m_semihosting::hprintln;
    use narx_core::commissioning::{Mode, Nameplate};
    use narx_core::device::{ControlTick, Queues};
    use narx_core::dictionary::number;
    use narx_core::master::{Config, Download, Master, Request, Service};
    use narx_core::motor::{Drive, Event, PwmCommand, Samples, Status};
    use narx_core::node::Identity;
    use narx_core::recording::{Recording, Replayable, replay_with};
    use narx_core::scope::Memory;
    use narx_core::storage::{FlashReply, FlashTask, Mailbox, Storage};
    use narx_firmware::boards::qemu::flash::Chip;
    use narx_firmware::boards::qemu::stack::used;
    use narx_firmware::boards::qemu::{MOTOR, semihosting};
    use narx_sim::plant::{Plant, PlantConfig};
    use narx_sim::presets::preset;
    use serde::Deserialize;

    const TICK_US: u64 = 100;
    /// Boot takes the first half second; what a driving motor forbids is asked before its start. Ticks.
    const BOOTED: u64 = 6_000;
    const START: u64 = 8_000;
    const END: u64 = 20_000;
    /// Words of stack that are looked at: of the tick, and of the background.
    const TICK: usize = 384;
    const BACKGROUND: usize = 1536;

    /// The drive, through every recording; false if one cannot be replayed.
    pub(crate) fn replay_all<'a>(arguments: impl Iterator<Item = &'a str>, buffer: &mut [u8]) -> bool {
        let mut peak = 0;
        for path in arguments {
            let Ok(bytes) = semihosting::read_file(path, buffer) else { return false };
            let Ok(recording) = Recording::open(bytes) else { return false };
            let outcome = replay_with::<Measured>(&recording, |drive, _, _| peak = drive.peak.max(peak));
            if !matches!(outcome, Ok(outcome) if outcome.is_identical()) {
                return false;
            }
        }
        hprintln!("bytes stack_drive {}", peak);
        true
    }

    #[derive(Deserialize)]
    struct Measured {
        drive: Drive,
        #[serde(skip)]
        peak: usize,
    }

    impl Measured {
        fn note<T>(&mut self, work: impl FnOnce(&mut Drive) -> T) -> T {
            let (result, bytes) = used::<TICK, _>(|| work(&mut self.drive));
            self.peak = self.peak.max(bytes);
            result
        }
    }

    impl Replayable for Measured {
        fn handle_event(&mut self, event: Event) {
            self.note(|drive| drive.handle_event(&event));
        }

        fn step(&mut self, samples: &Samples) -> PwmCommand {
            self.note(|drive| drive.step(samples))
        }

        fn poll_status(&mut self) -> Option<Status> {
            self.drive.poll_status()
        }
    }

    /// The most that one kind of call took.
    #[derive(Default)]
    struct Peak(usize);

    impl Peak {
        fn of<T>(&mut self, work: impl FnOnce() -> T) -> T {
            let (result, bytes) = used::<BACKGROUND, _>(work);
            self.0 = self.0.max(bytes);
            result
        }
    }

    /// A function of its own, as an interrupt would call it.
    #[inline(never)]
    fn step(tick: &mut ControlTick<'_, '_>, samples: &Samples) -> PwmCommand {
        tick.step(samples)
    }

    /// The whole device with a motor, a flash and a master; `None` if it cannot be made.
    pub(crate) fn run(
        queues: &'static mut Queues<'static>,
        scope: &'static mut Memory,
        mailbox: &Mailbox,
    ) -> Option<()> {
        let preset = preset(MOTOR)?;
        let supply = preset.data.nominal_voltage;
        let rated_current = preset.data.rated_current;
        let plate = Nameplate { motor: preset.motor.figures(), rated_current, supply, open_loop_speed: None };
        let parameters = plate.commission(Mode::Hall).ok()?.parameters;
        let config = PlantConfig::new(preset.motor, supply);
        let mut chip = Chip::take()?;
        chip.clear();
        let mut storage = Storage::new(chip);
        let mut context = Context::from_waker(Waker::noop());
        if pin!(storage.format(&parameters)).poll(&mut context).is_pending() {
            return None;
        }
        let Poll::Ready(FlashReply::Opened(opened)) =
            pin!(storage.execute(FlashTask::Open)).poll(&mut context)
        else {
            return None;
        };
        let (mut tick, mut background) = queues.power_up(Identity::default(), config.board, parameters);
        background.attach_scope(scope);
        background.node().attach_storage(&opened);
        let addresses = background.node().addresses();
        let mut master = Master::new(Config { addresses, ..Config::default() });
        master.stop();
        let mut plant = Plant::new(&config);
        let mut task = pin!(mailbox.serve(&mut storage));
        let task_bytes = size_of_val(&*task);
        let [mut ticks, mut passes, mut node, mut flash, mut masters] = [const { Peak(0) }; 5];
        let wishes = [
            Request::Write { number: number::LOG_PERIOD, raw: 100 },
            Request::Write { number: number::SCOPE_CHANNELS, raw: 0xFF },
            Request::Run(Service::Store),
            Request::Write { number: number::LOGGING_SLOT_FIRST, raw: 0 },
            Request::TriggerScope,
            Request::TriggerScope,
            Request::BuildInfo,
        ];
        let mut wishes = wishes.into_iter().peekable();
        let mut downloads = [Download::Scope { words: 2048 }, Download::Description].into_iter().peekable();
        for now in 0..END {
            let samples = plant.sample();
            let command = ticks.of(|| step(&mut tick, &samples));
            plant.finish_period(&command);
            let us = now * TICK_US;
            if now == START {
                master.start(2000);
            }
            if now > BOOTED && now.is_multiple_of(500) {
                if let Some(wish) = wishes.next_if(|wish| masters.of(|| master.request(*wish)).is_ok()) {
                    hprintln!("# {:?}", wish);
                } else if wishes.peek().is_none() {
                    downloads.next_if(|what| masters.of(|| master.download(*what)).is_ok());
                }
            }
            while masters.of(|| master.poll_chunk()).is_some() {}
            masters.of(|| (master.poll_answer(), master.poll_download()));
            while let Some(frame) = masters.of(|| master.poll_frame(us)) {
                node.of(|| background.node().handle_frame(&frame));
            }
            passes.of(|| background.run(now));
            while let Some(frame) = node.of(|| background.node().poll_frame()) {
                masters.of(|| master.handle_frame(&frame, us));
            }
            if let Some(frame) = node.of(|| background.node().poll_bulk_frame()) {
                masters.of(|| master.handle_frame(&frame, us));
            }
            if let Some(asked) = node.of(|| background.node().poll_storage()) {
                mailbox.ask(asked);
            }
            flash.of(|| task.as_mut().poll(&mut context).is_pending());
            if let Some(report) = mailbox.take_report() {
                node.of(|| background.node().handle_storage(report));
            }
        }
        hprintln!("# state {:?}, {} wishes left", master.state(), wishes.count() + downloads.count());
        for (what, bytes) in [
            ("stack_tick", ticks.0),
            ("stack_background", passes.0),
            ("stack_node", node.0),
            ("stack_storage", flash.0),
            ("stack_master", masters.0),
            ("storage_task", task_bytes),
        ] {
            hprintln!("bytes {} {}", what, bytes);
        }
        Some(())
    }
}
