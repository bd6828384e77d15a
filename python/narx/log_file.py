"""Readers of log files: narx's own for candump text, those of python-can for all other formats."""

from __future__ import annotations

import io
import re
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO
from warnings import warn

from narx import _core, given
from narx.can_log import CanLog
from narx.columns import FLAGS, LogError
from narx.errors import NarxWarning, ParameterError
from narx.extras import need
from narx.progress import bar

if TYPE_CHECKING:
    import can

BATCH = 10_000
"""Number of frames that are passed on at a time."""
CHUNK = 1 << 16
"""Number of packed bytes that are unpacked at a time: everything before a damaged place is kept."""
PART = 1 << 22
"""Number of bytes of a file that are read at a time: a cache holds them, and they occupy every processor."""
EXPANSION, EXPANDED = 200, 1 << 26
"""Largest ratio of unpacked to packed bytes once there are this many: logs are packed 5- to 20-fold."""
GZIP = zlib.MAX_WBITS | 16
TOLD = 200
"""Number of characters of a line that an error shows."""

ASC_FRAME = re.compile(r"\s*\d+\.\d+\s+(?:\d+\s+[0-9a-f]+x?(?:\s+(?!J1939)|$)|CANFD\b)", re.I)
ASC_OTHER = re.compile(r"\s*(?:$|//|date\b|base\b|(?:no\s+)?internal\s+events|begin\b|end\b|\d+\.\d+\s)", re.I)
TRC_STATUS = {"Warng", "Error", "ST", "EC", "ER", "EV", "FFFFFFFF"}


def read_log(
    path: str | PathLike[str],
    *,
    slave: int | None = 170,
    monitor: int | None = 85,
    encoders: Iterable[int] = (),
    progress: bool | None = None,
) -> CanLog:
    """Reads and decodes a log of a CAN bus. The suffix of the file determines its format, as in
    `can.LogReader`: `.log` (candump), `.asc`, `.blf`, `.csv`, `.trc`, `.db`, `.mf4`; all but the last two
    also with `.gz` behind it.

    slave, monitor: addresses of the drive and its master; `None` for any. encoders: node-ids of TX-Drivers
    with two channels whose PDOs contain the encoder's value. Parts that are no frame are skipped and listed
    in `errors`, as is the end of a truncated file. A NarxWarning says that the clock of the log jumps back:
    see `CanLog.laps`. Formats other than candump need python-can. progress shows a progress bar of tqdm, by
    default after 1 s if tqdm is installed and the output is a terminal or a notebook.
    """
    path = given.path(path)
    nodes = given.several("encoders", encoders)
    reader = _core.LogReader(slave, monitor, nodes)
    errors: list[LogError] = []
    *_, ending, packing = ["", "", *(suffix.lower() for suffix in path.suffixes)]
    if packing != ".gz":
        ending = packing
    if ending == ".log":
        with bar(path.stat().st_size / 1e6, "MB", progress) as step:
            for part, size in unpacked(path, errors):
                reader.candump(part)
                step(size / 1e6)
    else:
        with bar(None, "frames", progress) as step:
            for batch in batches(frames(path, ending, errors), errors):
                reader.frames(batch)
                step(len(batch))
    return told(CanLog(reader, errors, nodes), path)


def read_candump(text: bytes, slave: int | None, monitor: int | None, encoders: Iterable[int]) -> CanLog:
    """Decodes a text of candump; arguments as those of `read_log`."""
    nodes = given.several("encoders", encoders)
    reader = _core.LogReader(slave, monitor, nodes)
    reader.candump(text)
    return told(CanLog(reader, (), nodes), "-")


def told(log: CanLog, path: str | Path) -> CanLog:
    """Returns the log; a warning says that its clock jumps back."""
    if jumps := len(log.laps) - 1:
        times = "once" if jumps == 1 else f"{jumps} times"
        warn(f'the clock of "{path}" jumps back {times}: `laps` has each part', NarxWarning, stacklevel=3)
    return log


def contents(path: Path, errors: list[LogError]) -> bytes:
    """Returns the bytes of a file, unpacked up to the first damage."""
    return b"".join(part for part, _ in unpacked(path, errors))


