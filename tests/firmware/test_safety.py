"""Reactions of the drive to its own failures: watchdog resets and failed self-tests."""

import pytest
from conftest import FAILED_SELF_TESTS, FAULT_WORD, MEASUREMENT_5, REBOOT, RESET_CAUSE, STATE, STATUS_WORD

STANDBY_REQUEST, DRIVE_REQUEST = 0, 1
INITIALIZATION, STANDBY, HALL_CLOSED_LOOP, FAULT = 0, 1, 5, 6
POWER_UP, REQUESTED, WATCHDOG = 1, 3, 4
SELF_TEST_FAULT = 1 << 27


def drive(master, rpm=2000):
    master.mode = STANDBY_REQUEST
    master.wait_for_state(STANDBY, 2.0)
    master.mode, master.rpm = DRIVE_REQUEST, rpm
    master.wait_for_state(HALL_CLOSED_LOOP, 0.5)


def faults(master):
    return int.from_bytes(master.seen.get(FAULT_WORD, bytes(4))[0:4], "big")


def test_the_drive_tells_why_it_started(master):
    master.mode = STANDBY_REQUEST
    master.wait_for_state(STANDBY, 2.0)
    assert (master.parameter(RESET_CAUSE), master.parameter(FAILED_SELF_TESTS)) == (POWER_UP, 0)
    master.send(REBOOT, 0)
    master.wait_for_state(INITIALIZATION, 1.0)
    assert master.parameter(RESET_CAUSE) == REQUESTED


@pytest.mark.arguments("--watchdog", "500", "--trouble", "background", "--after", "25000")
def test_a_drive_that_hung_at_speed_comes_back_in_standby_and_stays_there(master):
    drive(master)
    master.wait(1.0, lambda: abs(master.speed - 2000) <= 20, "set-point")
    # The drive hangs soon. The master goes on sending Drive requests.
    master.wait(6.0, lambda: master.seen.get(STATUS_WORD, b"")[2:3] == b"\0", "restart")
    assert master.parameter(RESET_CAUSE) == WATCHDOG
    for _ in range(10):
        master.run(0.05)
        assert master.parameter(STATE) in (INITIALIZATION, STANDBY)
    assert master.seen[MEASUREMENT_5][0:2] == b"\0\0"
    # The motor starts only after a Standby request and a new Drive request.
    master.mode = STANDBY_REQUEST
    master.run(0.2)
    drive(master)


@pytest.mark.arguments("--trouble", "program", "--after", "20000")
def test_a_bit_of_the_program_that_flips_stops_the_motor(master):
    drive(master)
    stops_for_good(master, 0b00010, seconds=4.0)


@pytest.mark.arguments("--trouble", "stack", "--after", "20000")
def test_a_stack_that_was_used_up_stops_the_motor(master):
    drive(master)
    stops_for_good(master, 0b01000, seconds=2.0)


def stops_for_good(master, bits, seconds):
    master.wait(seconds, lambda: faults(master) & SELF_TEST_FAULT, "fault 27")
    assert master.parameter(FAILED_SELF_TESTS) == bits
    master.wait_for_state(FAULT, 0.1)
    # The requests that clear another fault do not clear this one, and the motor does not start.
    master.mode = STANDBY_REQUEST
    master.run(0.8)
    master.mode = DRIVE_REQUEST
    for _ in range(3):
        master.run(0.05)
        assert master.parameter(STATE) == FAULT
    assert faults(master) & SELF_TEST_FAULT
