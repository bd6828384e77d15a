"""The emulated board with its bootloader: updates over the bus, with power cuts at any instant."""

import os
import pathlib
import random
import shutil
import time

import pytest
import updater
from conftest import REBOOT, Master, running, with_bootloader
from test_safety import STANDBY, STANDBY_REQUEST, drive

IMAGES = pathlib.Path(os.environ["NARX_QEMU_SLOTS"])
PSRAM, DFU, DFU_LENGTH = 16 << 20, 1 << 20, (1 << 20) + 4096
SEED = 20_261_122
OLD, NEW = (1, 1, 0, 1), (1, 2, 0, 2)


def image(name):
    return (IMAGES / name).with_suffix(".narximg").read_bytes()


def make_board(path, name="old"):
    """Writes the flash of a new board: one valid image, everything else erased."""
    content = image(name)
    path.write_bytes(content + b"\xff" * (PSRAM - len(content)))


def started(flash):
    """Runs the emulator on this flash, from power-up until it is killed, and yields its bus."""
    return running(with_bootloader(flash))


def standby(master):
    master.mode = STANDBY_REQUEST
    master.wait_for_state(STANDBY, 3.0)


def restart(master):
    master.send(REBOOT, 0)
    master.run(0.3)
    standby(master)


def put_candidate(flash, content):
    """Replaces the image in the slot for the next boot."""
    with flash.open("r+b") as file:
        file.seek(DFU)
        file.write(content.ljust(DFU_LENGTH, b"\xff"))


@pytest.fixture(scope="module")
def marked(tmp_path_factory):
    """A flash after several interrupted transfers and a complete one over the bus.

    The old image runs with a changed parameter; another, short image is marked for the next boot.
    """
    draw = random.Random(SEED)
    path, short = tmp_path_factory.mktemp("flash") / "marked", image("idle")
    make_board(path)
    with started(path) as bus:
        master = Master(bus)
        standby(master)
        assert updater.version(master) == OLD
        assert master.write(99, 1234) == 0
        assert (master.write(256, 0), master.write(256, 1)) == (0, 0), "stored"
    for _ in range(2):
        with started(path) as bus:
            master = Master(bus)
            standby(master)
            assert updater.version(master) == OLD
            updater.send(master, short, stop_at=draw.randrange(len(short)))
    with started(path) as bus:
        master = Master(bus)
        drive(master)
        standby(master)
        assert master.parameter(99) == 1234
        updater.send(master, short)
    return path


@pytest.fixture
def flash(marked, tmp_path):
    """A copy of the flash for each test, with the new drive's image in the slot for the next boot.

    The image is written to the flash directly: a transfer over the bus would take minutes.
    """
    path = tmp_path / "flash"
    shutil.copy(marked, path)
    put_candidate(path, image("new"))
    return path


def test_a_confirmed_image_stays_and_finds_the_parameters_of_the_one_before(flash):
    with started(flash) as bus:
        master = Master(bus)
        standby(master)
        assert updater.version(master) == NEW
        assert updater.status(master)[0] == updater.TRIAL
        assert master.parameter(99) == 1234
        updater.confirm(master)
        restart(master)
        assert updater.version(master) == NEW
        drive(master)


def test_an_image_that_is_not_confirmed_reverts(flash):
    with started(flash) as bus:
        master = Master(bus)
        standby(master)
        assert updater.version(master) == NEW
        restart(master)
        assert updater.version(master) == OLD
        assert updater.status(master)[0:2] == (updater.IDLE, updater.REVERTED)


def test_an_image_that_does_nothing_is_gone_after_the_next_reset(marked, tmp_path):
    flash = tmp_path / "flash"
    shutil.copy(marked, flash)
    with started(flash) as bus:
        assert bus.recv(2.0) is None
    with started(flash) as bus:
        master = Master(bus)
        standby(master)
        assert updater.version(master) == OLD


@pytest.mark.parametrize("seed", range(4))
def test_switched_off_at_any_instant_of_the_swap_a_working_image_runs(flash, seed):
    draw = random.Random(SEED + seed)
    for _ in range(draw.randrange(1, 4)):
        with started(flash):
            time.sleep(draw.uniform(0.0, 1.0))
    with started(flash) as bus:
        master = Master(bus)
        standby(master)
        assert updater.version(master) in (OLD, NEW)


@pytest.mark.parametrize("how", ["a foreign key", "a flipped bit"])
def test_what_is_not_signed_is_refused(flash, how):
    if how == "a foreign key":
        candidate = image("foreign")
    else:
        draw, content = random.Random(SEED), bytearray(image("new"))
        content[draw.randrange(512, len(content))] ^= 1 << draw.randrange(8)
        candidate = bytes(content)
    put_candidate(flash, candidate)
    with started(flash) as bus:
        master = Master(bus)
        standby(master)
        assert updater.version(master) == OLD
        assert updater.status(master)[0:2] == (updater.IDLE, updater.SIGNATURE)


def test_without_an_image_that_is_signed_nothing_is_entered(tmp_path):
    flash = tmp_path / "flash"
    make_board(flash, "foreign")
    with started(flash) as bus:
        assert bus.recv(3.0) is None
