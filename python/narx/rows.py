"""Rows of a run as it goes on: chosen, thinned out, in memory or in a file."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from narx import _core, given
from narx.errors import ParameterError, SignalError
from narx.extras import need
from narx.names import suggestion
from narx.trace import Trace

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Rows:
    """Takes the rows of a bench. As a context manager it closes the file."""

    def __init__(
        self, bench: _core.Bench, signals: Sequence[str] | None, every: int, to: str | PathLike[str] | None
    ) -> None:
        self._bench = bench
        self._every = _core.whole_number("every", every, 1, 1_000_000)
        columns, units = bench.take_rows()
        names = list(units) if signals is None else checked(signals, list(units))
        self._units = {name: units[name] for name in names}
        self._parts: dict[str, list[NDArray[Any]]] = {name: [columns[name][:0]] for name in names}
        self._seen = 0
        # Without thinning out, the simulation keeps the rows, so that nothing is copied.
        self._whole = signals is None and self._every == 1 and to is None
        self._path = None if to is None else parquet(to)
        self._file: Any = None

    def take(self, kept: bool) -> None:
        """Takes the rows since the previous call; `kept` is false where the bench keeps none."""
        if self._whole or not kept:
            return
        columns, _ = self._bench.take_rows()
        count = len(columns["time"])
        # The last row of each `every` ticks of the run.
        first = (self._every - 1 - self._seen) % self._every
        self._seen += count
        taken = {name: columns[name][first :: self._every] for name in self._units}
        if self._path is not None:
            self._write(taken)
            return
        for name, part in self._parts.items():
            # A copy, because a view would keep every row.
            part.append(taken[name].copy() if self._every > 1 else taken[name])

    def _write(self, columns: dict[str, NDArray[Any]]) -> None:
        arrow = need("pyarrow")
        table = arrow.table(columns)
        if self._file is None:
            self._file = need("pyarrow.parquet").ParquetWriter(self._path, table.schema)
        self._file.write_table(table)

    def end(self) -> Trace:
        """Takes the last rows; returns the trace."""
        recording = self._bench.recording()
        if self._whole:
            columns, units = self._bench.take_rows()
            return Trace(columns, units, recording)
        self.take(True)
        columns = {}
        for name in self._units:
            columns[name] = np.concatenate(self._parts.pop(name))
        return Trace(columns, self._units, recording)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._file is not None:
            self._file.close()


def checked(signals: Sequence[str], known: list[str]) -> list[str]:
    """Returns names of signals, "time" first."""
    if isinstance(signals, str | bytes):
        raise ParameterError(f"signals {signals!r}: must be a list of names")
    for name in signals:
        if name not in known:
            raise SignalError(f'there is no signal "{name}"{suggestion(str(name), known)}; there are {", ".join(known)}')
    return list(dict.fromkeys(["time", *signals]))


def parquet(path: str | PathLike[str]) -> Path:
    """Returns the path of a Parquet file."""
    found = given.path(path, "to")
    if found.suffix.lower() != ".parquet":
        raise ParameterError(f'to "{found}": must end in .parquet')
    need("pyarrow.parquet")
    return found
