//! Counts the instructions of every `Drive::step` in recordings: `count FILE... [--running FILE...]`, under
//! `-icount shift=7`.
//!
//! Prints `vector STEM TICKS TOTAL WORST` for every file, then `state NAME TICKS TOTAL WORST` for every
//! state (Table 6) over all files, and `bracket N`, what the measurement cost itself and was taken off. A
//! tick counts for the state in which it ends. Steps that answer anything else than what was recorded are not
//! counted: cheaper must mean the same bits.
//!
//! Files behind `--running` count for no state. Each gives `running STEM TICKS TOTAL WORST`: its ticks from
//! 0.2 s after the closed loop began. They are run twice more with a virtual scope, and give `scope STEM
//! TICKS TOTAL WORST` and `inputs STEM TICKS TOTAL WORST`: what it adds to every tick when it records
//! signals, and inputs; and once more with a scope on a full bus, that is with a command in every third tick,
//! and give `loaded STEM TICKS TOTAL WORST`: what all of that adds.
//!
//! `bytes WHAT N` are the sizes of things in memory.
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
    static mut SCOPE: narx_core::scope::Memory<[u16; narx_core::scope::WORDS]> =
        narx_core::scope::Memory::new();
    semihosting::exit(image::run(semihosting::arguments(ARGUMENTS), RECORDING, SCOPE))
}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_semihosting::hprintln;
    use narx_core::device::{Background, ControlTick, Queues};
    use narx_core::master::Master;
    use narx_core::motor::signal::{ShaftScale, Signal};
    use narx_core::motor::{Coefficients, Command, Drive, Event, PwmCommand, Samples, State, Status};
    use narx_core::node::Node;
    use narx_core::recording::{Recording, ReplayError, Replayable, replay_with};
    use narx_core::scope::{
        Answer, Keeper, Memory, Order, Scope, ScopeTask, Setup, State as ScopeState, Threshold, Trigger,
        WORDS,
    };
    use narx_core::storage::{Mailbox, Storage};
    use narx_firmware::boards::qemu::instructions::{self, Sum};
    use narx_firmware::boards::qemu::{Owned, semihosting, stem};
    use serde::Deserialize;

    /// States of the drive (Table 6).
    const STATES: usize = 8;
    /// Ticks of closed loop after which a motor counts as one that just runs: 0.2 s at 10 kHz.
    const SETTLED: u32 = 2_000;

    /// Counts all files; false if one could not be.
    pub(crate) fn run<'a>(
        arguments: impl Iterator<Item = &'a str>,
        buffer: &mut [u8],
        scope: &'static mut Memory,
    ) -> bool {
        MEMORY.give(Some(scope));
        let Some(mut peripherals) = cortex_m::Peripherals::take() else { return false };
        let bracket = instructions::start(&mut peripherals.SYST);
        let mut states = [Sum::default(); STATES];
        let (mut success, mut running) = (true, false);
        for path in arguments {
            if path == "--running" {
                running = true;
                continue;
            }
            let stem = stem(path);
            let bytes = match semihosting::read_file(path, buffer) {
                Ok(bytes) => bytes,
                Err(error) => {
                    hprintln!("{} error {} {}", stem, path, error);
                    success = false;
                    continue;
                }
            };
            let (kind, counted) = if running {
                ("running", count_running(bytes, bracket))
            } else {
                ("vector", count_all(bytes, bracket, &mut states))
            };
            match counted {
                Ok((sum, true)) => {
                    hprintln!("{} {} {}", kind, stem, sum);
                    if running {
                        success &= show_scope::<false>("scope", stem, bytes, bracket);
                        success &= show_scope::<true>("inputs", stem, bytes, bracket);
                        success &= show_loaded(stem, bytes);
                    }
                }
                Ok((_, false)) => {
                    hprintln!("{} error the outputs are not the recorded ones", stem);
                    success = false;
                }
                Err(error) => {
                    hprintln!("{} error {}", stem, error);
                    success = false;
                }
            }
        }
        for (state, sum) in State::ALL.iter().zip(&states).filter(|(_, sum)| sum.ticks > 0) {
            hprintln!("state {:?} {}", state, sum);
        }
        let device =
            size_of::<Queues<'_>>() + size_of::<ControlTick<'_, '_>>() + size_of::<Background<'_, '_>>();
        let storage = size_of::<Storage<()>>() + size_of::<Mailbox>();
        for (what, bytes) in [
            ("state", size_of::<Drive>() - size_of::<Coefficients>()),
            ("coefficients", size_of::<Coefficients>()),
            ("control_tick", size_of::<ControlTick<'_, '_>>()),
            ("queues", size_of::<Queues<'_>>()),
            ("background", size_of::<Background<'_, '_>>()),
            ("node", size_of::<Node>()),
            ("device", device),
            ("storage", storage),
            ("whole", device + storage),
            ("scope", size_of::<Memory<[u16; WORDS]>>()),
            ("scope_words", size_of::<[u16; WORDS]>()),
            ("master", size_of::<Master>()),
        ] {
            hprintln!("bytes {} {}", what, bytes);
        }
        hprintln!("bracket {}", bracket);
        success
    }

    /// Every tick, also for the state in which it ends.
    fn count_all(bytes: &[u8], bracket: u32, states: &mut [Sum; STATES]) -> Result<(Sum, bool), ReplayError> {
        let mut sum = Sum::default();
        let identical = count(bytes, bracket, |state, instructions| {
            sum.add(instructions);
            if let Some(state) = states.get_mut(state as usize) {
                state.add(instructions);
            }
        })?;
        Ok((sum, identical))
    }

    /// The ticks of a motor that just runs.
    fn count_running(bytes: &[u8], bracket: u32) -> Result<(Sum, bool), ReplayError> {
        let mut sum = Sum::default();
        let mut lasted = 0;
        let identical = count(bytes, bracket, |state, instructions| {
            let closed = matches!(state, State::HallClosedLoop | State::SensorlessClosedLoop);
            lasted = if closed { lasted + 1 } else { 0 };
            if lasted > SETTLED {
                sum.add(instructions);
            }
        })?;
        Ok((sum, identical))
    }

    /// Prints the instructions that a scope adds; false if they could not be counted.
    fn show_scope<const INPUTS: bool>(kind: &str, stem: &str, bytes: &[u8], bracket: u32) -> bool {
        let mut sum = Sum::default();
        let outcome =
            count_scope::<INPUTS>(bytes, |instructions| sum.add(instructions.saturating_sub(bracket)));
        let identical = matches!(outcome, Ok(true));
        if identical {
            hprintln!("{} {} {}", kind, stem, sum);
        } else {
            hprintln!("{} error with a scope the outputs are not the recorded ones", stem);
        }
        identical
    }

    /// Prints the instructions that a scope and a full bus add; false if they could not be counted.
    fn show_loaded(stem: &str, bytes: &[u8]) -> bool {
        let mut sum = Sum::default();
        let show = |loaded: &Loaded, _: &Samples, _: &PwmCommand| {
            if let Some(added) = loaded.added {
                sum.add(added);
            }
        };
        let outcome = Recording::open(bytes).map_err(ReplayError::from);
        let identical = outcome.and_then(|recording| replay_with::<Loaded>(&recording, show));
        let identical = matches!(identical, Ok(outcome) if outcome.is_identical());
        if identical {
            hprintln!("loaded {} {}", stem, sum);
        } else {
            hprintln!("{} error on a full bus the outputs are not the recorded ones", stem);
        }
        identical
    }

    fn count_scope<const INPUTS: bool>(bytes: &[u8], mut each: impl FnMut(u32)) -> Result<bool, ReplayError> {
        let outcome = replay_with::<Scoped<INPUTS>>(&Recording::open(bytes)?, |scoped, _, _| {
            each(scoped.instructions)
        })?;
        Ok(outcome.is_identical())
    }

    /// Shows `each` tick's state and instructions; true if the outputs were the recorded ones.
    fn count(bytes: &[u8], bracket: u32, mut each: impl FnMut(State, u32)) -> Result<bool, ReplayError> {
        let outcome = replay_with::<Metered>(&Recording::open(bytes)?, |metered, _, _| {
            each(metered.drive.state(), metered.instructions.saturating_sub(bracket));
        })?;
        Ok(outcome.is_identical())
    }

    /// A drive whose steps are counted.
    #[derive(Deserialize)]
    struct Metered {
        drive: Drive,
        /// Of the last step, the measurement's own included.
        #[serde(skip)]
        instructions: u32,
    }

    impl Replayable for Metered {
        fn handle_event(&mut self, event: Event) {
            self.drive.handle_event(event);
        }

        fn step(&mut self, samples: &Samples) -> PwmCommand {
            let (command, instructions) = measure(&mut self.drive, samples);
            self.instructions = instructions;
            command
        }

        fn poll_status(&mut self) -> Option<Status> {
            self.drive.poll_status()
        }
    }

    /// The scope's memory, while nobody has it.
    static MEMORY: Owned<Option<&'static mut Memory>> = Owned::nothing();

    /// A drive with a scope that waits, records, and is armed again: eight signals, those of the estimators
    /// among them, or inputs.
    #[derive(Deserialize)]
    struct Scoped<const INPUTS: bool> {
        drive: Drive,
        #[serde(skip)]
        scope: Scope<&'static mut Memory>,
        #[serde(skip)]
        keeper: Keeper<&'static mut Memory>,
        #[serde(skip)]
        wait: u16,
        #[serde(skip)]
        event: Option<Event>,
        #[serde(skip)]
        instructions: u32,
    }

    impl<const INPUTS: bool> Scoped<INPUTS> {
        /// Returns the keeper's order for this tick: a record is forced after 50 ms of waiting, and then
        /// another one is armed.
        fn order(&mut self) -> Option<Order<&'static mut Memory>> {
            self.wait = self.wait.saturating_sub(1);
            if self.scope.state() == ScopeState::Armed {
                return (self.wait == 0).then_some(Order::Force);
            }
            if self.scope.state() == ScopeState::Recording {
                return None;
            }
            MEMORY.with(|place| self.keeper = place.take().map(Keeper::new).unwrap_or_default());
            self.keeper.handle(ScopeTask::Arm(setup(INPUTS)));
            self.wait = 500;
            self.keeper.poll_order()
        }
    }

    impl<const INPUTS: bool> Drop for Scoped<INPUTS> {
        fn drop(&mut self) {
            if let Some(memory) = core::mem::take(&mut self.scope).into_memory() {
                MEMORY.give(Some(memory));
            }
        }
    }

    fn setup(inputs: bool) -> Setup {
        let signals = [
            Signal::SetPoint,
            Signal::SpeedSensorless,
            Signal::SpeedHall,
            Signal::Power,
            Signal::TerminalA,
            Signal::Angle,
            Signal::Limiter,
            Signal::CrossingMargin,
        ];
        let threshold = Threshold { signal: Signal::Angle, level: i16::MAX, above: true };
        Setup {
            signals: signals.into_iter().collect(),
            inputs,
            tick_rate: 10_000,
            samples: 512,
            prescaler: 1,
            before: 256,
            trigger: Trigger::Edge(threshold),
            speed: ShaftScale::new(8),
        }
    }

    impl<const INPUTS: bool> Replayable for Scoped<INPUTS> {
        fn handle_event(&mut self, event: Event) {
            self.event = Some(event.clone());
            self.drive.handle_event(event);
        }

        fn step(&mut self, samples: &Samples) -> PwmCommand {
            let command = self.drive.step(samples);
            let mut order = self.order();
            let event = self.event.take();
            let (answer, instructions) =
                look(&mut self.scope, &self.drive, samples, event.as_ref(), &mut order);
            self.instructions = instructions;
            if let Some(Answer::Done(memory)) = answer {
                MEMORY.give(Some(memory));
            }
            command
        }

        fn poll_status(&mut self) -> Option<Status> {
            self.drive.poll_status()
        }
    }

    /// A drive with a scope that gets a command in every third tick, beside one without.
    #[derive(Deserialize)]
    struct Loaded {
        scoped: Scoped<false>,
        #[serde(skip)]
        bare: Option<Drive>,
        /// Command that the master sends all the time: the last one of the recording.
        #[serde(skip)]
        command: Option<Command>,
        #[serde(skip)]
        ticks: u32,
        /// Instructions of the last step, beyond those of the one without. Nothing where the recording has an
        /// event.
        #[serde(skip)]
        added: Option<u32>,
    }

    impl Replayable for Loaded {
        fn handle_event(&mut self, event: Event) {
            if let Event::Command(command) = event {
                self.command = Some(command);
            }
            self.bare.get_or_insert_with(|| self.scoped.drive.clone()).handle_event(event.clone());
            self.scoped.event = Some(event);
        }

        fn step(&mut self, samples: &Samples) -> PwmCommand {
            let bare = self.bare.get_or_insert_with(|| self.scoped.drive.clone());
            let (_, without) = measure(bare, samples);
            self.ticks = self.ticks.wrapping_add(1);
            let recorded = self.scoped.event.take();
            let own = recorded.is_none();
            let command = self.command.filter(|_| self.ticks.is_multiple_of(3));
            let event = recorded.or(command.map(Event::Command));
            let mut order = self.scoped.order();
            let Scoped { drive, scope, .. } = &mut self.scoped;
            let ((command, answer), instructions) =
                count_whole(drive, scope, samples, event.as_ref(), &mut order);
            if let Some(Answer::Done(memory)) = answer {
                MEMORY.give(Some(memory));
            }
            self.added = own.then(|| instructions.saturating_sub(without));
            command
        }

        fn poll_status(&mut self) -> Option<Status> {
            self.bare.as_mut().and_then(Drive::poll_status);
            self.scoped.poll_status()
        }
    }

    /// A function of its own, like [`measure`].
    #[inline(never)]
    fn count_whole(
        drive: &mut Drive,
        scope: &mut Scope<&'static mut Memory>,
        samples: &Samples,
        event: Option<&Event>,
        order: &mut Option<Order<&'static mut Memory>>,
    ) -> ((PwmCommand, Option<Answer<&'static mut Memory>>), u32) {
        instructions::count(|| whole(drive, scope, samples, event, order))
    }

    /// The whole of a control tick.
    #[inline(never)]
    fn whole(
        drive: &mut Drive,
        scope: &mut Scope<&'static mut Memory>,
        samples: &Samples,
        event: Option<&Event>,
        order: &mut Option<Order<&'static mut Memory>>,
    ) -> (PwmCommand, Option<Answer<&'static mut Memory>>) {
        if let Some(event) = event {
            scope.handle_event(event);
            drive.handle_event(event);
        }
        let command = step(drive, samples);
        (command, attend(scope, drive, samples, None, order))
    }

    /// A function of its own, like [`measure`].
    #[inline(never)]
    fn look(
        scope: &mut Scope<&'static mut Memory>,
        drive: &Drive,
        samples: &Samples,
        event: Option<&Event>,
        order: &mut Option<Order<&'static mut Memory>>,
    ) -> (Option<Answer<&'static mut Memory>>, u32) {
        instructions::count(|| attend(scope, drive, samples, event, order))
    }

    /// Does the control tick's work for a scope, inlined into the tick's own function.
    #[inline(always)]
    fn attend(
        scope: &mut Scope<&'static mut Memory>,
        drive: &Drive,
        samples: &Samples,
        event: Option<&Event>,
        order: &mut Option<Order<&'static mut Memory>>,
    ) -> Option<Answer<&'static mut Memory>> {
        if let Some(event) = event {
            scope.handle_event(event);
        }
        let answer = if scope.has_answer() { scope.poll() } else { None };
        if order.is_some()
            && let Some(order) = order.take()
        {
            scope.handle(order);
        }
        scope.step(drive, samples);
        answer
    }

    /// A function of its own, so that what the compiler does around it does not move the figure.
    #[inline(never)]
    fn measure(drive: &mut Drive, samples: &Samples) -> (PwmCommand, u32) {
        instructions::count(|| step(drive, samples))
    }

    /// The step as one call, as an interrupt would make it.
    #[inline(never)]
    fn step(drive: &mut Drive, samples: &Samples) -> PwmCommand {
        drive.step(samples)
    }
}
