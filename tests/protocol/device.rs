//! Tests of node and control tick together, with healthy samples of a motor at rest: the whole device as the
//! master sees it.

use crate::bench::IDENTITY;
use narx_core::bus::narmotion::{
    Addresses, ControlMode, FromDrive, MotorMode, ParameterStatus, RequestWord, StatusWord, ToDrive,
};
use narx_core::dictionary::number;
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_core::motor::sense::front_end::Board;
use narx_core::motor::sense::samples::Samples;
use narx_core::motor::{Coefficients, Drive, Step};
use narx_core::node::Node;

struct Device {
    node: Node,
    drive: Drive,
    now: u64,
    /// Messages that the master has received, with the tick of their arrival.
    received: Vec<(u64, FromDrive)>,
    driven: bool,
}

impl Device {
    fn new() -> Self {
        let node = Node::new(IDENTITY, Board::BENCH);
        let drive = Drive::new(Coefficients::build(node.parameters(), &Board::BENCH).unwrap());
        Self { node, drive, now: 0, received: Vec::new(), driven: false }
    }

    /// Runs the device as a firmware does: one event per tick, reports back, frames out.
    fn run(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds * 10 {
            if let Some(event) = self.node.poll_event() {
                self.drive.handle_event(event);
            }
            // 48 V, no current, sector 0's hall code.
            let bus_voltage = 2458;
            let samples = Samples {
                tick: self.now,
                bus_voltage,
                bus_current: 2048,
                phase_voltage: [bus_voltage / 2; 3],
                hall: 0b001,
                ..Samples::default()
            };
            self.driven = self.drive.step(&samples).step != Step::Coast;
            if let Some(status) = self.drive.poll_status() {
                self.node.handle_status(status);
            }
            self.node.poll(self.now);
            while let Some(frame) = self.node.poll_frame() {
                self.received.push((self.now, FromDrive::decode(&frame).unwrap().1));
            }
            self.now += 1;
        }
    }

    fn send(&mut self, message: ToDrive) {
        self.node.handle_frame(&message.encode(Addresses::FACTORY));
    }

    fn request(&mut self, mode: MotorMode) {
        self.send(ToDrive::RequestWord(RequestWord { mode }));
    }

    fn set(&mut self, number: u16, value: i32) {
        assert_eq!(self.node.write_parameter(number, value), ParameterStatus::Done, "parameter {number}");
    }

    fn last_status(&self) -> (MotorMode, ControlMode) {
        let words = self.received.iter().rev().find_map(|(_, message)| match message {
            FromDrive::Status(StatusWord { mode, control, .. }) => Some((*mode, *control)),
            _ => None,
        });
        words.expect("a status word")
    }
}

#[test]
fn a_master_that_sends_drive_once_gets_its_motor_and_then_the_time_out_fault() {
    let mut device = Device::new();
    device.run(600);
    assert_eq!(device.last_status(), (MotorMode::Standby, ControlMode::Off));
    device.set(number::HALL_ENABLE, 1);
    device.set(number::HALL_STALL_TIME, 10_000);
    device.run(10);
    let start = device.now;
    device.request(MotorMode::Drive);
    device.send(ToDrive::MotorCommand { speed: 1000 });
    device.run(100);
    assert_eq!(device.last_status(), (MotorMode::Drive, ControlMode::Hall));
    assert_eq!(device.node.read_parameter(number::DRIVE_STATE), Some(5));
    assert!(device.driven);
    assert!(device.received.iter().any(|(_, message)| *message == FromDrive::MotorCommand { speed: 1000 }));

    device.run(200);
    assert!(!device.driven);
    assert_eq!(device.last_status(), (MotorMode::Fault, ControlMode::Off));
    let code = Cause::CommandTimeout as u16;
    let announced = FromDrive::CriticalFault { faults: FaultWord::DEVICE_TIMEOUT, code };
    let at = device.received.iter().find(|(_, message)| *message == announced).expect("CRITICAL_FAULT").0;
    // 250 ms, including the tick that took the command.
    assert_eq!(at - start, 2499);

    // With a silent master status and fault words go on, measurements do not.
    device.received.clear();
    device.run(200);
    let opcodes: Vec<u16> = device.received.iter().map(|(_, message)| message.opcode().raw()).collect();
    assert_eq!(opcodes, [3, 4].repeat(4));

    // The wait has passed; a Standby request acknowledges, while a Drive request before it had no effect.
    device.run(200);
    device.request(MotorMode::Drive);
    device.run(60);
    assert_eq!(device.last_status().0, MotorMode::Fault);
    device.request(MotorMode::Standby);
    device.run(60);
    assert_eq!(device.last_status(), (MotorMode::Standby, ControlMode::Off));
}

