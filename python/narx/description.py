"""Description of a drive: parameters, measurements and scope signals, from the XML text that the drive itself
serves.

The tables of this package describe its own version of the drive. They are used until a drive's description
has been read, and for a drive that serves none.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from zlib import crc32

from narx import _core
from narx.download import download
from narx.errors import DescriptionWarning, NarxError, NoAnswerError, RefusedError
from narx.link import Link, ask


@dataclass(frozen=True)
class Row:
    """Properties of one parameter, without its value."""

    number: int
    name: str
    category: str
    unit: str
    """Unit of the values; "" without one."""
    type: Literal["uint16", "int32", "uint32"]
    scale: float
    """Step of the value: the value of a raw 1."""
    min: float
    max: float
    factory: float
    """Factory value."""
    access: str
    """"live", "stopped" (in Standby, and in Fault at standstill) or "read-only"."""
    command: bool
    """True for a command: writing 0, then 1 executes it."""
    acts: str
    """Time at which a written value takes effect."""
    description: str


class Description:
    """The tables of a drive: from the text that it serves, or without a text those of this package. Raises
    RefusedError for a text that cannot be read."""

    def __init__(self, text: bytes | None = None) -> None:
        self.core = _core.Description(text)
        self.rows: Mapping[int, Row] = {row["number"]: Row(**row) for row in self.core.parameters()}
        """Parameters by number."""
        self.signals = {name: (bit, unit, base) for bit, name, unit, base in sorted(self.core.scope_signals())}
        """Signals of the scope in the order of their bits: bit, unit, and value of a sample of 1."""


def whole_words(text: bytes) -> bytes:
    """Returns the text as it is downloaded, in whole words."""
    return text + b"\n" * (len(text) % 2)


OWN = Description()
_known = {(1, crc32(whole_words(_core.xml().encode()))): OWN}


def describe(link: Link) -> Description:
    """Returns the tables of a link's drive. The first call reads them from the drive, unless a description
    with the same build number and CRC was read before on this computer. A silent master and a drive that does
    not answer get the tables of this package."""
    if link.is_described or link.master.silent:
        return link.description or OWN
    try:
        ask(link, lambda: link.master.request("build info"))
    except NoAnswerError:
        # The drive does not answer; the caller's next request raises the error.
        return link.description or OWN
    link.is_described = True
    link.description = None
    try:
        link.description = read(link)
        link.master.describe(link.description.core)
    except NarxError as error:
        link.master.describe(OWN.core)
        warnings.warn(
            f"the drive's description cannot be read ({error}): names, units, scales and ranges are those of this package",
            DescriptionWarning,
            stacklevel=3,
        )
    return link.description or OWN


def read(link: Link) -> Description:
    """Reads build number and CRC of the drive's description, and downloads the description if it is not
    known."""
    ask(link, lambda: link.master.request("description info"))
    build, told = link.master.build, link.master.description
    number, check = build[0] if build else 0, told[1] if told else 0
    if check and (number, check) in _known:
        return _known[number, check]
    file = folder() / f"description-{number}-{check:08x}.xml"
    text = kept(file, check)
    if text is None:
        text = download(link, "description", progress=False)
        if check and crc32(text) != check:
            raise RefusedError(f"CRC {crc32(text):08x} of the download differs from {check:08x}, which the drive reports")
    description = Description(text)
    if check:
        _known[number, check] = description
        keep(file, text)
    return description


def folder() -> Path:
    """Returns the folder of stored descriptions."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home())) / "narx"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "narx"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "narx"


def kept(file: Path, check: int) -> bytes | None:
    """Returns a stored description, or `None` if it is absent or damaged."""
    try:
        text = file.read_bytes() if check else b""
    except OSError:
        return None
    return text if check and crc32(text) == check else None


def keep(file: Path, text: bytes) -> None:
    """Stores a description atomically. If it cannot be stored, the next program downloads it again."""
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        part = file.with_suffix(f".{os.getpid()}")
        part.write_bytes(text)
        part.replace(file)
