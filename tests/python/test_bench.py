"""The bench: motors reach their speed, and the same call gives the same bits."""

import _thread
import importlib.metadata
import math
import mmap
import signal
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import pytest

import narx


@pytest.mark.parametrize("name", narx.Motor.presets())
def test_presets_reach_their_speed(name: str) -> None:
    motor = narx.Motor.preset(name)
    bench = narx.Bench(motor, supply_voltage=48.0, load=narx.Load(viscous=1e-7), mode="hall")
    limits = motor.commission(48.0, mode="hall")
    low, high = (limits[f"Speed setpoint {end} saturation HES"] for end in ("min", "max"))
    rpm = int(low + 0.3 * (high - low))
    bench.drive.start(rpm)
    assert bench.drive.state == narx.State.HALL_CLOSED_LOOP and not bench.drive.faults
    bench.run(2.0)
    trace = bench.run(0.2)
    assert trace["speed"].mean() == pytest.approx(rpm, rel=0.01)
    replay = narx.replay(trace.recording())
    assert replay.identical and replay.ticks == round(bench.time * 10_000)


def test_rows_are_those_of_the_run(bench: narx.Bench) -> None:
    assert bench.time == 0.0 and bench.drive.state is narx.State.INITIALIZATION
    bench.drive.start(2000)
    start = bench.time
    assert 0.5 < start < 2.0
    first, second = bench.run(0.3), bench.run(0.2)
    assert (len(first), len(second)) == (3000, 2000)
    assert first.time[0] == pytest.approx(start + 1e-4) and second.time[0] == pytest.approx(start + 0.3001)
    assert np.diff(np.concatenate([first.time, second.time])) == pytest.approx(1e-4)
    assert bench.time == pytest.approx(start + 0.5) == second.time[-1]
    assert len(bench.run(0.0)) == 0


def test_a_replay_has_the_rows_of_the_bench(bench: narx.Bench, motor: narx.Motor) -> None:
    bench.drive.start(-2500, wait=False)
    trace = bench.run(1.5)
    assert trace["speed"][-1] == pytest.approx(-2500, rel=0.02)
    replay = narx.replay(trace.recording())
    assert len(replay) == len(trace) == 15_000
    shared = [name for name in replay if name in trace]
    assert {"time", "state", "duty", "hall", "step", "limiter", "crossing", "faults"} <= set(shared)
    for name in shared:
        same = np.allclose(replay[name], trace[name], rtol=1e-12, atol=0.0)
        # The bench shows the faults of the last report; a replay shows those of the tick.
        assert same or name == "faults", name
        assert replay.signals[name] == trace.signals[name]
    # Other signals of the bench are true values. The replay has measured values, reported once a millisecond.
    motor_turns = slice(12_000, None)
    assert np.abs(replay["bus_voltage_measured"] - trace["bus_voltage"])[motor_turns].max() < 0.3
    assert np.abs(replay["voltage_a_measured"] - trace["voltage_a"])[motor_turns].mean() < 3.0
    rpm = replay["electrical_speed_hall"] * 60.0 / motor.pole_pairs
    assert np.abs(rpm - trace["speed_estimated"])[motor_turns].max() < 5.0


def test_same_arguments_same_bits(motor: narx.Motor) -> None:
    def digest(seed: int) -> int:
        bench = narx.Bench(motor, supply_voltage=24.0, mode="hall", seed=seed)
        bench.drive.start(1500)
        return narx.replay(bench.run(0.2).recording()).digest

    assert digest(5) == digest(5) != digest(6)


def state(bench: narx.Bench) -> narx.State | None:
    return bench.drive.state


def test_commands(bench: narx.Bench) -> None:
    bench.drive.start(2000)
    bench.drive.set_speed(1500)
    assert bench.run(1.5)["speed"][-1] == pytest.approx(1500, rel=0.02)
    bench.drive.start(-1200)
    assert state(bench) is narx.State.HALL_CLOSED_LOOP
    assert bench.run(1.5)["speed"][-1] == pytest.approx(-1200, rel=0.02)
    bench.drive.stop()
    bench.run(0.1)
    assert state(bench) is narx.State.STANDBY
    assert bench.run(0.1)["duty"].max() == 0.0
    bench.drive.start(1000)
    assert bench.run(1.0)["speed"][-1] == pytest.approx(1000, rel=0.02)


