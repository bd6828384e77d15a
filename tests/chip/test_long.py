"""The board lives on: starts, speeds, loads, stops, stores and new power, one after the other, and nothing that the model
stops a run for. NARX_CHIP_SECONDS is the time that each mode lives, in the board's seconds; NARX_CHIP_SEED another life.
"""

import os
import random

import pytest
from conftest import RUNNING, Bench
from narx import Load, State

SECONDS = float(os.environ.get("NARX_CHIP_SECONDS", "3"))
SEED = int(os.environ.get("NARX_CHIP_SEED", "1"))
LOAD_MAX = 0.08
"""Torque, N m: 0.6 of the motor's rating."""
STORED = "Over-temperature warning threshold"
"""A parameter that nothing depends on while the board is cold."""


def start(bench, mode, chance):
    bench.drive.start(chance.choice([-1, 1]) * chance.randint(1500, 3000))
    assert bench.drive.state is RUNNING[mode]


def stop(bench):
    bench.plant.set_load(Load())
    bench.drive.stop()
    bench.reach(State.STANDBY)
    assert bench.wait(lambda: abs(bench.plant.speed) < 50, 5.0)


def turn(bench, mode, chance):
    """A motor that turns: other speeds and loads, and whether it follows."""
    start(bench, mode, chance)
    for _ in range(chance.randint(1, 4)):
        speed = chance.randint(1500, 3000)
        bench.drive.set_speed(speed)
        bench.plant.set_load(Load(constant=chance.uniform(0, LOAD_MAX)))
        bench.run(1.0)
        assert abs(bench.mean_speed()) == pytest.approx(speed, rel=2e-2)
    if chance.random() < 0.3:
        assert len(bench.drive.scope.capture(["Duty", "HV Current"], samples=200)) == 200
    stop(bench)


def store(bench, chance):
    """A parameter is changed and stored, and power comes back."""
    degrees = chance.randint(60, 90)
    bench.drive.parameters[STORED] = degrees
    bench.drive.parameters.store()
    again = Bench(bench.chip.image, bytes(bench.chip.processor.flash))
    again.stand_by()
    assert again.drive.parameters[STORED] == degrees
    return again


@pytest.mark.parametrize("mode", RUNNING)
def test_the_board_lives_on(mode, image, request):
    chance, lived = random.Random(SEED), 0.0
    bench = Bench(image, request.getfixturevalue(f"{mode}_flash"))
    bench.stand_by()
    while lived + bench.chip.time < SECONDS:
        turn(bench, mode, chance)
        assert bench.drive.faults == set() and bench.chip.resets == []
        if chance.random() < 0.2:
            lived += bench.chip.time
            bench = store(bench, chance)
    print(f"{mode}: {lived + bench.chip.time:.1f} s")
