"""Injected failures of the bench, and the reactions of the drive."""

import inspect
from typing import Any

import pytest

import narx

BREAKS: list[tuple[str, dict[str, Any], set[str]]] = [
    ("supply", {"value": 66.0}, {"over_voltage"}),
    ("supply", {"value": 8.0}, {"under_voltage"}),
    ("driver", {"phase": "B"}, {"legs_driver"}),
    ("hall-supply-lost", {}, {"hall_sensors"}),
    ("hall_stuck", {"phase": "A", "high": True}, {"hall_sensors"}),
    ("break", {}, {"emergency_shutdown"}),
]


@pytest.mark.parametrize(("fault", "options", "bits"), BREAKS, ids=[f"{name}{options}" for name, options, _ in BREAKS])
def test_a_fault_is_told_and_mended(
    bench: narx.Bench, fault: str, options: dict[str, Any], bits: set[str]
) -> None:
    bench.drive.start(3000)
    bench.run(0.3)
    bench.inject(fault, **options)
    trace = bench.run(1.0)
    assert trace["state"][-1] == narx.State.FAULT and trace["duty"][-1] == 0.0
    assert bits <= bench.drive.faults, bench.drive.faults
    bench.clear(fault, **({"phase": options["phase"]} if "phase" in options else {}))
    bench.run(2.0)
    bench.drive.stop()
    bench.run(0.3)
    bench.drive.start(2000)
    assert bench.drive.state == narx.State.HALL_CLOSED_LOOP


def test_everything_is_mended_at_once(bench: narx.Bench) -> None:
    bench.inject("hall-supply-lost")
    bench.inject("break")
    bench.clear()
    bench.drive.start(2000)
    assert bench.drive.state == narx.State.HALL_CLOSED_LOOP


@pytest.mark.parametrize(
    ("fault", "options", "message"),
    [
        ("rotor", {}, 'fault "rotor": unknown; one of .*blocked-rotor'),
        ("supply", {}, 'fault "supply": needs a value: must be a number from 0 to 80 V'),
        ("supply", {"value": 81.0}, 'fault "supply": value 81: must be a number from 0 to 80 V'),
        ("leak", {"value": float("nan")}, 'fault "leak": value NaN'),
        ("driver", {}, 'fault "driver": needs a phase'),
        ("driver", {"phase": "D"}, 'phase "D": must be one of A, B, C'),
    ],
)
def test_what_cannot_break(bench: narx.Bench, fault: str, options: dict[str, Any], message: str) -> None:
    with pytest.raises(narx.ParameterError, match=message):
        bench.inject(fault, **options)


def test_load_and_inputs_can_change(bench: narx.Bench) -> None:
    bench.drive.start(2000)
    bench.run(1.0)
    before = bench.run(0.2)["bus_current"].mean()
    bench.set_load(narx.Load(constant=0.03))
    bench.run(0.5)
    assert bench.run(0.2)["bus_current"].mean() > before + 0.1
    bench.set_input("accel_x", 0.5)
    bench.run(0.5)
    assert bench.drive.measurements["Accel X"] == pytest.approx(0.5, abs=0.01)
    assert "rail14_v" in bench.inputs and "supply" in bench.faults
    with pytest.raises(narx.ParameterError, match="AccelX takes -2 to 2 g"):
        bench.set_input("accel_x", 3.0)
    with pytest.raises(narx.ParameterError, match='input "accel": must be one of asi, '):
        bench.set_input("accel", 0.0)


def test_halls_are_calibrated_where_they_stand(motor: narx.Motor) -> None:
    figures = {name: getattr(motor, name) for name in inspect.signature(narx.Motor).parameters}
    bench = narx.Bench(narx.Motor(**figures | {"hall_offset_deg": 20.0}), supply_voltage=18.0, mode="hall")
    drive = bench.drive
    bench.inject("hall-swapped", phase="A")
    drive.calibrate_hall(run=True)
    drive.start(2000)
    assert bench.run(1.0)["speed"][-1] == pytest.approx(2000, rel=0.01)
    assert drive.parameters["Select control sequence for standard motor"] == 0
    assert drive.parameters["Hall effect offset angle"] == pytest.approx(20.0, abs=1.0)
    assert drive.parameters["Hall order"] != 0
    with pytest.raises(narx.RefusedError, match="not in this state of the drive"):
        drive.calibrate_hall(run=True)
    drive.stop()
    drive.wait(1.0)
    bench.inject("hall-supply-lost")
    with pytest.raises(narx.StartError, match="the hall calibration failed: the drive is in Standby"):
        drive.calibrate_hall(run=True)
    bench.inject("break")
    drive.wait(0.1)
    with pytest.raises(narx.RefusedError, match="not in this state of the drive"):
        drive.calibrate_hall(run=True)
    # The earlier result stays valid, and the next start works as usual.
    bench.clear("hall-supply-lost")
    bench.clear("break")
    drive.wait(1.0)
    drive.stop()
    drive.wait(0.3)
    drive.start(1000)
    assert bench.run(0.1)["state"][-1] == narx.State.HALL_CLOSED_LOOP
