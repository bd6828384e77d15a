"""The parameters of a drive: Tables 10 and 11 of the specification, and from number 256 on those of narx."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from os import PathLike
from typing import cast

from narx import _core, given
from narx.description import OWN, Description, Row, describe
from narx.errors import NoAnswerError, ParameterError
from narx.link import Link, ask

DEVICE_NUMBER = 1
READ_ONLY = "read-only"


class Rows:
    """Descriptor of `rows`: the class has the rows of this package, an object those of its drive."""

    def __get__(self, parameters: Parameters | None, owner: type[Parameters]) -> Mapping[int, Row]:
        return OWN.rows if parameters is None else parameters._description.rows


class Parameters(MutableMapping[str | int, float]):
    """Parameters by name (case does not matter) or number, in their units. Reading sends a request to the
    drive, writing waits for its answer.

    Raises ParameterError for a parameter that does not exist or a value out of range, RefusedError when the
    drive's state forbids the access, NoAnswerError.
    """

    rows: Mapping[int, Row] = cast("Mapping[int, Row]", Rows())
    """Properties of every parameter, by number, from the drive's description. `narx.Parameters.rows` has
    those of this package."""

    def __init__(self, link: Link) -> None:
        self._link = link

    @property
    def _description(self) -> Description:
        return describe(self._link)

    @property
    def _table(self) -> _core.Description:
        return self._description.core

    def __getitem__(self, key: str | int) -> float:
        number = self._table.number(key)
        raw = self._ask("read", number)
        return self._table.from_raw(number, raw)

    def __setitem__(self, key: str | int, value: float) -> None:
        number = self._table.number(key)
        self._ask("write", number, self._table.to_raw(number, value))

    def __delitem__(self, key: str | int) -> None:
        raise ParameterError(f"parameter {key}: a drive's parameters cannot be deleted")

    def __iter__(self) -> Iterator[str]:
        return (row.name for row in self.rows.values())

    def __len__(self) -> int:
        return len(self.rows)

    def _ipython_key_completions_(self) -> list[str]:
        return [row.name for row in self.rows.values()]

    def __contains__(self, key: object) -> bool:
        try:
            self._table.number(key)  # type: ignore[arg-type]
        except ParameterError:
            return False
        return True

    def row(self, key: str | int) -> Row:
        """Returns the properties of a parameter."""
        return self.rows[self._table.number(key)]

    def find(self, text: str) -> list[Row]:
        """Returns the parameters whose name, category or description contains the text; case does not
        matter."""
        folded = str(text).casefold()
        return [row for row in self.rows.values() if folded in f"{row.name} {row.category} {row.description}".casefold()]

    def to_dict(self) -> dict[str, float]:
        """Returns every parameter that can be written and is not a command, by name, for `load`."""
        return {row.name: self[row.number] for row in self.rows.values() if row.access != READ_ONLY and not row.command}

    def load(self, values: Mapping[str, float] | Mapping[int, float] | Mapping[str | int, float]) -> list[str]:
        """Writes the values that differ from the drive's; returns their names. All values are checked before
        the first is written. The device number is not written (use `store_once`)."""
        if not isinstance(values, Mapping):
            raise ParameterError(f"values {values!r}: must be a mapping of names to values")
        table = self._table
        wanted = {table.number(key): value for key, value in values.items()}
        raw = {number: table.to_raw(number, value) for number, value in wanted.items()}
        for number in wanted:
            if self.rows[number].access == READ_ONLY:
                raise ParameterError(f'parameter {number} "{self.rows[number].name}": read-only')
        different = [number for number in raw if number != DEVICE_NUMBER and self._ask("read", number) != raw[number]]
        for number in different:
            self._ask("write", number, raw[number])
        return [self.rows[number].name for number in different]

    def save(self, path: str | PathLike[str]) -> None:
        """Writes `to_dict` as a JSON file."""
        import json

        given.path(path).write_text(json.dumps(self.to_dict(), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")

    def load_file(self, path: str | PathLike[str]) -> list[str]:
        """Loads a file of `save`; returns the names of the parameters that have changed."""
        return self.load(read_file(path))

    def diff(self, values: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Compares the drive with `values`; returns the differences: name -> (value there, value on the
        drive)."""
        pairs = {self.row(key).name: (value, self[key]) for key, value in values.items()}
        return {name: pair for name, pair in pairs.items() if self._differs(self.row(name).number, pair)}

    def store(self) -> None:
        """Stores every parameter except the device number and the calibration in the drive's memory now.
        Without this call written values are stored within 2 s (parameter 307 "Automatic store")."""
        self._ask("store")

    def store_once(self) -> None:
        """Stores the device number and the calibration (category 02), which no other call stores. A new
        device number is used from the next reboot on."""
        self._ask("store once")

    def reset_calibration(self) -> None:
        """Sets the calibration (category 02) to its factory values."""
        self._ask("reset calibration")

    def restore_factory(self) -> None:
        """Stores factory values for everything except the device number and the calibration (category 02). It
        is allowed at any time, also while driving. The values take effect at the next reboot."""
        # The drive checks the serial number of its power-up; parameter 1 may have been written since.
        self._ask("device info")
        device = self._link.master.device
        if device is None:
            raise NoAnswerError("the drive does not report its device number")
        self._ask("restore factory", device[2])

    def _ask(self, what: str, number: int = 0, raw: int = 0) -> int:
        return ask(self._link, lambda: self._link.master.request(what, number, raw))

    def _differs(self, number: int, pair: tuple[float, float]) -> bool:
        left, right = pair
        return self._table.to_raw(number, left) != self._table.to_raw(number, right)


def read_file(path: str | PathLike[str]) -> dict[str, float]:
    """Returns the names and values of a file of `Parameters.save`."""
    import json

    file = given.path(path)
    try:
        values = json.loads(file.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ParameterError(f'file "{path}" is not a parameter file: {error}') from None
    if not isinstance(values, dict):
        raise ParameterError(f'file "{path}" is not a parameter file: it must contain one object of names and values')
    return values
