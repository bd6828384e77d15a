//! Plays a scenario on the bench.

use super::action::Action;
use super::expect::{Seen, WINDOW};
use super::scenario::Scenario;
use narx_core::bus::narmotion::ToDrive;
use narx_core::master;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::{LoadConfig, SupplyConfig};
use std::f64::consts::TAU;

/// What a scenario gave.
#[derive(Clone, Debug)]
pub struct Run {
    /// The drive's recording.
    pub recording: Vec<u8>,
    /// Digest of its outputs.
    pub digest: u64,
    /// Control ticks.
    pub ticks: u64,
    /// What the drive reported.
    pub seen: Seen,
    /// Mean speed of the shaft over the last 0.1 s, mechanical rpm.
    pub speed: f64,
}

/// Plays a scenario from power-up to its end.
pub fn run(scenario: &Scenario) -> Run {
    let mut bench = Bench::new(&BenchConfig {
        plant: scenario.plant.clone(),
        parameters: scenario.parameters.clone(),
        label: scenario.name.clone(),
        trace: false,
    });
    let mut master = Master::new(&bench);
    let mut seen = Seen::default();
    let mut steps = scenario.steps.iter().peekable();
    let tick_rate = f64::from(scenario.plant.board.tick_rate);
    let ticks = (scenario.seconds * tick_rate).round() as u64;
    let mut mark = bench.plant().observe();
    for tick in 0..ticks {
        while let Some(step) = steps.next_if(|step| step.time * tick_rate <= tick as f64) {
            master.act(&mut bench, step.action);
        }
        if tick + WINDOW == ticks {
            mark = bench.plant().observe();
        }
        master.send(&mut bench);
        let before = bench.status().tick;
        bench.step();
        if bench.status().tick != before || tick == 0 {
            seen.note(bench.status());
        }
        while bench.receive().is_some() {}
        while bench.overhear().is_some() {}
    }
    let now = bench.plant().observe();
    let speed = (now.angle - mark.angle) / (now.time - mark.time) * 60.0 / TAU;
    Run { recording: bench.recording(), digest: bench.digest(), ticks, seen, speed }
}

/// The master's place on the bus.
struct Master {
    master: master::Master,
    silent: bool,
}

impl Master {
    /// It asks for Standby.
    fn new(bench: &Bench) -> Self {
        let addresses = bench.node().addresses();
        let mut master = master::Master::new(master::Config { addresses, ..master::Config::default() });
        master.stop();
        Self { master, silent: false }
    }

    fn send(&mut self, bench: &mut Bench) {
        let now = bench.now_ns() / 1000;
        while !self.silent
            && let Some(frame) = self.master.poll_frame(now)
        {
            // A few frames every 50 ms do not fill a queue of 64.
            let _ = bench.send(frame);
        }
    }

    fn act(&mut self, bench: &mut Bench, action: Action) {
        match action {
            Action::Start(rpm) => self.master.start(rpm),
            Action::Stop => self.master.stop(),
            Action::Shutdown => self.master.shut_down(),
            Action::Silence(silent) => self.silent = silent,
            Action::Set(number, value) => {
                let frame = ToDrive::SetParameter { number, value }.encode(bench.node().addresses());
                // As above.
                let _ = bench.send(frame);
            }
            Action::Inject(fault) => bench.plant_mut().inject(fault),
            Action::Clear(fault) => bench.plant_mut().clear(fault),
            Action::Supply(voltage) => {
                let supply = SupplyConfig { voltage, ..bench.plant().config().supply };
                bench.plant_mut().set_supply(supply);
            }
            Action::Load(constant) => {
                let load = LoadConfig { constant, ..bench.plant().load() };
                bench.plant_mut().set_load(load);
            }
        }
    }
}
