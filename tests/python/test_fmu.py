"""FMUs, in FMPy: every output in every step has the bits of the same run of a bench, in FMI 2 and 3."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal

import fmpy  # type: ignore[import-untyped]
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException  # type: ignore[import-untyped]
from fmpy.fmi2 import FMU2Slave  # type: ignore[import-untyped]
from fmpy.fmi3 import FMU3Slave  # type: ignore[import-untyped]
from fmpy.validation import validate_fmu  # type: ignore[import-untyped]
from typer.testing import CliRunner

import narx
from narx.cli.app import app

STEP = 0.001
"""Communication step, s."""


def made() -> narx.Bench:
    """Returns a bench on which no argument has its default value."""
    load = narx.Load(constant=0.01, quadratic=1e-8, inertia=1e-6)
    return narx.Bench(
        "ec45-flat-50w-18v", 18.5, load, "sensorless", {"Phase current limit": 5.0}, ambient=30.0, seed=3, pwm_rate=20_000
    )


class Fmu:
    """An FMU in FMPy, the same for both versions."""

    def __init__(self, path: Path, version: int) -> None:
        self.description = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))
        self.version = version
        self.messages: list[str] = []
        self.references = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        about = {"guid": self.description.guid, "unzipDirectory": self.folder, "instanceName": "drive"}
        self.fmu: Any = (FMU2Slave if version == 2 else FMU3Slave)(**about, modelIdentifier="narx_drive")

    def instantiate(self) -> None:
        if self.version == 2:
            self.fmu.instantiate()
        else:
            self.fmu.instantiate(logMessage=None)

    def begin(self, time: float = 0.0) -> None:
        self.instantiate()
        if self.version == 2:
            self.fmu.setupExperiment(startTime=time)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=time)
        self.fmu.exitInitializationMode()

    def set(self, **inputs: float | bool) -> None:
        for name, value in inputs.items():
            if isinstance(value, bool):
                self.fmu.setBoolean([self.references[name]], [value])
            else:
                (self.fmu.setReal if self.version == 2 else self.fmu.setFloat64)([self.references[name]], [value])

    def get(self, name: str) -> float:
        kind = next(variable.type for variable in self.description.modelVariables if variable.name == name)
        found: float = getattr(self.fmu, f"get{kind}")([self.references[name]])[0]
        return found

    def step(self, time: float, length: float = STEP) -> None:
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=length)

    def outputs(self) -> list[str]:
        return [variable.name for variable in self.description.modelVariables if variable.causality == "output"]


@pytest.fixture(params=[2, 3])
def fmu(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Fmu]:
    """A bench's FMU, unpacked."""
    made().fmu(tmp_path / "drive.fmu", request.param)
    found = Fmu(tmp_path / "drive.fmu", request.param)
    yield found
    shutil.rmtree(found.folder)


Act = tuple[float, dict[str, float | bool], Callable[[narx.Bench], object]]
ACTS: list[Act] = [
    (0.0, {"speed_request": 2000.0, "run": True}, lambda bench: bench.drive.start(2000, wait=False)),
    (0.5, {"speed_request": 2500.0}, lambda bench: bench.drive.set_speed(2500)),
    (0.7, {"load_torque": 0.03, "machine_torque": -0.005}, lambda bench: bench.set_load(narx.Load(0.03, 0, 1e-8, 1e-6, -0.005))),
    (0.8, {"supply_voltage": 21.0}, lambda bench: bench.set_supply(21.0)),
    (1.0, {"run": False}, lambda bench: bench.drive.stop()),
]
"""Time, s, inputs of the FMU, and the same on a bench."""


def test_every_output_has_the_bits_of_the_same_run_of_a_bench(fmu: Fmu) -> None:
    bench, begin = made(), 7.0
    fmu.begin(begin)
    seen, rows = [], []
    for count in range(1200):
        for time, inputs, act in ACTS:
            if count == round(time / STEP):
                fmu.set(**inputs)
                act(bench)
        fmu.step(begin + count * STEP)
        seen.append([fmu.get(name) for name in fmu.outputs()])
        rows.append(bench.run(STEP, progress=False))
    trace = {name: np.concatenate([row[name][-1:] for row in rows]) for name in rows[0]}
    assert fmu.outputs() == list(trace)[1:] and set(trace["state"]) == {0, 1, 2, 3, 4}
    assert abs(fmu.get("time") - (begin + bench.time)) < 1e-9
    for name, values in zip(fmu.outputs(), np.array(seen).T, strict=True):
        # A trace keeps 32 bits of most signals.
        assert np.array_equal(values.astype(trace[name].dtype), trace[name]), name
    fmu.fmu.terminate()
    fmu.fmu.freeInstance()


def test_the_description_is_valid_and_the_archive_repeatable(tmp_path: Path) -> None:
    platforms: list[tuple[Literal[2, 3], str]] = [(2, "linux64"), (3, "x86_64-linux")]
    for version, platform in platforms:
        first, second = tmp_path / f"first{version}.fmu", tmp_path / f"second{version}.fmu"
        made().fmu(first, version)
        made().fmu(second, version)
        assert validate_fmu(str(first)) == [] and first.read_bytes() == second.read_bytes()
        with zipfile.ZipFile(first) as archive:
            assert set(archive.namelist()) == {"modelDescription.xml", f"binaries/{platform}/narx_drive.so", "resources/drive.json"}
        described = fmpy.read_model_description(str(first))
        starts = {variable.name: variable.start for variable in described.modelVariables if variable.causality == "input"}
        assert list(starts) == ["run", "speed_request", "load_torque", "machine_torque", "supply_voltage"]
        assert float(starts["load_torque"]) == 0.01 and float(starts["supply_voltage"]) == 18.5


