//! Tests of the bench: a drive with its flash on a CAN bus, in real time.

use narx_core::bus::narmotion::{FromDrive, MotorMode, ParameterStatus, RequestWord, ToDrive};
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::State;
use narx_core::storage::{Record, record};
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::PlantConfig;
use narx_sim::presets::preset;

pub(crate) fn config(parameters: Option<Parameters>) -> BenchConfig {
    let preset = preset("bly172s-24v").unwrap();
    let supply = preset.data.nominal_voltage;
    let plate = Nameplate {
        motor: preset.motor.figures(),
        rated_current: preset.data.rated_current,
        supply,
        open_loop_speed: None,
    };
    let parameters = parameters.unwrap_or_else(|| plate.commission(Mode::Hall).unwrap().parameters);
    let plant = PlantConfig::new(preset.motor, supply);
    BenchConfig { plant, parameters, label: String::new(), trace: false }
}

struct Host {
    bench: Bench,
    /// Messages that have arrived, with their times in ns.
    received: Vec<(u64, FromDrive)>,
}

impl Host {
    fn new(bench: Bench) -> Self {
        let mut host = Self { bench: bench.without_recording(), received: Vec::new() };
        host.run(520);
        host
    }

    fn run(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds * 10 {
            self.bench.step();
            let now = self.bench.now_ns();
            while let Some(received) = self.bench.receive() {
                self.received.push((now, FromDrive::decode(&received.frame).unwrap().1));
            }
        }
    }

    fn send(&mut self, message: ToDrive) {
        let addresses = self.bench.node().addresses();
        self.bench.send(message.encode(addresses)).unwrap();
    }

    /// Writes a parameter; returns the answer and the time it took, ns.
    fn write(&mut self, number: u16, value: i32) -> (ParameterStatus, u64) {
        self.received.clear();
        let start = self.bench.now_ns();
        self.send(ToDrive::SetParameter { number, value });
        for _ in 0..2000 {
            self.run(1);
            for (time, message) in &self.received {
                if let FromDrive::Parameter { number: asked, status, .. } = message
                    && *asked == number
                {
                    return (*status, time - start);
                }
            }
        }
        panic!("no answer to parameter {number}");
    }

    fn command(&mut self, number: u16) -> (ParameterStatus, u64) {
        self.write(number, 0);
        self.write(number, 1)
    }
}

#[test]
fn a_drive_keeps_what_it_stored_and_its_flash_can_change_drives() {
    let mut host = Host::new(Bench::new(&config(None)));
    assert_eq!(host.write(number::SPEED_RATE, 1234).0, ParameterStatus::Done);
    let (status, time) = host.command(number::STORE);
    assert_eq!(status, ParameterStatus::Done);
    // About eight pages of 120 us each, and reading back.
    assert!((1_000_000..50_000_000).contains(&time), "{time} ns");
    // This one is stored automatically, before the drive restarts.
    assert_eq!(host.write(number::SPEED_RATE, 99).0, ParameterStatus::Done);
    host.send(ToDrive::Reboot);
    host.run(600);
    assert_eq!(host.bench.node().parameters().value(number::SPEED_RATE).unwrap(), 99);
    let flash = host.bench.into_flash();
    let other = Host::new(Bench::with_flash(&config(Some(Parameters::new())), flash));
    assert_eq!(other.bench.node().parameters().value(number::SPEED_RATE).unwrap(), 99);
    assert_eq!(other.bench.node().parameters().value(number::HALL_ENABLE).unwrap(), 1);
}

#[test]
fn what_is_written_while_the_motor_turns_lasts() {
    let mut host = Host::new(Bench::new(&config(None)));
    for turn in 0..25 {
        host.send(ToDrive::RequestWord(RequestWord { mode: MotorMode::Drive }));
        host.send(ToDrive::MotorCommand { speed: 2000 });
        if turn == 4 {
            assert_eq!(host.write(number::SPEED_RATE, 1234).0, ParameterStatus::Done);
        }
        host.run(100);
        assert!(turn == 0 || host.bench.status().state == State::HallClosedLoop);
    }
    // The power is cut during the store.
    let other = Host::new(Bench::with_flash(&config(None), host.bench.into_flash()));
    assert_eq!(other.bench.node().parameters().value(number::SPEED_RATE).unwrap(), 1234);
}

#[test]
fn without_its_flash_a_drive_does_not_run() {
    let mut flash = Bench::new(&config(None)).into_flash();
    flash.set_absent(true);
    let host = Host::new(Bench::with_flash(&config(None), flash));
    assert_eq!(host.bench.status().state, State::Fault);
}

/// While a motor runs, the log writes and a download takes the rest of the bus, status words keep their
/// period.
#[test]
fn a_download_under_way_moves_no_status_word() {
    let mut host = Host::new(Bench::new(&config(None)));
    for (number, value) in [
        (number::LOG_PERIOD, 2),
        (29, 0x2000 + 202 * 4),
        (30, 0x2000 + 205 * 4),
        (31, 0x3_2000 + 202 * 4 + 1),
    ] {
        assert_eq!(host.write(number, value).0, ParameterStatus::Done);
    }
    host.send(ToDrive::RequestWord(RequestWord { mode: MotorMode::Standby }));
    host.run(5);
    for turn in 0..10 {
        host.send(ToDrive::RequestWord(RequestWord { mode: MotorMode::Drive }));
        host.send(ToDrive::MotorCommand { speed: 2000 });
        host.run(100);
        assert!(turn == 0 || host.bench.status().state == State::HallClosedLoop);
    }
    assert_eq!(host.write(number::LOG_READ_START, 10).0, ParameterStatus::Done);
    assert_eq!(host.write(number::LOG_READ_COUNT, 300).0, ParameterStatus::Done);
    host.write(number::LOG_READ_REQUEST, 0);
    host.received.clear();
    host.send(ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 1 });
    for _ in 0..10 {
        host.send(ToDrive::RequestWord(RequestWord { mode: MotorMode::Drive }));
        host.run(100);
    }
    let status: Vec<u64> = host
        .received
        .iter()
        .filter(|(_, message)| matches!(message, FromDrive::Status(_)))
        .map(|(time, _)| *time)
        .collect();
    assert!(status.len() > 15);
    for pair in status.windows(2) {
        let period = pair[1] - pair[0];
        assert!(period.abs_diff(50_000_000) < 1_000_000, "{period} ns");
    }
    let data: Vec<(u64, u16, [u16; 3])> = host
        .received
        .iter()
        .filter_map(|(time, message)| match message {
            FromDrive::LogData { counter, data } => Some((*time, *counter, *data)),
            _ => None,
        })
        .collect();
    assert_eq!(data.len(), 300 * 6);
    let bytes: Vec<u8> =
        data.iter().flat_map(|(_, _, words)| words).flat_map(|word| word.to_be_bytes()).collect();
    let mut fastest = 0;
    for (place, bytes) in bytes.chunks(Record::size(3)).enumerate() {
        let record = Record::parse(bytes).expect("a record that is whole");
        assert_eq!(record.index(), 10 + place as u32);
        fastest = fastest.max(record.entry().values[1].1);
    }
    assert!(fastest > 1500, "the motor turned: {fastest} rpm");
    let seconds = (data.last().unwrap().0 - data[0].0) as f64 * 1e-9;
    println!("download: {:.0} frames a second", data.len() as f64 / seconds);
    assert!(data.len() as f64 / seconds > 2000.0, "{seconds} s");
    assert_eq!(record::PAGE, 256);
}
