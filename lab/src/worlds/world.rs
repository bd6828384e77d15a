//! Life of one world from its number to its end.

use super::mishap::{Chip, Fate, KINDS, Kind, Mishap};
use super::neighbour::Neighbour;
use super::never::{Broken, Checked, Watch};
use narx_core::commissioning::{Commissioning, Mode, Nameplate};
use narx_core::dictionary::number;
use narx_core::identification::{Asked, Identification};
use narx_core::master::{Answer, Config, Master};
use narx_core::motor::{Board, State};
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::can::Attachment;
use narx_sim::plant::{Injection, LoadConfig, MotorConfig, PlantConfig, SupplyConfig};
use narx_sim::presets::{PRESETS, Preset};
use narx_sim::random::Random;
use std::collections::hash_map::DefaultHasher;
use std::fmt;
use std::hash::{Hash, Hasher};

/// Periods of the PWM, microseconds: 10 to 50 kHz. Each period has one tick.
const PERIODS: [u64; 6] = [100, 80, 50, 40, 25, 20];
/// Duration of the faults, s.
pub(super) const TROUBLE: f64 = 20.0;
/// Shortest and longest time between two mishaps, s: with short ones mishaps coincide, long ones let a motor
/// start.
const PAUSE: (f64, f64) = (0.002, 1.2);
/// Pauses are so many times longer while the drive measures its motor, which takes 11 s: some come to a
/// result.
const CALM: f64 = 8.0;
/// Number of ticks between two checks of the physics.
const LOOK: u64 = 10;

/// Results of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Story {
    /// Number of the world.
    pub seed: u64,
    /// Simulated time, s.
    pub seconds: f64,
    /// Number of power-ups.
    pub boots: u64,
    /// Number of restarts without a power cut, which the operator has requested.
    pub resets: u64,
    /// Number of times that the drive's controller went bus-off.
    pub bus_offs: u64,
    /// Number of frames on the bus.
    pub frames: u64,
    /// Number of mishaps of each kind, in the order of [`KINDS`].
    pub mishaps: [u64; KINDS.len()],
    /// Number of injected failures, in the order of [`Injection::NAMES`].
    pub injections: [u64; Injection::NAMES.len()],
    /// Time in each state, microseconds.
    pub states: [u64; 8],
    /// Number of identifications that came to a result.
    pub identified: u64,
    /// Time in which a second drive on the bus has driven its motor, microseconds, if there was one.
    pub neighbour: Option<u64>,
    /// All fault bits that were seen.
    pub faults: u32,
    /// Largest phase current, A.
    pub peak: f64,
    /// Digest of state, step and duty of every tick.
    pub digest: u64,
    /// True if the drive did not start in the end, and an untouched drive did not either.
    pub unable: bool,
    /// Broken invariant.
    pub broken: Option<Broken>,
}

impl fmt::Display for Story {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seed, seconds, boots, frames, peak, digest, .. } = self;
        write!(
            f,
            "world {seed}: {seconds:.1} s, {boots} boots, {frames} frames, {peak:.1} A at most, {digest:016x}"
        )?;
        if let Some(broken) = &self.broken {
            write!(f, "\n  {broken}\n  cargo xtask worlds --world {seed}")?;
        }
        Ok(())
    }
}

/// Runs the world of that number; `tell` prints its events.
pub fn run(seed: u64, tell: bool) -> Story {
    let mut world = World::new(seed, tell);
    let broken = world.live().err();
    let time = world.time();
    Story { broken: broken.map(|(never, what)| Broken { time, never, what }), ..world.story() }
}

pub(super) struct World {
    pub(super) seed: u64,
    pub(super) tell: bool,
    pub(super) fate: Fate,
    pub(super) setting: Setting,
    pub(super) bench: Bench,
    pub(super) neighbour: Option<Neighbour>,
    pub(super) master: Master,
    pub(super) watch: Watch,
    pub(super) ticks: u64,
    pub(super) silent_until: u64,
    pub(super) unplugged_until: u64,
    pub(super) cut_at: Option<u64>,
    pub(super) answer: Option<Answer>,
    pub(super) boots: u64,
    pub(super) resets: u64,
    pub(super) bus_offs: u64,
    /// Bus-offs that the drive has counted since its last boot.
    pub(super) bus_offs_seen: i32,
    pub(super) frames: u64,
    pub(super) mishaps: [u64; KINDS.len()],
    pub(super) injections: [u64; Injection::NAMES.len()],
    pub(super) states: [u64; 8],
    pub(super) identification: Option<Identification>,
    pub(super) identified: u64,
    pub(super) faults: u32,
    pub(super) peak: f64,
    /// Mechanical angle of the rotor at the last start, rad.
    pub(super) begun_at: f64,
    pub(super) unable: bool,
    pub(super) hasher: DefaultHasher,
}

