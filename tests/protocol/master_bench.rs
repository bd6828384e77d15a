//! Tests of the master at its place on the simulated bus: a whole drive with its motor, from power-up on.

use narx_core::bus::narmotion::{ControlMode, MotorMode};
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::dictionary::{PARAMETER_COUNT, Parameters, number};
use narx_core::master::{Answer, Config, Download, DownloadError, Master, Request, RequestError, Service};
use narx_core::motor::State;
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::can::Attachment;
use narx_sim::plant::{Injection, Phase, PlantConfig};
use narx_sim::presets::preset;

/// A commissioned drive and its master on one bus.
pub(crate) struct Rig {
    pub(crate) bench: Bench,
    pub(crate) master: Master,
    /// True while the master's frames reach the drive.
    pub(crate) alive: bool,
}

impl Rig {
    pub(crate) fn new(mode: Mode, config: Config) -> Self {
        let preset = preset("ec45-flat-50w-18v").unwrap();
        let plate = Nameplate {
            motor: preset.motor.figures(),
            rated_current: preset.data.rated_current,
            supply: 18.0,
            open_loop_speed: None,
        };
        Self::of(PlantConfig::new(preset.motor, 18.0), plate.commission(mode).unwrap().parameters, config)
    }

    pub(crate) fn of(plant: PlantConfig, parameters: Parameters, config: Config) -> Self {
        let bench = Bench::new(&BenchConfig { plant, parameters, label: String::new(), trace: false });
        Self { bench: bench.without_recording(), master: Master::new(config), alive: true }
    }

    pub(crate) fn step(&mut self) {
        let now = self.bench.now_ns() / 1000;
        while self.alive
            && let Some(frame) = self.master.poll_frame(now)
        {
            self.bench.send(frame).unwrap();
        }
        self.bench.step();
        while let Some(received) = self.bench.receive() {
            self.master.handle_frame(&received.frame, received.time_ns / 1000);
        }
        while self.bench.monitor().is_some() {}
    }

    pub(crate) fn run(&mut self, seconds: f64) {
        (0..(seconds * 10_000.0) as u64).for_each(|_| self.step());
    }

    /// Waits until the master sees a state; returns the time, s.
    pub(crate) fn until(&mut self, state: State) -> f64 {
        let begin = self.bench.time();
        for _ in 0..50_000 {
            if self.master.state() == Some(state) {
                return self.bench.time() - begin;
            }
            self.step();
        }
        panic!("{state:?} is not reached but {:?}", self.master.state());
    }

    pub(crate) fn ask(&mut self, request: Request) -> Answer {
        self.master.request(request).unwrap();
        for _ in 0..50_000 {
            if let Some(answer) = self.master.poll_answer() {
                return answer;
            }
            self.step();
        }
        panic!("every request is answered in time");
    }

    fn now(&self) -> u64 {
        self.bench.now_ns() / 1000
    }

    /// Value of a measured signal, in its unit.
    fn signal(&self, name: &str) -> f64 {
        let value = self.master.measurements().find(name).unwrap().value;
        value.digits as f64 * 10_f64.powi(value.exponent.into())
    }

    pub(crate) fn speed(&self) -> f64 {
        self.bench.plant().observe().speed * 60.0 / std::f64::consts::TAU
    }
}

#[test]
fn a_motor_is_operated_from_power_up_to_the_end() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Initialization);
    rig.until(State::Standby);
    assert_eq!(rig.master.parameters().known(), PARAMETER_COUNT, "read during boot");

    rig.master.start(-2000);
    assert!(rig.until(State::HallClosedLoop) < 0.06, "the next status word tells");
    rig.run(2.0);
    let status = rig.master.report().status.unwrap();
    assert_eq!((status.value.mode, status.value.control), (MotorMode::Reverse, ControlMode::Hall));
    assert!((rig.speed() + 2000.0).abs() < 20.0);
    let speed = rig.master.speed().unwrap();
    assert!((f64::from(speed.value) - rig.speed()).abs() < 40.0, "{speed:?}");
    assert!(speed.age(rig.now()) <= 60_000);
    assert!((rig.signal("HV Voltage") - rig.bench.plant().observe().bus_voltage).abs() < 0.2);
    assert!((rig.signal("Ambient Temperature") - 25.0).abs() < 1.0);

    rig.master.set_speed(60_000);
    rig.run(0.1);
    let accepted = rig.master.report().accepted_speed.unwrap().value;
    assert_eq!(
        Some(i32::from(accepted)),
        rig.master.parameters().get(number::SPEED_MAX_HES).map(|received| received.value)
    );
    rig.master.stop();
    rig.until(State::Standby);
    assert_eq!(rig.bench.status().state, State::Standby);
    assert_eq!(rig.ask(Request::Read { number: number::REFUSED_FRAMES }).result, Ok(0));
    assert_eq!(rig.ask(Request::Read { number: number::MALFORMED_FRAMES }).result, Ok(0));
}

#[test]
fn a_sensorless_start_shows_every_state() {
    let mut rig = Rig::new(Mode::Sensorless, Config::default());
    rig.until(State::Standby);
    rig.master.start(1500);
    let mut seen = Vec::new();
    for _ in 0..20_000 {
        rig.step();
        seen.extend(rig.master.state());
    }
    seen.dedup();
    assert_eq!(seen, [State::Standby, State::RotorLock, State::OpenLoop, State::SensorlessClosedLoop]);
    assert!((f64::from(rig.master.speed().unwrap().value) - 1500.0).abs() < 30.0);
}

