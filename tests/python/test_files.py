"""Files and frames of other tools, each read back by that tool."""

from pathlib import Path

import asammdf
import can
import numpy as np
import pytest
from logs import DATABASE, stamped, write

import narx


@pytest.fixture
def trace(bench: narx.Bench) -> narx.Trace:
    bench.drive.start(1500)
    return bench.run(0.05)


def test_a_trace_is_mdf(trace: narx.Trace, tmp_path: Path) -> None:
    trace.save(tmp_path / "run.mf4")
    with asammdf.MDF(tmp_path / "run.mf4") as file:
        assert file.version.startswith("4.")
        for name, unit in trace.signals.items():
            if name == "time":
                continue
            read = file.get(name)
            assert np.array_equal(read.samples, trace[name]) and read.samples.dtype == trace[name].dtype
            assert np.array_equal(read.timestamps, trace.time) and read.unit == unit and read.comment == trace.descriptions[name]
    # A second time writes over it.
    trace.select(slice(0, 10)).save(tmp_path / "run.mf4")
    with asammdf.MDF(tmp_path / "run.mf4") as file:
        assert len(file.get("speed")) == 10


def test_a_trace_is_polars_and_xarray(trace: narx.Trace) -> None:
    frame = trace.to_polars()
    assert frame.columns == list(trace) and np.array_equal(frame["speed"].to_numpy(), trace["speed"])
    data = trace.to_xarray()
    assert set(data.data_vars) == set(trace) - {"time"} and data["speed"].attrs["units"] == "rpm"
    assert data["bus_voltage"].attrs["long_name"] == trace.descriptions["bus_voltage"]
    assert float(data["speed"].sel(time=trace.time[7], method="nearest")) == trace["speed"][7]


def test_a_trace_without_a_recording_says_so(trace: narx.Trace, tmp_path: Path) -> None:
    with pytest.raises(narx.ParameterError, match=r"run.narxrec\": this trace has no recording"):
        trace.select(slice(0, 10)).save(tmp_path / "run.narxrec")
    assert not (tmp_path / "run.narxrec").exists()
    trace.save(tmp_path / "run.narxrec")
    assert narx.replay(tmp_path / "run.narxrec").identical


FRAMES = stamped([
    *(can.Message(arbitration_id=DATABASE.get_message_by_name("MEASUREMENT_5").frame_id, data=speed.to_bytes(2, "big") + bytes(6)) for speed in range(50)),
    can.Message(arbitration_id=0x123, is_extended_id=False, data=b"\1\2\3"),
    can.Message(arbitration_id=0x7FF, is_extended_id=False, is_remote_frame=True),
])  # fmt: skip


@pytest.mark.parametrize("ending", [".asc", ".blf", ".csv", ".log"])
def test_frames_are_a_log_of_python_can(tmp_path: Path, ending: str) -> None:
    log = narx.read_log(write(tmp_path / "in.log", FRAMES))
    log.frames.save(tmp_path / f"out{ending}")
    with can.LogReader(tmp_path / f"out{ending}") as reader:
        read = list(reader)
    assert len(read) == len(FRAMES)
    for found, frame in zip(read, FRAMES, strict=True):
        assert found.equals(frame, timestamp_delta=None, check_channel=False, check_direction=False)
    times = np.diff([found.timestamp for found in read])
    assert times == pytest.approx(0.001, abs=2e-4)
    again = narx.read_log(tmp_path / f"out{ending}")
    assert len(again.frames) == len(FRAMES) and np.array_equal(again["Mechanical estimated speed HES"].values, np.arange(50))


def test_a_log_of_another_name_is_refused(tmp_path: Path) -> None:
    log = narx.read_log(write(tmp_path / "in.log", FRAMES))
    with pytest.raises(narx.ParameterError, match='"" must be one of .asc, .blf, .csv, .log'):
        log.frames.save(tmp_path / "out")
    some = log.frames[:5]
    some.save(tmp_path / "some.blf")
    assert len(narx.read_log(tmp_path / "some.blf").frames) == 5
