"""Every refusal names the argument, its value and the allowed values."""

import warnings
from collections.abc import Callable
from pathlib import Path
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
    (lambda: motor(static_friction=-1), "static_friction -1 N m: must be a number from 0 to 1000 N m"),
    (lambda: motor(back_emf="sine"), 'back_emf "sine": must be one of trapezoidal, sinusoidal'),
    (lambda: motor(rated_current=0), "rated_current 0 A: must be a finite number above 0"),
    (lambda: motor(max_speed=float("inf")), "max_speed inf rpm: must be a finite number above 0"),
    (lambda: MOTOR.replace(max_speed=90_000).commission(24.0), "maximum speed 90000 rpm is outside 500 to 5781 rpm: the supply voltage allows no more"),
    (lambda: narx.Load(inertia=-1), "inertia -1 kg m2: must be a number from 0 to 1000 kg m2"),
    (lambda: narx.Load(constant=1e308), "constant 1e308 N m: must be a number from 0 to 1000 N m"),
    (lambda: narx.Motor.preset("bly172"), 'there is no preset "bly172"; did you mean "bly172s-24v"'),
    (lambda: MOTOR.commission(12.0), "supply voltage 12 V is outside 18 to 60 V"),
    (lambda: MOTOR.commission(24.0, mode="foc"), 'mode "foc": must be one of hall, sensorless, open-loop'),  # type: ignore[arg-type]
    (lambda: bench(supply_voltage=61.0), "supply voltage 61 V is outside 18 to 60 V"),
    (lambda: bench(mode="foc"), 'mode "foc": must be one of hall, sensorless, open-loop'),
    (lambda: bench(seed=-1), "seed -1: must be a whole number from 0 to 18446744073709551615"),
    (lambda: bench(ambient=float("inf")), "ambient inf degrees Celsius: must be a number from -55 to 250 degrees Celsius"),
    (lambda: bench(ambient=1e8), "ambient 100000000 degrees Celsius: must be a number from -55 to 250"),
    (lambda: bench(ambient=-400), "ambient -400 degrees Celsius: must be a number from -55 to 250"),
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


BENCH = bench()
BENCH.add_tx_driver(2)
TX = narx.TxDriver(BENCH, 2)

NUMBERS: list[tuple[str, str, Callable[[Any], object]]] = [
    # Name of the number, the allowed values, and the call that takes it.
    ("seconds", "a finite number, 0 or more", lambda value: BENCH.drive.wait(value)),
    ("timeout", "a finite number, 0 or more", lambda value: BENCH.drive.wait_for(lambda: True, value)),
    ("timeout", "a finite number, 0 or more", lambda value: narx.connect("narx", "errors", timeout=value)),
    ("timeout", "a finite number, 0 or more", lambda value: BENCH.drive.scope.wait(value)),
    ("seconds", "a finite number, 0 or more", lambda value: BENCH.run(value)),
    ("seconds", "a finite number, 0 or more", lambda value: TX.wait(value)),
    ("timeout", "a finite number, 0 or more", lambda value: TX.wait_for(lambda: True, value)),
    ("seconds", "a finite number, 0 or more", lambda value: TX.record(value)),
    ("period", "a number from 0.0001 to 3600", lambda value: TX.record(0.0, value)),
    ("timeout", "a number from 0.003 to 10", lambda value: narx.TxDriver(BENCH, 2, timeout=value)),
    ("node_id", "a whole number from 1 to 127", lambda value: narx.TxDriver(BENCH, value)),
    ("channels", "1 or 2", lambda value: BENCH.add_tx_driver(9, channels=value)),
    ("encoder", "a whole number from 1 to 65535", lambda value: BENCH.add_tx_driver(9, encoder=value)),
    ("period", "a number from 0.001 to 3600", lambda value: BENCH.drive.log.configure(["HV Voltage"], period=value)),
    ("first", "a whole number, 0 or more", lambda value: BENCH.drive.log.download(first=value)),
    ("rpm", "a whole number from -65535 to 65535", lambda value: BENCH.drive.start(2.5 if value == -1 else value)),
    ("rpm", "a whole number from 0 to 65535", lambda value: BENCH.drive.set_speed(value)),
    ("samples", "a whole number from 0 to 65535", lambda value: BENCH.drive.scope.arm(["Duty"], samples=value)),
    ("seed", "a whole number from 0 to 18446744073709551615", lambda value: bench(seed=value)),
    ("pwm_rate", "a whole number from 8000 to 50000 Hz", lambda value: bench(pwm_rate=value)),
    ("resistance", "a finite number above 0", lambda value: motor(resistance=value)),
    ("pole_pairs", "a whole number from 1 to 255", lambda value: motor(pole_pairs=value)),
    ("until", "a whole number from 0 to 18446744073709551615", lambda value: narx.replay(BENCH.run(0.0).recording(), value)),
    ("samples", "a whole number, 1 or more", lambda value: narx.sweep(abs, grid={"rpm": 1}, samples=value)),  # type: ignore[arg-type]
    ("chunk", "a whole number, 1 or more", lambda value: narx.sweep(abs, grid={"rpm": 1}, chunk=value)),  # type: ignore[arg-type]
    ("channels", "1 or 2", lambda value: narx.eds(value)),
    ("step_rate", "a whole number from 1 to 1000000", lambda value: narx.blocks.Pi(1.0, 1.0, value, 0.0, 1.0)),
    ("code", "a whole number from 0 to 7", lambda value: narx.blocks.Hall().step(value)),
]
ODD: list[Any] = [float("nan"), float("-inf"), -1, True, "1", "\N{ARABIC-INDIC DIGIT EIGHT}", b"1", {}, [1], 10**400, 1j]


