"""Logs of a CAN bus as numpy columns: what `narx.read_log` returns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from narx import _core
from narx.errors import SignalError
from narx.messages import Message, NodeMessage, decode_parts
from narx.names import suggestion
from narx.parameters import Parameters
from narx.trace import Trace, save_table

if TYPE_CHECKING:
    from pandas import DataFrame

FLAGS = dict(_core.frame_flags())
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
"""What a bench calls it, for what the protocol calls otherwise. `speed` is more than that: see `CanLog.speed`."""
HALL = "Hall closed loop"


def folded(name: str) -> str:
    """Letters and digits of a name: "HV Voltage", "hv voltage" and the data base's "HV_Voltage" are one signal."""
    return "".join(filter(str.isalnum, name)).casefold()


class LogError(NamedTuple):
    """A part of a log that is no frame."""

    line: int | None
    """Line of the file, from 1; `None` where it has no lines."""
    text: str
    """The line, or its beginning."""
    reason: str


@dataclass(frozen=True)
class Frames:
    """Frames as they stand in the log, a row each."""

    time: NDArray[np.float64]
    """s, as stamped."""
    id: NDArray[np.uint32]
    flags: NDArray[np.uint8]
    """What else they are, a bit each; `flag` tells them apart."""
    dlc: NDArray[np.uint8]
    """Data bytes; of a remote frame those that it asks for."""
    data: NDArray[np.uint8]
    """Shape (frames, 8), zeros behind the last byte; wider where CAN FD frames are."""
    message: NDArray[np.uint8]
    channel: NDArray[np.uint16]
    """Place in `channels`."""
    channels: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, rows: Any) -> Frames:
        """Some of the frames: by a slice, a mask or an array of rows."""
        columns = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "channels"}
        return replace(self, **{name: column[rows] for name, column in columns.items()})

    def flag(self, name: str) -> NDArray[np.bool_]:
        """Whether each is "extended", "remote", "error", "fd", "received", "bitrate_switch", "error_state"."""
        found: NDArray[np.bool_] = (self.flags & FLAGS[name]) != 0
        return found

    def __repr__(self) -> str:
        return f"<narx.Frames: {len(self)}>"

    def to_pandas(self) -> DataFrame:
        """A row per frame, its data as bytes."""
        from pandas import DataFrame

        data = [row[:length].tobytes() for row, length in zip(self.data, self.dlc, strict=True)]
        channel = [self.channels[place] for place in self.channel]
        flags = {name: self.flag(name) for name in FLAGS}
        columns = {"time": self.time, "channel": channel, "id": self.id, **flags, "dlc": self.dlc, "data": data}
        return DataFrame(columns)


class Series:
    """One signal over time; numpy takes it for its values."""

    def __init__(
        self, name: str, unit: str, time: NDArray[np.float64], values: NDArray[Any], names: Mapping[int, str]
    ) -> None:
        self.name = name
        self.unit = unit
        """SI unit, rpm, degrees or mm; "" for plain numbers."""
        self.time = time
        """s, as stamped."""
        self.values = values
        """float64 of quantities, int64 of plain numbers, bool of flags, uint16 of what has names, uint32 of fault bits."""
        self.names = dict(names)
        """What a value is called, where it is."""

    def __len__(self) -> int:
        return len(self.time)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.values, dtype, copy=copy)

    def __getitem__(self, rows: Any) -> Any:
        return self.values[rows]

    def __repr__(self) -> str:
        return f"<narx.Series {self.name}{f' [{self.unit}]' if self.unit else ''}: {len(self)} values>"

    def text(self) -> list[str]:
        """Every value by its name, or as a number where it has none."""
        return [self.names.get(int(value), str(value)) for value in self.values]

    def at(self, time: NDArray[np.float64] | Iterable[float]) -> NDArray[Any]:
        """The last value heard at each time; NaN (of numbers) before the first one."""
        order = np.argsort(self.time, kind="stable")
        place = np.searchsorted(self.time[order], np.asarray(time), side="right") - 1
        held: NDArray[Any] = np.full(place.shape, np.nan)
        if len(order):
            held[place >= 0] = self.values[order][place[place >= 0]]
        return held


class Table(Trace):
    """Every message of one kind: `time` in s, and a column for each signal."""

    def __init__(
        self,
        name: str,
        from_device: bool,
        columns: Mapping[str, NDArray[Any]],
        units: Mapping[str, str],
        names: Mapping[str, Mapping[int, str]],
    ) -> None:
        super().__init__(columns, units)
        self.name = name
        self.from_device = from_device
        """A drive or node has sent it, else its master."""
        self.names = names
        """By signal: what its values are called."""
        self._folded = {folded(signal): signal for signal in columns}

    def __getitem__(self, signal: str) -> NDArray[Any]:
        return super().__getitem__(self._folded.get(folded(signal), signal))

    def __contains__(self, signal: object) -> bool:
        return isinstance(signal, str) and folded(signal) in self._folded

    def __repr__(self) -> str:
        return f"<narx.Table {self.name} of {len(self)} rows: {', '.join(self)}>"

    def series(self, signal: str) -> Series:
        """One signal with its time."""
        values = self[signal]
        name = self._folded[folded(signal)]
        return Series(name, self.signals[name], self.time, values, self.names.get(name, {}))

    def select(self, rows: Any) -> Table:
        """Some of the messages: by a slice, a mask or an array of rows."""
        columns = {name: column[rows] for name, column in self._columns.items()}
        return Table(self.name, self.from_device, columns, self._units, self.names)


