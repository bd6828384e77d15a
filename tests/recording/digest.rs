//! Tests of the digest, written again from its description alone.

use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::machine::event::{HallCalibration, HallWiring, Limiter, Refusal, Status, Why};
use narx_core::motor::machine::state::State;
use narx_core::motor::{Commutation, Direction, PwmCommand, Rectification, SampleMode, Step};
use narx_core::recording::Digest;
use narx_core::units::{Amps, Duty, ElectricalAngle, ElectricalSpeed, Volts, Watts};

/// CRC-64/XZ, one bit at a time.
fn crc64(bytes: &[u8]) -> u64 {
    let mut crc = !0u64;
    for byte in bytes {
        crc ^= u64::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xc96c_5795_d787_0f42 } else { crc >> 1 };
        }
    }
    !crc
}

fn digest(command: &PwmCommand, status: Option<&Status>) -> u64 {
    let mut digest = Digest::default();
    digest.update(command, status);
    digest.value()
}

#[test]
fn check_value_of_the_catalogue() {
    assert_eq!(crc64(b"123456789"), 0x995d_c9bb_df19_39fa);
    assert_eq!(Digest::default().value(), crc64(b""));
}

#[test]
fn command_and_status_by_hand() {
    let mut command = PwmCommand {
        duty: Duty::from_bits(0x1234),
        rectification: Rectification::Synchronous,
        sample_at: 0x8000,
        sample_mode: SampleMode::OnTime,
        step: Step::BA,
        ..PwmCommand::default()
    };
    let mut bytes = vec![b'P', 0x34, 0x12, 1, 0x00, 0x80, 1, 4, 0];
    assert_eq!(digest(&command, None), crc64(&bytes));

    command.commutations.push(Commutation { instant: 0xabcd, step: Step::CA });
    bytes[8] = 1;
    bytes.extend([0xcd, 0xab, 5]);
    assert_eq!(digest(&command, None), crc64(&bytes));

    let status = Status {
        tick: 0x0102_0304_0506_0708,
        state: State::HallClosedLoop,
        faults: FaultWord::OVER_CURRENT,
        critical: FaultWord::STORE_VERSION,
        extended_code: 0x1122,
        command_expired: true,
        refusal: Refusal::Parameters,
        supply_low: true,
        direction: Direction::Reverse,
        setpoint: ElectricalSpeed::from_bits(-1),
        speed_hall: ElectricalSpeed::from_bits(2),
        speed_sensorless: ElectricalSpeed::from_bits(3),
        angle: ElectricalAngle(0x4455),
        sectors: -2,
        standstill: true,
        unseen: false,
        bus_voltage: Volts::from_bits(4),
        bus_current: Amps::from_bits(5),
        power: Watts::from_bits(6),
        phase_voltage: [7, 8, 9].map(Volts::from_bits),
        duty: Duty::from_bits(10),
        limiter: Limiter::Slew,
        hall_invalid: 11,
        hall_jumps: 12,
        hall_calibration: HallCalibration::Done(HallWiring { order: 13, polarity: 14, offset: -2 }),
        crossing: Why::DemagLate,
        crossing_margin: -3,
        crossings: 15,
    };
    bytes.extend([b'S', 8, 7, 6, 5, 4, 3, 2, 1, 5]);
    bytes.extend([0x10, 0, 0, 0, 0, 0, 0, 0x80, 0x22, 0x11, 1, 2, 1, 1]);
    bytes.extend([0xff, 0xff, 0xff, 0xff, 2, 0, 0, 0, 3, 0, 0, 0, 0x55, 0x44, 0xfe, 0xff, 0xff, 0xff, 1, 0]);
    for value in 4..=9u8 {
        bytes.extend([value, 0, 0, 0]);
    }
    bytes.extend([10, 0, 8, 11, 0, 12, 0, 2, 13, 14, 0xfe, 0xff, 4, 0xfd, 0xff, 15, 0, 0, 0]);
    assert_eq!(digest(&command, Some(&status)), crc64(&bytes));
}
