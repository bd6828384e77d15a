"""The emulated board with its bootloader, updated by the Python package and by the command `narx`."""

import contextlib
import os
import random
import subprocess
import sys
import time

import can
import narx
import pytest
import updater
from conftest import Master, operated, powered, running, spin, with_bootloader
from narx import State
from test_update import NEW, OLD, SEED, image, make_board, standby

LONG = bool(os.environ.get("NARX_LONG"))
"""Switch for the tests that take minutes (NARX_LONG)."""
STAGES = ["asking", "erasing", "sending", "verifying", "restarting"]


@pytest.fixture
def flash(tmp_path):
    path = tmp_path / "flash"
    make_board(path)
    return path


@pytest.fixture
def drive(flash):
    with operated(with_bootloader(flash)) as (drive, _):
        yield drive


class Progress:
    """A progress callback that records its calls and then calls `then`."""

    def __init__(self, length, then=lambda stage, done: None):
        self.told, self._length, self._then = [], length, then

    def __call__(self, stage, done, total):
        assert 0 <= done <= total == self._length
        self.told.append((STAGES.index(stage), done))
        self._then(stage, done)

    @property
    def stages(self):
        assert self.told == sorted(self.told), "it never goes back"
        return [STAGES[place] for place in sorted({place for place, _ in self.told})]


def version_that_runs(flash):
    """Returns the version that runs after a power cut.

    The master that reads it shares no code with the package.
    """
    with running(with_bootloader(flash)) as bus:
        master = Master(bus)
        standby(master)
        return updater.version(master)


def written(folder, content):
    path = folder / "drive.narximg"
    path.write_bytes(content)
    return path


def idle(offset=0, data=b""):
    """Returns a short image in which `data` replaces the bytes at `offset`."""
    content = bytearray(image("idle"))
    content[offset : offset + len(data)] = data
    return bytes(content)


def test_the_drive_says_the_version_of_the_image_that_runs(drive):
    major, minor, _, build = OLD
    info = drive.info
    assert (info.software, info.build_number) == (f"{major}.{minor}", build)


@pytest.mark.parametrize(
    ("place", "data", "error", "message"),
    [
        (12, b"\x4e\x58\0\0", narx.ImageError, "for hardware 4E580000h, the drive is 4E580001h"),
        (16, b"\1\0", narx.ImageError, r"version 1\.0\.0\+2, older than the running version 1\.1\.0\+1"),
        (0, b"x", narx.ImageError, "not an image"),
        (448, bytes(64), narx.RefusedError, "the board's bootloader does not accept the signature"),
    ],
)
def test_what_the_board_must_not_run_is_refused(drive, tmp_path, place, data, error, message):
    with pytest.raises(error, match=message):
        drive.update(written(tmp_path, idle(place, data)))
    # The refusal has changed nothing: the motor starts, and a running drive refuses an update.
    assert drive.wait_for(lambda: drive.state is State.STANDBY, 60.0)
    spin(drive, 2000)
    with pytest.raises(narx.RefusedError, match="not in Standby, nor in Fault at standstill"):
        drive.update(written(tmp_path, idle()))
    assert drive.state is State.HALL_CLOSED_LOOP


def test_who_stops_an_update_has_a_drive_that_runs(drive, tmp_path):
    class Stop(Exception):
        pass

    def then(stage, done):
        if stage == "sending" and done > len(idle()) / 2:
            raise Stop

    progress = Progress(len(idle()), then)
    with pytest.raises(Stop):
        drive.update(written(tmp_path, idle()), progress)
    assert progress.stages == STAGES[:3]
    spin(drive, 2000)


@pytest.mark.parametrize("seed", range(3))
def test_a_power_cut_in_a_transfer_is_an_error_and_the_old_image_runs(flash, tmp_path, seed):
    place = random.Random(SEED + seed).randrange(len(idle()))
    with contextlib.suppress(narx.BusError), operated(with_bootloader(flash)) as (drive, emulator):
        progress = Progress(len(idle()), lambda stage, done: stage == "sending" and done >= place and emulator.cut())
        with pytest.raises(narx.BusError):
            drive.update(written(tmp_path, idle()), progress)
        # On closing, the drive cannot be told to stop either: this raises the BusError that is suppressed
        # above.
    assert progress.stages == STAGES[:3]
    assert version_that_runs(flash) == OLD


def narx_command(emulator, *arguments):
    options = [word for name in ("sleep_after_open", "timeout") for word in ("-o", f"{name}={emulator.bus.get(name, 60.0)}")]
    connection = ["-i", emulator.bus["interface"], "-c", emulator.bus["channel"], *options]
    command = [sys.executable, "-c", "import narx.cli; narx.cli.main()", *connection, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_command_tells_why_an_image_is_refused(flash, tmp_path):
    with powered(with_bootloader(flash)) as emulator:
        # The image starts with the first connection, and connections are refused until the port is open.
        # `connect` repeats the attempt; the command does not.
        emulator.connect(can.Bus).shutdown()
        path = written(tmp_path, idle(448, bytes(64)))
        done = narx_command(emulator, "update", str(path))
    last = done.stderr.strip().splitlines()[-1]
    assert (done.returncode, last) == (2, "narx: the board's bootloader does not accept the signature")


@pytest.mark.skipif(not LONG, reason="takes minutes: NARX_LONG=1")
def test_the_whole_drive_is_programmed_by_the_command(flash, tmp_path):
    path = written(tmp_path, image("new"))
    begin = time.monotonic()
    with powered(with_bootloader(flash)) as emulator:
        emulator.connect(can.Bus).shutdown()
        done = narx_command(emulator, "update", str(path))
    assert done.returncode == 0, done.stderr
    major, minor, _, build = NEW
    assert done.stdout == f"software {major}.{minor}, build {build} runs\n"
    assert STAGES[-1] in done.stderr and "100%" in done.stderr
    print(f"{len(image('new'))} bytes in {time.monotonic() - begin:.0f} s")
    # The confirmed image still runs after a power cut.
    assert version_that_runs(flash) == NEW