def test_open_loop_returns_in_open_loop(motor: narx.Motor) -> None:
    bench = narx.Bench(motor, supply_voltage=24.0, mode="open-loop")
    bench.drive.start(bench.drive.parameters["Open-loop speed setpoint"])
    assert bench.drive.state is narx.State.OPEN_LOOP


def test_load_takes_torque(motor: narx.Motor) -> None:
    def current(load: narx.Load | None) -> float:
        bench = narx.Bench(motor, supply_voltage=24.0, load=load, mode="hall")
        bench.drive.start(2000)
        bench.run(1.0)
        return float(bench.run(0.1)["bus_current"].mean())

    assert current(narx.Load(constant=0.03)) > current(None) + 0.1


def test_explicit_parameters_win(motor: narx.Motor) -> None:
    name = "Speed setpoint max saturation HES"
    number = 103
    choices: list[Mapping[str | int, float]] = [{name: 1200}, {name.lower(): 1200.0}, {number: 1200}]
    for parameters in choices:
        bench = narx.Bench(motor, supply_voltage=24.0, mode="hall", parameters=parameters)
        with pytest.raises(narx.ParameterError, match=f'speed 3000 rpm is above parameter 103 "{name}": must be [0-9]+ to 1200 rpm'):
            bench.drive.start(3000)
        bench.drive.start(1200)
        assert bench.run(2.0)["speed"][-1] == pytest.approx(1200, rel=0.02)


def test_commissioned_parameters_are_those_of_the_bench(motor: narx.Motor) -> None:
    parameters = motor.commission(24.0, mode="hall")
    assert parameters["Motor pair poles"] == 8 and isinstance(parameters["Motor pair poles"], int)
    assert parameters["Nominal supply voltage"] == 24.0
    traces = []
    for given in (None, parameters):
        bench = narx.Bench(motor, supply_voltage=24.0, mode="hall", parameters=given)
        bench.drive.start(1500)
        traces.append(bench.run(0.2))
    assert traces[0].recording() == traces[1].recording()


def test_speed_and_load_of_a_motor_without_a_rated_current() -> None:
    # Data of a maxon EC 90 flat with the winding for 48 V.
    motor = narx.Motor(12, 2.3, 2.5e-3, 0.217, 3.06e-4, static_friction=0.01, viscous_friction=2e-5)
    no_load = 24.0 / 0.217 * 60.0 / (2.0 * math.pi)
    able = motor.operating_range(24.0, mode="hall")
    assert 0.8 * no_load < able.speed_max < no_load and able.speed_limit == "voltage"
    assert able.speed[0] == able.speed_min and able.speed[-1] == pytest.approx(able.speed_max)
    assert len(able.speed) == len(able.torque) == len(able.torque_limit)
    # 6 W of heat in the winding set the rated current of a motor that names none. The torque falls with the
    # speed.
    assert able.rated_current == pytest.approx(math.sqrt(6.0 / 2.3)) and able.torque_limit[0] == "rated current"
    assert able.torque[0] == pytest.approx(0.217 * able.rated_current - 0.01, rel=0.01)
    assert able.torque == sorted(able.torque, reverse=True) and able.torque_limit[-1] == "voltage"
    bench = narx.Bench(motor, supply_voltage=24.0, mode="hall")
    bench.drive.start(round(0.8 * no_load))
    bench.run(2.0)
    assert bench.run(0.5)["speed"].mean() == pytest.approx(0.8 * no_load, rel=0.01)

    # A given rated current must be reached at every speed, which lowers the speed limit, unless a maximum
    # speed is given.
    rated = motor.replace(rated_current=4.0)
    assert rated.operating_range(24.0, mode="hall").speed_max < 0.6 * no_load
    asked = rated.replace(max_speed=800.0).operating_range(24.0, mode="hall")
    assert (asked.speed_max, asked.speed_limit, asked.rated_current) == (800.0, "asked", 4.0)
    with pytest.raises(narx.ParameterError, match=r"maximum speed 2000 rpm is outside 167 to 9\d\d rpm: the supply"):
        rated.replace(max_speed=2000.0).commission(24.0, mode="hall")


def test_notes_name_what_limits() -> None:
    motor = narx.Motor.preset("ec4pole30-200w-36v")
    assert any("ripple" in note for note in narx.Bench(motor, supply_voltage=36.0, mode="hall").notes)


