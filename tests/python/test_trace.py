"""Traces are numpy arrays with names and units."""

from pathlib import Path

import numpy as np
import pandas as pd
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


def test_tables_are_saved_and_read_back(trace: narx.Trace, tmp_path: Path) -> None:
    frame = trace.to_pandas()
    for name, read, exact in (
        ("run.csv", pd.read_csv, False),
        ("run.parquet", pd.read_parquet, True),
        ("run.xlsx", pd.read_excel, False),
    ):
        trace.save(tmp_path / name)
        back = read(tmp_path / name)
        assert list(back.columns) == list(frame.columns), name
        assert np.allclose(back.to_numpy(float), frame.to_numpy(float), rtol=0.0 if exact else 1e-6), name
    trace.save(tmp_path / "run.narxrec")
    assert narx.replay(tmp_path / "run.narxrec").identical


def test_what_cannot_be_saved_is_named(trace: narx.Trace, tmp_path: Path) -> None:
    with pytest.raises(narx.ParameterError, match='".txt" must be one of .csv, .parquet, .xlsx, .narxrec'):
        trace.save(tmp_path / "run.txt")


def test_plots_have_a_panel_for_each_unit(trace: narx.Trace, tmp_path: Path) -> None:
    figure = trace.plot()
    assert [axis.get_ylabel() for axis in figure.axes] == ["[rpm]", "[A]", "duty"]
    figure = trace.plot("speed", "voltage_a", "voltage_b", "hall")
    assert [axis.get_ylabel() for axis in figure.axes] == ["speed [rpm]", "[V]", "hall"]
    figure.savefig(tmp_path / "run.png")
    assert (tmp_path / "run.png").stat().st_size > 10_000
    with pytest.raises(narx.SignalError, match='no signal "sped"'):
        trace.plot("sped")


def test_no_peak_is_lost_in_a_plot(bench: narx.Bench) -> None:
    bench.drive.start(1500)
    trace = bench.run(5.0)
    for axis in trace.plot("current_a", "current_b").axes:
        for line in axis.lines:
            values = trace[str(line.get_label())]
            drawn = np.asarray(line.get_ydata())
            assert len(drawn) < len(values) and (drawn.min(), drawn.max()) == (values.min(), values.max())