@pytest.mark.parametrize("value", ODD, ids=lambda value: repr(value)[:20])
@pytest.mark.parametrize(("name", "allowed", "call"), NUMBERS, ids=[f"{place} {name}" for place, (name, _, _) in enumerate(NUMBERS)])
def test_no_number_is_taken_that_is_none(name: str, allowed: str, call: Callable[[Any], object], value: Any) -> None:
    with pytest.raises(narx.ParameterError, match=f"^{name} .*: must be {allowed}"):
        call(value)


WORDS: list[tuple[Callable[[Any], object], str]] = [
    (lambda value: narx.Bench(value), "motor 5: must be a narx.Motor, the name of a preset, or a file of figures (.toml)"),
    (lambda value: bench(load=value), "load 5: must be a narx.Load"),
    (lambda value: bench(mode=value), "mode 5: must be one of hall, sensorless, open-loop"),
    (lambda value: bench(parameters=value), "parameters 5: must be a mapping of names to values"),
    (lambda value: narx.coefficients(value), "parameters 5: must be a mapping of names to values"),
    (lambda value: narx.Motor.preset(value), "there is no preset 5; there are ec45"),
    (lambda value: BENCH.inject(value), 'fault "5": '),
    (lambda value: BENCH.inject("hall-stuck", phase=value), "phase 5: must be one of A, B, C"),
    (lambda value: BENCH.set_input(value, 1.0), "input 5: must be one of asi"),
    (lambda value: BENCH.copy().set_load([value]), "load [5]: must be a narx.Load"),  # type: ignore[arg-type]
    (lambda value: narx.read_log(value), "path 5: must be the path of a file"),
    (lambda value: narx.replay(value), "recording 5: must be the path of a file"),
    (lambda value: BENCH.drive.parameters.save(value), "path 5: must be the path of a file"),
    (lambda value: BENCH.drive.parameters.load_file(value), "path 5: must be the path of a file"),
    (lambda value: BENCH.drive.update(value), "path 5: must be the path of a file"),
    (lambda value: BENCH.run(0.0).save(value), "path 5: must be the path of a file"),
    (lambda value: BENCH.run(0.0).save(f"run{value}\0.csv"), "path 'run5\\x00.csv': must be the path of a file, without a zero byte"),
    (lambda value: BENCH.drive.set_outputs(dsio1=value), "dsio1 5: must be True or False"),
    (lambda value: BENCH.drive.parameters.load(value), "values 5: must be a mapping of names to values"),
    (lambda value: BENCH.drive.scope.arm(value), "signals 5: must be a list"),
    (lambda value: BENCH.drive.log.configure(value, 1.0), "values 5: must be a list"),
    (lambda value: narx.read_log("none.log", encoders=value), "encoders 5: must be a list"),
    (lambda value: narx.decode(value), "identifier 0x5: its data is missing"),
    (lambda value: narx.decode(0x123, value), "identifier 0x123: its data 5 must be bytes"),
    (lambda value: narx.decode(str(value)), "message '5': must be a can.Message"),  # type: ignore[arg-type]
    (lambda value: narx.sweep(value), "grid 5: must be a list"),
    (lambda value: TX.parameters[float(value)], "there is no object 5.0"),  # type: ignore[index]
]


@pytest.mark.parametrize(("call", "message"), WORDS, ids=[message for _, message in WORDS])
def test_an_argument_of_another_kind_is_named(call: Callable[[Any], object], message: str) -> None:
    with pytest.raises(narx.ParameterError) as caught:
        call(5)
    assert str(caught.value).startswith(message)


def test_names_of_another_kind_are_no_names() -> None:
    for look in (lambda: BENCH.drive.measurements[5], lambda: BENCH.run(0.0)[[1]], lambda: BENCH.drive.scope.arm([5])):  # type: ignore[index,list-item]
        with pytest.raises(narx.SignalError, match="there is no .*signal|there is no measurement"):
            look()


def test_a_parameter_file_that_is_too_deep_is_named(tmp_path: Path) -> None:
    file = tmp_path / "deep.json"
    file.write_text("[" * 100_000)
    with pytest.raises(narx.ParameterError, match=f'file "{file}" is not a parameter file'):
        BENCH.drive.parameters.load_file(file)


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
    stopped.drive.stop()
    with pytest.raises(narx.RefusedError, match="speed 1200 rpm: the drive was stopped and is in Hall closed loop; call start"):
        stopped.drive.set_speed(1200)


def test_a_speed_for_a_drive_that_has_refused_its_start_is_told() -> None:
    refusing = bench(parameters={"Closed-loop Hall Effect Sensors enable": 0})
    refusing.drive.start(1500, wait=False)
    refusing.run(1.0)
    with pytest.warns(narx.NarxWarning, match="speed 1200 rpm: the drive is in Standby: it has not accepted the start yet, or has refused it"):
        refusing.drive.set_speed(1200)


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