def test_fmpy_simulates_it(tmp_path: Path) -> None:
    versions: tuple[Literal[2, 3], ...] = (2, 3)
    for version in versions:
        made().fmu(tmp_path / "drive.fmu", version)
        inputs = np.array([(0.0, True, 2000.0), (2.0, True, 2000.0)], [("time", float), ("run", bool), ("speed_request", float)])
        result = fmpy.simulate_fmu(
            str(tmp_path / "drive.fmu"), stop_time=1.0, output_interval=0.01, input=inputs, output=["speed", "state", "bus_voltage"]
        )
        bench = made()
        bench.drive.start(2000, wait=False)
        trace = bench.run(1.0)
        assert np.float32(result["speed"][-1]) == trace["speed"][-1] > 1500
        assert result["state"][-1] == narx.State.SENSORLESS_CLOSED_LOOP


def test_a_state_that_is_set_again_continues_with_the_same_bits(fmu: Fmu) -> None:
    fmu.begin()
    fmu.set(run=True, speed_request=2000.0)
    fmu.step(0.0, 0.5)
    get, put, free = (
        [getattr(fmu.fmu, f"{verb}FMU{'s' if fmu.version == 2 else 'S'}tate") for verb in ("get", "set", "free")]
    )
    state = get()
    ends = []
    for _ in range(2):
        fmu.step(0.5, 0.25)
        ends.append([fmu.get(name) for name in fmu.outputs()])
        put(state)
    assert ends[0] == ends[1] and fmu.get("time") == 0.5
    free(state)
    fmu.fmu.reset()
    assert fmu.get("time") == 0.0 and fmu.get("speed_request") == 0.0 and fmu.get("supply_voltage") == 18.5
    fmu.fmu.freeInstance()


@pytest.mark.parametrize(
    ("inputs", "time", "length"),
    [
        ({"speed_request": 65_000.0, "run": True}, 0.0, STEP),
        ({"speed_request": 0.0, "run": True}, 0.0, STEP),
        ({}, 0.5, STEP),
        ({}, 0.0, -1.0),
        ({}, 0.0, float("nan")),
        ({}, 0.0, float("inf")),
    ],
)
def test_a_step_that_cannot_be_is_an_error(fmu: Fmu, inputs: dict[str, float | bool], time: float, length: float) -> None:
    fmu.begin()
    fmu.set(**inputs)
    with pytest.raises(FMICallException):
        fmu.step(time, length)
    assert fmu.get("time") == 0.0
    fmu.set(run=False)
    fmu.step(0.0)
    assert fmu.get("time") == pytest.approx(STEP)
    fmu.fmu.freeInstance()


@pytest.mark.parametrize(("name", "value"), [("supply_voltage", 81.0), ("load_torque", -1.0), ("machine_torque", float("nan")), ("speed_request", 1e9)])
def test_an_input_out_of_range_is_an_error(fmu: Fmu, name: str, value: float) -> None:
    fmu.begin()
    before = fmu.get(name)
    with pytest.raises(FMICallException):
        fmu.set(**{name: value})
    with pytest.raises(FMICallException):
        fmu.fmu.getReal([77]) if fmu.version == 2 else fmu.fmu.getFloat64([77])
    assert fmu.get(name) == before
    fmu.fmu.freeInstance()


@pytest.mark.parametrize("damage", ["token", "file", "missing"])
def test_other_resources_make_no_instance(fmu: Fmu, damage: str) -> None:
    file = Path(fmu.folder) / "resources/drive.json"
    if damage == "token":
        fmu.fmu.guid = "{0}"
    elif damage == "file":
        file.write_text(file.read_text().replace("18.5", "19.5"))
    else:
        file.unlink()
    with pytest.raises(Exception, match="nstantiate"):
        fmu.instantiate()


def test_arguments_are_checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = narx.Bench("ec45-flat-50w-18v")
    for version in (1, "3", True, float("nan"), None):
        with pytest.raises(narx.ParameterError, match=r"version .*: must be 2 or 3"):
            bench.fmu(tmp_path / "drive.fmu", version)  # type: ignore[arg-type]
    with pytest.raises(narx.ParameterError, match="path 3: must be the path of a file"):
        bench.fmu(3)  # type: ignore[arg-type]
    monkeypatch.setattr(narx.fmu, "LIBRARY", "binaries/other.so")
    with pytest.raises(narx.MissingError, match="no library for FMUs"):
        bench.fmu(tmp_path / "drive.fmu")
    assert not list(tmp_path.iterdir())


def test_a_shell_writes_one(tmp_path: Path) -> None:
    path = tmp_path / "pump.fmu"
    done = CliRunner().invoke(app, ["fmu", str(path), "--motor", "bly172s-24v", "--mode", "hall", "--version", "2"])
    assert done.exit_code == 0, done.output
    assert fmpy.read_model_description(str(path)).fmiVersion == "2.0" and validate_fmu(str(path)) == []
