"""Traces of a run: named numpy arrays."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from narx import given, table
from narx.errors import ParameterError, SignalError
from narx.extras import need
from narx.names import suggestion
from narx.signals import DESCRIPTIONS, ENUMS, Fault

if TYPE_CHECKING:
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

    @property
    def descriptions(self) -> dict[str, str]:
        """Descriptions of the signals, in order: name -> meaning, and the place or instant in which it is
        measured; "" for a signal that is no one of a bench or a replay."""
        return {name: DESCRIPTIONS.get(name, "") for name in self._columns}

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

    def _repr_html_(self) -> str:
        parts = [summary(column) for column in self._columns.values()]
        columns = {"signal": list(self._columns), "unit": list(self._units.values())}
        columns |= {title: [part[place] for part in parts] for place, title in enumerate(("first", "least", "mean", "largest", "last"))}
        return table.html(f"narx.{type(self).__name__} of {len(self)} rows", columns | {"meaning": list(self.descriptions.values())}, rows=len(parts))

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._columns)

    def select(self, rows: Any) -> Trace:
        """Selects rows by a slice, a mask or an array of rows. The result has no recording. Raises
        ParameterError for rows that do not exist."""
        try:
            columns = {name: column[rows] for name, column in self._columns.items()}
        except (IndexError, TypeError) as error:
            raise ParameterError(f"rows {rows!r}: {error}") from None
        if any(column.ndim != 1 for column in columns.values()):
            raise ParameterError(f"rows {rows!r}: must be a slice, a mask or an array of rows")
        return Trace(columns, self._units)

    def between(self, start: float, end: float) -> Trace:
        """Selects the rows from `start` to before `end`, s on the trace's own time. The result has no
        recording. Raises ParameterError if there is no such row."""
        first, last = np.searchsorted(self.time, [start, end])
        if not first < last:
            span = f"from {self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "and there is none"
            raise ParameterError(f"start {start:g} s, end {end:g} s: must have rows between them {span}")
        return self.select(slice(first, last))

    def named(self, signal: str) -> NDArray[Any]:
        """Returns a signal that is a code as members of its enumeration, an array of objects of shape
        (rows,): "state" as `narx.State`, "step" as `narx.blocks.Step`, "limiter" as `narx.Limiter`, "crossing"
        as `narx.Crossing`, "faults" as flags of `narx.Fault`. Raises SignalError for any other."""
        values = self[signal]
        if signal not in ENUMS:
            raise SignalError(f'signal "{signal}" is no code{suggestion(signal, ENUMS)}; codes are {", ".join(ENUMS)}')
        kinds, places = np.unique(values.astype(np.int64), return_inverse=True)
        members = np.array([ENUMS[signal](int(kind)) for kind in kinds] + [None], object)[:-1]
        found: NDArray[Any] = members[places]
        return found

    def keys(self) -> KeysView[str]:
        """Names of the signals."""
        return self._columns.keys()

    def items(self) -> ItemsView[str, NDArray[np.float32 | np.float64]]:
        """Name and array of each signal."""
        return self._columns.items()

    def to_pandas(self, named: bool = False) -> DataFrame:
        """Returns the columns as a pandas data frame. With `named`, signals that are codes are categories with
        the names of their enumeration, of several faults with "|" between them. Raises MissingError without
        pandas."""
        pandas = need("pandas")
        frame: DataFrame = pandas.DataFrame(self._columns)
        for signal in ENUMS if named else ():
            if signal in self._columns:
                kinds, places = np.unique(self._columns[signal].astype(np.int64), return_inverse=True)
                names = [name_of(signal, int(kind)) for kind in kinds]
                frame[signal] = pandas.Categorical.from_codes(places, names)
        return frame

    def to_polars(self) -> Any:
        """Returns the columns as a polars data frame. Raises MissingError without polars."""
        return need("polars").DataFrame(self._columns)

    def to_xarray(self) -> Any:
        """Returns an xarray data set: a variable for each signal along "time" (s), with "units" and "long_name".
        Raises MissingError without xarray."""
        xarray = need("xarray")
        about = {name: {"units": unit, "long_name": self.descriptions[name]} for name, unit in self._units.items()}
        variables = {name: ("time", column, about[name]) for name, column in self._columns.items() if name != "time"}
        return xarray.Dataset(variables, coords={"time": ("time", self.time, about["time"])})

    def save(self, path: str | PathLike[str]) -> None:
        """Writes a table: `.csv`, `.parquet` or `.xlsx`; measurement data with units as `.mf4` (MDF 4); or the
        recording as `.narxrec`. Raises ParameterError for any other name and for a recording of a trace that
        has none, MissingError without the library of a format."""
        match table.check(path, ".mf4", ".narxrec"):
            case ".narxrec":
                if not self._recording:
                    raise ParameterError(f'path "{path}": this trace has no recording; a run of a bench has one')
                given.path(path).write_bytes(self._recording)
            case ".mf4":
                save_mdf(self, path)
            case _:
                table.save(self._columns, path)

    def plot(self, *signals: str) -> Figure:
        """Draws the signals over time, one panel for each unit; without names speed, currents, duty and
        state."""
        from narx.plot import plot

        return plot(self, signals)

    def recording(self) -> bytes:
        """Returns the recording of the drive's inputs from its last boot to the end of this trace, for
        `narx.replay` or a `.narxrec` file. It is empty if the trace is not a run of a bench."""
        return self._recording


def name_of(signal: str, kind: int) -> str:
    """Returns a code's name in lower case."""
    if signal == "faults":
        return "|".join(name.lower() for name, fault in Fault.__members__.items() if kind & fault)
    return str(ENUMS[signal](kind).name).lower()


def save_mdf(trace: Trace, path: str | PathLike[str]) -> None:
    """Writes a trace as MDF 4, every signal over "time", s."""
    mdf = need("asammdf")
    named = [(name, column) for name, column in trace.items() if name != "time" and column.dtype.kind in "iufb"]
    signals = [
        mdf.Signal(samples=column, timestamps=trace.time, name=name, unit=trace.signals[name], comment=trace.descriptions[name])
        for name, column in named
    ]
    with mdf.MDF(version="4.10") as file:
        file.append(signals, comment="narx")
        file.save(given.path(path), overwrite=True)


def summary(column: NDArray[Any]) -> list[Any]:
    """Returns first, least, mean, largest and last value of numbers; five times `None` of anything else."""
    if not len(column) or column.dtype.kind not in "iuf":
        return [None] * 5
    return [float(value) for value in (column[0], column.min(), column.mean(), column.max(), column[-1])]
