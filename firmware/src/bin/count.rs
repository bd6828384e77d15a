//! Counts the instructions of every `Drive::step` in recordings: `count FILE... [--running FILE...]`, under `-icount shift=7`.
//!
//! Prints `vector STEM TICKS TOTAL WORST` for every file, then `state NUMBER TICKS TOTAL WORST` for every state (Table 6)
//! over all files, and `bracket N`, what the measurement cost itself and was taken off. A tick counts for the state in which
//! it ends. Steps that answer anything else than what was recorded are not counted: cheaper must mean the same bits.
//!
//! Files behind `--running` count for no state. Each gives `running STEM TICKS TOTAL WORST`: its ticks from 0.2 s after the closed loop began. They
//! are run once more with a virtual scope, and give `scope STEM TICKS TOTAL WORST`: what it adds to every tick.
//!
//! `bytes state N` and `bytes coefficients N` are the sizes of the drive without its coefficients, and of these.
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
    semihosting::exit(image::run(semihosting::arguments(ARGUMENTS), RECORDING))
}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_semihosting::hprintln;
    use heapless::Vec;
    use narx_core::motor::signal::{Signal, SpeedScale};
    use narx_core::motor::{Coefficients, Drive, Event, PwmCommand, Samples, State, Status};
    use narx_core::recording::{Recording, ReplayError, Replayable, replay_with};
    use narx_core::scope::{Report, Request, Scope, Setup, State as ScopeState, Threshold, Trigger, WORDS};
    use narx_firmware::boards::qemu::instructions::{self, Sum};
    use narx_firmware::boards::qemu::{semihosting, stem};
    use serde::Deserialize;

    /// States of the drive (Table 6).
    const STATES: usize = 8;
    /// Ticks of closed loop after which a motor counts as one that just runs: 0.2 s at 10 kHz.
    const SETTLED: u32 = 2_000;

    /// Counts all files; false if one could not be.
    pub(crate) fn run<'a>(arguments: impl Iterator<Item = &'a str>, buffer: &mut [u8]) -> bool {
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
                        success &= show_scope(stem, bytes, bracket);
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
        for (number, sum) in states.iter().enumerate().filter(|(_, sum)| sum.ticks > 0) {
            hprintln!("state {} {}", number, sum);
        }
        hprintln!("bytes state {}", size_of::<Drive>() - size_of::<Coefficients>());
        hprintln!("bytes coefficients {}", size_of::<Coefficients>());
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

    /// What a scope adds; false if that could not be counted.
    fn show_scope(stem: &str, bytes: &[u8], bracket: u32) -> bool {
        let mut sum = Sum::default();
        let outcome = count_scope(bytes, |instructions| sum.add(instructions.saturating_sub(bracket)));
        let identical = matches!(outcome, Ok(true));
        if identical {
            hprintln!("scope {} {}", stem, sum);
        } else {
            hprintln!("{} error with a scope the outputs are not the recorded ones", stem);
        }
        identical
    }

    fn count_scope(bytes: &[u8], mut each: impl FnMut(u32)) -> Result<bool, ReplayError> {
        let outcome =
            replay_with::<Scoped>(&Recording::open(bytes)?, |scoped, _, _| each(scoped.instructions))?;
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

    /// A drive with a scope that waits for an edge, records, is read, and is armed again; eight signals, those of the estimators among them.
    #[derive(Deserialize)]
    struct Scoped {
        drive: Drive,
        #[serde(skip, default = "whole")]
        scope: Scope<Vec<u16, WORDS>>,
        #[serde(skip)]
        wait: u16,
        #[serde(skip)]
        stage: Stage,
        #[serde(skip)]
        instructions: u32,
    }

    fn whole() -> Scope<Vec<u16, WORDS>> {
        let mut memory = Vec::new();
        let _ = memory.resize(WORDS, 0);
        Scope::new(memory)
    }

    impl Scoped {
        /// What the background asks for: a record after 50 ms of waiting, all of it, and another one.
        fn ask(&mut self) -> Option<Request> {
            self.wait = self.wait.saturating_sub(1);
            let (next, request) = match (self.stage, self.scope.state()) {
                (Stage::Arm, _) => (Stage::Wait, Request::Arm(setup())),
                (Stage::Wait, ScopeState::Armed) if self.wait == 0 => (Stage::Record, Request::Force),
                (Stage::Record, ScopeState::Done) => (Stage::Read, Request::Read),
                (Stage::Read, _) if !self.scope.has_report() => (Stage::Wait, Request::Arm(setup())),
                _ => return None,
            };
            if matches!(request, Request::Arm(_)) {
                self.wait = 500;
            }
            self.stage = next;
            Some(request)
        }
    }

    #[derive(Clone, Copy, Default)]
    enum Stage {
        #[default]
        Arm,
        Wait,
        Record,
        Read,
    }

    fn setup() -> Setup {
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
            samples: 512,
            prescaler: 1,
            before: 256,
            trigger: Trigger::Edge(threshold),
            speed: SpeedScale::new(8),
        }
    }

    impl Replayable for Scoped {
        fn handle_event(&mut self, event: Event) {
            self.drive.handle_event(event);
        }

        fn step(&mut self, samples: &Samples) -> PwmCommand {
            let command = self.drive.step(samples);
            let request = self.ask();
            self.instructions = look(&mut self.scope, &self.drive, samples, request);
            command
        }

        fn poll_status(&mut self) -> Option<Status> {
            self.drive.poll_status()
        }
    }

    #[inline(never)]
    fn look(
        scope: &mut Scope<Vec<u16, WORDS>>,
        drive: &Drive,
        samples: &Samples,
        request: Option<Request>,
    ) -> u32 {
        let (report, instructions) = instructions::count(|| attend(scope, drive, samples, request));
        core::hint::black_box(report);
        instructions
    }

    /// What the control tick does with a scope.
    #[inline(never)]
    fn attend(
        scope: &mut Scope<Vec<u16, WORDS>>,
        drive: &Drive,
        samples: &Samples,
        request: Option<Request>,
    ) -> Option<Report> {
        if let Some(request) = request {
            scope.handle(request);
        }
        scope.step(drive, samples);
        if scope.has_report() { scope.poll() } else { None }
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