def unpacked(path: Path, errors: list[LogError]) -> Iterator[tuple[bytes, int]]:
    """Yields the bytes of a file part by part, unpacked up to the first damage, each with the number of bytes
    that it has in the file."""
    with path.open("rb") as file:
        if path.suffix.lower() != ".gz":
            while part := file.read(PART):
                yield part, len(part)
            return
        yield from members(file, errors)


def members(file: BinaryIO, errors: list[LogError]) -> Iterator[tuple[bytes, int]]:
    """Unpacks a .gz file, which may have several members with zeros between them."""
    read = size = 0
    member, begun = zlib.decompressobj(GZIP), False
    try:
        while packed := file.read(CHUNK):
            count = len(packed)
            read += count
            while packed := packed if begun else packed.lstrip(b"\0"):
                part = member.decompress(packed)
                yield part, count
                count, size = 0, size + len(part)
                if size > EXPANDED and size > EXPANSION * read:
                    errors.append(LogError(None, "", f"expands more than {EXPANSION}-fold: reading ended after {size} bytes"))
                    return
                packed, begun = member.unused_data, not member.eof
                if member.eof:
                    member = zlib.decompressobj(GZIP)
    except zlib.error as error:
        errors.append(LogError(None, "", f"damaged: {error}"))
    else:
        if begun:
            errors.append(LogError(None, "", "truncated: the end of the packed data is missing"))


Found = tuple["can.Message", int | None, str]
"""A message of python-can, with its line if there is one."""


def frames(path: Path, ending: str, errors: list[LogError]) -> Iterator[Found]:
    """Yields the messages of a file in a format that python-can reads."""
    formats = need("can").io
    texts: dict[str, tuple[Callable[..., Iterable[can.Message]], Callable[[str], bool]]] = {
        ".asc": (formats.ASCReader, lambda line: bool(ASC_FRAME.match(line)) or not ASC_OTHER.match(line)),
        ".csv": (formats.CSVReader, lambda line: not line.startswith("timestamp,")),
        ".trc": (formats.TRCReader, lambda line: line.strip()[:1] not in ("", ";") and not TRC_STATUS & {*line.split()}),
    }
    if ending in texts:
        read, expected = texts[ending]
        yield from text_frames(contents(path, errors), read, expected, errors)
    elif ending == ".blf":
        yield from blf_frames(contents(path, errors), errors)
    else:
        yield from other_frames(path, errors)


class Lines:
    """Lines for a reader of python-can that makes at most one message of a line. It records the lines that
    the reader skips or fails on."""

    def __init__(self, text: Iterable[str], expected: Callable[[str], bool], errors: list[LogError]) -> None:
        self._text = iter(text)
        self._expected = expected
        self._errors = errors
        self._blank = False
        self.settled = True
        """True once the outcome of the last line is known."""
        self.number = 0
        self.line = ""

    def __iter__(self) -> Lines:
        return self

    def __next__(self) -> str:
        if self._blank:
            self._blank = False
            return "\n"
        self.settle()
        self.line = next(self._text)
        self.number += 1
        self.settled = False
        return self.line

    def close(self) -> None:
        """Does nothing: there is no open file."""

    def insert_blank(self) -> None:
        """Inserts a blank line next: a reader takes the first line after its start for a header, or for the
        end of one."""
        self._blank = True

    def settle(self, reason: str | None = None) -> None:
        """Settles the last line, which made no message. Without a reason the reader skipped it; that is an
        error only if a frame was expected."""
        if not self.settled and (reason or self._expected(self.line)):
            told = reason or "python-can reads no frame from it"
            self._errors.append(LogError(self.number, self.line.strip()[:TOLD], told))
        self.settled = True

    def take(self) -> None:
        """Settles the last line as a frame."""
        self.settled = True


