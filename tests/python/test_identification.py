"""Tests of the identification of a motor by its drive."""

import math
import tomllib
from pathlib import Path
from typing import Literal

import pytest

import narx

NAME = "ec45-flat-50w-18v"


@pytest.fixture(scope="module")
def found() -> narx.Identified:
    return narx.Bench(NAME, recording=False).drive.identify(8)


def test_a_motor_is_measured_with_stated_uncertainties(found: narx.Identified) -> None:
    truth = narx.Motor.preset(NAME)
    for name, share in {"resistance": 0.03, "inductance": 0.10, "torque_constant": 0.02, "inertia": 0.10}.items():
        figure = getattr(found, name)
        assert figure.value == pytest.approx(getattr(truth, name), rel=share), name
        assert abs(figure.value - getattr(truth, name)) <= figure.uncertainty, name
    assert "torque constant" in str(found) and "mN m/A" in str(found)


def test_the_figures_make_a_motor_that_runs(found: narx.Identified, tmp_path: Path) -> None:
    bench = narx.Bench(found.motor(), 18)
    bench.drive.start(2000)
    bench.run(1.0)
    assert bench.drive.measurements.speed == pytest.approx(2000, rel=0.02)
    found.save(tmp_path / "motor.toml")
    assert tomllib.loads((tmp_path / "motor.toml").read_text())["resistance"] == found.resistance.value
    from_file = narx.Bench(tmp_path / "motor.toml", 18)
    from_file.drive.start(2000)
    from_file.run(1.0)
    assert from_file.digest == bench.digest


@pytest.mark.parametrize(
    ("text", "message"),
    [("pole_pairs = 4", "missing"), ("pole_pairs = ", "Invalid value"), ("torque = 4", "torque"), ("", "missing")],
)
def test_a_motor_file_that_is_none_is_named(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "motor.toml"
    path.write_text(text)
    with pytest.raises(narx.ParameterError, match=rf"motor\.toml: .*{message}"):
        narx.Bench(path)


def test_hall_sensors_are_calibrated_on_request(found: narx.Identified) -> None:
    assert found.halls is None and found.temperature == pytest.approx(25, abs=1)
    drive = narx.Bench(narx.Motor.preset(NAME).replace(hall_offset_deg=12.0), 18.0, recording=False).drive
    stages: list[str] = []
    halls = drive.identify(8, halls=True, progress=stages.append).halls
    assert halls is not None and stages[-2:] == ["calibrating", "restoring"]
    assert halls.offset == pytest.approx(12, abs=3)
    names = ("Hall order", "Hall polarity mask", "Hall effect offset angle")
    assert tuple(drive.parameters[name] for name in names) == (halls.order, halls.polarity, halls.offset)


def test_a_rotor_that_is_held_has_no_motor() -> None:
    held = narx.Bench(NAME, recording=False).drive.identify(8, current=2, turn=False)
    assert held.torque_constant is None and held.resistance.value == pytest.approx(0.447, rel=0.05)
    with pytest.raises(narx.RefusedError, match="not allowed to turn"):
        held.motor()


def test_stages_are_told_and_an_interrupt_leaves_the_drive_as_it_was() -> None:
    bench = narx.Bench(NAME, recording=False)
    bench.drive.wait(1.0)
    before = bench.drive.parameters["Rotor lock duty cycle"]
    stages: list[str] = []

    def interrupt(stage: str) -> None:
        stages.append(stage)
        if stage == "spinning":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bench.drive.identify(8, progress=interrupt)
    assert stages == ["asking", "holding", "spinning"]
    assert bench.drive.parameters["Rotor lock duty cycle"] == before
    assert bench.drive.state is narx.State.STANDBY


def test_a_motor_that_runs_is_left_alone() -> None:
    bench = narx.Bench(NAME, recording=False)
    bench.drive.start(2000)
    with pytest.raises(narx.StartError, match="not in Standby"):
        bench.drive.identify(8)
    bench.run(1.0)
    assert bench.drive.measurements.speed == pytest.approx(2000, rel=0.02)


def test_what_is_wrong_has_a_name() -> None:
    bench = narx.Bench(NAME, recording=False)
    phases: list[Literal["A", "B", "C"]] = ["A", "B", "C"]
    for phase in phases:
        bench.inject("open-phase", phase=phase)
    with pytest.raises(narx.StartError, match="no motor is connected"):
        bench.drive.identify(8)
    with pytest.raises(narx.ParameterError, match="pole_pairs"):
        bench.drive.identify(0)
    with pytest.raises(narx.ParameterError, match="6 A"):
        bench.drive.identify(8, current=7)
    with pytest.raises(narx.ParameterError, match="need a rotor that may turn"):
        bench.drive.identify(8, turn=False, halls=True)


def test_pole_pairs_are_counted_by_marks() -> None:
    """Somebody sees a mark on the bench's shaft pass."""
    bench = narx.Bench(NAME, recording=False)
    stages: list[str] = []
    turns = 0

    def mark() -> bool:
        nonlocal turns
        position = bench.run(1e-4, signals=["position"])["position"][-1]
        before, turns = turns, int(abs(position) / math.tau)
        return turns > before

    found = bench.drive.identify(progress=stages.append, mark=mark)
    assert found.pole_pairs == 8 and stages[:4] == ["asking", "holding", "counting", "spinning"]
    with pytest.raises(narx.ParameterError, match="pole_pairs is missing"):
        bench.drive.identify()
    with pytest.raises(narx.ParameterError, match="need a rotor that may turn"):
        bench.drive.identify(turn=False)
