"""Experiments: each is one call, leaves its bench as it is, and its figures follow what is changed."""

from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
import pytest

import narx
from narx import experiments
from narx.experiments import Result


@pytest.fixture
def running() -> narx.Bench:
    """A motor at 2000 rpm under some load."""
    bench = narx.Bench("ec45-flat-50w-18v", load=narx.Load(constant=0.02), mode="hall")
    bench.drive.start(2000)
    bench.run(1.0)
    return bench


def test_a_map_has_every_point_and_its_efficiency(tmp_path: Path) -> None:
    found = experiments.torque_speed_map("ec45-flat-50w-18v", speeds=[1000, 3000], torques=[0.0, 0.05, 0.5])
    assert len(found) == 6 and found["setpoint"].tolist() == [1000] * 3 + [3000] * 3
    held = found["outcome"] == "running"
    assert held.tolist() == [True, True, False] * 2
    assert (found["efficiency"] < found["efficiency_bus"])[held & (found["load"] > 0)].all()
    power = 0.05 * 3000 * np.pi / 30
    assert found["load_power"][4] == pytest.approx(power, rel=0.01)
    assert found["efficiency"][4] == pytest.approx(power / found["supply_power"][4], rel=0.01)
    assert 0.7 < found.figures["best_efficiency"] < 0.9 and found.figures["best_speed"] == pytest.approx(3000, rel=0.01)
    assert found.figures["best_torque"] == 0.05 and found.units["load"] == "N m"
    # A motor of twice the resistance loses more.
    worse = experiments.torque_speed_map(narx.Motor.preset("ec45-flat-50w-18v").replace(resistance=1.6), 18.0, [1000], [0.05])
    assert worse["efficiency"][0] < found["efficiency"][1] - 0.02
    with pytest.raises(narx.ParameterError, match="speed 9000 rpm is above parameter 103"):
        experiments.torque_speed_map("ec45-flat-50w-18v", speeds=[9000], torques=[0.05])
    found.save(str(tmp_path / "map.csv"))
    assert len(pd.read_csv(tmp_path / "map.csv")) == len(found.to_pandas()) == 6
    assert len(experiments.torque_speed_map("ec45-flat-50w-18v", speeds=2, torques=2)) == 4
    with pytest.raises(narx.ParameterError, match="speeds 0: must be a whole number from 1"):
        experiments.torque_speed_map("ec45-flat-50w-18v", speeds=0)


def test_a_step_has_its_figures(running: narx.Bench) -> None:
    found = experiments.step_response(running, 2500)
    figures = found.figures
    assert 0.02 < figures["rise_time"] < figures["settling_time"] < 0.5 and abs(figures["error"]) < 5
    assert found["time"][0] == 0 and found["speed"][0] == pytest.approx(2000, abs=30) and found["speed"][-1] == pytest.approx(2500, abs=30)
    slow = running.copy()
    slow.drive.parameters["Speed setpoint rate"] = 1000
    assert experiments.step_response(slow, 2500).figures["rise_time"] > 3 * figures["rise_time"]
    assert np.isnan(experiments.step_response(slow, 2500, seconds=0.02).figures["settling_time"])
    turned = experiments.step_response(running, -1000, 2.0)
    assert turned["speed"][-1] == pytest.approx(-1000, abs=30)
    with pytest.raises(narx.ParameterError, match="speed 60000 rpm is above"):
        experiments.step_response(running, 60_000)


def test_a_load_step_has_its_figures(running: narx.Bench) -> None:
    small, large = (experiments.load_step(running, load).figures for load in (0.03, 0.06))
    assert 2 * small["dip"] < large["dip"] < 8 * small["dip"] and large["peak_current"] > small["peak_current"]
    assert 0 < large["dip_time"] < large["recovery_time"] < 0.5 and abs(large["error"]) < 5
    assert np.isnan(experiments.load_step(running, 0.5).figures["recovery_time"])


