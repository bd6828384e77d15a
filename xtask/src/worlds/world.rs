//! One world from its number to its end.

use super::mishap::{Fate, KINDS, Mishap};
use super::never::{Broken, Watch};
use narx_core::bus::narmotion::DigitalOutputs;
use narx_core::dictionary::{Access, Parameters, number};
use narx_core::master::{Answer, Config, Master, Request};
use narx_core::motor::State;
use narx_core::motor::event::Refusal;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::can::Attachment;
use narx_sim::commissioning::{Commissioning, Mode, Nameplate};
use narx_sim::engineering;
use narx_sim::plant::{LoadConfig, MotorConfig, PlantConfig, SupplyConfig};
use narx_sim::presets::PRESETS;
use narx_sim::random::Random;
use std::collections::hash_map::DefaultHasher;
use std::fmt;
use std::hash::{Hash, Hasher};

/// One tick, s.
const TICK: f64 = 1e-4;
/// How long things go wrong, s.
const TROUBLE: f64 = 20.0;
/// Time between two mishaps, s, at least and at most: short ones come together, long ones let a motor start.
const PAUSE: (f64, f64) = (0.002, 1.2);
/// After the trouble: until a drive that was asked for Standby is there, and until one that was asked to turn does, s. A fault waits for its
/// acknowledgement, Auto-restart tries for its time, and a rotor without friction turns for long.
const CALM: f64 = 12.0;
/// Two requests for Standby and the wait of a fault, s.
const ACKNOWLEDGED: f64 = 1.0;
const START: f64 = 20.0;
/// A master repeats a request a few times before it gives up, s.
const ANSWER: f64 = 5.0;
/// Ticks between two looks at the physics.
const LOOK: u64 = 10;

/// What became of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Story {
    /// Its number.
    pub seed: u64,
    /// Simulated time, s.
    pub seconds: f64,
    /// Power-ups.
    pub boots: u64,
    /// Frames on the bus.
    pub frames: u64,
    /// Mishaps in the order of [`KINDS`].
    pub mishaps: [u64; KINDS.len()],
    /// Ticks in each state.
    pub states: [u64; 8],
    /// Every fault bit that was seen.
    pub faults: u32,
    /// Largest phase current, A.
    pub peak: f64,
    /// Of state, step and duty of every tick.
    pub digest: u64,
    /// What happened that may not.
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

/// Lives through the world of that number; `tell` prints what happens.
pub fn run(seed: u64, tell: bool) -> Story {
    let mut world = World::new(seed, tell);
    let broken = world.live().err();
    let time = world.time();
    Story { broken: broken.map(|what| Broken { time, what }), ..world.story() }
}

struct World {
    seed: u64,
    tell: bool,
    fate: Fate,
    config: BenchConfig,
    mode: Mode,
    commissioning: Commissioning,
    rated_torque: f64,
    bench: Bench,
    master: Master,
    watch: Watch,
    ticks: u64,
    silent_until: u64,
    unplugged_until: u64,
    cut_at: Option<u64>,
    answer: Option<Answer>,
    boots: u64,
    frames: u64,
    mishaps: [u64; KINDS.len()],
    states: [u64; 8],
    faults: u32,
    peak: f64,
    hasher: DefaultHasher,
}

impl World {
    fn new(seed: u64, tell: bool) -> Self {
        let mut fate = Fate(Random::new(seed));
        let (config, mode, commissioning, rated_torque) = loop {
            if let Some(drawn) = draw(&mut fate, seed) {
                break drawn;
            }
        };
        let bench = Bench::new(&config).without_recording();
        let master = master(&bench);
        Self {
            seed,
            tell,
            fate,
            config,
            mode,
            commissioning,
            rated_torque,
            bench,
            master,
            watch: Watch::default(),
            ticks: 0,
            silent_until: 0,
            unplugged_until: 0,
            cut_at: None,
            answer: None,
            boots: 1,
            frames: 0,
            mishaps: [0; KINDS.len()],
            states: [0; 8],
            faults: 0,
            peak: 0.0,
            hasher: DefaultHasher::new(),
        }
    }