def test_what_is_not_kept_changes_no_bit(motor: narx.Motor) -> None:
    def bench(recording: bool) -> narx.Bench:
        bench = narx.Bench(motor, supply_voltage=24.0, mode="hall", recording=recording)
        bench.drive.start(1500)
        return bench

    recorded, bare = bench(True), bench(False)
    whole, nothing = recorded.run(0.3), bare.run(0.3, trace=False)
    assert (len(whole), len(nothing)) == (3000, 0) and nothing.signals == whole.signals
    assert bare.digest == 0 and nothing.recording() == b"" and recorded.digest == narx.replay(whole.recording()).digest
    # The drive itself is the same without recorded rows: the next run proves it.
    assert recorded.run(0.1, trace=False).recording() != whole.recording()
    bare.run(0.1)
    first, second = recorded.run(0.1), bare.run(0.1)
    assert all(np.array_equal(first[name], second[name]) for name in first) and len(first) == 1000


def test_other_threads_run_while_the_bench_does(bench: narx.Bench) -> None:
    """A thread that only counts makes progress while this one is in `run` and `replay`."""
    bench.drive.start(2000)
    counts = 0
    over = threading.Event()

    def count() -> None:
        nonlocal counts
        while not over.is_set():
            counts += 1
            time.sleep(0.0005)

    thread = threading.Thread(target=count)
    thread.start()
    try:
        before = counts
        trace = bench.run(10.0)
        ran = counts - before
        recording = trace.recording()
        before = counts
        narx.replay(recording)
        replayed = counts - before
    finally:
        over.set()
        thread.join()
    assert ran >= 20 and replayed >= 5, (ran, replayed)


def test_ctrl_c_ends_a_long_run(bench: narx.Bench) -> None:
    # A process in the background inherits an ignored SIGINT; then nothing could interrupt the run.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.2, _thread.interrupt_main).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            bench.run(600.0)
    finally:
        signal.signal(signal.SIGINT, before)
    # The bench continues at the time at which it was interrupted.
    stopped = bench.time
    assert stopped < 600.0
    assert len(bench.run(0.1)) == 1000 and bench.time == pytest.approx(stopped + 0.1)


@pytest.mark.parametrize("mode", ["hall", "sensorless"])
@pytest.mark.parametrize("pwm_rate", [8_000, 16_000, 20_000])
def test_the_pwm_rate_is_a_choice(mode: Literal["hall", "sensorless"], pwm_rate: int) -> None:
    """A drive at another rate starts and holds its speed, and its recording replays."""
    motor = narx.Motor.preset("ec45-flat-50w-18v")
    bench = narx.Bench(motor, 18.0, mode=mode, pwm_rate=pwm_rate)
    bench.run(0.6)
    bench.drive.start(2000)
    trace = bench.run(2.0)
    assert len(trace) == 2 * pwm_rate and bench.drive.faults == set()
    assert bench.drive.measurements.speed == pytest.approx(2000, rel=0.005)
    captured = bench.drive.scope.capture(["Duty"], samples=20)
    # The drive tells the time between two samples in whole microseconds.
    assert np.diff(captured.time) == pytest.approx(1 / pwm_rate, abs=1e-6)


def test_a_pwm_rate_beyond_the_board_is_refused() -> None:
    motor = narx.Motor.preset("ec45-flat-50w-18v")
    for rate in (7_999, 50_001, -1):
        with pytest.raises(narx.ParameterError, match=f"pwm_rate {rate}: must be a whole number from 8000 to 50000 Hz"):
            narx.Bench(motor, 18.0, pwm_rate=rate)
        with pytest.raises(narx.ParameterError, match=f"pwm_rate {rate}: must be"):
            motor.commission(18.0, "hall", pwm_rate=rate)
    # A sector has four samples up to a speed that goes with the rate, until the voltage ends it.
    slow, fast = (motor.operating_range(18.0, pwm_rate=rate).speed_max for rate in (10_000, 20_000))
    assert fast > 1.25 * slow


def test_notes_name_every_limit_of_torque_and_speed() -> None:
    # Its rated current of 9.3 A is more than the drive has.
    notes = narx.Bench("bm-180e-24v", mode="hall").notes
    able = narx.Motor.preset("bm-180e-24v").operating_range(24.0, "hall")
    most = max(speed for speed, limit in zip(able.speed, able.torque_limit, strict=True) if limit == "phase current")
    assert notes == able.notes == [
        f"torque is limited by the drive's phase current from 500 to {most:.0f} rpm, not by the motor's rated current of 9.3 A",
        f"speed is limited to {able.speed_max:.0f} rpm, 80 % of the no-load speed: the winding's current and the reserve of the speed loop take "
        "the rest of the supply voltage",
    ]  # fmt: skip
    assert narx.Motor.preset("bm-180e-24v").replace(rated_current=2.0, max_speed=2000).operating_range(24.0, "hall").notes == []