impl World {
    pub(super) fn new(seed: u64, tell: bool) -> Self {
        let mut fate = Fate(Random::new(seed));
        let setting = loop {
            if let Some(drawn) = Setting::draw(&mut fate, seed) {
                break drawn;
            }
        };
        if tell {
            let PlantConfig { board, motor, supply, angle_deg, .. } = &setting.config.plant;
            let (mode, rate) = (setting.mode, board.tick_rate);
            println!("{mode:?}, {rate} Hz, {motor:?}, {supply:?}, rotor at {angle_deg:.0} degrees");
        }
        Self::of(seed, tell, fate, setting)
    }

    /// Builds a world with a drive at power-up, without faults so far.
    pub(super) fn of(seed: u64, tell: bool, fate: Fate, setting: Setting) -> Self {
        let mut bench = Bench::new(&setting.config).without_recording();
        let master = master(&bench);
        Self {
            neighbour: Neighbour::draw(seed, &mut bench, setting.period),
            seed,
            tell,
            fate,
            setting,
            bench,
            master,
            watch: Watch::default(),
            ticks: 0,
            silent_until: 0,
            unplugged_until: 0,
            cut_at: None,
            answer: None,
            boots: 1,
            resets: 0,
            bus_offs: 0,
            bus_offs_seen: 0,
            frames: 0,
            mishaps: [0; KINDS.len()],
            injections: [0; Injection::NAMES.len()],
            states: [0; 8],
            identification: None,
            identified: 0,
            faults: 0,
            peak: 0.0,
            begun_at: 0.0,
            unable: false,
            hasher: DefaultHasher::new(),
        }
    }

    pub(super) fn time(&self) -> f64 {
        (self.ticks * self.setting.period) as f64 * 1e-6
    }

    /// Ticks in this time, s.
    pub(super) fn ticks_in(&self, seconds: f64) -> u64 {
        (seconds * 1e6) as u64 / self.setting.period
    }

    fn story(&self) -> Story {
        Story {
            seed: self.seed,
            seconds: self.time(),
            boots: self.boots,
            resets: self.resets,
            bus_offs: self.bus_offs,
            frames: self.frames,
            mishaps: self.mishaps,
            injections: self.injections,
            states: self.states.map(|ticks| ticks * self.setting.period),
            identified: self.identified,
            neighbour: self.neighbour.as_ref().map(Neighbour::driven),
            faults: self.faults,
            peak: self.peak,
            digest: self.hasher.finish(),
            unable: self.unable,
            broken: None,
        }
    }

    pub(super) fn say(&self, what: impl FnOnce() -> String) {
        if self.tell {
            println!("{:10.4} s  {:<24} {}", self.time(), self.bench.status().state.name(), what());
        }
    }

    /// Prints a change of state, and its reason.
    fn tell_state(&self, before: State) {
        let status = self.bench.status();
        if status.state == before {
            return;
        }
        self.say(|| match status.state {
            State::Fault => {
                format!("  from {}: {:?}, code {:04X}h", before.name(), status.faults, status.extended_code)
            }
            _ => format!("  from {}", before.name()),
        });
    }

    /// Runs the faults, then peace, in which the drive has to work.
    fn live(&mut self) -> Checked {
        while self.time() < TROUBLE {
            let mishap = self.next()?;
            self.say(|| format!("{mishap:?}"));
            self.mishaps[mishap.kind() as usize] += 1;
            if let Mishap::Break(injection) = &mishap {
                self.injections[injection.index()] += 1;
            }
            self.happen(mishap);
        }
        self.make_peace()?;
        self.work()?;
        self.neighbour_works()
    }

    /// Runs until the next mishap; returns it.
    pub(super) fn next(&mut self) -> Checked<Mishap> {
        // The square of an even draw: often soon, sometimes late.
        let share = self.fate.between(0.0, 1.0);
        let calm = if self.identification.is_some() { CALM } else { 1.0 };
        self.run(calm * (PAUSE.0 + (PAUSE.1 - PAUSE.0) * share * share))?;
        Ok(self.fate.draw())
    }

