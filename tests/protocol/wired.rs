//! A whole drive on the simulated bus, with a master that sends only the messages of a test.

use narx_core::bus::Frame;
use narx_core::bus::narmotion::{
    Addresses, FromDrive, MotorMode, ParameterStatus, RequestWord, SIGNALS, ToDrive, Words,
};
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::dictionary::Parameters;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::{Input, MotorConfig, PlantConfig};
use narx_sim::presets::preset;

/// Ticks between two requests of a master that keeps the drive's command alive: 50 ms.
const ALIVE: u64 = 500;

pub(crate) struct Wired {
    pub(crate) bench: Bench,
    /// Motor mode that is requested repeatedly; without it the master is silent.
    pub(crate) asks: Option<MotorMode>,
    /// Frames that have passed on the bus, with the end of each, ns.
    pub(crate) received: Vec<(u64, Frame)>,
}

impl Wired {
    /// A drive with factory parameters and a resting 24 V motor, in Standby.
    pub(crate) fn resting() -> Self {
        Self::new(PlantConfig::new(MotorConfig::default(), 24.0), Parameters::new())
    }

    /// A drive with a motor that turns at 1500 rpm under hall control.
    pub(crate) fn turning() -> Self {
        let preset = preset("ec45-flat-50w-18v").unwrap();
        let plate = Nameplate {
            motor: preset.motor.figures(),
            rated_current: preset.data.rated_current,
            supply: 18.0,
            open_loop_speed: None,
        };
        let parameters = plate.commission(Mode::Hall).unwrap().parameters;
        let mut wired = Self::new(PlantConfig::new(preset.motor, 18.0), parameters);
        wired.send(ToDrive::MotorCommand { speed: 1500 });
        wired.asks = Some(MotorMode::Drive);
        wired.run(1.0);
        assert!((wired.speed() - 1500.0).abs() < 20.0, "{}", wired.speed());
        wired
    }

    fn new(plant: PlantConfig, parameters: Parameters) -> Self {
        let config = BenchConfig { plant, parameters, label: String::new(), trace: false };
        let bench = Bench::new(&config).without_recording();
        let mut wired = Self { bench, asks: Some(MotorMode::Standby), received: Vec::new() };
        wired.run(0.7);
        wired
    }

    pub(crate) fn step(&mut self) {
        if let Some(mode) = self.asks
            && self.bench.plant().tick().is_multiple_of(ALIVE)
        {
            // While the bus is lost the queue may be full; an older request in it is equal.
            let _ = self.bench.send(ToDrive::RequestWord(RequestWord { mode }).encode(Addresses::FACTORY));
        }
        self.bench.step();
        while let Some(received) = self.bench.monitor() {
            self.received.push((received.time_ns, received.frame));
        }
        while self.bench.receive().is_some() {}
    }

    pub(crate) fn run(&mut self, seconds: f64) {
        (0..(seconds * 10_000.0).round() as u64).for_each(|_| self.step());
    }

    pub(crate) fn send(&mut self, message: ToDrive) {
        self.bench.send(message.encode(Addresses::FACTORY)).unwrap();
    }

    /// Messages that have arrived since the last call.
    pub(crate) fn take_messages(&mut self) -> Vec<FromDrive> {
        let frames = std::mem::take(&mut self.received);
        frames
            .iter()
            .filter_map(|(_, frame)| FromDrive::decode(frame).ok())
            .map(|(_, message)| message)
            .collect()
    }

    pub(crate) fn write(&mut self, number: u16, value: i32) {
        self.send(ToDrive::SetParameter { number, value });
        assert_eq!(self.answer(number), (value, ParameterStatus::Done), "parameter {number}");
    }

    pub(crate) fn read(&mut self, number: u16) -> i32 {
        self.send(ToDrive::RequestParameter { number });
        self.answer(number).0
    }

    fn answer(&mut self, wanted: u16) -> (i32, ParameterStatus) {
        self.received.clear();
        for _ in 0..200 {
            self.step();
            for message in self.take_messages() {
                if let FromDrive::Parameter { number, value, status } = message
                    && number == wanted
                {
                    return (value, status);
                }
            }
        }
        panic!("no answer for parameter {wanted}");
    }

    /// Value of a broadcast signal in its unit, two readings and a broadcast from now.
    pub(crate) fn signal(&mut self, name: &str) -> f64 {
        self.received.clear();
        self.run(0.075);
        let signal = SIGNALS.iter().find(|signal| signal.name == name).unwrap();
        let words = self.received.iter().rev().find_map(|(_, frame)| {
            let (id, words) = Words::of(frame).ok()?;
            (id.opcode == signal.opcode).then_some(words)
        });
        let value = signal.value(words.expect("it is broadcast"));
        value.digits as f64 * 10_f64.powi(value.exponent.into())
    }

    pub(crate) fn put(&mut self, input: Input, value: f64) {
        self.bench.plant_mut().set_input(input, value).unwrap();
    }

    /// Value of a parameter in the drive, read without the bus.
    pub(crate) fn look(&self, number: u16) -> i32 {
        self.bench.node().read_parameter(number).unwrap()
    }

    /// True mechanical speed, rpm.
    pub(crate) fn speed(&self) -> f64 {
        self.bench.plant().observe().speed * 60.0 / std::f64::consts::TAU
    }
}
