"""Arguments of variants and results are unchanged after the way to another process."""

import pickle
from typing import Any

import numpy as np
import pytest

import narx

PRESET = narx.Motor.preset("ec45-flat-50w-18v")
PLAIN = narx.Motor(4, 0.36, 2e-4, 0.036, 4.8e-6, 1e-3, 1e-6, "sinusoidal", -3.0)


def again(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))


CHANGED = PRESET.replace(resistance=1.5, hall_offset_deg=2.0)
LIMITED = PRESET.replace(rated_current=2.0, max_speed=3000.0)


@pytest.mark.parametrize("motor", [PRESET, PLAIN, CHANGED, LIMITED], ids=repr)
def test_motors(motor: narx.Motor) -> None:
    back = again(motor)
    assert back == motor and hash(back) == hash(motor) and repr(back) == repr(motor)
    assert (back.name, back.rated_current, back.max_speed, back.nominal_voltage) == (
        motor.name,
        motor.rated_current,
        motor.max_speed,
        motor.nominal_voltage,
    )
    # The copy also has the properties that no argument gives, such as cogging.
    digests = []
    for each in (motor, back):
        bench = narx.Bench(each, 24.0, mode="hall")
        bench.drive.start(1000, wait=False)
        bench.run(0.8)
        digests.append(bench.digest)
    assert digests[0] == digests[1]


@pytest.mark.parametrize("name", narx.Motor.presets())
def test_every_preset_comes_back_whole(name: str) -> None:
    motor = narx.Motor.preset(name)
    assert again(motor) == motor == motor.replace() and again(motor).name == name


def test_motors_differ_by_what_they_are() -> None:
    changed = PRESET.replace(resistance=1.5)
    assert changed != PRESET and changed.resistance == 1.5 and changed.inductance == PRESET.inductance
    assert changed.name is None and changed.rated_current == PRESET.rated_current and PRESET.name is not None
    assert changed.replace(resistance=PRESET.resistance) == PRESET and PRESET.replace() == PRESET
    assert PLAIN.name is None and PLAIN.rated_current is None and len({PRESET, changed, again(PRESET)}) == 2
    assert LIMITED not in (PRESET, PRESET.replace(max_speed=3000.0), PRESET.replace(rated_current=2.0))
    assert LIMITED.name is None and LIMITED.replace(rated_current=PRESET.rated_current, max_speed=None) == PRESET
    with pytest.raises(narx.ParameterError, match='a motor has no "resistence"; did you mean "resistance"'):
        PRESET.replace(resistence=1.0)
    with pytest.raises(narx.ParameterError, match="resistance -1 ohm: must be a finite number above 0"):
        PRESET.replace(resistance=-1.0)


def test_loads_and_states() -> None:
    load = narx.Load(constant=0.01, viscous=1e-5, quadratic=1e-8, inertia=1e-6)
    assert again(load) == load and hash(again(load)) == hash(load) and again(load).quadratic == 1e-8
    assert (
        load != narx.Load(constant=0.01)
        and narx.Load() == narx.Load(-0.0)
        and hash(narx.Load()) == hash(narx.Load(-0.0))
    )
    assert again(narx.State.FAULT) is narx.State.FAULT


def test_traces_replays_and_errors(bench: narx.Bench) -> None:
    bench.drive.start(1000)
    trace = bench.run(0.05)
    back = again(trace)
    assert back.signals == trace.signals and back.recording() == trace.recording()
    assert all(np.array_equal(back[name], trace[name]) for name in trace)
    replay = narx.replay(trace.recording())
    assert again(replay).identical and again(replay).digest == replay.digest == bench.digest
    error = again(narx.StartError("the drive is in Fault"))
    assert isinstance(error, narx.StartError) and str(error) == "the drive is in Fault"
    trigger = narx.Trigger.above("HV Voltage", 20.0)
    assert again(trigger) == trigger
