"""Updates of a drive on a bench, and over a bus of python-can."""

import json
from pathlib import Path

import pytest
from signing import BENCH, SECRET, image, sign
from test_cli import run

import narx

BODY = bytes(range(256)) * 4


def write(folder: Path, data: bytes) -> Path:
    """Writes the data to a file."""
    path = folder / "drive.narximg"
    path.write_bytes(data)
    return path


def test_signatures_are_those_of_the_standard() -> None:
    """Signatures agree with the test vector of RFC 8032, section 7.3."""
    secret = bytes.fromhex("833fe62409237b9d62ec77587520911e9a759cec1d19755b7da901b96dca3d42")
    assert sign(secret, b"abc").hex() == (
        "98a70222f0b8121aa9d30f813d683f809e462b469c7ff87639499bb94e6dae4131f85042463c2a355a2003d062adf5aaa10b8c61e636062aaad11c2a26083406"
    )


def test_a_bench_is_programmed(bench: narx.Bench, tmp_path: Path) -> None:
    told: list[tuple[str, int]] = []

    def progress(stage: str, done: int, total: int) -> None:
        assert 0 <= done <= total == 512 + len(BODY)
        told.append((stage, done))

    bench.run(0.7)
    assert bench.drive.info.software == "0.1"
    bench.drive.update(write(tmp_path, image((0, 3, 1, 99), BODY)), progress)
    assert list(dict(told)) == ["asking", "erasing", "sending", "verifying", "restarting"]
    assert told[-1] == ("restarting", 512 + len(BODY)), "it ends with all that there is"
    assert (bench.drive.info.software, bench.drive.info.build_number) == ("0.3", 99)
    bench.drive.start(2000)
    assert bench.drive.state == narx.State.HALL_CLOSED_LOOP


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "the file has 0 bytes; the image needs 512"),
        (b"\x7fELF" + bytes(2000), "not an image: it does not begin with NARXIMG"),
        (image((0, 3, 0, 0), BODY)[:-8], "the file has 1528 bytes; the image needs 1536"),
        (image((0, 3, 0, 0), BODY) + b"x", "the file has 1537 bytes; the image needs 1536"),
        (image((0, 3, 0, 0), BODY, hardware=BENCH + 2), "for hardware 4E580002h, the drive is 4E580000h"),
        (image((0, 0, 9, 9), BODY), "version 0.0.9+9, older than the running version 0.1.0+1"),
        (image((0, 3, 0, 0), bytes(50 << 10)), "51712 bytes, the drive has room for 51200"),
    ],
)
def test_a_file_that_is_no_image_for_this_drive(
    bench: narx.Bench, tmp_path: Path, data: bytes, message: str
) -> None:
    bench.run(0.7)
    with pytest.raises(narx.ImageError, match=message.replace("+", r"\+")):
        bench.drive.update(write(tmp_path, data))
    assert bench.drive.info.software == "0.1"


def test_a_signature_of_somebody_else_is_refused_by_the_bootloader(bench: narx.Bench, tmp_path: Path) -> None:
    bench.run(0.7)
    with pytest.raises(narx.RefusedError, match="the board's bootloader does not accept the signature"):
        bench.drive.update(write(tmp_path, image((0, 3, 0, 0), BODY, secret=bytes(32))))
    assert SECRET != bytes(32) and bench.drive.info.software == "0.1"


def test_a_drive_that_drives_is_not_programmed(bench: narx.Bench, tmp_path: Path) -> None:
    bench.drive.start(2000)
    with pytest.raises(narx.RefusedError, match="not in Standby, nor in Fault at standstill"):
        bench.drive.update(write(tmp_path, image((0, 3, 0, 0), BODY)))
    assert bench.drive.state == narx.State.HALL_CLOSED_LOOP


def test_what_stops_progress_stops_the_update(bench: narx.Bench, tmp_path: Path) -> None:
    class Stop(Exception):
        pass

    def progress(stage: str, done: int, total: int) -> None:
        if stage == "sending" and done > 500:
            raise Stop

    bench.run(0.7)
    path = write(tmp_path, image((0, 3, 0, 0), BODY))
    with pytest.raises(Stop):
        bench.drive.update(path, progress)
    # The stopped update has released the drive: the motor starts, and the next image is accepted.
    bench.drive.start(2000)
    bench.drive.stop()
    bench.run(1.0)
    bench.drive.update(path)
    assert bench.drive.info.software == "0.3"


def test_the_command_programs_a_virtual_drive(tmp_path: Path) -> None:
    done = run("update", str(write(tmp_path, image((1, 0, 0, 7), BODY))), "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["software"] == "1.0"
    wrong = run("update", str(write(tmp_path, b"nothing")))
    assert wrong.returncode == 2 and wrong.stderr.strip().endswith("narx: the file has 7 bytes; the image needs 512")


def test_a_drive_that_only_receives_is_reached_without_waiting(tmp_path: Path) -> None:
    """Nobody is on the bus: waiting ends in an error, and so does the update, which says why."""
    with pytest.raises(narx.NoAnswerError, match="no frame of drive 170"):
        narx.connect("virtual", "empty", timeout=0.1)
    with narx.connect("virtual", "empty", timeout=0) as drive:
        with pytest.raises(narx.NoAnswerError, match="it may have no bootloader"):
            drive.update(write(tmp_path, image((0, 3, 1, 99), BODY)))
