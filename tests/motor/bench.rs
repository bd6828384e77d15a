//! Drive and plant in a loop, with a master that repeats its command and a background that measures slowly.

use narx_core::commissioning::{Mode, Nameplate};
use narx_core::motor::machine::event::SlowMeasurements;
use narx_core::motor::{Coefficients, Command, Drive, Event, PwmCommand, RunRequest, Samples, State, Status};
use narx_core::units::{Celsius, ElectricalSpeed, Volts};
use narx_sim::plant::{BackEmf, MotorConfig, Phase, Plant, PlantConfig};

/// Commanded speed, mechanical rpm.
pub(crate) const RPM: f64 = 2000.0;

/// The plant's plain 24 V motor with a little friction.
pub(crate) const MOTOR: MotorConfig = MotorConfig {
    pole_pairs: 4,
    resistance: 0.36,
    inductance: 2e-4,
    torque_constant: 0.036,
    inertia: 4.8e-6,
    static_friction: 0.002,
    viscous_friction: 0.0,
    back_emf: BackEmf::Trapezoidal { flat_top_deg: 120.0 },
    cogging_torque: 0.0,
    cogging_periods: 24,
    copper_drift: 0.003_93,
    magnet_drift: -0.001,
    thermal_resistance: 0.0,
    thermal_time: 60.0,
    phase_order: [Phase::A, Phase::B, Phase::C],
};

/// End of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// In state 6 after these many ticks, with this extended code.
    Fault { ticks: u64, code: u16 },
    /// No fault.
    Running,
}

#[derive(Clone)]
pub(crate) struct Closed {
    pub drive: Drive,
    pub plant: Plant,
    pub status: Status,
    /// Largest phase current seen at a period's end, A.
    pub peak: f64,
    /// Largest |speed|, rpm.
    pub fastest: f64,
    pub bus_max: f64,
    /// The master sends nothing.
    pub silent: bool,
    /// Second drive for comparison; see [`watch`](Self::watch).
    watched: Option<Drive>,
    /// Set-point, mechanical rpm.
    pub set_point: f64,
    /// Command of the last tick.
    pub output: PwmCommand,
    request: RunRequest,
    mode: Mode,
    rated_current: Option<f64>,
}

impl Closed {
    /// A commissioned hall drive; raw parameters in `changes` replace the commissioned ones.
    pub(crate) fn new(config: &PlantConfig, changes: &[(u16, i32)]) -> Self {
        Self::with_mode(config, changes, Mode::Hall)
    }

    /// A commissioned drive without sensors, with `changes` as in [`new`](Self::new).
    pub(crate) fn sensorless(config: &PlantConfig, changes: &[(u16, i32)]) -> Self {
        Self::with_mode(config, changes, Mode::Sensorless)
    }

    fn with_mode(config: &PlantConfig, changes: &[(u16, i32)], mode: Mode) -> Self {
        Self::rated(config, changes, mode, Some(4.0))
    }

    /// A drive commissioned with the motor's rated current.
    pub(crate) fn rated(
        config: &PlantConfig,
        changes: &[(u16, i32)],
        mode: Mode,
        rated_current: Option<f64>,
    ) -> Self {
        let coefficients = commissioned(config, changes, mode, rated_current);
        Self {
            drive: Drive::new(coefficients),
            plant: Plant::new(config),
            status: Status::default(),
            peak: 0.0,
            fastest: 0.0,
            bus_max: 0.0,
            silent: false,
            watched: None,
            set_point: RPM,
            output: PwmCommand::default(),
            request: RunRequest::Standby,
            mode,
            rated_current,
        }
    }

    /// Sets other parameters from now on: the commissioned ones with these raw values changed.
    pub(crate) fn configure(&mut self, changes: &[(u16, i32)]) {
        let coefficients = commissioned(self.plant.config(), changes, self.mode, self.rated_current);
        self.handle_event(Event::Coefficients(coefficients));
    }

    pub(crate) fn ask(&mut self, request: RunRequest) {
        self.request = request;
        self.handle_event(self.command());
    }