    fn time(&self) -> f64 {
        self.ticks as f64 * TICK
    }

    fn story(&self) -> Story {
        Story {
            seed: self.seed,
            seconds: self.time(),
            boots: self.boots,
            frames: self.frames,
            mishaps: self.mishaps,
            states: self.states,
            faults: self.faults,
            peak: self.peak,
            digest: self.hasher.finish(),
            broken: None,
        }
    }

    fn say(&self, what: impl FnOnce() -> String) {
        if self.tell {
            println!("{:10.4} s  {:<24} {}", self.time(), self.bench.status().state.name(), what());
        }
    }

    /// Trouble, then peace: and in peace it has to work.
    fn live(&mut self) -> Result<(), String> {
        let end = (TROUBLE / TICK) as u64;
        while self.ticks < end {
            // Often soon, sometimes late: the square of an even draw.
            let share = self.fate.between(0.0, 1.0);
            let pause = PAUSE.0 + (PAUSE.1 - PAUSE.0) * share * share;
            self.run(pause)?;
            let mishap = self.fate.draw();
            self.say(|| format!("{mishap:?}"));
            self.mishaps[mishap.kind() as usize] += 1;
            self.happen(mishap);
        }
        self.make_peace()?;
        self.work()
    }

    fn happen(&mut self, mishap: Mishap) {
        let speed = |share: f64| share * self.commissioning.speed_max;
        let ticks = |seconds: f64| (seconds / TICK) as u64;
        match mishap {
            Mishap::Start(share) => self.master.start(speed(share) as i32),
            Mishap::SetSpeed(share) => self.master.set_speed(speed(share) as u16),
            Mishap::Stop => self.master.stop(),
            Mishap::ShutDown => self.master.shut_down(),
            // What is not taken now was one request too many: operators click twice.
            Mishap::Request(request) => drop(self.master.request(request)),
            Mishap::Download(download) => drop(self.master.download(download)),
            Mishap::AbortDownload => self.master.abort_download(),
            Mishap::Silence(seconds) => self.silent_until = self.ticks + ticks(seconds),
            Mishap::Frames(frames) => {
                self.bench.set_other(Attachment::Normal);
                for frame in frames {
                    // More than the queue holds is no more trouble.
                    let _ = self.bench.send_as_other(frame);
                }
            }
            Mishap::Break(injection) => self.bench.plant_mut().inject(injection),
            Mishap::Mend(Some(injection)) => self.bench.plant_mut().clear(injection),
            Mishap::Mend(None) => self.bench.plant_mut().clear_all(),
            Mishap::Load(share) => self
                .bench
                .plant_mut()
                .set_load(LoadConfig { constant: share * self.rated_torque, ..LoadConfig::default() }),
            Mishap::Source(resistance, may_sink) => {
                let voltage = self.config.plant.supply.voltage;
                self.bench.plant_mut().set_supply(SupplyConfig { voltage, resistance, may_sink });
            }
            Mishap::Disturb(frames, bit) => self.bench.disturb_bus(frames, bit),
            Mishap::Unplug(seconds) => {
                self.bench.set_host(Attachment::Detached);
                self.unplugged_until = self.ticks + ticks(seconds);
            }
            Mishap::Cut(steps, tear) => {
                self.bench.flash().cut_after(steps, tear);
                self.cut_at = Some(self.ticks + 1 + steps);
            }
            Mishap::Flip(share, bit) => self.bench.flash().flip((share * 65_536.0) as u32, bit),
        }
    }

    fn run(&mut self, seconds: f64) -> Result<(), String> {
        let until = self.ticks + (seconds / TICK) as u64;
        while self.ticks < until {
            self.tick()?;
        }
        Ok(())
    }

