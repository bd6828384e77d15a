"""Traces are numpy arrays with names and units."""

import importlib.metadata
import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narx
from narx.extras import EXTRAS
from narx.plot import CROSSINGS, crossings


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
    with pytest.raises(narx.ParameterError, match='".txt" must be one of .csv, .parquet, .xlsx, .mf4, .narxrec'):
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


def test_notebooks_show_plots(trace: narx.Trace) -> None:
    image = trace.plot("speed")._repr_png_()  # type: ignore[attr-defined]
    assert image.startswith(b"\x89PNG") and len(image) > 10_000


def test_codes_are_drawn_in_steps(trace: narx.Trace) -> None:
    styles = [str(axis.lines[0].get_drawstyle()) for axis in trace.plot("hall", "duty", "speed").axes]
    assert styles == ["steps-post", "default", "default"]


def test_zero_crossings_are_marked_by_what_became_of_them(motor: narx.Motor) -> None:
    bench = narx.Bench(motor, supply_voltage=18.0, mode="sensorless")
    bench.drive.start(2000, wait=False)
    trace = bench.run(1.5)
    time, kinds = crossings(trace)
    # There are six zero crossings in an electrical revolution, and all are accepted once the motor runs.
    runs = time > 1.45
    electrical = trace["speed"][trace.time > 1.45].mean() / 60.0 * motor.pole_pairs
    assert np.diff(time[runs]).mean() == pytest.approx(1.0 / (6.0 * electrical), rel=0.02)
    assert set(kinds[runs]) == {1} and set(kinds) > {1}
    assert time[0] > trace.time[trace["state"] == narx.State.OPEN_LOOP][0]

    strip = trace.plot().axes[-1]
    assert [label.get_text() for label in strip.get_yticklabels()] == [CROSSINGS[kind][0] for kind in CROSSINGS if kind in kinds]
    assert sum(len(np.asarray(line.get_xdata())) for line in strip.lines) == len(time)
    assert [axis.get_ylabel() for axis in trace.plot("speed").axes] == ["speed [rpm]"]


def test_with_sensors_there_are_no_marks(trace: narx.Trace) -> None:
    assert len(crossings(trace)[0]) == 0 and len(trace.plot().axes) == 3
    assert [axis.get_ylabel() for axis in trace.plot("crossing").axes] == ["crossing"]


def test_no_peak_is_lost_in_a_plot(bench: narx.Bench) -> None:
    bench.drive.start(1500)
    trace = bench.run(5.0)
    for axis in trace.plot("current_a", "current_b").axes:
        for line in axis.lines:
            values = trace[str(line.get_label())]
            drawn = np.asarray(line.get_ydata())
            assert len(drawn) < len(values) and (drawn.min(), drawn.max()) == (values.min(), values.max())


def test_every_signal_is_described(trace: narx.Trace) -> None:
    replay = narx.replay(trace.recording())
    for one in (trace, replay):
        assert list(one.descriptions) == list(one) and all(one.descriptions.values())
    shown = trace._repr_html_()
    assert "<td>bus_voltage</td><td>V</td>" in shown and trace.descriptions["energy_in"] in shown
    assert "<th>least</th>" in shown and f"<td>{trace['bus_voltage'].min():.5g}</td>" in shown
    assert trace._ipython_key_completions_() == list(trace)


def test_parts_of_a_trace(trace: narx.Trace) -> None:
    part = trace.select(slice(100, 200))
    assert np.array_equal(part["speed"], trace["speed"][100:200]) and part.signals == trace.signals and part.recording() == b""
    assert len(trace.select(trace["speed"] > trace["speed"][250])) < len(trace)
    middle = trace.between(trace.time[100], trace.time[200])
    assert np.array_equal(middle.time, trace.time[100:200])
    for start, end in [(5.0, 6.0), (trace.time[200], trace.time[100])]:
        with pytest.raises(narx.ParameterError, match=r"must have rows between them from [\d.]+ to [\d.]+ s"):
            trace.between(start, end)
    for rows in (3, "speed", [10_000], None, slice(0.5, 1.0)):
        with pytest.raises(narx.ParameterError, match="^rows "):
            trace.select(rows)


def test_codes_are_members_of_their_enumerations(bench: narx.Bench) -> None:
    bench.drive.start(1500)
    bench.inject("supply", 63.0)
    trace = bench.run(0.5)
    states = trace.named("state")
    assert states[0] is narx.State.HALL_CLOSED_LOOP and states[-1] is narx.State.FAULT
    assert trace.named("limiter")[0] in (narx.Limiter.SPEED, narx.Limiter.SLEW) and trace.named("limiter")[-1] is narx.Limiter.OFF
    assert trace.named("step")[-1] is narx.blocks.Step.COAST and trace.named("crossing")[0] is narx.Crossing.NONE
    faults = trace.named("faults")[-1]
    assert isinstance(faults, narx.Fault) and {name.lower() for name in narx.Fault.__members__ if narx.Fault[name] & faults} == bench.drive.faults != set()
    frame = trace.to_pandas(named=True)
    assert list(frame["state"].cat.categories) == ["hall_closed_loop", "fault"] and frame["state"].iloc[-1] == "fault"
    assert set(frame["faults"].iloc[-1].split("|")) == bench.drive.faults and frame["faults"].iloc[0] == ""
    assert trace.to_pandas()["state"].dtype == np.float32
    with pytest.raises(narx.SignalError, match='signal "speed" is no code; codes are state, step, limiter, crossing, faults|did you mean'):
        trace.named("speed")