#[test]
fn a_fault_is_told_and_acknowledged_by_stop_alone() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    rig.master.start(1500);
    rig.run(1.0);
    rig.bench.plant_mut().inject(Injection::Driver(Phase::A));
    let took = rig.until(State::Fault);
    assert!(took < 0.06, "{took} s");
    let report = *rig.master.report();
    assert!(report.faults.unwrap().value.contains(FaultWord::LEGS_DRIVER));
    let critical = report.critical.unwrap().value;
    assert_eq!(critical.cause().map(|row| row.cause), Some(Cause::DriverLine));
    rig.bench.plant_mut().clear(Injection::Driver(Phase::A));
    rig.run(1.5);
    assert_eq!(rig.master.state(), Some(State::Fault), "the master still asks for Drive");
    rig.master.stop();
    rig.until(State::Standby);
    rig.run(0.1);
    assert_eq!(rig.master.report().faults.unwrap().value, FaultWord::empty());
    rig.master.start(1500);
    rig.until(State::HallClosedLoop);
}

#[test]
fn a_master_that_comes_after_a_fault_still_sees_it() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    rig.master.start(1500);
    rig.run(1.0);
    rig.alive = false;
    rig.run(0.5);
    assert_eq!(rig.bench.status().state, State::Fault, "nobody feeds the drive");
    rig.master = Master::new(Config::default());
    rig.alive = true;
    rig.run(2.0);
    assert_eq!(rig.master.state(), Some(State::Fault));
    assert!(rig.master.report().faults.unwrap().value.contains(FaultWord::DEVICE_TIMEOUT));
    assert!(
        rig.master.measurements().find("HV Voltage").unwrap().age(rig.now()) < 100_000,
        "and is told the rest"
    );
    rig.master.stop();
    rig.until(State::Standby);
}

#[test]
fn services_of_the_drive() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    rig.run(0.5);
    let offset =
        |rig: &Rig| rig.master.parameters().get(number::HV_VOLTAGE_OFFSET).map(|received| received.value);
    assert_eq!(rig.ask(Request::Run(Service::AutoCalibrate)).result, Ok(1));
    rig.run(0.5);
    let calibrated = offset(&rig).unwrap();
    assert_ne!(calibrated, 0, "noise and divider have an error");
    assert_eq!(rig.bench.node().parameters().value(number::HV_VOLTAGE_OFFSET).unwrap(), calibrated);
    assert_eq!(rig.ask(Request::Run(Service::ResetCalibration)).result, Ok(1));
    rig.run(0.5);
    assert_eq!(offset(&rig), Some(0));
    let rate = Request::Write { number: number::SPEED_RATE, raw: 777 };
    assert_eq!(rig.ask(rate).result, Ok(777));
    assert_eq!(rig.ask(Request::Run(Service::Store)).result, Ok(1));
    let refused = rig.ask(Request::Run(Service::Store)).result.unwrap_err();
    assert!(matches!(refused, RequestError::Refused(_)), "once a second at most");
    assert_eq!(rig.ask(Request::Reboot).result, Ok(0));
    rig.until(State::Initialization);
    rig.until(State::Standby);
    assert_eq!(rig.ask(Request::Read { number: number::SPEED_RATE }).result, Ok(777), "it was stored");

    // The scope has no record yet.
    rig.master.download(Download::Scope { words: 3 }).unwrap();
    rig.run(2.0);
    assert_eq!(rig.master.poll_download(), Some(Err(DownloadError::NoAnswer)));
    assert_eq!(rig.bench.node().read_parameter(number::REFUSED_FRAMES), Some(3), "asked three times");
}

#[test]
fn a_broken_line_is_noticed_at_both_ends() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    rig.master.start(1500);
    rig.run(1.0);
    assert!(rig.master.is_connected(rig.now()));
    rig.bench.set_host(Attachment::Detached);
    rig.run(0.6);
    assert!(!rig.master.is_connected(rig.now()));
    assert!(rig.master.measurements().find("HV Voltage").unwrap().age(rig.now()) > 500_000);
    assert_eq!(rig.bench.status().state, State::Fault);
    rig.bench.set_host(Attachment::Normal);
    rig.run(1.0);
    assert!(rig.master.is_connected(rig.now()));
    assert_eq!(rig.master.state(), Some(State::Fault));
    assert!(rig.master.report().faults.unwrap().value.contains(FaultWord::DEVICE_TIMEOUT));
}

/// Reading all parameters takes neither long nor the whole bus: requests and answers take a third of it,
/// beside the broadcasts.
#[test]
fn reading_everything_leaves_the_bus_to_the_commands() {
    let mut rig = Rig::new(Mode::Hall, Config::default());
    rig.until(State::Standby);
    rig.master.start(1500);
    rig.run(1.0);
    let before = rig.bench.bus_statistics();
    let begin = rig.now();
    rig.master.read_parameters();
    while rig.master.parameters_to_read() > 0 {
        rig.step();
        assert!(rig.now() - begin < 400_000);
    }
    let load = rig.bench.bus_statistics().load_since(&before, (rig.now() - begin) * 1000);
    assert!(load < 0.45, "{load}");
    assert_eq!(rig.bench.status().state, State::HallClosedLoop);
    assert_eq!(rig.ask(Request::Read { number: number::FRAMES_LOST }).result, Ok(0));
}
