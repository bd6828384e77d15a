"""python-can reads the logs that narx writes: every frame, to the microsecond.

`cargo xtask test` writes the samples and runs this; NARX_INTEROP names their folder.
"""

import csv
import os
from pathlib import Path

import can
import pytest

SAMPLES = Path(os.environ["NARX_INTEROP"])


@pytest.fixture(scope="module")
def messages():
    with can.LogReader(SAMPLES / "frames.log") as reader:
        return list(reader)


@pytest.fixture(scope="module")
def expected():
    with open(SAMPLES / "frames.csv", newline="") as table:
        return list(csv.DictReader(table))


def test_every_frame_reads_back(messages, expected):
    assert len(messages) == len(expected) == 1 + 9 * 3 * 2
    for message, row in zip(messages, expected, strict=True):
        assert round(message.timestamp * 1e6) == int(row["micros"])
        assert message.arbitration_id == int(row["id"])
        assert message.is_extended_id == (row["extended"] == "1")
        assert message.is_remote_frame == (row["remote"] == "1")
        assert message.dlc == int(row["length"])
        assert bytes(message.data) == bytes.fromhex(row["data"])
        assert message.channel == "can0"
        assert message.is_rx and not message.is_error_frame and not message.is_fd


def test_the_drive_request_of_the_specification(messages):
    (request,) = [m for m in messages if m.arbitration_id == 0x0AAD5202]
    assert request.is_extended_id and not request.is_remote_frame
    assert bytes(request.data) == bytes([0, 0, 0, 1, 0, 0, 0, 0])


def test_frames_follow_each_other_on_the_wire(messages):
    # At 500 kbit/s no frame is shorter than 47 bits, none longer than 160.
    steps = [b.timestamp - a.timestamp for a, b in zip(messages, messages[1:])]
    assert all(47 * 2e-6 - 1e-6 <= step <= 160 * 2e-6 + 1e-6 for step in steps)
