"""The bootloader enters the slot, and receives an image over the bus."""

import itertools
import os
import pathlib

import narx
import pytest
from conftest import Bench, forked
from narx import State
from stm32g4.flash import PowerCut, blank
from stm32g4.processor import FLASH

SLOTS = pathlib.Path(os.environ["NARX_BOARD_SLOTS"])
SLOT = 22 * 1024
VECTORS = FLASH + SLOT + 512
LEFT = 8
"""Operations of the flash without which the drive has not made way for an image: a page is erased, and two records of
four words are written, of which the second counts once three of its words are whole."""
WATCHDOG = 32.0
"""Time that the bootloader's watchdog gives an image, s."""


def path(name):
    return (SLOTS / name).with_suffix(".narximg")


def with_image(name, flash=None):
    """A flash with this image in the slot."""
    flash, image = bytearray(flash or blank()), path(name).read_bytes()
    flash[SLOT : SLOT + len(image)] = image
    return bytes(flash)


def is_receiving(bench):
    """The bootloader runs at the full clock, with the gates off, and its LED changes every 0.1 s."""
    chip = bench.chip
    chip.run(3.0, lambda: chip.board.can_is_on(chip))
    led = [chip.run(0.02) or chip.ports["C"].output(6) for _ in range(13)]
    changes = sum(old != new for old, new in itertools.pairwise(led))
    inside = chip.processor.vectors == FLASH and chip.clocks.rate == 170e6 and chip.gates == ("off", "off", "off")
    return inside and changes in (2, 3)


def is_entered(bench):
    """The bootloader enters the image, which takes it a second and a half at its clock of 16 MHz."""
    return bench.chip.run(2.0, lambda: bench.chip.processor.vectors == VECTORS)


@pytest.fixture(scope="session")
def in_slot(image, boot, hall_flash):
    """A board in Standby whose bootloader has entered the image `old`. Use it in a forked test."""
    bench = Bench(image, with_image("old", hall_flash), boot=boot)
    assert is_entered(bench)
    bench.stand_by()
    return bench


def test_a_blank_board_receives_the_drive_over_the_bus_and_runs_it(image, boot):
    bench = Bench(image, boot=boot)
    assert is_receiving(bench)
    bench.drive.update(path("old"))
    assert bench.chip.resets == ["software"]
    assert bench.wait(lambda: bench.drive.state is State.FAULT, 1.0)
    assert bench.drive.faults == {"store_mismatch"} and bench.chip.processor.vectors == VECTORS
    # The whole drive is there, byte by byte, and confirmed: it stays after the next reset.
    assert bytes(bench.chip.processor.flash[SLOT : SLOT + path("old").stat().st_size]) == path("old").read_bytes()
    bench.drive.reboot()
    assert bench.drive.state is State.FAULT


def send(bench, name):
    """Sends an image until the bootloader has entered it; nobody waits for its answer."""
    link = bench.drive._link
    link.master.update(path(name).read_bytes())
    link.wake()
    assert bench.wait(lambda: bench.chip.processor.vectors == VECTORS, 5.0)
    assert bench.chip.resets[-1] == "software"


@forked
def test_an_image_that_hangs_is_left_by_the_watchdog_and_not_entered_again(in_slot):
    begun = in_slot.chip.time
    with pytest.raises(narx.RefusedError, match="was not confirmed, and does not run any more"):
        in_slot.drive.update(path("idle"))
    assert in_slot.chip.resets == ["software", "software", "watchdog"]
    assert in_slot.chip.time - begun > 0.9 * WATCHDOG
    assert is_receiving(in_slot)


@pytest.mark.parametrize("operation", [1, 2, LEFT, LEFT + 1, 20, 700])
@forked
def test_the_power_fails_in_an_update_and_the_drive_is_as_it_was_or_the_next_update_succeeds(image, boot, in_slot, operation):
    flash = in_slot.chip.flash
    flash.cut_at = flash.operations + operation
    with pytest.raises(PowerCut):
        in_slot.drive.update(path("idle"))
    again = Bench(image, bytes(in_slot.chip.processor.flash), boot=boot)
    again.chip.flash.torn.update(in_slot.chip.flash.torn)
    if operation <= LEFT:
        assert is_entered(again)
        again.stand_by()
    else:
        assert is_receiving(again)
        send(again, "idle")


@pytest.mark.parametrize("name", ["foreign", "damaged", "torn"])
def test_no_image_is_entered_that_is_not_its_owners_to_the_last_bit(image, boot, name):
    flash = bytearray(with_image("foreign" if name == "foreign" else "old"))
    word = SLOT + 40_000
    if name != "foreign":
        flash[word] ^= 0x10
    bench = Bench(image, bytes(flash), boot=boot)
    if name == "torn":
        # Reading it is a non-maskable interrupt.
        bench.chip.flash.torn[word] = 1
    assert is_receiving(bench) and bench.chip.resets == []
