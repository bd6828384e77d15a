//! Plays a scenario on the bench.

use super::action::Action;
use super::expect::{Seen, window};
use super::scenario::{Of, Scenario};
use narx_core::bus::eddycan::{Channels, NodeId};
use narx_core::bus::narmotion::ToDrive;
use narx_core::master;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::{LoadConfig, SupplyConfig};
use narx_sim::sensor::{EddyCurrentConfig, Encoder};
use narx_sim::tx_driver::{Device, TxDriverConfig};
use std::f64::consts::TAU;

/// Results of a scenario.
#[derive(Clone, Debug)]
pub struct Run {
    /// Recording of the device that the scenario concerns.
    pub recording: Vec<u8>,
    /// Number of control ticks.
    pub ticks: u64,
    /// Content of the drive's reports.
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
    match scenario.of {
        Of::Drive => {}
        // Without a bootloader, because some programs that replay have none.
        Of::Node => bench = bench.without_programming().with_transcript(),
        Of::TxDriver => begin_tx_driver(&mut bench, &scenario.name),
    }
    let mut master = Master::new(&bench);
    let board = scenario.plant.board;
    let mut seen = Seen::new(board.tick_rate);
    let mut steps = scenario.steps.iter().peekable();
    let tick_rate = f64::from(board.tick_rate);
    let ticks = (scenario.seconds * tick_rate).round() as u64;
    let mut mark = bench.plant().observe();
    for tick in 0..ticks {
        while let Some(step) = steps.next_if(|step| step.time * tick_rate <= tick as f64) {
            master.act(&mut bench, step.action);
        }
        if tick + window(board.tick_rate) == ticks {
            mark = bench.plant().observe();
        }
        master.send(&mut bench);
        let before = bench.status().tick;
        bench.step();
        if bench.status().tick != before || tick == 0 {
            seen.note(bench.status());
        }
        while bench.receive().is_some() {}
        while let Some(received) = bench.monitor() {
            if received.sender != bench.host() {
                seen.note_sent(received.frame.id());
            }
        }
    }
    let now = bench.plant().observe();
    let speed = (now.angle - mark.angle) / (now.time - mark.time) * 60.0 / TAU;
    let recording = match scenario.of {
        Of::Drive => bench.recording(),
        Of::Node => bench.transcript(),
        Of::TxDriver => bench.tx_drivers().first().map(Device::transcript).unwrap_or_default(),
    };
    Run { recording, ticks, seen, speed }
}

/// Adds a TX-Driver and begins its transcript. Its samples have no noise: a shaft at rest then takes no room.
fn begin_tx_driver(bench: &mut Bench, label: &str) {
    let Some(node) = NodeId::new(5) else { return };
    let config = TxDriverConfig::new(node);
    let config = TxDriverConfig {
        channels: Channels::Dual,
        sensors: config.sensors.map(|sensor| EddyCurrentConfig { noise: 0.0, ..sensor }),
        encoder: Some(Encoder::Rotary { counts: 4096 }),
        ..config
    };
    // Cannot fail: a bus has room for one.
    let _ = bench.add_tx_driver(&config);
    for device in bench.tx_drivers_mut() {
        device.begin_transcript(label);
    }
}

/// The master on the bus.
struct Master {
    master: master::Master,
    silent: bool,
}

impl Master {
    /// Builds a master that requests Standby.
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
            Action::Send(frame) => {
                // As above.
                let _ = bench.send(frame);
            }
            // Bit 40 is in the middle of the data.
            Action::Disturb(frames) => bench.disturb_bus(frames, 40),
            Action::Health(health) => bench.set_health(health),
        }
    }
}