def test_a_motor_whose_friction_takes_all_is_left_no_speed() -> None:
    with pytest.raises(narx.ParameterError, match="^the drive's limits leave this motor 0 rpm on this supply, less than the 500 rpm it needs"):
        narx.Motor(4, 50.0, 1e-4, 0.05, 1e-4, static_friction=1.0).commission(24.0)


def test_a_preset_is_a_motor_by_its_name() -> None:
    named = narx.Bench("ec45-flat-50w-18v", mode="hall")
    assert repr(named) == "<narx.Bench of ec45-flat-50w-18v, 18 V, hall: Initialization, 0.000 s>"
    assert repr(named.drive) == "<narx.Drive in Initialization, 0.000 s>"
    named.drive.start(2000)
    trace = named.run(1.0)
    assert repr(named) == f"<narx.Bench of ec45-flat-50w-18v, 18 V, hall: Hall closed loop, 2000 rpm, {named.time:.3f} s>"
    whole = narx.Bench(narx.Motor.preset("ec45-flat-50w-18v"), 18.0, mode="hall")
    whole.drive.start(2000)
    assert whole.run(1.0).recording() == trace.recording()
    assert "48 V" in repr(narx.Bench(narx.Motor.preset("ec45-flat-50w-18v"))) and "24 V" in repr(narx.Bench("ec45-flat-50w-18v", 24))
    with pytest.raises(narx.ParameterError, match='there is no preset "ec45"'):
        narx.Bench("ec45")


def test_the_reference_names_the_presets_and_the_package_its_version() -> None:
    documented = narx.Motor.preset.__doc__ or ""
    assert all(name in documented for name in narx.Motor.presets())
    assert importlib.metadata.version("narx") == narx.__version__


def test_a_copy_continues_with_the_same_bits(bench: narx.Bench) -> None:
    bench.set_load(lambda time: 0.01 + 0.005 * math.sin(20.0 * time))
    bench.drive.start(2000)
    bench.run(0.2)
    branch = bench.copy()
    assert branch.time == bench.time and branch.drive.state is narx.State.HALL_CLOSED_LOOP and repr(branch) == repr(bench)
    first, second = bench.run(0.3), branch.run(0.3)
    assert first.recording() == second.recording() and np.array_equal(first["speed"], second["speed"])
    # What happens to one bench does not happen to the other.
    branch.drive.stop()
    branch.inject("blocked-rotor")
    branch.run(0.2)
    assert bench.run(0.2)["speed"][-1] == pytest.approx(2000, rel=0.02)
    assert branch.drive.state is not narx.State.HALL_CLOSED_LOOP


def test_a_load_is_a_function_of_time(bench: narx.Bench) -> None:
    bench.drive.start(2000)
    bench.run(0.5)
    begin = bench.time

    def torque(load: Any) -> list[float]:
        branch = bench.copy()
        branch.set_load(load)
        trace = branch.run(1.0)
        return [float(trace["torque"][rows].mean()) for rows in (slice(4000, 5000), slice(9000, None))]

    free = torque(0.0)
    step = torque(lambda time: narx.Load(constant=0.04 if time > begin + 0.7 else 0.02))
    table = torque(([0.0, begin + 0.69, begin + 0.7, 10.0], [0.02, 0.02, 0.04, 0.04]))
    assert np.subtract(step, free) == pytest.approx([0.02, 0.04], abs=0.002)
    assert table == pytest.approx(step, abs=1e-3)


def test_a_machine_drives_the_shaft_and_pumps_the_bus_of_a_supply_that_takes_nothing_back(bench: narx.Bench) -> None:
    assert narx.Load(machine=-0.02) != narx.Load() and "machine -0.02 N m" in repr(narx.Load(machine=-0.02))
    bench.set_load(narx.Load(machine=-0.02))
    turned = bench.run(0.5)
    # At standstill the drive's bridge is off, and the machine turns the shaft against its friction.
    assert turned["speed"][-1] > 500 and turned["energy_shaft"][-1] <= 0
    battery = bench.copy()
    battery.set_supply(may_sink=True)
    top = []
    for one in (bench, battery):
        one.set_load(0.0)
        one.run(3.0)
        one.drive.start(3000)
        one.run(0.5)
        one.set_load(narx.Load(machine=-0.05))
        top.append(float(one.run(0.5)["bus_voltage"].max()))
    assert top[0] > 18.5 > top[1]


