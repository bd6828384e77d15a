"""The motor turns: hall sensors, without sensors, load, reverse, stop."""

import os
import pathlib

import pytest
from conftest import Bench, stored
from narx import Load, State
from stm32g4 import SECOND
from stm32g4.chip import Image

SPEED = 2000
CONTROL = 16 + 18
"""Exception of the control interrupt."""


def test_a_hall_motor_starts_holds_its_speed_under_load_reverses_and_stops(image, hall_flash):
    bench = Bench(image, hall_flash)
    bench.stand_by()
    bench.drive.start(SPEED)
    assert bench.drive.state is State.HALL_CLOSED_LOOP
    bench.run(0.3)
    assert bench.mean_speed() == pytest.approx(SPEED, rel=5e-3)
    assert bench.drive.measurements.speed == pytest.approx(SPEED, rel=1e-2)

    bench.plant.set_load(Load(constant=0.1))
    bench.run(0.3)
    assert bench.mean_speed() == pytest.approx(SPEED, rel=5e-3)
    flows, shown = bench.bus_currents()
    # What returns to the bus in the off-time is not seen where the on-time is sampled.
    assert flows > 0.5 and flows < shown < 1.07 * flows
    bench.plant.set_load(Load())

    bench.drive.stop()
    bench.reach(State.STANDBY)
    assert bench.chip.gates == ("off", "off", "off")
    assert bench.wait(lambda: abs(bench.plant.speed) < 50, 3.0), "it comes to rest by itself"
    bench.drive.start(-1500)
    bench.run(0.3)
    assert bench.mean_speed() == pytest.approx(-1500, rel=5e-3)
    assert bench.drive.faults == set() and bench.chip.resets == []


def test_a_motor_starts_without_sensors_and_holds_its_speed_under_load(image, sensorless_flash):
    bench = Bench(image, sensorless_flash)
    bench.stand_by()
    bench.drive.start(SPEED)
    assert bench.drive.state is State.SENSORLESS_CLOSED_LOOP
    bench.run(0.4)
    assert bench.mean_speed() == pytest.approx(SPEED, rel=5e-3)
    bench.plant.set_load(Load(constant=0.08))
    bench.run(0.3)
    assert bench.mean_speed() == pytest.approx(SPEED, rel=5e-3)
    assert bench.drive.faults == set() and bench.chip.resets == []


@pytest.mark.skipif("NARX_BOARD_IMAGE_20_KHZ" not in os.environ, reason="NARX_LONG=1")
@pytest.mark.parametrize("mode", ["hall", "sensorless"])
def test_at_20_khz_no_control_tick_takes_the_whole_period(mode):
    image = Image(pathlib.Path(os.environ["NARX_BOARD_IMAGE_20_KHZ"]))
    bench = Bench(image, stored(image, mode))
    bench.stand_by()
    bench.drive.start(SPEED)
    bench.run(0.4)
    assert bench.mean_speed() == pytest.approx(SPEED, rel=5e-3)
    longest = bench.chip.processor.longest
    instructions, time = longest[CONTROL]
    print(f"{mode}: {instructions} instructions at a start, {time / SECOND * 1e6:.1f} us")
    assert time < SECOND // 20_000
    longest.clear()
    bench.run(0.2)
    instructions, time = longest[CONTROL]
    print(f"{mode}: {instructions} instructions, {time / SECOND * 1e6:.1f} us")
    assert time < SECOND // 40_000
    assert bench.drive.faults == set() and bench.chip.resets == []
