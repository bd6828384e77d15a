"""Replaying recordings."""

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from narx import _core
from narx.trace import Trace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Replay(Trace):
    """A recording that ran again: a trace of what the drive answered (numpy arrays, a row per control tick), and whether it was the same."""

    ticks: int
    """Ticks that ran."""
    digest: int
    """Digest of the outputs now."""
    recorded_digest: int | None
    """Digest of the outputs when they were recorded; `None` when only a part ran."""
    outputs: str | None
    """What the last tick answered, every field in raw bits; `None` when none ran."""
    label: str
    """The recording's label."""
    same_behaviour: bool
    """Whether the version that recorded behaves as this one. If not, the digests may rightly differ."""

    def __init__(
        self,
        columns: "Mapping[str, NDArray[np.float32 | np.float64]]",
        units: Mapping[str, str],
        recording: bytes,
    ) -> None:
        super().__init__(columns, units, recording)

    @property
    def identical(self) -> bool | None:
        """Whether every output was the same, bit for bit; `None` when only a part ran."""
        return None if self.recorded_digest is None else self.recorded_digest == self.digest

    def __repr__(self) -> str:
        verdict = {True: "identical", False: "not identical", None: "a part of the recording"}[self.identical]
        return f"<narx.Replay of {self.ticks} ticks: digest {self.digest:016x}, {verdict}>"


def replay(recording: bytes | bytearray | str | PathLike[str], until: int | None = None) -> Replay:
    """Runs a drive through a recording, or its first `until` ticks, and compares what it answers with what was recorded.

    A transcript, of what a drive's node or a TX-Driver was told and asked, runs as well: its ticks are calls, and it has no columns. `recording` is
    the recording's bytes, or the path of a file. Raises RecordingError for bytes that are no recording.
    """
    data = bytes(recording) if isinstance(recording, bytes | bytearray) else Path(recording).read_bytes()
    columns, units, ticks, digest, recorded, outputs, label, same = _core.replay(data, until)
    result = Replay(columns, units, data)
    result.ticks, result.digest, result.recorded_digest = ticks, digest, recorded
    result.outputs, result.label, result.same_behaviour = outputs, label, same
    return result