def test_crossings_have_the_names_of_the_plot() -> None:
    assert {member.value: member.name.lower().replace("_", " ") for member in narx.Crossing if member} == {
        kind: name for kind, (name, _) in CROSSINGS.items()
    }


def test_csv_is_written_without_pandas(trace: narx.Trace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for library in ("pandas", "pyarrow", "openpyxl", "matplotlib", "tqdm", "can"):
        monkeypatch.setitem(sys.modules, library, None)
        monkeypatch.delitem(sys.modules, f"{library}.auto", raising=False)
    trace.save(tmp_path / "run.csv")
    swept = narx.sweep({"motor": "ec45-flat-50w-18v", "supply_voltage": 18.0, "mode": "hall", "rpm": [1000, 70_000], "seconds": 0.1})
    swept.save(tmp_path / "sweep.csv")
    calls: list[tuple[Callable[[], object], str, str]] = [
        (trace.to_pandas, "pandas", "pandas"),
        (lambda: trace.save(tmp_path / "run.parquet"), "pyarrow", "tables"),
        (lambda: trace.save(tmp_path / "run.xlsx"), "openpyxl", "tables"),
        (trace.plot, "matplotlib", "plot"),
        (lambda: narx.connect("virtual"), "can", "can"),
        (narx.devices, "can", "can"),
        (lambda: narx.sweep({"motor": "ec45-flat-50w-18v"}, progress=True), "tqdm", "progress"),
    ]
    for call, library, extra in calls:
        with pytest.raises(narx.MissingError) as caught:
            call()
        assert str(caught.value) == f"{library} is not installed: pip install 'narx[{extra}]'"
        assert isinstance(caught.value, ImportError) and isinstance(caught.value, narx.NarxError)
    monkeypatch.undo()
    written = pd.read_csv(tmp_path / "run.csv", dtype={name: trace[name].dtype for name in trace})
    assert all(np.array_equal(written[name], trace[name]) for name in trace)
    rows = pd.read_csv(tmp_path / "sweep.csv")
    assert list(rows) == list(swept) and np.array_equal(rows["speed"], swept["speed"], equal_nan=True)
    assert rows["motor"].tolist() == ["ec45-flat-50w-18v"] * 2 if "motor" in rows else True


def test_every_extra_is_one_of_the_package() -> None:
    extras = set(importlib.metadata.metadata("narx").get_all("Provides-Extra") or [])
    assert set(EXTRAS.values()) <= extras


@pytest.mark.parametrize("page", ["python/README.md", "docs/FROM-PYTHON.md"])
def test_the_first_lines_of_a_page_need_no_extra(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (Path(__file__).parents[2] / page).read_text(encoding="utf-8")
    lines = text[text.index("import narx\n") :].splitlines()
    # The block ends at a fence, or at the first line that is not indented.
    end = next(row for row, line in enumerate(lines) if line == "```" or (row and page == "python/README.md" and line[:1].strip()))
    monkeypatch.chdir(tmp_path)
    for library in EXTRAS:
        monkeypatch.setitem(sys.modules, library, None)
    code = "\n".join(line.removeprefix("    ") for line in lines[:end])
    assert "bench.run(1.0)" in code
    exec(compile(code, page, "exec"), {})  # noqa: S102


def members(file: str, name: str) -> dict[str, int]:
    """Returns the members of an enumeration of the core, from its source."""
    source = (Path(__file__).parents[2] / "core/src/motor" / file).read_text(encoding="utf-8")
    found = re.search(rf"pub enum {name} \{{(.*?)\n\}}", source, re.S)
    assert found is not None
    rows = re.findall(r"^    (\w+) = (\d+),$", found[1], re.M)
    return {re.sub(r"(?<!^)(?=[A-Z])", "_", member).upper(): int(number) for member, number in rows}


def test_enumerations_are_those_of_the_core() -> None:
    limiters = members("control/limits.rs", "Limiter")
    assert limiters == {member.name: member.value for member in narx.Limiter} and len(limiters) == 11
    # The core has other words for the outcomes of a crossing.
    outcomes = members("rotor/zero_crossing.rs", "Why")
    assert list(outcomes.values()) == [member.value for member in narx.Crossing] and outcomes["ACCEPTED"] == narx.Crossing.ACCEPTED