    fn tick(&mut self) -> Result<(), String> {
        self.ticks += 1;
        let now = self.bench.now_ns() / 1000;
        if self.ticks >= self.silent_until {
            while let Some(frame) = self.master.poll_frame(now) {
                // A master whose cable is off has its frames refused.
                let _ = self.bench.send(frame);
            }
        }
        if self.ticks == self.unplugged_until {
            self.bench.set_host(Attachment::Normal);
        }
        self.bench.step();
        let now = self.bench.now_ns() / 1000;
        while let Some(received) = self.bench.receive() {
            self.master.handle_frame(&received.frame, now);
        }
        while self.bench.receive_as_other().is_some() {}
        let address = self.bench.node().addresses().drive;
        while let Some(heard) = self.bench.overhear() {
            self.frames += 1;
            Watch::frame(&heard.frame, address)?;
        }
        while let Some(answer) = self.master.poll_answer() {
            self.answer = Some(answer);
        }
        while self.master.poll_chunk().is_some() {}
        let _ = self.master.poll_download();
        self.keep();
        self.watch.tick(&self.bench)?;
        if self.ticks.is_multiple_of(LOOK) {
            Watch::physics(&self.bench)?;
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

    /// The power is gone, and comes back; the flash has what it has, and the rotor stands.
    fn cut(&mut self) {
        self.cut_at = None;
        let angle_deg = self.fate.between(0.0, 360.0);
        let config = BenchConfig {
            plant: PlantConfig { angle_deg, ..self.config.plant.clone() },
            ..self.config.clone()
        };
        let empty = Bench::new(&config).without_recording();
        let mut flash = std::mem::replace(&mut self.bench, empty).into_flash();
        flash.restore_power();
        self.bench = Bench::with_flash(&config, flash).without_recording();
        self.boots += 1;
        // The master goes on: it has not lost its power, only its drive. But its clock is the bench's, which begins anew.
        self.master = master(&self.bench);
        self.watch = Watch::default();
        self.unplugged_until = 0;
    }

    /// Everything is mended, and the operator pulls himself together: Standby, and the parameters as they were commissioned.
    fn make_peace(&mut self) -> Result<(), String> {
        self.say(|| "peace".into());
        self.cut_at = None;
        self.bench.flash().restore_power();
        self.silent_until = 0;
        self.bench.disturb_bus(0, 0);
        self.bench.set_host(Attachment::Normal);
        self.bench.set_other(Attachment::Detached);
        self.bench.plant_mut().clear_all();
        self.bench.plant_mut().set_supply(self.config.plant.supply);
        self.bench.plant_mut().set_load(self.config.plant.load);
        self.master.abort_download();
        // A new master: what the old one had still to ask for is nobody's wish any more.
        self.master = master(&self.bench);
        // A threshold that the operator has changed may keep a fault alive, and it can be written in Fault, too.
        let rests = |state| state == State::Standby || state == State::Fault;
        let is_standby = |state| state == State::Standby;
        self.run(ACKNOWLEDGED)?;
        if !self.until(CALM, rests)? {
            return Err(format!("asked for Standby it is in {:?}", self.bench.status()));
        }
        self.ask(Request::DisableHallSupply(false))?;
        self.ask(Request::DigitalOutputs(DigitalOutputs::default()))?;
        let parameters = self.commissioning.parameters.clone();
        self.write_all(&parameters)?;
        if !self.until(CALM, is_standby)? {
            return Err(format!("all is mended, and it is in {:?}", self.bench.status()));
        }
        Ok(())
    }

    /// Waits for a state; false if it does not come.
    fn until(&mut self, seconds: f64, holds: impl Fn(State) -> bool) -> Result<bool, String> {
        let until = self.ticks + (seconds / TICK) as u64;
        while !holds(self.bench.status().state) && self.ticks < until {
            self.tick()?;
        }
        Ok(holds(self.bench.status().state))
    }

    /// Writes every parameter that is another one; commands and what the drive alone writes stay.
    fn write_all(&mut self, parameters: &Parameters) -> Result<(), String> {
        for (row, raw) in parameters.iter() {
            let now = self.bench.node().parameters().raw(row.number);
            if row.access == Access::ReadOnly || row.command || now == raw {
                continue;
            }
            self.write(row.number, raw)?;
        }
        Ok(())
    }

    fn write(&mut self, number: u16, raw: i32) -> Result<(), String> {
        self.ask(Request::Write { number, raw })?;
        if self.bench.node().parameters().raw(number) == raw {
            return Ok(());
        }
        Err(format!("parameter {number} does not become {raw}"))
    }

    /// Asks, and waits for the answer.
    fn ask(&mut self, request: Request) -> Result<(), String> {
        self.answer = None;
        self.master.request(request).map_err(|error| format!("{request:?}: {error:?}"))?;
        for _ in 0..(ANSWER / TICK) as u32 {
            self.tick()?;
            if let Some(answer) = self.answer.take() {
                return answer.result.map(drop).map_err(|error| format!("{request:?}: {error}"));
            }
        }
        Err(format!("{request:?}: no end within {ANSWER} s"))
    }

    /// It has to start, and to turn as it was asked to.
    fn work(&mut self) -> Result<(), String> {
        let rpm = if self.mode == Mode::OpenLoop {
            engineering::value(&self.commissioning.parameters, number::OPEN_LOOP_SPEED).unwrap_or(0.0)
        } else {
            0.5 * (self.commissioning.speed_min + self.commissioning.speed_max)
        };
        // The first start may be one that calibrates the hall sensors, because somebody has asked for it; it ends in Standby.
        for _ in 0..2 {
            self.say(|| format!("start {rpm:.0} rpm"));
            self.master.start(rpm as i32);
            let until = self.ticks + (START / TICK) as u64;
            while self.ticks < until && self.bench.status().refusal != Refusal::NoFreshRequest {
                self.tick()?;
                let speed = self.bench.plant().observe().speed * 60.0 / std::f64::consts::TAU;
                if (speed / rpm - 1.0).abs() < 0.05 {
                    self.say(|| format!("turns at {speed:.0} rpm"));
                    return Ok(());
                }
            }
            self.master.stop();
            self.run(ACKNOWLEDGED)?;
        }
        let speed = self.bench.plant().observe().speed;
        Err(format!("all is mended, and it does not turn: {:?}, {speed:.0} rad/s", self.bench.status()))
    }
}

/// The operator's master, who asks for Standby at first.
fn master(bench: &Bench) -> Master {
    let addresses = bench.node().addresses();
    let mut master = Master::new(Config { addresses, read_parameters: false, ..Config::default() });
    master.stop();
    master
}

/// A motor of the market, a bit off its data sheet, in a mode that runs it on this supply.
fn draw(fate: &mut Fate, seed: u64) -> Option<(BenchConfig, Mode, Commissioning, f64)> {
    let preset = &PRESETS[fate.below(PRESETS.len())];
    let mode = Mode::ALL[fate.below(Mode::ALL.len())];
    let supply = fate.between(20.0, 58.0);
    let plate = Nameplate {
        motor: preset.motor,
        rated_current: preset.data.rated_current,
        supply,
        open_loop_speed: None,
    };
    let commissioning = plate.commission(mode).ok()?;
    let sheet = &preset.motor;
    let motor = MotorConfig {
        inertia: sheet.inertia * fate.between(0.7, 2.0),
        static_friction: sheet.static_friction * fate.between(0.5, 2.0),
        resistance: sheet.resistance * fate.between(0.9, 1.3),
        torque_constant: sheet.torque_constant * fate.between(0.9, 1.05),
        ..*sheet
    };
    let mut plant = PlantConfig::new(motor, supply);
    plant.angle_deg = fate.between(0.0, 360.0);
    plant.seed = seed;
    let parameters = commissioning.parameters.clone();
    let label = format!("world {seed}");
    Some((BenchConfig { plant, parameters, label, trace: false }, mode, commissioning, preset.rated_torque()))
}
