"""Rows of a run as it goes on: chosen, thinned out, in memory or in a file."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from narx import _core, given
from narx.errors import ParameterError, SignalError
from narx.extras import need
from narx.names import suggestion
from narx.trace import Trace


class Rows:
    """Rows that a bench keeps during a run. As a context manager it ends that, and closes the file."""

    def __init__(
        self,
        bench: _core.Bench,
        kept: bool,
        signals: Sequence[str] | None,
        every: int,
        to: str | PathLike[str] | None,
        seconds: float,
    ) -> None:
        self._bench = bench
        known = [name for name, _ in bench.signals()]
        names = known if signals is None else checked(signals, known)
        self._path = None if to is None else parquet(to)
        self._file: Any = None
        bench.keep_rows([known.index(name) for name in names], every)
        if not kept:
            bench.keep_no_rows()
        elif self._path is None:
            bench.reserve_rows(seconds)

    def pass_on(self) -> None:
        """Writes the rows since the previous call to the file, if there is one."""
        if self._path is None:
            return
        columns, _ = self._bench.take_rows()
        table = need("pyarrow").table(columns)
        if self._file is None:
            self._file = need("pyarrow.parquet").ParquetWriter(self._path, table.schema)
        self._file.write_table(table)

    def end(self) -> Trace:
        """Returns the rows that are in no file."""
        self.pass_on()
        return Trace(*self._bench.take_rows(), self._bench.recording())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._bench.keep_no_rows()
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