    pub(super) fn happen(&mut self, mishap: Mishap) {
        if self.is_refused(&mishap) {
            return;
        }
        let speed = |share: f64| share * self.setting.commissioning.speed_max;
        match mishap {
            Mishap::Start(share) => self.master.start(speed(share) as i32),
            Mishap::SetSpeed(share) => self.master.set_speed(speed(share) as u16),
            Mishap::Stop => self.master.stop(),
            Mishap::ShutDown => self.master.shut_down(),
            // A request that is not accepted now is dropped, as if an operator had clicked twice.
            Mishap::Request(request) => drop(self.master.request(request)),
            Mishap::Download(download) => drop(self.master.download(download)),
            Mishap::AbortDownload => self.master.abort_download(),
            Mishap::Identify(halls) => {
                let poles = self.setting.config.plant.motor.pole_pairs;
                self.identification = Identification::new(Asked { halls, ..Asked::new(poles) }).ok();
            }
            Mishap::Silence(seconds) => self.silent_until = self.ticks + self.ticks_in(seconds),
            Mishap::Frames(frames) => {
                self.bench.set_other(Attachment::Normal);
                for frame in frames {
                    // Frames that do not fit the queue are dropped.
                    let _ = self.bench.send_as_other(frame);
                }
            }
            Mishap::Break(injection) => self.bench.plant_mut().inject(injection),
            Mishap::Mend(Some(injection)) => self.bench.plant_mut().clear(injection),
            Mishap::Mend(None) => self.bench.plant_mut().clear_all(),
            Mishap::Load(share) => self.bench.plant_mut().set_load(LoadConfig {
                constant: share * self.setting.rated_torque,
                ..LoadConfig::default()
            }),
            Mishap::Source(resistance, may_sink) => {
                let voltage = self.setting.config.plant.supply.voltage;
                self.bench.plant_mut().set_supply(SupplyConfig { voltage, resistance, may_sink });
            }
            Mishap::Disturb(frames, bit) => self.bench.disturb_bus(frames, bit),
            Mishap::Unplug(seconds) => {
                self.bench.set_host(Attachment::Detached);
                self.unplugged_until = self.ticks + self.ticks_in(seconds);
            }
            Mishap::Cut(steps, tear) => {
                self.bench.flash().cut_after(steps, tear);
                self.cut_at = Some(self.ticks + 1 + steps);
            }
            Mishap::Flip(share, bit) => self.bench.flash().flip((share * 65_536.0) as u32, bit),
            Mishap::Chip(chip) => {
                self.watch.spare_store();
                self.bench.flash().set_absent(matches!(chip, Chip::Silent));
                if matches!(chip, Chip::New) {
                    self.bench.flash().clear();
                    self.cut_at = Some(self.ticks + 1);
                }
            }
        }
    }

    /// While the drive measures its motor, the operator's program refuses what else he asks for; now and then
    /// he aborts it.
    fn is_refused(&mut self, mishap: &Mishap) -> bool {
        let Some(identification) = &mut self.identification else { return false };
        if !matches!(mishap.kind(), Kind::Command | Kind::Request | Kind::Download | Kind::Identify) {
            return false;
        }
        if self.fate.chance(0.1) {
            identification.abort(&mut self.master);
        }
        true
    }

    /// Goes on with what the operator's program does.
    fn identify(&mut self, now: u64) {
        let Some(identification) = &mut self.identification else { return };
        if let Some(outcome) = identification.step(&mut self.master, now) {
            self.say(|| match &outcome {
                Ok(_) => "the motor is identified".into(),
                Err(error) => format!("identification: {error}"),
            });
            self.identified += u64::from(outcome.is_ok());
            self.identification = None;
        }
    }

    pub(super) fn run(&mut self, seconds: f64) -> Checked {
        let until = self.ticks + self.ticks_in(seconds);
        while self.ticks < until {
            self.tick()?;
        }
        Ok(())
    }

    pub(super) fn tick(&mut self) -> Checked {
        self.ticks += 1;
        let now = self.bench.now_ns() / 1000;
        self.identify(now);
        if self.ticks >= self.silent_until {
            while let Some(frame) = self.master.poll_frame(now) {
                // The frames of a master whose cable is disconnected are refused.
                let _ = self.bench.send(frame);
            }
        }
        if self.ticks == self.unplugged_until {
            self.bench.set_host(Attachment::Normal);
        }
        let before = self.bench.status().state;
        self.bench.step();
        if let Some(neighbour) = &mut self.neighbour {
            neighbour.tick(&mut self.bench, self.ticks < self.silent_until)?;
        }
        self.tell_state(before);
        self.resets +=
            u64::from(before != State::Initialization && self.bench.status().state == State::Initialization);
        let now = self.bench.now_ns() / 1000;
        while let Some(received) = self.bench.receive() {
            self.master.handle_frame(&received.frame, now);
            if let Some(neighbour) = &mut self.neighbour {
                neighbour.receive(&received.frame);
            }
        }
        while self.bench.receive_as_other().is_some() {}
        let address = self.bench.node().addresses().drive;
        while let Some(received) = self.bench.monitor() {
            self.frames += 1;
            Watch::frame(&received.frame, address)?;
            if let Some(neighbour) = &self.neighbour {
                neighbour.check(&received)?;
            }
        }
        // They belong to the identification while there is one.
        if self.identification.is_none() {
            while let Some(answer) = self.master.poll_answer() {
                self.answer = Some(answer);
            }
            while self.master.poll_chunk().is_some() {}
            let _ = self.master.poll_download();
        }
        self.keep();
        self.watch.tick(&self.bench, self.setting.period)?;
        if self.ticks.is_multiple_of(LOOK) {
            let PlantConfig { motor, inverter, .. } = &self.setting.config.plant;
            // Two windings in series store the most.
            let stored = 0.5 * motor.inductance * self.peak * self.peak;
            Watch::physics(&self.bench, stored, inverter.capacitance)?;
            self.count_bus_offs();
        }
        if self.cut_at.is_some_and(|tick| tick <= self.ticks) || self.bench.flash().is_off() {
            self.cut();
        }
        Ok(())
    }

