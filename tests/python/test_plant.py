"""narx.Plant: a motor whose gates the caller sets."""

import math
from typing import Literal, TypeAlias

import pytest

import narx

MOTOR = narx.Motor.preset("bly172s-24v")
Gate: TypeAlias = Literal["off", "high", "low"]
REVERSED: dict[Gate, Gate] = {"off": "off", "high": "low", "low": "high"}


def test_a_blocked_rotors_current_is_that_of_its_winding() -> None:
    plant = narx.Plant(MOTOR, supply_voltage=24.0, on_resistance=1e-6)
    plant.set_blocked(True)
    plant.set_gates("high", "low", "off")
    assert plant.advance(100e-6) == pytest.approx(100e-6)
    expected = 24.0 / MOTOR.resistance * (1 - math.exp(-100e-6 * MOTOR.resistance / MOTOR.inductance))
    assert plant.currents == pytest.approx((expected, -expected, 0.0), rel=0.01)
    assert plant.shunts == (0.0, plant.currents[0], 0.0)
    assert plant.charge == pytest.approx(0.5 * 100e-6 * expected, rel=0.05)
    assert plant.time == pytest.approx(100e-6) and plant.bus_voltage == pytest.approx(24.0, abs=0.5)


def test_it_is_turned_by_its_hall_sensors() -> None:
    plant = narx.Plant(MOTOR, load=narx.Load(viscous=2e-5))
    # Legs by the code of the hall lines: what drives Forward.
    steps: dict[int, tuple[Gate, Gate, Gate]] = {5: ("high", "low", "off"), 1: ("high", "off", "low"), 3: ("off", "high", "low")}
    steps |= {code ^ 7: (REVERSED[a], REVERSED[b], REVERSED[c]) for code, (a, b, c) in steps.items()}
    sectors = 0
    while plant.time < 0.2:
        plant.set_gates(*steps[plant.hall])
        plant.advance(0.01)
        sectors += len(plant.hall_edges)
    assert plant.speed > 1000 and sectors == pytest.approx(plant.angle_deg / 360 * MOTOR.pole_pairs * 6, abs=2)
    plant.set_gates("off", "off", "off")
    speed = plant.speed
    while plant.time < 0.4:
        plant.advance(0.01)
    assert 0 < plant.speed < speed, "it coasts"


def test_it_stops_where_a_current_passes_the_limit() -> None:
    plant = narx.Plant(MOTOR)
    plant.set_blocked(True)
    plant.set_gates("low", "high", "off")
    assert plant.advance(0.001, shunt_limit=5.0) < 0.001
    assert plant.shunts[0] == pytest.approx(5.0, abs=0.02)


def test_load_supply_and_cables_can_change() -> None:
    plant = narx.Plant(MOTOR, speed=1000.0, angle_deg=0.0)
    assert plant.speed == pytest.approx(1000.0) and plant.angle_deg == pytest.approx(0.0)
    plant.set_load(narx.Load(constant=0.2))
    plant.advance(0.001)
    while plant.time < 0.05:
        plant.advance(0.01)
    assert plant.speed < 1000.0
    plant.set_open("AC")
    plant.set_gates("high", "low", "low")
    plant.advance(0.001)
    assert plant.currents == (0.0, 0.0, 0.0)
    plant.set_supply(12.0)
    plant.set_open("")
    plant.advance(0.001)
    assert plant.currents[0] > 0.5 and repr(plant).startswith("<narx.Plant at ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"supply_voltage": 81.0}, "supply_voltage 81 V: must be a number from 0 to 80 V"),
        ({"capacitance": 0.0}, "capacitance 0 F: must be a finite number above 0"),
        ({"on_resistance": -1.0}, "on_resistance -1 ohm: must be"),
        ({"diode_drop": "x"}, "diode_drop 'x': must be"),
        ({"hall_order": 6}, "hall_order 6: must be a whole number from 0 to 5"),
        ({"angle_deg": float("inf")}, "angle_deg inf degrees: must be a finite number"),
        ({"speed": 2e6}, "speed 2000000 rpm: must be"),
    ],
)
def test_bad_arguments_are_named(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(narx.ParameterError, match=message):
        narx.Plant(MOTOR, **arguments)  # type: ignore[arg-type]


def test_bad_calls_are_named() -> None:
    plant = narx.Plant(MOTOR)
    with pytest.raises(narx.ParameterError, match='b "on": must be one of off, high, low'):
        plant.set_gates("off", "on", "off")  # type: ignore[arg-type]
    with pytest.raises(narx.ParameterError, match="seconds 2 s: must be a number from 0 to 1 s"):
        plant.advance(2.0)
    with pytest.raises(narx.ParameterError, match="phases 'D': must be of A, B and C"):
        plant.set_open("AD")
    with pytest.raises(narx.ParameterError, match="blocked 1: must be True or False"):
        plant.set_blocked(1)  # type: ignore[arg-type]