def test_a_supply_is_a_function_of_time(bench: narx.Bench) -> None:
    bench.drive.start(1500)
    begin = bench.time
    bench.set_supply(([begin, begin + 1.0], [18.0, 24.0]), resistance=0.01)
    trace = bench.run(1.5)
    assert trace["bus_voltage"][4900:5100].mean() == pytest.approx(21.0, abs=0.1)
    assert trace["bus_voltage"][-1000:].mean() == pytest.approx(24.0, abs=0.1)
    bench.set_supply(20.0)
    assert bench.run(0.5)["bus_voltage"][-100:].mean() == pytest.approx(20.0, abs=0.1)


def test_courses_that_are_none(bench: narx.Bench) -> None:
    for load, message in [
        ("heavy", "load 'heavy': must be a narx.Load, a torque in N m, a function of time, or times and torques"),
        (float("nan"), "constant NaN N m: must be a number from 0 to 1000 N m"),
        (2000.0, "constant 2000 N m: must be a number from 0 to 1000 N m"),
        (([0.0, 1.0], [0.1]), r"load: times of shape \(2,\) and values of shape \(1,\)"),
        (([1.0, 0.0], [0.1, 0.1]), "load: time 0 s in row 1 is before 1 s: must ascend"),
        (([0.0, float("inf")], [0.1, 0.1]), "load: times and values must be finite numbers"),
        (([0.0], ["x"]), "load: times and values must be arrays of numbers"),
        ((1.0, 2.0, 3.0), "load: must be a pair of times and values"),
    ]:  # fmt: skip
        with pytest.raises(narx.ParameterError, match=message):
            bench.set_load(load)  # type: ignore[arg-type]
    bench.set_load(lambda time: 0.0 if time < 0.01 else float("nan"))
    with pytest.raises(narx.ParameterError, match="at 0.0100 s: constant NaN N m"):
        bench.run(0.1)
    assert bench.time == pytest.approx(0.01)
    bench.set_load(0.0)
    for voltage, message in [(81.0, "voltage 81 V: must be a number from 0 to 80 V"), ("24", "voltage '24': must be")]:
        with pytest.raises(narx.ParameterError, match=message):
            bench.set_supply(voltage)  # type: ignore[arg-type]
    with pytest.raises(narx.ParameterError, match="machine 2000 N m: must be a number from -1000 to 1000 N m"):
        narx.Load(machine=2000)
    with pytest.raises(narx.ParameterError, match="resistance -1 ohm: must be a number from 0 to 100 ohm"):
        bench.set_supply(resistance=-1)
    with pytest.raises(narx.ParameterError, match="may_sink 'no': must be True or False"):
        bench.set_supply(may_sink="no")  # type: ignore[arg-type]


def test_a_winding_that_burns_has_a_note() -> None:
    motor = narx.Motor.preset("ec45-flat-50w-18v")
    assert motor.thermal_resistance > 0 and motor.max_winding_temperature == 155.0
    hot = motor.replace(thermal_time=0.5, thermal_resistance=20.0, max_winding_temperature=80.0)
    assert hot.name is None and (hot.thermal_time, hot.max_winding_temperature) == (0.5, 80.0)
    bench = narx.Bench(hot, 18.0, narx.Load(constant=0.08), mode="hall")
    bench.drive.start(1500)
    before = bench.notes
    temperature = bench.run(3.0)["winding_temperature"].max()
    assert temperature > 80.0 and not any("winding has reached" in note for note in before)
    assert bench.notes[-1].startswith(f"the winding has reached {temperature:.0f} degrees Celsius at ")
    assert bench.notes[-1].endswith("and may have 80: this motor would be damaged") and bench.copy().notes == bench.notes
    with pytest.raises(narx.ParameterError, match="max_winding_temperature 20 degrees Celsius: must be a number from 40 to 1000"):
        motor.replace(max_winding_temperature=20)
    for name, value in [("thermal_resistance", -1), ("thermal_time", 0)]:
        with pytest.raises(narx.ParameterError, match=f"{name} {value} "):
            motor.replace(**{name: value})