def text_frames(
    data: bytes,
    read: Callable[..., Iterable[can.Message]],
    expected: Callable[[str], bool],
    errors: list[LogError],
) -> Iterator[Found]:
    """Yields the messages of a text. After an error of its reader it goes on with the next line."""
    text = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig", errors="replace")
    lines = Lines(text, expected, errors)
    if re.match(rb"\s*\d+\.\d+[\s,]", data):
        # Without a header the first line is a frame.
        lines.insert_blank()
    reader = read(lines)
    while True:
        try:
            for message in reader:
                lines.take()
                yield message, lines.number, lines.line
            lines.settle()
            return
        except (ValueError, LookupError, TypeError) as error:
            if lines.settled:
                errors.append(LogError(None, "", f"not a log of this format: {error}"))
                return
            lines.settle(str(error) or type(error).__name__)
            lines.insert_blank()


def blf_frames(data: bytes, errors: list[LogError]) -> Iterator[Found]:
    """Yields the messages of a binary log, up to its first damage."""
    from can import io as formats
    from can.io.blf import BLFParseError

    reader = None
    reason = ""
    try:
        reader = formats.BLFReader(io.BytesIO(data))
        for message in reader:
            yield message, None, ""
    except (BLFParseError, struct.error, zlib.error, ValueError) as error:
        reason = str(error) or "no object at the expected place"
    announced = reader.file_size if reader is not None else None
    if announced is not None and announced > len(data):
        errors.append(LogError(None, "", f"truncated: {len(data)} of {announced} bytes"))
    elif reason:
        errors.append(LogError(None, "", f"damaged: {reason}" if reader else f"not a log of this format: {reason}"))
    elif getattr(reader, "_tail", b"").strip(b"\0"):
        # The reader ignores an incomplete last object without an error.
        errors.append(LogError(None, "", "damaged: the last object is not complete"))


def other_frames(path: Path, errors: list[LogError]) -> Iterator[Found]:
    """Yields the messages of any other format that python-can reads."""
    import can

    path.stat()
    try:
        reader = can.LogReader(path)
    except (ValueError, NotImplementedError) as error:
        raise ParameterError(f'path "{path}": {error}') from None
    count = 0
    try:
        for message in reader:
            count += 1
            yield message, None, ""
    except Exception as error:  # noqa: BLE001 - its readers raise what their libraries do
        errors.append(LogError(None, "", f"reading ended after {count} frames: {error}"))


Given = tuple[float, str, int, int, int, bytes]


def batches(found: Iterator[Found], errors: list[LogError]) -> Iterator[list[Given]]:
    """Groups frames for the core's reader; messages that cannot be frames become errors."""
    batch: list[Given] = []
    for message, line, text in found:
        reason = flaw(message)
        if reason:
            errors.append(LogError(line, text.strip()[:TOLD], reason))
            continue
        batch.append(parts(message))
        if len(batch) == BATCH:
            yield batch
            batch = []
    yield batch


def flaw(message: Any) -> str | None:
    """Returns the reason why a message is not a possible CAN frame; `None` if it is."""
    if message.is_error_frame:
        return None
    bits = 29 if message.is_extended_id else 11
    if not 0 <= message.arbitration_id < 1 << bits:
        return f"identifier {message.arbitration_id:#x}: must have {bits} bits"
    most = 64 if message.is_fd else 8
    if not 0 <= message.dlc <= most:
        return f"{message.dlc} data bytes: must be at most {most}"
    if not message.is_remote_frame and len(message.data) != message.dlc:
        return f"{len(message.data)} data bytes where there should be {message.dlc}"
    return None


def parts(message: can.Message) -> Given:
    """Converts a message for the core's reader."""
    flags = (
        FLAGS["extended"] * message.is_extended_id
        | FLAGS["remote"] * message.is_remote_frame
        | FLAGS["error"] * message.is_error_frame
        | FLAGS["fd"] * message.is_fd
        | FLAGS["received"] * message.is_rx
        | FLAGS["bitrate_switch"] * message.bitrate_switch
        | FLAGS["error_state"] * message.error_state_indicator
    )
    channel = "" if message.channel is None else str(message.channel)
    number, data = message.arbitration_id & 0x1FFF_FFFF, bytes(message.data or b"")
    return message.timestamp, channel, flags, number, min(message.dlc, 64), data[:64]
