"""Scope and recordings of the board, downloaded over its bus and replayed here."""

import narx
import numpy as np
import pytest
from conftest import forked
from narx import State, Trigger


@forked
def test_the_scope_sees_the_hall_sensors_in_step_with_the_motor(turning):
    seen = turning.drive.scope.capture(["Hall code", "Duty"], samples=300, before=50)
    assert len(seen) == 300 and set(seen["Hall code"]) == {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}
    changes = np.count_nonzero(np.diff(seen["Hall code"])) / (len(seen) * 1e-4)
    assert changes == pytest.approx(2000 / 60 * narx.Motor.preset("bly172s-24v").pole_pairs * 6, rel=0.05)


@forked
def test_a_recording_of_a_start_replays_to_the_same_digest(standing):
    drive = standing.drive
    drive.scope.arm_inputs(ticks=200, before=60, trigger=Trigger.state_change())
    drive.start(1500)
    drive.scope.wait(5.0)
    record = drive.scope.download_recording()
    assert record.agrees
    again = narx.replay(record.recording)
    assert again.identical and again.ticks > 50
    states = again["state"].tolist()
    assert states[0] == State.STANDBY and states[-1] == State.HALL_CLOSED_LOOP
