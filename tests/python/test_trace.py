"""Traces are numpy arrays with names and units."""

import numpy as np
import pytest

import narx


@pytest.fixture
def trace(bench: narx.Bench) -> narx.Trace:
    bench.drive.start(1500)
    return bench.run(0.05)


def test_columns_of_the_specified_csv_come_first(trace: narx.Trace) -> None:
    assert list(trace)[:13] == [
        "time", "setpoint", "speed", "speed_estimated", "state", "sector", "duty", "current_a", "current_b",
        "current_c", "bus_current", "bus_voltage", "torque",
    ]  # fmt: skip
    units = {"time": "s", "speed": "rpm", "duty": "", "current_a": "A", "bus_voltage": "V", "torque": "N m"}
    assert {name: trace.signals[name] for name in units} == units


def test_columns_are_arrays_without_copies(trace: narx.Trace) -> None:
    assert trace.time.dtype == np.float64 and trace["speed"].dtype == np.float32
    assert all(len(trace[name]) == len(trace) == 500 for name in trace)
    assert trace["speed"] is trace["speed"] and trace.time is trace["time"]
    assert not trace["speed"].flags.owndata and trace["speed"].flags.c_contiguous
    assert "speed" in trace and "sped" not in trace


def test_an_unknown_signal_is_named(trace: narx.Trace) -> None:
    with pytest.raises(narx.SignalError, match='^there is no signal "sped"; did you mean "speed"') as caught:
        trace["sped"]
    assert isinstance(caught.value, KeyError)


def test_to_pandas(trace: narx.Trace) -> None:
    frame = trace.to_pandas()
    assert list(frame.columns) == list(trace) and len(frame) == len(trace)
    assert np.array_equal(frame["current_a"].to_numpy(), trace["current_a"])
