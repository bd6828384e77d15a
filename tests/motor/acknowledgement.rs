//! Tests of the acknowledgement of a fault (T61).

use narx_core::motor::clock::Instant;
use narx_core::motor::machine::{Inputs, Machine, MachineCoefficients};
use narx_core::motor::{Command, State};
use narx_core::units::ElectricalSpeed;

/// Only REQUEST_WORD can request Standby anew: a set-point after a fault restarts the time-out and
/// acknowledges nothing.
#[test]
fn a_set_point_acknowledges_no_fault() {
    let mut machine = Machine::default();
    let c = MachineCoefficients { boot: 1, fault_wait: 10, command_timeout: 1_000, ..Default::default() };
    let mut inputs = Inputs {
        critical: false,
        unhealthy: false,
        causes_gone: true,
        stopped: true,
        calibrated: false,
        parameters_fit: true,
    };
    let mut now = Instant::default().next();
    machine.step(&c, now, &inputs);
    inputs.critical = true;
    now = now.next();
    machine.step(&c, now, &inputs);
    assert_eq!(machine.state(), State::Fault);
    inputs.critical = false;
    for _ in 0..100 {
        machine.handle_set_point(now, ElectricalSpeed::ZERO);
        now = now.next();
        machine.step(&c, now, &inputs);
    }
    assert_eq!(machine.state(), State::Fault);
    machine.handle_command(now, Command::default());
    now = now.next();
    machine.step(&c, now, &inputs);
    assert_eq!(machine.state(), State::Standby);
}
