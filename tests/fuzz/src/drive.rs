//! Target: the drive as a shell links it, with its flash and a scope: frames, ticks, samples and disturbances
//! in any order.

mod watch;

use crate::program::Program;
use crate::real::{self, Chip, now, open};
use narx_core::bus::narmotion::{Addresses, MESSAGES, MessageKind, MotorMode, RequestWord, ToDrive, Words};
use narx_core::bus::{BusState, ErrorState, Frame};
use narx_core::device::{Background, ControlTick, Queues};
use narx_core::dictionary::{Dictionary, PARAMETER_COUNT, Parameter, Parameters};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::{Board, Edge, EdgeSource, Lines, Samples};
use narx_core::node::{Action, Identity, SelfTests, SlowInputs};
use narx_core::scope::Memory;
use narx_core::storage::{FlashReply, FlashTask, Part, Storage};
use narx_core::units::{Celsius, Volts};
use watch::Watch;

/// Words of the scope: more than a chunk of either kind of record.
const SCOPE_WORDS: usize = 1024;
/// Longest life, ticks: 0.5 s of boot and 1.5 s more.
const LIFE: u64 = 20_000;
/// Ticks until a drive is in Standby.
const BOOT: u64 = 5_100;

/// Runs an input. First byte: bit 0 for a drive that is ready to start, else one with factory parameters and
/// a blank flash; bit 1 for one that has booted. Steps follow; after a reboot the remaining steps go on.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    let first = program.byte();
    let chip = if first & 1 != 0 { real::chip().clone() } else { real::blank() };
    let mut world = World {
        storage: Storage::new(chip),
        samples: at_rest(),
        turning: 0,
        angle: 0,
        hold: 0,
        stored: None,
        both: false,
        lived: 0,
    };
    let boot = if first & 2 != 0 { BOOT } else { 0 };
    while live(&mut world, &mut program, boot) {}
}

/// State that survives a reboot.
struct World {
    storage: Storage<Chip>,
    samples: Samples,
    /// Speed of a shaft that is turned from outside, sectors per tick, 2^-16.
    turning: i16,
    angle: u16,
    /// Delay of the flash's answers, ticks.
    hold: u8,
    /// Parameters that the flash must hold, once both parts are known.
    stored: Option<Parameters>,
    /// True if the next store writes both parts: the flash has no layout yet.
    both: bool,
    lived: u64,
}

/// Samples of a healthy board at rest: 24 V, no current.
fn at_rest() -> Samples {
    Samples { bus_voltage: 1_229, bus_current: 2_048, hall: 0b001, ..Samples::default() }
}

/// Runs from power-up to a reboot (true), or to the end of the program.
fn live(world: &mut World, program: &mut Program<'_>, boot: u64) -> bool {
    let opened = open(&mut world.storage);
    let known = world.stored.replace(opened.parameters.clone());
    world.both = opened.faults.contains(FaultWord::STORE_MISMATCH);
    for (row, raw) in opened.parameters.iter() {
        let stored = is_stored(row);
        let before = known.as_ref().map(|known| known.raw(row.number));
        assert!(
            !stored || before.is_none_or(|before| before == raw),
            "{row} was stored as {before:?} and is {raw}"
        );
    }
    let mut memory = Memory::<[u16; SCOPE_WORDS]>::new();
    let mut queues = Queues::new();
    let (tick, mut background) =
        queues.power_up(Identity::default(), Board::BENCH, opened.parameters.clone());
    background.attach_scope(&mut memory);
    background.node().attach_storage(&opened);
    let addresses = background.node().addresses();
    let watch = Watch::new(addresses, background.node().parameters());
    let mut life = Life { tick, background, addresses, watch, now: 0, report: None, world };
    life.run(boot);
    while !program.is_over() && life.world.lived < LIFE {
        life.handle(program);
        if life.watch.reboots {
            return true;
        }
    }
    life.run(2);
    life.watch.end(life.background.node());
    false
}

struct Life<'q, 'm, 'w> {
    tick: ControlTick<'q, 'm>,
    background: Background<'q, 'm>,
    addresses: Addresses,
    watch: Watch,
    now: u64,
    /// Report of the flash, and the time at which it is delivered.
    report: Option<(u64, FlashReply)>,
    world: &'w mut World,
}

