"""The motor turns: hall sensors, without sensors, load, reverse, stop."""

import os
import pathlib

import pytest
from conftest import RUNNING, SPEED, Bench, stored
from stm32g4 import SECOND
from stm32g4.chip import Image

CONTROL = 16 + 18
"""Exception of the control interrupt."""


@pytest.mark.parametrize("mode", RUNNING)
def test_the_motor_starts_holds_its_speed_under_load_stops_and_reverses(mode, image, request):
    bench = Bench(image, request.getfixturevalue(f"{mode}_flash"))
    bench.stand_by()
    bench.spin(mode)


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