    fn command(&self) -> Event {
        let speed = self.set_point / 60.0 * f64::from(self.plant.config().motor.pole_pairs);
        Event::Command(Command {
            request: self.request,
            speed: ElectricalSpeed::from_bits((speed * 65_536.0) as i32),
        })
    }

    /// Runs one period.
    pub(crate) fn tick(&mut self) {
        self.tick_altered(|_, _| {});
    }

    /// Runs one period in which `alter` changes the samples that the drive reads; it also gets the command
    /// that was applied last.
    pub(crate) fn tick_altered(&mut self, alter: impl FnOnce(&mut Samples, &PwmCommand)) {
        let mut samples = self.plant.sample();
        alter(&mut samples, &self.output);
        match samples.tick % 500 {
            0 if !self.silent => self.handle_event(self.command()),
            k if k % 100 == 50 => self.handle_event(Event::Slow(SlowMeasurements {
                temperature: Celsius::from_milli((self.plant.ambient() * 1e3) as i32),
                pressure: Volts::from_milli((self.plant.pressure() * 1e3) as i32),
            })),
            _ => {}
        }
        let watched = self.watched.as_mut().map(|drive| {
            drive.wake();
            (drive.step(&samples), drive.poll_status())
        });
        let output = self.drive.step(&samples);
        let status = self.drive.poll_status();
        if let Some(expected) = watched {
            assert_eq!(expected, (output, status), "tick {}", samples.tick);
        }
        if let Some(status) = status {
            self.status = status;
        }
        self.plant.finish_period(&output);
        self.output = output;
        let now = self.plant.observe();
        self.peak = now.current.iter().fold(self.peak, |peak, current| peak.max(current.abs()));
        self.fastest = self.fastest.max(self.rpm().abs());
        self.bus_max = self.bus_max.max(now.bus_voltage);
    }

    fn handle_event(&mut self, event: Event) {
        if let Some(drive) = &mut self.watched {
            drive.handle_event(event.clone());
        }
        self.drive.handle_event(event);
    }

    /// Compares every tick from now on with a second drive that runs every station in every tick: both must
    /// answer alike.
    pub(crate) fn watch(&mut self) {
        self.watched = Some(self.drive.clone());
    }

    /// Boots into Standby.
    pub(crate) fn boot(&mut self) {
        for _ in 0..5_100 {
            self.tick();
        }
        assert_eq!(self.drive.state(), State::Standby);
    }

    /// Runs up to `ticks` periods, or to a fault.
    pub(crate) fn run(&mut self, ticks: u64) -> Outcome {
        for tick in 1..=ticks {
            self.tick();
            if self.drive.state() == State::Fault {
                return Outcome::Fault { ticks: tick, code: self.status.extended_code };
            }
        }
        Outcome::Running
    }

    /// True mean mechanical speed over the next `ticks`; `see` gets the drive in each.
    pub(crate) fn mean_rpm(&mut self, ticks: u64, mut see: impl FnMut(&Drive)) -> f64 {
        let from = self.plant.observe();
        for _ in 0..ticks {
            self.tick();
            see(&self.drive);
        }
        let to = self.plant.observe();
        (to.angle - from.angle) / (to.time - from.time) * 60.0 / std::f64::consts::TAU
    }

    /// True mechanical speed, rpm.
    pub(crate) fn rpm(&self) -> f64 {
        self.plant.observe().speed * 60.0 / std::f64::consts::TAU
    }
}

fn commissioned(
    config: &PlantConfig,
    changes: &[(u16, i32)],
    mode: Mode,
    rated_current: Option<f64>,
) -> Coefficients {
    let plate = Nameplate {
        motor: config.motor.figures(),
        rated_current,
        supply: config.supply.voltage,
        open_loop_speed: None,
    };
    let mut parameters = plate.commission(mode).unwrap().parameters;
    for (number, raw) in changes {
        parameters.set(*number, *raw).unwrap();
    }
    Coefficients::build(&parameters, &config.board).unwrap()
}