def test_energies_and_their_planes(motor: narx.Motor) -> None:
    """The source delivers what the bus takes, the loss in its own resistance, and the drive's electronics."""
    bench = narx.Bench(motor, 18.0, narx.Load(constant=0.1), mode="hall")
    bench.drive.start(2500)
    bench.run(1.0, trace=False)
    trace = bench.run(0.5)
    seconds = trace.time[-1] - trace.time[0]
    source = (trace["energy_in"][-1] - trace["energy_in"][0]) / seconds
    current, voltage = trace["bus_current"].mean(), trace["bus_voltage"].mean()
    own = voltage * voltage * 15e-3 / 60.0
    assert source == pytest.approx(18.0 * current + own, rel=3e-3)
    assert 1.01 < source / (voltage * current) < 1.04
    assert "before the supply's own resistance" in trace.descriptions["energy_in"]


def test_a_long_run_keeps_what_is_chosen(bench: narx.Bench, tmp_path: Path) -> None:
    bench.drive.start(2000)
    whole = bench.copy().run(2.5)
    thin = bench.copy().run(2.5, signals=["speed", "duty"], every=10)
    assert list(thin) == ["time", "speed", "duty"] and thin.recording() == whole.recording()
    assert len(thin) == 2500 and all(np.array_equal(thin[name], whole[name][9::10]) for name in thin)
    odd = bench.copy().run(2.5, every=7777)
    assert np.array_equal(odd["speed"], whole["speed"][7776::7777]) and list(odd) == list(whole)
    file = tmp_path / "run.parquet"
    empty = bench.copy().run(2.5, to=file, every=2)
    written = pd.read_parquet(file)
    assert len(empty) == 0 and len(written) == 12_500 and list(written) == list(whole)
    assert np.array_equal(written["speed"].to_numpy(), whole["speed"][1::2])
    for arguments, error, message in [
        ({"signals": ["sped"]}, narx.SignalError, 'there is no signal "sped"; did you mean "speed"'),
        ({"signals": "speed"}, narx.ParameterError, "signals 'speed': must be a list of names"),
        ({"every": 0}, narx.ParameterError, "every 0: must be a whole number from 1"),
        ({"to": "run.csv"}, narx.ParameterError, 'to "run.csv": must end in .parquet'),
        ({"to": 3}, narx.ParameterError, "to 3: must be the path of a file"),
    ]:  # fmt: skip
        with pytest.raises(error, match=message):
            bench.run(0.1, **arguments)  # type: ignore[arg-type]


def resident() -> float:
    """Returns the memory of this process, MB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE / 1e6


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="this system does not tell the memory of a process")
@pytest.mark.parametrize("keeps", ["columns and every", "every", "parquet", "nothing", "recording"])
def test_a_long_run_has_bounded_memory(keeps: str, motor: narx.Motor, tmp_path: Path) -> None:
    """From 60 to 120 s of simulated time: all rows of all signals take 77 MB, a recording 4 MB."""
    bench = narx.Bench(motor, 18.0, mode="hall", recording=keeps == "recording")
    bench.drive.start(2000)
    options: dict[str, dict[str, Any]] = {
        "columns and every": {"signals": ["speed", "winding_temperature"], "every": 100},
        "every": {"every": 1000},
        "parquet": {"to": tmp_path / "run.parquet"},
        "nothing": {"trace": False},
        "recording": {"trace": False},
    }
    bench.run(60.0, progress=False, **options[keeps])
    before = resident()
    bench.run(60.0, progress=False, **options[keeps])
    assert resident() - before < 20.0


def test_rows_are_kept_during_a_run_only(bench: narx.Bench) -> None:
    """A call that waits adds no rows, and another run in another thread has its own."""
    bench.drive.start(2000)
    assert len(bench._bench.take_rows()[0]["time"]) == 0
    traces: dict[str, narx.Trace] = {}
    threads = [
        threading.Thread(target=lambda name=name: traces.update({name: bench.run(0.2, signals=[name])}))
        for name in ("speed", "duty")
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert {name: list(trace) for name, trace in traces.items()} == {name: ["time", name] for name in ("speed", "duty")}
    assert all(len(trace) == 2000 for trace in traces.values())


def test_ctrl_c_keeps_the_rows_so_far(bench: narx.Bench) -> None:
    def load(time: float) -> float:
        if time > 1.7:
            raise KeyboardInterrupt
        return 0.0

    bench.set_load(load)
    with pytest.raises(narx.RunInterrupted) as caught:
        bench.run(60.0, every=10)
    trace = caught.value.trace
    assert len(trace) == pytest.approx(1700, abs=2) and trace.time[-1] == pytest.approx(bench.time, abs=1e-3)
    assert isinstance(caught.value, KeyboardInterrupt)
