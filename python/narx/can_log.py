"""Logs of a CAN bus as numpy columns: the result of `narx.read_log`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from narx import _core, table
from narx.columns import Frames, LogError, Series, Table, folded
from narx.errors import SignalError
from narx.extras import need
from narx.messages import Message, NodeMessage, decode_parts
from narx.names import suggestion
from narx.parameters import Parameters

if TYPE_CHECKING:
    from pandas import DataFrame

UNKNOWN, MALFORMED, ERROR = _core.frame_kinds()
FAULTS = dict(_core.fault_bits())

ALIASES = {
    "status": ("STATUS_WORD", None),
    "setpoint": ("MOTOR_CMD_SET", "Speed"),
    "faults": ("FAULT_WORD", "Faults"),
    "busvoltage": ("MEASUREMENT_2", "HV Voltage"),
    "buscurrent": ("MEASUREMENT_2", "HV Current"),
    "temperature": ("MEASUREMENT_3", "Ambient Temperature"),
}
"""Names of a bench for signals that have another name in the protocol. `speed` is computed: see
`CanLog.speed`."""
LAP = 1.0
"""A clock that jumps back further begins a lap, s. The stamps of several channels may be a little out of
order."""
HALL = "Hall closed loop"


class CanLog:
    """A decoded log. `log["STATUS_WORD"]` is the table of a message, `log["PDO1", 2]` that of one node,
    `log["HV Voltage"]` a signal over time from whichever message carries it, or a parameter's value from the
    drive's answers. `log["speed"]` is the speed that the control uses. Names are those of the CAN data base,
    of `narx.decode` or of a bench; case and punctuation do not matter.
    """

    def __init__(self, reader: _core.LogReader, errors: Iterable[LogError] = (), encoders: Iterable[int] = ()) -> None:
        columns, channels, tables, refused, lines = reader.finish()
        self.frames = Frames(**columns, channels=tuple(channels))
        """Every frame of the log, decoded or not."""
        self.errors = [*(LogError(*error) for error in refused), *errors]
        """Parts of the log that are no frame, in the order of the lines; they were skipped."""
        self.lines = lines
        """Number of lines of a candump log; 0 of other formats."""
        self._raw = tables
        self._places = {folded(name): place for place, (name, *_) in enumerate(tables)}
        self._tables: dict[int, Table] = {}
        self._encoders = frozenset(encoders)

    @cached_property
    def laps(self) -> tuple[CanLog, ...]:
        """The parts between jumps of the log's clock back by more than a second (a logger that was restarted,
        files that were joined), each a log of its own without `errors`; a log whose clock does not jump has
        one."""
        begins = np.flatnonzero(np.diff(self.frames.time) < -LAP) + 1
        if not len(begins):
            return (self,)
        edges = [0, *begins.tolist(), len(self)]
        return tuple(self._part(begin, end) for begin, end in zip(edges, edges[1:], strict=False))

    def _part(self, begin: int, end: int) -> CanLog:
        """Returns the frames from `begin` to before `end` as a log."""
        part = CanLog.__new__(CanLog)
        part.frames, part.errors, part.lines = self.frames[begin:end], [], 0
        part._raw = []
        for place, (name, from_device, time, columns) in enumerate(self._raw):
            first, last = (int(np.count_nonzero(self.frames.message[:edge] == place)) for edge in (begin, end))
            part._raw.append((name, from_device, time[first:last], [(signal, column[first:last]) for signal, column in columns]))
        part._places, part._tables, part._encoders = self._places, {}, self._encoders
        return part

    @cached_property
    def unknown(self) -> Frames:
        """Frames that belong to no known protocol, CAN FD among them, or that are between other addresses."""
        return self.frames[self.frames.message == UNKNOWN]

    @cached_property
    def malformed(self) -> Frames:
        """Frames with the identifier of a message but another length, a remote flag, or an undefined
        value."""
        return self.frames[self.frames.message == MALFORMED]

    @cached_property
    def error_frames(self) -> Frames:
        """Errors on the bus that the adapter has logged; `id` is the class of the error."""
        return self.frames[self.frames.message == ERROR]

    @property
    def counts(self) -> dict[str, int]:
        """Number of frames of each message in the log, in the order of the protocol."""
        return {name: len(time) for name, _, time, _ in self._raw if len(time)}

    @property
    def signals(self) -> dict[str, str]:
        """Signals of the messages in the log: name -> unit."""
        return {
            signal: unit for _, _, time, columns in self._raw if len(time) for (signal, unit, _), _ in columns
        }

    def __iter__(self) -> Iterator[str]:
        """Iterates over the names of the messages in the log."""
        return iter(self.counts)

    def _ipython_key_completions_(self) -> list[str]:
        return [*self, *self.signals]

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and folded(key) in map(folded, (*self.counts, *self.signals))

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.frames)

    def __repr__(self) -> str:
        rows = [f"  {name}: {count}" for name, count in self.counts.items()]
        others = {"unknown": self.unknown, "malformed": self.malformed, "error frames": self.error_frames}
        rows += [f"  {name}: {len(frames)}" for name, frames in others.items() if len(frames)]
        return "\n".join([f"<narx.CanLog of {len(self)} frames, {len(self.errors)} errors", *rows, ">"])

    def __getitem__(self, key: str | tuple[str, int]) -> Any:
        if isinstance(key, tuple):
            name, node = key
            table = self.table(name)
            if "Node" not in table:
                raise SignalError(f"{table.name} is not a message of a node")
            return table.select(table["Node"] == node)
        name = folded(key)
        if name == "speed":
            return self.speed
        if name in self._places:
            return self.table(key)
        if name in ALIASES:
            message, signal = ALIASES[name]
            return self.table(message) if signal is None else self.table(message).series(signal)
        return self._signal(key)

    def table(self, message: str) -> Table:
        """Returns every message of this name; none if none came. Raises SignalError for a name that no
        message has."""
        try:
            place = self._places[folded(message)]
        except KeyError:
            names = [name for name, *_ in self._raw]
            raise SignalError(f'there is no message "{message}"{suggestion(message, names)}') from None
        if place not in self._tables:
            self._tables[place] = table_of(*self._raw[place])
        return self._tables[place]

    @property
    def speed(self) -> Series:
        """Mechanical speed, rpm, as estimated from the source that the control mode uses: the hall sensors in
        hall closed loop, else back-EMF."""
        hall, sensorless, status = map(self.table, ("MEASUREMENT_5", "MEASUREMENT_1", "STATUS_WORD"))
        modes = status.names["Control mode"]
        control = np.array([modes.get(int(mode)) == HALL for mode in status["Control mode"]], bool)
        told = self._rows(status)
        times, values, rows = [], [], []
        for table, signal, is_hall in (
            (hall, "Mechanical estimated speed HES", True),
            (sensorless, "Mechanical estimated speed SL", False),
        ):
            row = self._rows(table)
            # The status before the measurement determines the mode; before the first status the mode counts
            # as not hall.
            last = np.searchsorted(told, row) - 1
            mode = np.zeros(len(row), bool)
            mode[last >= 0] = control[last[last >= 0]]
            used = mode == is_hall
            times.append(table.time[used])
            values.append(table[signal][used])
            rows.append(row[used])
        order = np.argsort(np.concatenate(rows))
        return Series("speed", "rpm", np.concatenate(times)[order], np.concatenate(values)[order], {})

    def messages(self) -> Iterator[tuple[float, Message | NodeMessage]]:
        """Yields time, s, and content of every decoded message, in the order of the log."""
        frames = self.frames[self.frames.message < ERROR]
        extended, remote = frames.flag("extended"), frames.flag("remote")
        for row in range(len(frames)):
            number, length = int(frames.id[row]), int(frames.dlc[row])
            encoder = not extended[row] and number & 0x7F in self._encoders
            data = frames.data[row, :length].tobytes()
            message = decode_parts(number, bool(extended[row]), bool(remote[row]), data, encoder)
            if message is not None:
                yield float(frames.time[row]), message

    def to_pandas(self, *signals: str, period: float | None = None) -> DataFrame:
        """Returns a data frame with the signals side by side, each held from one message to the next, NaN
        before its first one. Without names it has all signals that are in one message only. It has a row for
        every time at which one of them came, or every `period` s. A log with several `laps` has the rows of
        one after those of the other, and a column "lap", from 0. Raises SignalError for a name that is not a
        signal, ParameterError for a period that is not at least a microsecond.
        """
        frame: DataFrame = need("pandas").DataFrame(self._side_by_side(signals, period))
        return frame

    def _side_by_side(self, signals: tuple[str, ...], period: float | None) -> dict[str, NDArray[Any]]:
        """Returns the columns of `to_pandas`."""
        if period is not None:
            period = _core.number("period", period, "s", 1e-6)
        chosen = {name: self[name] for name in signals} if signals else self._all()
        for name, series in chosen.items():
            if not isinstance(series, Series):
                raise SignalError(f'"{name}" is a message: its table has a to_pandas of its own')
        if len(self.laps) == 1:
            return held(chosen, period)
        parts = [held(lap._those_of(chosen), period) for lap in self.laps]
        for number, part in enumerate(parts):
            part["lap"] = np.full(len(part["time"]), number)
        return {name: np.concatenate([part[name] for part in parts]) for name in ("time", "lap", *chosen)}

    def _those_of(self, chosen: Mapping[str, Series]) -> dict[str, Series]:
        """Returns the signals of a lap; one that did not come in it has no value."""
        found = {}
        for name, series in chosen.items():
            try:
                found[name] = self[name]
            except SignalError:
                found[name] = Series(name, series.unit, np.zeros(0), np.zeros(0), series.names)
        return found

    def save(self, path: str | PathLike[str], *signals: str, period: float | None = None) -> None:
        """Writes the table of `to_pandas`: `.csv`, `.parquet` or `.xlsx`. period: s. Raises ParameterError
        for any other name."""
        table.check(path)
        table.save(self._side_by_side(signals, period), path)

    def _rows(self, table: Table) -> NDArray[np.intp]:
        """Returns the indices of a table's messages among the frames."""
        return np.flatnonzero(self.frames.message == self._places[folded(table.name)])

    def _holders(self, signal: str) -> list[str]:
        """Returns the messages in the log that have this signal: those of devices if there are any, else
        those of masters."""
        holders = [
            (name, from_device)
            for name, from_device, time, columns in self._raw
            if len(time) and any(folded(own) == signal for (own, _, _), _ in columns)
        ]
        return [name for name, from_device in holders if from_device] or [name for name, _ in holders]

    def _all(self) -> dict[str, Series]:
        holders = {signal: self._holders(folded(signal)) for signal in self.signals}
        return {signal: self.table(names[0]).series(signal) for signal, names in holders.items() if len(names) == 1}

    def _signal(self, key: str) -> Series:
        name = folded(key)
        holders = self._holders(name)
        if len(holders) > 1:
            raise SignalError(f'"{key}" is a signal of {", ".join(holders)}: take it from one of them')
        if holders:
            return self.table(holders[0]).series(key)
        fault = next((fault for fault in FAULTS if folded(fault) == name), None)
        if fault is not None:
            return self.table("FAULT_WORD").series(fault)
        row = next((row for row in Parameters.rows.values() if folded(row.name) == name), None)
        if row is not None:
            return self._parameter(row.number, row.name, row.unit)
        known = [signal for _, _, _, columns in self._raw for (signal, _, _), _ in columns]
        if name in map(folded, known):
            raise SignalError(f'no message with a signal "{key}" came')
        names = [*known, *(name for name, *_ in self._raw), *FAULTS, *(row.name for row in Parameters.rows.values())]
        raise SignalError(f'there is no message or signal "{key}"{suggestion(key, names)}')

    def _parameter(self, number: int, name: str, unit: str) -> Series:
        """Returns the values of a parameter from the drive's answers."""
        answers = self.table("PARAMETER")
        answers = answers.select((answers["Number"] == number) & (answers["Status"] == 0))
        return Series(name, unit, answers.time, answers["Value"], {})


def held(chosen: Mapping[str, Series], period: float | None) -> dict[str, NDArray[Any]]:
    """Returns columns with the signals side by side, each held from one value to the next."""
    times = [series.time for series in chosen.values()]
    time = np.unique(np.concatenate(times)) if times else np.zeros(0)
    if period is not None and len(time):
        time = np.arange(time[0], time[-1] + period / 2, period)
    return {"time": time} | {name: series.at(time) for name, series in chosen.items()}


def table_of(
    name: str,
    from_device: bool,
    time: NDArray[np.float64],
    columns: list[tuple[tuple[str, str, list[tuple[int, str]]], NDArray[Any]]],
) -> Table:
    """Builds a table from the reader's columns. A fault word also gets a column for each fault, as in the
    data base."""
    arrays: dict[str, NDArray[Any]] = {"time": time}
    units, names = {"time": "s"}, {}
    for (signal, unit, values), array in columns:
        arrays[signal], units[signal], names[signal] = array, unit, dict(values)
        if signal == "Faults":
            arrays |= {fault: (array & bit) != 0 for fault, bit in FAULTS.items()}
            units |= dict.fromkeys(FAULTS, "")
    return Table(name, from_device, arrays, units, names)