class CanLog:
    """A decoded log. `log["STATUS_WORD"]` is the table of a message, `log["PDO1", 2]` that of one node, `log["HV Voltage"]` a signal
    over time wherever it comes from, or a parameter's value as the drive has told it; `log["speed"]` is what the control uses.
    Names are those of the CAN data base, of `narx.decode` or of a bench; case and punctuation do not matter.
    """

    def __init__(self, reader: _core.LogReader, errors: Iterable[LogError] = (), encoders: Iterable[int] = ()) -> None:
        columns, channels, tables, refused, lines = reader.finish()
        self.frames = Frames(**columns, channels=tuple(channels))
        """Every frame of the log, decoded or not."""
        self.errors = [*(LogError(*error) for error in refused), *errors]
        """What is no frame, in the order of the lines: it was skipped."""
        self.lines = lines
        """Lines of a candump log; 0 of other formats."""
        self._raw = tables
        self._places = {folded(name): place for place, (name, *_) in enumerate(tables)}
        self._tables: dict[int, Table] = {}
        self._encoders = frozenset(encoders)

    @cached_property
    def unknown(self) -> Frames:
        """Frames of no protocol that is known here, CAN FD among them, or between other addresses."""
        return self.frames[self.frames.message == UNKNOWN]

    @cached_property
    def malformed(self) -> Frames:
        """Frames with the identifier of a message, but not its shape: length, remote, or a value without a meaning."""
        return self.frames[self.frames.message == MALFORMED]

    @cached_property
    def error_frames(self) -> Frames:
        """Errors that the adapter has seen on the bus; `id` is the class of the error."""
        return self.frames[self.frames.message == ERROR]

    @property
    def counts(self) -> dict[str, int]:
        """Frames by message, in the order of the protocol: those that came."""
        return {name: len(time) for name, _, time, _ in self._raw if len(time)}

    @property
    def signals(self) -> dict[str, str]:
        """Signals of the messages that came: name -> unit."""
        return {
            signal: unit for _, _, time, columns in self._raw if len(time) for (signal, unit, _), _ in columns
        }

    def __iter__(self) -> Iterator[str]:
        """Names of the messages that came."""
        return iter(self.counts)

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
                raise SignalError(f"{table.name} is no message of a node")
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
        """Every message of this name; none if none came."""
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
        """Mechanical speed, rpm, as estimated by what the control mode uses: the hall sensors in hall closed loop, else back-EMF."""
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
            # The last status before the measurement; before the first one it is not hall.
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
        """Time and content of every decoded message, in the order of the log."""
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
        """Signals side by side, each held from one message to the next, NaN before its first one; without names all that are in one
        message only. A row for every time at which one of them came, or every `period` seconds.
        """
        from pandas import DataFrame

        chosen = {name: self[name] for name in signals} if signals else self._all()
        for name, series in chosen.items():
            if not isinstance(series, Series):
                raise SignalError(f'"{name}" is a message: its table has a to_pandas of its own')
        times = [series.time for series in chosen.values()]
        time = np.unique(np.concatenate(times)) if times else np.zeros(0)
        if period is not None and len(time):
            time = np.arange(time[0], time[-1] + period / 2, period)
        return DataFrame({"time": time} | {name: series.at(time) for name, series in chosen.items()})

    def save(self, path: str | PathLike[str], *signals: str, period: float | None = None) -> None:
        """Writes the table of `to_pandas`: `.csv`, `.parquet` or `.xlsx`."""
        save_table(lambda: self.to_pandas(*signals, period=period), path)

    def _rows(self, table: Table) -> NDArray[np.intp]:
        """Rows of a table's messages among the frames."""
        return np.flatnonzero(self.frames.message == self._places[folded(table.name)])

    def _holders(self, signal: str) -> list[str]:
        """Messages that came and have this signal: if devices sent some of them, those."""
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
        """A parameter as the drive has answered it."""
        answers = self.table("PARAMETER")
        answers = answers.select((answers["Number"] == number) & (answers["Status"] == 0))
        return Series(name, unit, answers.time, answers["Value"], {})


def table_of(
    name: str,
    from_device: bool,
    time: NDArray[np.float64],
    columns: list[tuple[tuple[str, str, list[tuple[int, str]]], NDArray[Any]]],
) -> Table:
    """A table from the reader's columns; a fault word becomes a column for each fault, too, as in the data base."""
    arrays: dict[str, NDArray[Any]] = {"time": time}
    units, names = {"time": "s"}, {}
    for (signal, unit, values), array in columns:
        arrays[signal], units[signal], names[signal] = array, unit, dict(values)
        if signal == "Faults":
            arrays |= {fault: (array & bit) != 0 for fault, bit in FAULTS.items()}
            units |= dict.fromkeys(FAULTS, "")
    return Table(name, from_device, arrays, units, names)
