"""The emulated board operated by the Python package: scope, recordings, log and parameters.

Each test then checks the use of the stack.
"""

import pathlib
import re
import tomllib

import narx
import numpy as np
import pytest
from conftest import operated, run_for_a_broadcast, spin, with_arguments
from narx import State, Trigger

POLE_PAIRS = narx.Motor.preset("bly172s-24v").pole_pairs


PROOF = pathlib.Path(__file__).parents[1] / "golden" / "proof.toml"


@pytest.fixture
def drive():
    with operated(with_arguments()) as (drive, emulator):
        yield drive
        # The image prints from time to time how much of its stack has been used.
        assert drive.wait_for(lambda: "stack: " in emulator.said(), 60.0)
        used = max(int(mark) for mark in re.findall(r"stack: (\d+) bytes", emulator.said()))
    assert used <= tomllib.loads(PROOF.read_text())["stack"]["program"], "more than is proven to be enough"


def test_the_scope_captures_at_once_and_by_a_trigger(drive):
    spin(drive, 3000)
    assert drive.wait_for(lambda: abs((drive.measurements.speed or 0.0) - 3000) <= 30, timeout=60.0)
    seen = drive.scope.capture(["Hall code", "Duty"], samples=400, before=100, timeout=60.0)
    assert list(seen) == ["time", "Duty", "Hall code"] and len(seen) == 400
    assert seen.time[100] == 0.0 and np.diff(seen.time) == pytest.approx(1e-4)
    assert set(seen["Hall code"]) == {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}
    changes = np.count_nonzero(np.diff(seen["Hall code"])) / (len(seen) * 1e-4)
    assert changes == pytest.approx(3000 / 60 * POLE_PAIRS * 6, rel=0.05)

    drive.scope.arm(["Drive state"], samples=50, before=10, trigger=Trigger.state_change())
    assert drive.scope.state is narx.ScopeState.ARMED
    # The samples from before the trigger take 1 ms of the drive's time; the emulator can be that slow.
    run_for_a_broadcast(drive)
    drive.stop()
    drive.scope.wait(60.0)
    states = drive.scope.download()["Drive state"]
    assert (states[9], states[11]) == (State.HALL_CLOSED_LOOP, State.STANDBY)


def test_what_the_scope_records_of_a_start_replays_to_the_bits_of_the_board(drive, tmp_path):
    drive.scope.arm_inputs(ticks=400, before=200, trigger=Trigger.state_change())
    spin(drive, 2000)
    drive.scope.wait(60.0)
    record = drive.scope.download_recording()
    assert record.agrees, "the state in the second checkpoint is not what the first one and the inputs lead to"
    record.save(tmp_path / "start.narxrec")
    again = narx.replay(tmp_path / "start.narxrec")
    # The recording is as long as the memory allows, 34 to 68 ms, even if more was requested.
    assert again.identical and 340 <= again.ticks <= 680
    states = again["state"].tolist()
    assert states[0] == State.STANDBY and states[-1] != State.STANDBY and set(np.diff(states) != 0) == {True, False}
    assert narx.replay(drive.scope.record(ticks=200, before=50, timeout=60.0).recording).identical, "while it turns"


def test_the_log_is_written_downloaded_and_erased(drive):
    log = drive.log
    assert log.capacity > 1000 and len(log) == 0
    log.configure({"HV Voltage": "mean", "Mechanical estimated speed HES": "max", "Drive state": "live"}, period=0.01)
    spin(drive, 2000)
    assert drive.wait_for(lambda: len(log) >= 40, timeout=60.0)
    drive.stop()
    log.configure([], period=1.0)
    records = log.download()
    assert list(records) == ["index", "time", "HV Voltage mean", "Mechanical estimated speed HES max", "Drive state"]
    assert len(records) == len(log) and records["index"].tolist() == list(range(len(records)))
    assert np.diff(records.time)[1:-1] == pytest.approx(0.01)
    assert records["HV Voltage mean"] == pytest.approx(24.0, rel=0.1)
    assert {State.HALL_CLOSED_LOOP} <= set(records["Drive state"])
    assert drive.wait_for(lambda: drive.state is State.STANDBY, timeout=60.0)
    log.erase()
    assert len(log) == 0 and drive.faults == set()
    log.configure(["HV Voltage"], period=0.01)
    assert drive.wait_for(lambda: len(log) > 2, timeout=60.0), "after the erase it goes on"


def test_parameters_are_changed_stored_and_found_again(drive):
    before = drive.parameters["Winding resistance"]
    drive.parameters["Winding resistance"] = before + 0.25
    with pytest.raises(narx.ParameterError, match="Motor pair poles"):
        drive.parameters["Motor pair poles"] = 99
    drive.parameters.store()
    drive.parameters["Winding resistance"] = before + 0.5  # this one is stored by itself, before the restart at the latest
    drive.reboot()
    assert drive.parameters["Winding resistance"] == pytest.approx(before + 0.5)
    assert drive.parameters["Motor pair poles"] == POLE_PAIRS
