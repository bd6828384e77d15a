"""Errors on the bus: nobody acknowledges, and wires that are shorted."""

from conftest import Bench, forked
from narx import State
from test_update import is_receiving

BUS_OFFS = 296
PASSIVE = 1 << 5
RECOVERY = 129 * 11 / 500e3
"""Time that a controller waits before it comes back, s (ISO 11898-1)."""


@forked
def test_a_bus_that_is_shorted_stops_the_motor_and_the_drive_comes_back(turning):
    chip = turning.chip
    chip.bus.is_broken = True
    assert chip.run(0.3, lambda: chip.fdcan.bus_off), "the drive sends, and every frame is an error"
    chip.run(0.3)
    assert chip.gates == ("off", "off", "off")
    chip.bus.is_broken = False
    assert chip.run(RECOVERY + 0.01, chip.fdcan.is_on)
    turning.reach(State.FAULT, 1.0)
    assert chip.resets == [] and turning.drive.parameters[BUS_OFFS] >= 1
    turning.drive.stop()
    turning.reach(State.STANDBY)
    assert turning.turns_at(1500)


@forked
def test_a_drive_that_nobody_acknowledges_is_error_passive_and_not_off(standing):
    chip = standing.chip
    chip.bus.is_there = False
    chip.run(0.5)
    assert chip.find("FDCAN1.PSR").read() & PASSIVE and chip.fdcan.is_on()
    chip.bus.is_there = True
    standing.run(0.1)
    assert standing.drive.parameters[BUS_OFFS] == 0


def test_a_bootloader_whose_bus_was_shorted_receives_again(image, boot):
    bench = Bench(image, boot=boot)
    assert is_receiving(bench)
    chip = bench.chip
    chip.fdcan.fail(unheard=False)
    chip.fdcan.errors = 248
    chip.fdcan.fail(unheard=False)
    assert chip.fdcan.bus_off
    assert chip.run(RECOVERY + 0.01, chip.fdcan.is_on)
