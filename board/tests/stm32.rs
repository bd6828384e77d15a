//! The bus current, from shunts below the legs.

use narx_board::stm32::{bus_current, gates};
use narx_core::motor::SampleMode::{self, OffTime, OnTime};
use narx_core::motor::{Rectification, Step};
use narx_core::units::Duty;

/// Dead time, 1/64 of the period.
const DEAD: u16 = 512;
/// On-time at half duty.
const ON: f64 = 0.5 - 1.0 / 64.0;

/// Mean of the bus at half duty, A, of shunts in mA.
fn amperes(shunts: [i32; 3], step: Step, sampled: SampleMode) -> f64 {
    let gates = gates(step, Rectification::Synchronous);
    bus_current(shunts, gates, Duty::from_bits(1 << 14), DEAD, sampled) as f64 / 32_768.0 / 1_000.0
}

#[test]
fn the_bus_carries_what_all_legs_carry_to_ground() {
    for (what, shunts, step, sampled, is) in [
        ("3 A from A to B, on-time", [0, 3_000, 0], Step::AB, OnTime, 3.0 * ON),
        (
            "the same, off-time: A's lower switch carries them up",
            [-3_000, 3_000, 0],
            Step::AB,
            OffTime,
            3.0 * ON,
        ),
        ("3 A from B to A, generating", [0, -3_000, 0], Step::AB, OnTime, -3.0 * (1.0 - ON)),
        ("A switched, B and C low", [0, 1_000, 1_000], Step::LockA, OnTime, 2.0 * ON),
        ("A and B switched, C low", [0, 0, 1_000], Step::LockAB, OnTime, ON),
        (
            "off: 1 A comes up through A's diode, and goes to the bus",
            [-1_000, 0, 0],
            Step::Coast,
            OffTime,
            -1.0,
        ),
        (
            "from A to C, B low: 1 of 3 A still comes up through A's diode",
            [-1_000, 3_000, 0],
            Step::CB,
            OnTime,
            2.0 * ON,
        ),
        ("the same, off-time", [-1_000, 3_000, -2_000], Step::CB, OffTime, 2.0 * ON),
        (
            "from B to C, A switched: 1 of 3 A still returns through B's upper diode",
            [0, 0, 2_000],
            Step::AC,
            OnTime,
            2.0 * ON,
        ),
        ("the same, off-time: 1 A returns", [-3_000, 0, 2_000], Step::AC, OffTime, 2.0 * ON - (1.0 - ON)),
    ] {
        let said = amperes(shunts, step, sampled);
        assert!((said - is).abs() < 1e-3, "{what}: {is} A, said {said} A");
    }
}

#[test]
fn diodes_alone_take_no_dead_time() {
    let gates = gates(Step::AB, Rectification::Diode);
    let said = bus_current([0, 3_000, 0], gates, Duty::from_bits(1 << 14), DEAD, OnTime);
    assert_eq!(said, 3_000 << 14);
}
