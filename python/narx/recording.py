"""Replaying recordings."""

from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING

from narx import _core, given
from narx.trace import Trace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Replay(Trace):
    """A replayed recording: the trace of the drive's outputs (numpy arrays, a row per control tick), and the
    comparison with the recorded ones."""

    ticks: int
    """Number of ticks that ran."""
    digest: int
    """Digest of the outputs of this replay."""
    recorded_digest: int | None
    """Digest of the outputs when they were recorded; `None` when only a part ran."""
    outputs: str | None
    """Outputs of the last tick, every field in raw bits; `None` when no tick ran."""
    label: str
    """Label of the recording."""
    same_behaviour: bool
    """True if the recording version has the same behaviour as this one. If not, the digests may rightly
    differ."""

    def __init__(
        self,
        columns: "Mapping[str, NDArray[np.float32 | np.float64]]",
        units: Mapping[str, str],
        recording: bytes,
    ) -> None:
        super().__init__(columns, units, recording)

    @property
    def identical(self) -> bool | None:
        """True if every output was the same, bit for bit; `None` when only a part ran."""
        return None if self.recorded_digest is None else self.recorded_digest == self.digest

    def __repr__(self) -> str:
        verdict = {True: "identical", False: "not identical", None: "a part of the recording"}[self.identical]
        return f"<narx.Replay of {self.ticks} ticks: digest {self.digest:016x}, {verdict}>"


def replay(recording: bytes | bytearray | str | PathLike[str], until: int | None = None) -> Replay:
    """Runs a drive through a recording, or its first `until` ticks, and compares its outputs with the
    recorded ones.

    A transcript of the calls of a drive's node or of a TX-Driver runs as well: its ticks are calls, and it
    has no columns. `recording` is the recording's bytes, or the path of a file. Raises RecordingError for
    bytes that are no recording.
    """
    data = bytes(recording) if isinstance(recording, bytes | bytearray) else given.path(recording, "recording").read_bytes()
    columns, units, ticks, digest, recorded, outputs, label, same = _core.replay(data, until)
    result = Replay(columns, units, data)
    result.ticks, result.digest, result.recorded_digest = ticks, digest, recorded
    result.outputs, result.label, result.same_behaviour = outputs, label, same
    return result