impl Life<'_, '_, '_> {
    /// Runs one step of the program.
    fn handle(&mut self, program: &mut Program<'_>) {
        match program.byte() % 10 {
            0 => self.give(&program.frame()),
            1 => self.give(&message(program, self.addresses)),
            2 => {
                let mode = [MotorMode::Standby, MotorMode::Drive, MotorMode::Reverse, MotorMode::Fault];
                let word = RequestWord { mode: mode[usize::from(program.byte() % 4)] };
                self.give(&ToDrive::RequestWord(word).encode(self.addresses));
            }
            3 => {
                let row = Dictionary::rows().nth(usize::from(program.word()) % PARAMETER_COUNT);
                let number = row.expect("fewer than all").number;
                self.give(
                    &ToDrive::SetParameter { number, value: program.long() as i32 }.encode(self.addresses),
                );
            }
            // The values 0 and 1, which commands and switches take.
            4 => {
                let number = program.word() % 320;
                for value in [0, 1] {
                    self.give(&ToDrive::SetParameter { number, value }.encode(self.addresses));
                }
            }
            5 => self.run(u64::from(program.byte()) + 1),
            6 => self.run((u64::from(program.byte()) + 1) * 16),
            7 => self.sample(program),
            8 => self.disturb(program),
            _ => self.give(&ToDrive::MotorCommand { speed: program.word() }.encode(self.addresses)),
        }
    }

    fn give(&mut self, frame: &Frame) {
        self.watch.give(frame, self.background.node(), self.now);
        self.act();
    }

    fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            if self.watch.reboots {
                return;
            }
            self.step();
        }
    }

    fn step(&mut self) {
        let World { samples, turning, angle, .. } = self.world;
        let before = samples.hall;
        samples.tick = self.now;
        samples.edges.clear();
        if *turning != 0 {
            *angle = angle.wrapping_add_signed(*turning);
            samples.hall = HALL[(usize::from(*angle) * 6) >> 16];
            if samples.hall != before {
                let edge = Edge { instant: *angle, source: EdgeSource::Hall, code: samples.hall };
                samples.edges.push(edge).expect("it was empty");
            }
        }
        let command = self.tick.step(samples);
        self.background.run(self.now);
        self.serve();
        self.watch.tick(self.tick.drive(), &command, self.background.node(), self.now);
        self.act();
        self.now += 1;
        self.world.lived += 1;
    }

    /// Does the shell's work: frames to the bus, and a restart.
    fn act(&mut self) {
        let node = self.background.node();
        while let Some(frame) = node.poll_frame() {
            self.watch.received(&frame);
        }
        // One frame of a download in three ticks: the pace of the bus.
        if self.now.is_multiple_of(3)
            && let Some(frame) = node.poll_bulk_frame()
        {
            self.watch.received(&frame);
        }
        self.watch.reboots |= node.poll_action() == Some(Action::Reboot);
    }

    /// Serves one request of the flash at a time.
    fn serve(&mut self) {
        let World { storage, hold, stored, both, .. } = self.world;
        if let Some((_, report)) = self.report.take_if(|(due, _)| *due <= self.now) {
            self.background.node().handle_storage(report);
        }
        let Some(request) = self.background.node().poll_storage() else { return };
        assert!(self.report.is_none(), "one request at a time");
        let asked = if let FlashTask::Store(parameters, part) = &request {
            Some((parameters.clone(), *part))
        } else {
            None
        };
        let report = now(storage.execute(request));
        if let (Some((parameters, part)), FlashReply::Stored { done: true, .. }, Some(stored)) =
            (asked, &report, stored)
        {
            for (row, raw) in
                parameters.iter().filter(|(row, _)| part.contains(row) || (*both && is_stored(row)))
            {
                stored.set(row.number, raw).expect("it was within its range");
            }
            *both = false;
        }
        self.report = Some((self.now + u64::from(*hold), report));
    }

    /// Changes the samples of converters and lines from now on.
    fn sample(&mut self, program: &mut Program<'_>) {
        let samples = &mut self.world.samples;
        let (what, code) = (program.byte(), program.word() & 0x0FFF);
        match what % 8 {
            0 => samples.bus_voltage = code,
            1 => samples.bus_current = code,
            phase @ 2..=4 => samples.phase_voltage[usize::from(phase - 2)] = code,
            5 => samples.hall = code as u8 & 7,
            6 => samples.lines = Lines::from_bits_truncate(code as u8),
            _ => self.world.turning = (code << 4) as i16 >> 3,
        }
    }

    /// Begins or ends a disturbance of the drive.
    fn disturb(&mut self, program: &mut Program<'_>) {
        let (what, value) = (program.byte(), program.byte());
        let node = self.background.node();
        match what % 5 {
            0 => {
                let error =
                    [ErrorState::Active, ErrorState::Passive, ErrorState::BusOff][usize::from(value % 3)];
                self.watch.off |= error == ErrorState::BusOff;
                node.handle_bus_state(BusState { error, transmit_errors: value.into(), receive_errors: 0 });
            }
            1 => node.handle_inputs(SlowInputs {
                ambient_temperature: Celsius::from_ratio(i64::from(value) - 60, 1),
                pressure: Volts::from_ratio(value.into(), 50),
                dsi1: value & 1 != 0,
                dsi2: value & 2 != 0,
                ..SlowInputs::default()
            }),
            2 => node.handle_self_tests(SelfTests::from_bits_truncate(value.into())),
            3 => self.world.hold = value,
            _ => self.world.samples.edges_lost = value & 1,
        }
    }
}

/// Hall codes of the six sectors, forward.
const HALL: [u8; 6] = [0b001, 0b011, 0b010, 0b110, 0b100, 0b101];

/// A frame to the drive from its master: any existing type and opcode, any words.
fn message(program: &mut Program<'_>, addresses: Addresses) -> Frame {
    let (place, bytes) = (program.byte(), program.array::<8>());
    let mut to_drive = MESSAGES.iter().filter(|message| message.kind != MessageKind::SlaveTx).cycle();
    let message = to_drive.nth(place.into()).expect("there are some");
    let words = Words(
        [[0, 1], [2, 3], [4, 5], [6, 7]].map(|[high, low]| u16::from_be_bytes([bytes[high], bytes[low]])),
    );
    words.frame(message.id(addresses))
}

fn is_stored(row: &Parameter) -> bool {
    Part::Set.contains(row) || Part::Once.contains(row)
}
