"""Columns of values, and tables as files."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from narx._core import Load, Motor
from narx.errors import ParameterError

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from pandas import DataFrame

SUFFIXES = (".csv", ".parquet", ".xlsx")
"""Suffixes of the formats that `save` writes."""
EXACT = 2**53
"""Largest magnitude below which every whole number is exact as a float."""


def check(path: str | PathLike[str], *others: str) -> str:
    """Returns the suffix of a path, which must be one of `SUFFIXES` or of the others."""
    suffix = Path(path).suffix.lower()
    if suffix not in (*SUFFIXES, *others):
        raise ParameterError(f'path "{path}": "{suffix}" must be one of {", ".join((*SUFFIXES, *others))}')
    return suffix


def save(frame: DataFrame, path: str | PathLike[str]) -> None:
    """Writes a frame in the format of the path's suffix."""
    match check(path):
        case ".csv":
            frame.to_csv(path, index=False)
        case ".parquet":
            frame.to_parquet(path, index=False)
        case _:
            frame.to_excel(path, index=False)


def plain(value: Any) -> Any:
    """Converts a value for a table: motors and loads become their names."""
    if isinstance(value, Motor):
        return value.name or repr(value)
    return repr(value) if isinstance(value, Load) else value


def column(values: list[Any]) -> NDArray[Any]:
    """Returns an array of numbers if all values are numbers, else of objects; a missing text becomes ""."""
    known = [value for value in values if value is not None]
    complete = len(known) == len(values)
    if all(isinstance(value, str) for value in known):
        return np.array(["" if value is None else value for value in values], object)
    if complete and all(isinstance(value, bool | np.bool_) for value in known):
        return np.array(values, bool)
    if all(isinstance(value, int | float | np.number) and not isinstance(value, bool) for value in known):
        if complete:
            return np.array(values)
        # A larger whole number, such as a digest, would be rounded as a float.
        if all(isinstance(value, float) or abs(int(value)) <= EXACT for value in known):
            return np.array([np.nan if value is None else value for value in values])
    whole = np.empty(len(values), object)
    whole[:] = values
    return whole
