"""Traces of a run: named numpy arrays."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from narx import table
from narx.errors import SignalError
from narx.names import suggestion

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray
    from pandas import DataFrame


class Trace:
    """A table of signals, a row per sample: `trace["speed"]` is a numpy array of shape (rows,)."""

    def __init__(
        self,
        columns: Mapping[str, NDArray[np.float32 | np.float64]],
        units: Mapping[str, str],
        recording: bytes = b"",
    ) -> None:
        self._columns = dict(columns)
        self._units = dict(units)
        self._recording = recording

    @property
    def time(self) -> NDArray[np.float64]:
        """Time of each row, s: since power-up, or since the trigger in a capture of the scope."""
        return self["time"]  # type: ignore[return-value]

    @property
    def signals(self) -> dict[str, str]:
        """Units of the signals, in order: name -> unit; "" for plain numbers."""
        return dict(self._units)

    def __getitem__(self, signal: str) -> NDArray[np.float32 | np.float64]:
        try:
            return self._columns[signal]
        except (KeyError, TypeError):
            hint = suggestion(signal, self._columns)
            names = ", ".join(self._columns)
            raise SignalError(f'there is no signal "{signal}"{hint}; there are {names}') from None

    def __contains__(self, signal: object) -> bool:
        return signal in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """Number of rows."""
        return len(next(iter(self._columns.values()), ()))

    def __repr__(self) -> str:
        return f"<narx.{type(self).__name__} of {len(self)} rows: {', '.join(self)}>"

    def keys(self) -> KeysView[str]:
        """Names of the signals."""
        return self._columns.keys()

    def items(self) -> ItemsView[str, NDArray[np.float32 | np.float64]]:
        """Name and array of each signal."""
        return self._columns.items()

    def to_pandas(self) -> DataFrame:
        """Returns the columns as a pandas data frame."""
        from pandas import DataFrame

        return DataFrame(self._columns)

    def save(self, path: str | PathLike[str]) -> None:
        """Writes a table: `.csv`, `.parquet` or `.xlsx`, or the recording as `.narxrec`. Raises
        ParameterError for any other name."""
        if table.check(path, ".narxrec") == ".narxrec":
            Path(path).write_bytes(self._recording)
        else:
            table.save(self.to_pandas(), path)

    def plot(self, *signals: str) -> Figure:
        """Draws the signals over time, one panel for each unit; without names speed, currents, duty and
        state."""
        from narx.plot import plot

        return plot(self, signals)

    def recording(self) -> bytes:
        """Returns the recording of the drive's inputs from its last boot to the end of this trace, for
        `narx.replay` or a `.narxrec` file. It is empty if the trace is not a run of a bench."""
        return self._recording
