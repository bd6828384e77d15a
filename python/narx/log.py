"""The external log memory of a drive: records of chosen values, written periodically."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache

import numpy as np

from narx import _core, given
from narx.description import Description, describe
from narx.download import download
from narx.errors import ParameterError
from narx.link import Link, ask, record
from narx.names import suggestion
from narx.parameters import Parameters
from narx.trace import Trace

KEEP: dict[str, int] = {"live": 0, "min": 1, "max": 2, "mean": 3}

SLOT_FIRST, SLOT_LAST, NOTHING = 29, 65, 0xFFFF
RECORD_BYTES, INDEX_MAX, WRITE_INDEX, PERIOD, FULL = 69, 70, 71, 72, 77
SIGNAL_FIRST = 0x2000


class Names:
    """Parameters and measurements that a slot can name, from a drive's tables."""

    def __init__(self, description: Description) -> None:
        # Number in a slot, unit, and value of a raw 1.
        self.what: dict[str, tuple[int, str, float]] = {
            name: (SIGNAL_FIRST + 4 * opcode + word, unit, scale)
            for name, opcode, word, unit, scale in description.core.measurement_signals()
        }
        rows = description.rows.values()
        # A measurement that is also a parameter of the same name has two numbers for the same value; slots
        # use that of the measurement.
        self.what |= {row.name: (row.number, row.unit, row.scale) for row in rows if row.name not in self.what}
        self.names = {number: name for name, (number, _, _) in self.what.items()} | {row.number: row.name for row in rows}
        self._folded = {name.casefold(): name for name in self.what}

    def number(self, name: str) -> int:
        """Returns the number of a name in a slot; case does not matter."""
        try:
            return self.what[self._folded[str(name).casefold()]][0]
        except KeyError:
            raise ParameterError(f'there is no parameter or measurement "{name}"{suggestion(name, self.what)}') from None


names_of = lru_cache(maxsize=8)(Names)


class Log:
    """Sets up, reads and erases the log."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._parameters = Parameters(link)

    @property
    def _names(self) -> Names:
        return names_of(describe(self._link))

    def __len__(self) -> int:
        """Number of records in the memory."""
        return int(self._parameters[WRITE_INDEX])

    def __bool__(self) -> bool:
        return True

    @property
    def capacity(self) -> int:
        """Number of records that the memory can hold; 0 without a memory."""
        return int(self._parameters[INDEX_MAX])

    @property
    def full(self) -> bool:
        """True if the memory is full: nothing more is written until it is erased."""
        return bool(self._parameters[FULL])

    @property
    def state(self) -> str:
        """Logging state (Table 8) of the last STATUS_WORD."""
        status = self._link.master.status or {}
        return str(status.get("Logging state", "unknown"))

    @property
    def slots(self) -> dict[str, str]:
        """Logged values: name -> "live", or "min", "max" or "mean" since the previous record."""
        kinds = {number: kind for kind, number in KEEP.items()}
        values = [int(self._parameters[number]) for number in range(SLOT_FIRST, SLOT_LAST + 1)]
        names = self._names.names
        return {
            names.get(value & 0xFFFF, f"parameter {value & 0xFFFF}"): kinds[value >> 16 & 3]
            for value in values
            if value & 0xFFFF != NOTHING
        }

    def configure(self, values: Iterable[str] | Mapping[str, str], period: float) -> None:
        """Selects the logged values and the period of the records.

        values: up to 37 names of parameters or measurements; a mapping selects which value of each is kept:
        "live", "min", "max" or "mean" since the previous record. period: 0.001 to 3600 s. Records begin once
        the drive has these settings; `parameters.store` stores them. Raises ParameterError for an unknown
        name, too many names or a period out of range.
        """
        chosen = dict(values) if isinstance(values, Mapping) else dict.fromkeys(given.several("values", values), "live")
        period = _core.number("period", period, "s", 0.001, 3600)
        slots = [self._names.number(name) | kind_of(kind) << 16 for name, kind in chosen.items()]
        count = SLOT_LAST + 1 - SLOT_FIRST
        if len(slots) > count:
            raise ParameterError(f"values: {len(slots)} exceed the {count} slots of the log")
        self._parameters[PERIOD] = period * 1000.0
        for at, slot in enumerate(slots + [NOTHING] * (count - len(slots))):
            self._parameters[SLOT_FIRST + at] = slot

    def download(
        self,
        first: int = 0,
        count: int | None = None,
        progress: Callable[[int, int], None] | bool | None = None,
    ) -> Trace:
        """Downloads the records from index `first` on, to the last one or `count` of them: `index`, `time` in
        s since power-up, and the values.

        A value that a record does not have is NaN; a record that the drive cannot read any more is left out.
        progress: called with the number of words received and the total; or whether to show a progress bar, as
        of `narx.read_log`. Raises ParameterError for records that the log does not have.
        """
        last = len(self)
        first = _core.whole_number("first", first, 0)
        count = max(last - first, 0) if count is None else _core.whole_number("count", count, 0)
        if first + count > last:
            raise ParameterError(f"records {first} to {first + count}: the log has {last} records")
        if count == 0:
            return table([], self._names)
        size = int(self._parameters[RECORD_BYTES])
        data = download(self._link, "log", first, count, progress)
        return table([record for record in _core.log_records(data, size) if record is not None], self._names)

    def erase(self, wait: bool = True) -> None:
        """Erases every record; refused while driving. With `wait`, returns when that is done, which takes
        minutes for a full memory; raises NoAnswerError if the drive is lost meanwhile."""
        if wait:
            record(self._link, "erase log")
        else:
            ask(self._link, lambda: self._link.master.request("erase log"))


def table(records: list[tuple[int, float, list[tuple[int, int]]]], known: Names) -> Trace:
    """Converts records to columns."""
    columns: dict[str, np.ndarray[tuple[int], np.dtype[np.float64]]] = {
        "index": np.array([index for index, _, _ in records], float),
        "time": np.array([time for _, time, _ in records], float),
    }
    units = {"index": "", "time": "s"}
    kinds = {number: kind for kind, number in KEEP.items()}
    for row, (_, _, values) in enumerate(records):
        for what, raw in values:
            name = known.names.get(what & 0x3FFF, f"parameter {what & 0x3FFF}")
            kind = kinds[what >> 14]
            _, unit, scale = known.what.get(name, (0, "", 1.0))
            label = name if kind == "live" else f"{name} {kind}"
            if label not in columns:
                columns[label] = np.full(len(records), np.nan)
                units[label] = unit
            columns[label][row] = raw * scale
    return Trace(columns, units)


def kind_of(kind: str) -> int:
    """Returns the number of a kind of kept value."""
    if kind not in KEEP:
        raise ParameterError(f'kept value "{kind}": must be one of {", ".join(KEEP)}')
    return KEEP[kind]

