"""The emulated board with its bootloader: updated over the bus, and switched off at any instant of that."""

import os
import pathlib
import random
import shutil
import time

import pytest
import updater
from conftest import REBOOT, Master, running
from test_safety import STANDBY, STANDBY_REQUEST, drive

IMAGES = pathlib.Path(os.environ["NARX_QEMU_SLOTS"])
PSRAM, DFU, DFU_LENGTH = 16 << 20, 1 << 20, (1 << 20) + 4096
SEED = 20_261_122
OLD, NEW = (1, 1, 0, 1), (1, 2, 0, 2)


def image(name):
    return (IMAGES / name).with_suffix(".narximg").read_bytes()


@pytest.fixture
def flash(tmp_path):
    """A board as it leaves the factory: the old image runs, all else is erased."""
    path = tmp_path / "flash"
    old = image("old")
    path.write_bytes(old + b"\xff" * (PSRAM - len(old)))
    return path


def started(flash):
    """The emulator on this flash, from power-up until it is killed."""
    return running(os.environ["NARX_QEMU_BOOTLOADER"].replace("{flash}", str(flash)))


def standby(master):
    master.mode = STANDBY_REQUEST
    master.wait_for_state(STANDBY, 3.0)


def restart(master):
    master.send(REBOOT, 0)
    master.run(0.3)
    standby(master)


def put_candidate(flash, content):
    """What lies in the slot for the next boot is another image."""
    with flash.open("r+b") as file:
        file.seek(DFU)
        file.write(content.ljust(DFU_LENGTH, b"\xff"))


def test_an_update_over_the_bus_and_everything_that_can_become_of_it(flash, tmp_path):
    """One transfer, because it is long; what comes of it begins each time from a copy of the flash that it left."""
    draw = random.Random(SEED)
    new = image("new")
    with started(flash) as bus:
        master = Master(bus)
        standby(master)
        assert updater.version(master) == OLD
        assert master.write(99, 1234) == 0
        assert (master.write(256, 0), master.write(256, 1)) == (0, 0), "stored"
    # Killed amid a transfer, the old image runs; the transfer begins anew.
    for _ in range(2):
        with started(flash) as bus:
            master = Master(bus)
            standby(master)
            updater.send(master, new, stop_at=draw.randrange(len(new) // 20))
    with started(flash) as bus:
        master = Master(bus)
        drive(master)
        standby(master)
        assert updater.version(master) == OLD
        updater.send(master, new)
    marked = tmp_path / "marked"
    shutil.copy(flash, marked)

    # Confirmed, it stays, with the parameters that the old one has stored; the motor turns.
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

    # Not confirmed, the old one comes back, and says so.
    shutil.copy(marked, flash)
    with started(flash) as bus:
        master = Master(bus)
        standby(master)
        assert updater.version(master) == NEW
        restart(master)
        assert updater.version(master) == OLD
        assert updater.status(master)[0:2] == (updater.IDLE, updater.REVERTED)

    # Killed at any instant of the swap, a working image runs at once.
    for _ in range(6):
        shutil.copy(marked, flash)
        for _ in range(draw.randrange(1, 4)):
            with started(flash):
                time.sleep(draw.uniform(0.0, 1.0))
        with started(flash) as bus:
            master = Master(bus)
            standby(master)
            assert updater.version(master) in (OLD, NEW)

    # With another key, or a bit flipped, it is refused, and the old one runs.
    flipped = bytearray(new)
    flipped[draw.randrange(512, len(new))] ^= 1 << draw.randrange(8)
    for candidate, code in ((image("foreign"), updater.SIGNATURE), (bytes(flipped), updater.SIGNATURE)):
        shutil.copy(marked, flash)
        put_candidate(flash, candidate)
        with started(flash) as bus:
            master = Master(bus)
            standby(master)
            assert updater.version(master) == OLD
            assert updater.status(master)[0:2] == (updater.IDLE, code)


def test_without_an_image_that_is_signed_nothing_is_entered(flash):
    with flash.open("r+b") as file:
        file.write(image("foreign"))
    with started(flash) as bus:
        assert bus.recv(3.0) is None