def test_the_loop_is_measured_by_sines(running: narx.Bench) -> None:
    frequencies = np.geomspace(1.5, 15.0, 6)
    found = experiments.frequency_response(running, frequencies)
    assert found["frequency"] == pytest.approx(frequencies) and (np.diff(found["gain"]) < 0).all()
    assert 2.0 < found.figures["crossover"] < 8.0 and 45 < found.figures["phase_margin"] < 110
    assert found.figures["bandwidth"] > found.figures["crossover"]
    # The loop is closed over the measured speed, which is late: at low frequencies it is the true one.
    closed = found["loop_gain"] * np.exp(1j * np.radians(found["loop_phase"]))
    assert np.abs(closed / (1 + closed))[:2] == pytest.approx(found["gain"][:2], rel=0.05)
    # Twice the controller's gain is twice the gain of the loop.
    faster = running.copy()
    for name in ("Speed Kp coefficient HES", "Speed Ki coefficient HES"):
        faster.drive.parameters[name] = 2 * faster.drive.parameters[name]
    faster.run(0.5)
    twice = experiments.frequency_response(faster, frequencies[:3])
    assert twice["loop_gain"] / found["loop_gain"][:3] == pytest.approx(2.0, rel=0.15)
    for arguments, message in [((running, [0.0]), "frequency 0 Hz: must be a number from 0.1 to 100 Hz"), ((running, [1.0], 0.5), "amplitude 0.5: must be"), ((running, []), "frequencies: must have a value")]:
        with pytest.raises(narx.ParameterError, match=message):
            experiments.frequency_response(*arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize(("name", "mode"), [("ec45-flat-50w-18v", "hall"), ("bly172s-24v", "sensorless")])
@pytest.mark.parametrize(("speed_min", "bandwidth"), [(500.0, None), (1000.0, None), (1000.0, 3.0)])
def test_a_loop_is_tuned_to_a_bandwidth(name: str, mode: Literal["hall", "sensorless"], speed_min: float, bandwidth: float | None) -> None:
    loop = narx.Motor.preset(name).speed_loop(speed_min, bandwidth)
    bench = narx.Bench(name, mode=mode, parameters=loop.parameters, recording=False)
    bench.drive.start(int(speed_min))
    bench.run(1.5)
    found = experiments.frequency_response(bench, loop.bandwidth * np.geomspace(0.6, 1.8, 5))
    assert found.figures["crossover"] == pytest.approx(loop.bandwidth, rel=0.2)
    assert found.figures["phase_margin"] == pytest.approx(loop.phase_margin, abs=12.0)
    assert loop.bandwidth == (bandwidth or pytest.approx(loop.bandwidth)) and loop.phase_margin > 59.9


def test_a_loop_that_cannot_be_is_refused() -> None:
    motor = narx.Motor.preset("bly172s-24v")
    most = motor.speed_loop(500).bandwidth
    for arguments, message in [
        ((500, 2 * most), rf"bandwidth .* Hz: must be greater than 0, and at most {most:.2f} Hz where set-points begin at 500 rpm"),
        ((500, 0.0), "bandwidth 0 Hz: must be greater than 0"),
        ((0, None), "slowest set-point 0 rpm: must be greater than 0"),
        ((float("nan"), None), "speed_min"),
    ]:
        with pytest.raises(narx.ParameterError, match=message):
            motor.speed_loop(*arguments)


def test_a_dip_of_the_supply(running: narx.Bench) -> None:
    found = experiments.brown_out(running, [10.0, 17.0], [0.005, 0.1])
    assert list(zip(found["voltage"], found["duration"], strict=True)) == [(10, 0.005), (10, 0.1), (17, 0.005), (17, 0.1)]
    assert found["outcome"].tolist() == ["fault", "fault", "running", "running"] and found.figures["survived"] == 0.5
    assert (found["bus_voltage_min"][:2] < 16).all() and (found["recovery_time"][2:] < 0.1).all() and np.isnan(found["recovery_time"][:2]).all()
    assert "under" in found["faults"][0] and found["faults"][2] == ""


def test_derating_by_temperature() -> None:
    # A fan: less torque turns it more slowly, where a constant load would stall.
    bench = narx.Bench("ec45-flat-50w-18v", load=narx.Load(quadratic=2.3e-6), mode="hall", parameters={"Over-temperature warning threshold": 60})
    bench.drive.start(2000)
    bench.run(1.0)
    found = experiments.derating(bench, [200.0, 40.0, 160.0], seconds=2.0)
    assert found["ambient"].tolist() == [40, 160, 200] and found["outcome"].tolist() == ["running", "limited", "fault"]
    assert found.figures == {"derates_from": 160, "faults_from": 200} and found["limited"][0] == 0 and "over_temperature" in found["faults"][2]


def test_a_stall_and_a_restart(running: narx.Bench) -> None:
    found = experiments.stall(running, [0.02, 1.0])
    assert np.isnan(found["detection_time"][0]) and 0.3 < found["detection_time"][1] < 1.0
    assert found["faults"].tolist() == ["", "hall_sensors"] and found["outcome"].tolist() == ["running", "running"]
    assert (found["peak_current"] > 5).all() and found["restart_time"][1] > found["restart_time"][0] > 0
    assert found.figures == {"restarted": 1.0}


CALLS: list[Callable[[narx.Bench], Result]] = [
    lambda bench: experiments.step_response(bench, 2200, 0.3),
    lambda bench: experiments.load_step(bench, 0.03, 0.3),
    lambda bench: experiments.frequency_response(bench, [5.0, 10.0]),
    lambda bench: experiments.brown_out(bench, [17.0], [0.01], recovery=0.2),
    lambda bench: experiments.derating(bench, [60.0], 0.2),
    lambda bench: experiments.stall(bench, [0.01], recovery=0.2),
]


@pytest.mark.parametrize("call", CALLS)
def test_it_leaves_its_bench_draws_and_gives_the_same_again(running: narx.Bench, call: Callable[[narx.Bench], Result], tmp_path: Path) -> None:
    time, digest = running.time, running.digest
    found, again = call(running), call(running)
    assert (running.time, running.digest) == (time, digest)
    assert all(np.array_equal(found[name], again[name], equal_nan=found[name].dtype.kind == "f") for name in found)
    found.plot().savefig(tmp_path / "figure.png")
    assert found._repr_html_().startswith("<p>narx.experiments.Result") and found._ipython_key_completions_() == list(found)
    with pytest.raises(narx.SignalError, match='there is no column "sped"'):
        found["sped"]
    standing = narx.Bench("ec45-flat-50w-18v", mode="hall")
    with pytest.raises(narx.RefusedError, match="the motor does not run: start it"):
        call(standing)