    fn keep(&mut self) {
        let (status, command) = (self.bench.status(), self.bench.command());
        self.states[status.state as usize] += 1;
        self.faults |= status.faults.bits();
        (status.state as u8, command.step as u8, command.duty.to_bits()).hash(&mut self.hasher);
        self.peak = self.peak.max(self.bench.plant().observe().peak_current);
    }

    /// Adds up the drive's own count, which begins anew when it restarts.
    fn count_bus_offs(&mut self) {
        let now = self.bench.node().read_parameter(number::BUS_OFFS).unwrap_or_default();
        self.bus_offs += u64::from((now - self.bus_offs_seen).max(0).unsigned_abs());
        self.bus_offs_seen = now;
    }

    /// Cuts the power and restores it; the flash keeps its content, and the rotor stands at a new angle.
    fn cut(&mut self) {
        self.cut_at = None;
        let angle_deg = self.fate.between(0.0, 360.0);
        let config = BenchConfig {
            plant: PlantConfig { angle_deg, ..self.setting.config.plant.clone() },
            ..self.setting.config.clone()
        };
        let empty = Bench::new(&config).without_recording();
        let mut flash = std::mem::replace(&mut self.bench, empty).into_flash();
        flash.restore_power();
        self.bench = Bench::with_flash(&config, flash).without_recording();
        if let Some(neighbour) = &mut self.neighbour {
            neighbour.power_up(&mut self.bench);
        }
        self.boots += 1;
        // The master has not lost its power, only its drive. It is built anew because its clock is the
        // bench's, which begins anew.
        self.master = master(&self.bench);
        self.identification = None;
        self.watch.begin_anew();
        self.unplugged_until = 0;
    }
}

/// Builds the operator's master, which requests Standby at first.
pub(super) fn master(bench: &Bench) -> Master {
    let addresses = bench.node().addresses();
    let mut master = Master::new(Config { addresses, read_parameters: false, ..Config::default() });
    master.stop();
    master
}

/// Initial conditions of a world.
#[derive(Clone)]
pub(super) struct Setting {
    pub(super) config: BenchConfig,
    /// Of the PWM, microseconds.
    pub(super) period: u64,
    pub(super) mode: Mode,
    pub(super) commissioning: Commissioning,
    pub(super) rated_torque: f64,
}

impl Setting {
    /// Draws a motor of the market with deviations from its data sheet, in a mode that runs it on this
    /// supply.
    fn draw(fate: &mut Fate, seed: u64) -> Option<Self> {
        let preset = &PRESETS[fate.below(PRESETS.len())];
        let mode = Mode::ALL[fate.below(Mode::ALL.len())];
        let supply = fate.between(20.0, 58.0);
        let period = PERIODS[fate.below(PERIODS.len())];
        let mut setting = Self::of(preset, mode, supply, period, seed)?;
        let sheet = &preset.motor;
        let motor = MotorConfig {
            inertia: sheet.inertia * fate.between(0.7, 2.0),
            static_friction: sheet.static_friction * fate.between(0.5, 2.0),
            resistance: sheet.resistance * fate.between(0.9, 1.3),
            torque_constant: sheet.torque_constant * fate.between(0.9, 1.05),
            ..*sheet
        };
        let plant = &mut setting.config.plant;
        (plant.motor, plant.angle_deg) = (motor, fate.between(0.0, 360.0));
        Some(setting)
    }

    /// Builds the drive of a motor as in its data sheet; nothing if it cannot be commissioned.
    pub(super) fn of(preset: &Preset, mode: Mode, supply: f64, period: u64, seed: u64) -> Option<Self> {
        let board = Board::BENCH.at_rate((1_000_000 / period) as u32)?;
        let plate = Nameplate {
            motor: preset.motor.figures(),
            rated_current: preset.data.rated_current,
            supply,
            open_loop_speed: None,
        };
        let commissioning = plate.commission_on(&board, mode, None).ok()?;
        let plant = PlantConfig { board, seed, ..PlantConfig::new(preset.motor, supply) };
        let parameters = commissioning.parameters.clone();
        let label = format!("world {seed}");
        let config = BenchConfig { plant, parameters, label, trace: false };
        Some(Self { config, period, mode, commissioning, rated_torque: preset.rated_torque() })
    }
}
