"""Every refusal names the argument, its value and the allowed values."""

import warnings
from collections.abc import Callable
from typing import Any

import pytest

import narx

MOTOR = narx.Motor.preset("bly172s-24v")
FIGURES: dict[str, Any] = {
    "pole_pairs": 4, "resistance": 0.36, "inductance": 2e-4, "torque_constant": 0.036, "inertia": 4.8e-6,
}  # fmt: skip


def motor(**figures: Any) -> narx.Motor:
    return narx.Motor(**FIGURES | figures)


def bench(**options: Any) -> narx.Bench:
    given: dict[str, Any] = {"supply_voltage": 24.0, "mode": "hall"} | options
    return narx.Bench(MOTOR, **given)


REFUSALS: list[tuple[Callable[[], object], str]] = [
    (lambda: motor(pole_pairs=0), "pole_pairs 0: must be a whole number from 1 to 255"),
    (lambda: motor(pole_pairs=2.5), "pole_pairs 2.5: must be a whole number from 1 to 255"),
    (lambda: motor(resistance=0), "resistance 0 ohm: must be a finite number above 0"),
    (lambda: motor(inertia=float("nan")), "inertia NaN kg m2: must be a finite number above 0"),
    (lambda: motor(static_friction=-1), "static_friction -1 N m: must be a finite number, 0 or more"),
    (lambda: motor(back_emf="sine"), 'back_emf "sine": must be one of trapezoidal, sinusoidal'),
    (lambda: motor(rated_current=0), "rated_current 0 A: must be a finite number above 0"),
    (lambda: motor(max_speed=float("inf")), "max_speed inf rpm: must be a finite number above 0"),
    (lambda: MOTOR.replace(max_speed=90_000).commission(24.0), "maximum speed 90000 rpm is outside 500 to 5781 rpm: the supply voltage allows no more"),
    (lambda: narx.Load(inertia=-1), "inertia -1 kg m2: must be a finite number, 0 or more"),
    (lambda: narx.Motor.preset("bly172"), 'there is no preset "bly172"; did you mean "bly172s-24v"'),
    (lambda: MOTOR.commission(12.0), "supply voltage 12 V is outside 18 to 60 V"),
    (lambda: MOTOR.commission(24.0, mode="foc"), 'mode "foc": must be one of hall, sensorless, open-loop'),  # type: ignore[arg-type]
    (lambda: bench(supply_voltage=61.0), "supply voltage 61 V is outside 18 to 60 V"),
    (lambda: bench(mode="foc"), 'mode "foc": must be one of hall, sensorless, open-loop'),
    (lambda: bench(seed=-1), "seed -1: must be a whole number from 0 to 18446744073709551615"),
    (lambda: bench(ambient=float("inf")), "ambient inf degrees Celsius: must be a finite number"),
    (lambda: bench(parameters={"Motor pair pole": 3}), 'there is no parameter "Motor pair pole"; did you mean "Motor'),
    (lambda: bench(parameters={999: 1}), "there is no parameter 999"),
    (lambda: bench(parameters={-1: 1}), "there is no parameter -1"),
    (lambda: bench(parameters={78: 51}), 'parameter 78 "Motor pair poles": 51 is outside 1 to 50'),
    (lambda: bench(parameters={78: "two"}), "parameter 78 \"Motor pair poles\": 'two' is not a whole number from 1 to 50"),
    (lambda: bench(parameters={78: 2.5}), 'parameter 78 "Motor pair poles": 2.5 is not a whole number from 1 to 50'),
    (lambda: bench(parameters={78: True}), 'parameter 78 "Motor pair poles": True is not a whole number from 1 to 50'),
    (lambda: bench(parameters={266: "24"}), "parameter 266 \"Nominal supply voltage\": '24' is not a number from "),
    (lambda: bench().run(-1.0), "seconds -1 s: must be a finite number, 0 or more"),
    (lambda: bench().run(float("nan")), "seconds NaN s: must be a finite number, 0 or more"),
    (lambda: bench().drive.start(70_000), "rpm 70000: must be a whole number from -65535 to 65535"),
    (lambda: bench().drive.start(1500.5), "rpm 1500.5: must be a whole number from -65535 to 65535"),
    (lambda: bench().drive.start(float("nan")), "rpm NaN: must be a whole number from -65535 to 65535"),
    (lambda: bench().drive.start(float("-inf")), "rpm -inf: must be a whole number from -65535 to 65535"),
    (lambda: bench().drive.start(True), "rpm True: must be a whole number from -65535 to 65535"),
    (lambda: bench().drive.start("1500"), "rpm '1500': must be a whole number from -65535 to 65535"),  # type: ignore[arg-type]
    (lambda: bench().drive.set_speed(-1), "rpm -1: must be a whole number from 0 to 65535"),
    (lambda: bench().drive.set_speed(1500.5), "rpm 1500.5: must be a whole number from 0 to 65535"),
    (lambda: bench(parameters={103: 2191}).drive.start(3120), 'speed 3120 rpm is above parameter 103 "Speed setpoint max saturation HES": must be '),
    (lambda: bench(parameters={103: 2191}).drive.start(-3120), "speed -3120 rpm is above parameter 103 "),
    (lambda: bench(parameters={104: 700}).drive.start(699), 'speed 699 rpm is below parameter 104 "Speed setpoint min saturation HES": must be 700 to '),
    (lambda: bench(parameters={101: 2191}, mode="sensorless").drive.set_speed(3120), "speed 3120 rpm is above parameter 101 "),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_refusal(call: Callable[[], object], message: str) -> None:
    with pytest.raises(narx.ParameterError) as caught:
        call()
    assert str(caught.value).startswith(message)
    assert isinstance(caught.value, narx.NarxError) and isinstance(caught.value, ValueError)


def test_open_loop_turns_at_its_own_speed() -> None:
    fixed = bench(mode="open-loop", parameters={"Open-loop speed setpoint": 250})
    with pytest.warns(narx.SpeedWarning, match='speed 300 rpm is not equal to parameter 88 "Open-loop speed setpoint": must be 250 rpm'):
        fixed.drive.start(300)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fixed.drive.start(-250)


def test_a_speed_without_a_start_is_refused() -> None:
    stopped = bench()
    with pytest.raises(narx.RefusedError, match="speed 1500 rpm: the drive is in Initialization; call start\\(1500\\) first"):
        stopped.drive.set_speed(1500)
    stopped.drive.start(1200, wait=False)
    stopped.drive.set_speed(1500)
    assert stopped.run(2.0)["speed"][-1] == pytest.approx(1500, rel=0.02)


def test_a_fault_is_told() -> None:
    # With all hall lines inverted the torque has the wrong direction.
    bad = bench(parameters={"Hall polarity mask": 7})
    bad.drive.start(1500)
    bad.run(1.0)
    assert bad.drive.state is narx.State.FAULT and bad.drive.faults == {"hall_sensors"}
    with pytest.raises(narx.StartError, match="the drive is in Fault: .* \\(hall_sensors\\)") as caught:
        bad.drive.start(1500)
    assert isinstance(caught.value, RuntimeError)


def test_a_mode_that_is_not_enabled_is_refused() -> None:
    with pytest.raises(narx.StartError, match="the drive refused the start: no mode"):
        bench(parameters={"Closed-loop Hall Effect Sensors enable": 0}).drive.start(1500)


def test_parameters_that_do_not_fit_each_other_are_named() -> None:
    low, high = "Speed setpoint min saturation HES", "Speed setpoint max saturation HES"
    with pytest.raises(narx.StartError, match=f'parameter [0-9]+ "({low}|{high})" does not fit the others'):
        bench(parameters={low: 2000, high: 1000}).drive.start(1500)
