"""Logs for tests: random frames of all messages, in the formats that python-can writes."""

from pathlib import Path
from typing import Any

import can
import cantools
from cantools.database.can import Database
from cantools.database.can import Message as Described
from hypothesis import strategies as st

import narx

found = cantools.database.load_string(narx.dbc())
assert isinstance(found, Database)
DATABASE: Database = found
MESSAGES: list[Described] = list(DATABASE.messages)
PARAMETERS = list(narx.Parameters.rows.values())


@st.composite
def drive_frames(draw: st.DrawFn) -> can.Message:
    """Draws a frame of one of the drive's messages with random bits.

    The number of a parameter is one that exists, and its value is within its range.
    """
    described = draw(st.sampled_from(MESSAGES))
    data = bytearray(draw(st.binary(min_size=8, max_size=8)))
    if described.is_multiplexed():
        row = draw(st.sampled_from(PARAMETERS))
        raw = draw(st.integers(round(row.min / row.scale), round(row.max / row.scale)))
        data[:6] = row.number.to_bytes(2, "big") + (raw & 0xFFFFFFFF).to_bytes(4, "big")
    return can.Message(arbitration_id=described.frame_id, data=data, is_extended_id=True)


@st.composite
def any_frames(draw: st.DrawFn) -> can.Message:
    """Draws a classic data or remote frame, a CAN FD frame or an error frame."""
    kind = draw(st.sampled_from(["data", "data", "data", "remote", "fd", "error"]))
    if kind == "error":
        return can.Message(is_error_frame=True)
    extended = draw(st.booleans())
    options: dict[str, Any] = {
        "arbitration_id": draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF)),
        "is_extended_id": extended,
        "is_rx": draw(st.booleans()),
    }
    if kind == "remote":
        return can.Message(is_remote_frame=True, **options)
    if kind == "fd":
        length = draw(st.sampled_from([0, 1, 8, 12, 64]))
        data = draw(st.binary(min_size=length, max_size=length))
        return can.Message(is_fd=True, bitrate_switch=draw(st.booleans()), data=data, **options)
    return can.Message(data=draw(st.binary(max_size=8)), **options)


def stamped(frames: list[can.Message], start: float = 1436509052.25) -> list[can.Message]:
    """Stamps the frames with times, one millisecond apart."""
    for row, frame in enumerate(frames):
        frame.timestamp = round(start + row / 1000, 6)
        frame.channel = 0
    return frames


def write(path: Path, frames: list[can.Message]) -> Path:
    """Writes the frames with python-can, in the format of the path's ending."""
    with can.Logger(path) as logger:
        for frame in frames:
            logger.on_message_received(frame)
    return path