#[test]
fn a_commanded_shutdown_and_a_set_that_does_not_build() {
    let mut device = Device::new();
    device.run(600);
    device.request(MotorMode::Standby);
    device.set(number::HALL_ENABLE, 1);
    device.set(number::SPEED_MIN_HES, 5000);
    device.run(10);
    device.request(MotorMode::Drive);
    device.run(60);
    assert_eq!(device.last_status(), (MotorMode::Standby, ControlMode::Off), "the start is refused");
    assert_eq!(device.node.read_parameter(number::START_REFUSAL), Some(2));
    assert_eq!(device.node.read_parameter(number::REJECTED_PARAMETER), Some(number::SPEED_MIN_HES.into()));

    device.request(MotorMode::Fault);
    device.run(60);
    assert_eq!(device.last_status(), (MotorMode::Fault, ControlMode::Off));
    let code = Cause::ShutdownCommanded as u16;
    let announced = FromDrive::CriticalFault { faults: FaultWord::EXTERNAL_SHUTDOWN, code };
    assert!(device.received.iter().any(|(_, message)| *message == announced));
    assert_eq!(device.node.read_parameter(number::EXTENDED_FAULT_CODE), Some(code.into()));
}

#[test]
fn an_uncommissioned_drive_does_not_turn() {
    let mut device = Device::new();
    device.run(600);
    device.request(MotorMode::Drive);
    device.send(ToDrive::MotorCommand { speed: 1000 });
    device.run(60);
    assert_eq!(device.last_status(), (MotorMode::Standby, ControlMode::Off));
    assert_eq!(device.node.read_parameter(number::START_REFUSAL), Some(1));
    assert!(!device.driven);
}

/// A master repeats Drive. A refused request is used up: enabling a mode, correcting the set or arming a
/// calibration afterwards does not start the motor; Standby and then Drive does.
#[test]
fn a_refused_start_needs_a_fresh_request() {
    let repeat = |device: &mut Device| {
        for _ in 0..5 {
            device.request(MotorMode::Drive);
            device.run(50);
            assert!(!device.driven);
        }
        assert_eq!(device.last_status(), (MotorMode::Standby, ControlMode::Off));
    };
    let mut device = Device::new();
    device.run(600);
    device.request(MotorMode::Standby);
    device.run(10);
    repeat(&mut device);
    device.set(number::HALL_ENABLE, 1);
    repeat(&mut device);
    device.set(number::HALL_CALIBRATE, 0);
    device.set(number::HALL_CALIBRATE, 1);
    repeat(&mut device);
    assert_eq!(device.node.read_parameter(number::START_REFUSAL), Some(1), "why it was refused stays");
    device.set(number::HALL_CALIBRATE, 0);

    device.request(MotorMode::Standby);
    device.run(10);
    assert_eq!(device.node.read_parameter(number::START_REFUSAL), Some(0));
    device.set(number::SPEED_MIN_HES, 5000);
    device.run(10);
    repeat(&mut device);
    device.set(number::SPEED_MIN_HES, 500);
    repeat(&mut device);
    assert_eq!(device.node.read_parameter(number::START_REFUSAL), Some(2));

    device.request(MotorMode::Standby);
    device.run(10);
    device.request(MotorMode::Reverse);
    device.run(10);
    assert_eq!(device.node.read_parameter(number::DRIVE_STATE), Some(5));
    assert_eq!(device.node.read_parameter(number::START_REFUSAL), Some(0));
}
