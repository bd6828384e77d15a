"""Columns of a log: frames, tables of messages, and signals over time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from narx import _core, given
from narx.errors import ParameterError
from narx.extras import need
from narx.trace import Trace

if TYPE_CHECKING:
    import can
    from pandas import DataFrame

FLAGS = dict(_core.frame_flags())
FORMATS = (".asc", ".blf", ".csv", ".log")
"""Suffixes of logs that `Frames.save` writes: those of python-can that hold every frame."""


def folded(name: str) -> str:
    """Returns the letters and digits of a name in lower case: "HV Voltage", "hv voltage" and the data base's
    "HV_Voltage" are one signal."""
    return "".join(filter(str.isalnum, name)).casefold()


class LogError(NamedTuple):
    """A part of a log that is no frame."""

    line: int | None
    """Line of the file, from 1; `None` if the format has no lines."""
    text: str
    """The line, or its beginning."""
    reason: str


@dataclass(frozen=True)
class Frames:
    """Frames of a log, a row each."""

    time: NDArray[np.float64]
    """Time stamp, s."""
    id: NDArray[np.uint32]
    flags: NDArray[np.uint8]
    """Further properties, a bit each; `flag` decodes them."""
    dlc: NDArray[np.uint8]
    """Number of data bytes; of a remote frame the number that it requests."""
    data: NDArray[np.uint8]
    """Shape (frames, 8), zeros behind the last byte; wider if there are CAN FD frames."""
    message: NDArray[np.uint8]
    channel: NDArray[np.uint16]
    """Index in `channels`."""
    channels: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, rows: Any) -> Frames:
        """Selects frames by a slice, a mask or an array of rows."""
        columns = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "channels"}
        return replace(self, **{name: column[rows] for name, column in columns.items()})

    def flag(self, name: str) -> NDArray[np.bool_]:
        """Returns for each frame whether it is "extended", "remote", "error", "fd", "received",
        "bitrate_switch", "error_state"."""
        found: NDArray[np.bool_] = (self.flags & FLAGS[name]) != 0
        return found

    def __repr__(self) -> str:
        return f"<narx.Frames: {len(self)}>"

    def messages(self) -> Iterator[can.Message]:
        """Yields the frames as messages of python-can, their time stamps in s. Raises MissingError without
        python-can."""
        message = need("can").Message
        flags = {name: self.flag(name).tolist() for name in FLAGS}
        for row, (time, number, length, channel) in enumerate(
            zip(self.time.tolist(), self.id.tolist(), self.dlc.tolist(), self.channel.tolist(), strict=True)
        ):
            remote, error = flags["remote"][row], flags["error"][row]
            yield message(
                timestamp=time, arbitration_id=number, is_extended_id=flags["extended"][row], is_remote_frame=remote,
                is_error_frame=error, is_fd=flags["fd"][row], bitrate_switch=flags["bitrate_switch"][row],
                error_state_indicator=flags["error_state"][row], is_rx=flags["received"][row], dlc=length,
                data=None if remote else self.data[row, :length].tobytes(), channel=self.channels[channel] or None,
            )  # fmt: skip

    def save(self, path: str | PathLike[str]) -> None:
        """Writes a log of the bus in a format of python-can by the suffix: `.asc`, `.blf`, `.csv`, `.log`
        (candump). Raises ParameterError for any other name, MissingError without python-can."""
        file = given.path(path)
        suffix = file.suffix.lower()
        if suffix not in FORMATS:
            raise ParameterError(f'path "{file}": "{suffix}" must be one of {", ".join(FORMATS)}')
        with need("can").Logger(file) as writer:
            for message in self.messages():
                writer(message)

    def to_pandas(self) -> DataFrame:
        """Returns a data frame with a row per frame, its data as bytes."""
        data = [row[:length].tobytes() for row, length in zip(self.data, self.dlc, strict=True)]
        channel = [self.channels[place] for place in self.channel]
        flags = {name: self.flag(name) for name in FLAGS}
        columns = {"time": self.time, "channel": channel, "id": self.id, **flags, "dlc": self.dlc, "data": data}
        frame: DataFrame = need("pandas").DataFrame(columns)
        return frame


class Series:
    """One signal over time (s), in its unit; numpy uses it as the array of its values."""

    def __init__(
        self, name: str, unit: str, time: NDArray[np.float64], values: NDArray[Any], names: Mapping[int, str]
    ) -> None:
        self.name = name
        self.unit = unit
        """SI unit, rpm, degrees or mm; "" for plain numbers."""
        self.time = time
        """Time stamps, s."""
        self.values = values
        """Values: float64 of quantities, int64 of plain numbers, bool of flags, uint16 of named values,
        uint32 of fault bits."""
        self.names = dict(names)
        """Names of the values that have one."""

    def __len__(self) -> int:
        return len(self.time)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.values, dtype, copy=copy)

    def __getitem__(self, rows: Any) -> Any:
        return self.values[rows]

    def __repr__(self) -> str:
        return f"<narx.Series {self.name}{f' [{self.unit}]' if self.unit else ''}: {len(self)} values>"

    def text(self) -> list[str]:
        """Returns every value by its name, or as a number if it has none."""
        return [self.names.get(int(value), str(value)) for value in self.values]

    def at(self, time: NDArray[np.float64] | Iterable[float]) -> NDArray[Any]:
        """Returns the last value received at each time, s; NaN (for numbers) before the first one."""
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
        """True if a drive or node sends the message, false if its master does."""
        self.names = names
        """Names of the values, by signal."""
        self._folded = {folded(signal): signal for signal in columns}

    def __getitem__(self, signal: str) -> NDArray[Any]:
        return super().__getitem__(self._folded.get(folded(signal), signal))

    def __contains__(self, signal: object) -> bool:
        return isinstance(signal, str) and folded(signal) in self._folded

    def __repr__(self) -> str:
        return f"<narx.Table {self.name} of {len(self)} rows: {', '.join(self)}>"

    def series(self, signal: str) -> Series:
        """Returns one signal with its time."""
        values = self[signal]
        name = self._folded[folded(signal)]
        return Series(name, self.signals[name], self.time, values, self.names.get(name, {}))

    def select(self, rows: Any) -> Table:
        """Selects messages by a slice, a mask or an array of rows."""
        columns = {name: column[rows] for name, column in self._columns.items()}
        return Table(self.name, self.from_device, columns, self._units, self.names)
