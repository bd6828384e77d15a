"""The object dictionary of a TX-Driver (eddyCAN specification, Table 4)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableMapping
from dataclasses import dataclass
from typing import ClassVar

from narx import _core
from narx.errors import ParameterError
from narx.names import suggestion

PROFILE = range(0x1000, 0x2000)
"""Indices of the communication profile of CANopen (CiA 301)."""
Key = str | int | tuple[int, int]
"""Key of an object: its name, its index, or index and subindex."""


@dataclass(frozen=True)
class Object:
    """Properties of one entry, without its value."""

    index: int
    subindex: int
    """Channel of an entry that exists for each channel; else 0."""
    name: str
    unit: str
    """Unit of the values: "ms", "nm"; "" for numbers, and for comparators, which are fractions of the
    measuring range."""
    scale: float
    """Step of the value: the value of a raw 1."""
    min: float
    max: float
    factory: float
    """Factory value."""
    access: str
    """"RW", "R" or "W"."""
    acts: str
    """Time at which a written value takes effect."""
    description: str

    def raw(self, value: float) -> int:
        """Returns the raw value that is nearest to `value` in the entry's unit. Raises ParameterError outside
        of the range."""
        name = f'object {self.index:04X}h "{self.name}"'
        if self.scale == 1.0:
            return _core.whole_number(name, value, int(self.min), int(self.max), self.unit)
        return round(_core.number(name, value, self.unit, self.min, self.max) / self.scale)


class Objects(MutableMapping[Key, float]):
    """Entries of a node by name (case does not matter), index, or (index, subindex), in their units. Reading
    sends a request to the node, writing waits for its answer. The node itself stores written values, which
    survive a restart.

    Raises ParameterError for an entry that does not exist or a value out of range, AbortError when the node
    refuses (a node that is Operational refuses every access), NoAnswerError.
    """

    rows: ClassVar[tuple[Object, ...]] = tuple(Object(**row) for row in _core.tx_objects())
    """Properties of every entry, in the order of the table."""

    def __init__(self, ask: Callable[[Object, int | None], int]) -> None:
        self._ask = ask

    def __getitem__(self, key: Key) -> float:
        row = self.row(key)
        raw = self._ask(row, None)
        return raw if row.scale == 1.0 else raw * row.scale

    def __setitem__(self, key: Key, value: float) -> None:
        row = self.row(key)
        self._ask(row, row.raw(value))

    def __delitem__(self, key: Key) -> None:
        raise ParameterError(f"object {key}: a node's objects cannot be deleted")

    def __iter__(self) -> Iterator[Key]:
        return (row.name for row in self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __contains__(self, key: object) -> bool:
        try:
            self.row(key)  # type: ignore[arg-type]
        except ParameterError:
            return False
        return True

    @classmethod
    def row(cls, key: Key) -> Object:
        """Returns the properties of an entry."""
        folded = key.casefold() if isinstance(key, str) else key
        for row in cls.rows:
            if folded in (row.name.casefold(), row.index, (row.index, row.subindex)):
                return row
        if isinstance(key, str):
            raise ParameterError(f'there is no object "{key}"{suggestion(key, (row.name for row in cls.rows))}')
        parts = key if isinstance(key, tuple) else (key,)
        address = ", ".join(f"{part:04X}h" if isinstance(part, int) else repr(part) for part in parts)
        own = [row.index for row in cls.rows]
        has = f"; eddyCAN has no communication profile: a TX-Driver has {min(own):04X}h to {max(own):04X}h" if parts[0] in PROFILE else ""
        raise ParameterError(f"there is no object {address}{has}")

    def to_dict(self) -> dict[str, float]:
        """Returns every entry that can be read and written, by name, for `load`."""
        return {row.name: self[row.name] for row in self.rows if row.access == "RW"}

    def load(self, values: Mapping[str, float]) -> list[str]:
        """Writes the values that differ from the node's; returns their names. All values are checked
        before the first is written. The node-id and the bit rate are not written (use `set_node_id`,
        `set_bitrate`)."""
        wanted = [(row, row.raw(value)) for row, value in ((self.row(key), value) for key, value in values.items())]
        configured = [pair for pair in wanted if pair[0].acts == "at once"]
        different = [(row, raw) for row, raw in configured if self._ask(row, None) != raw]
        for row, raw in different:
            self._ask(row, raw)
        return [row.name for row, _ in different]
