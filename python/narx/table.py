"""Columns of values, and tables as files."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from narx import given
from narx._core import Load, Motor
from narx.errors import ParameterError
from narx.extras import need

if TYPE_CHECKING:
    from numpy.typing import NDArray

SUFFIXES = (".csv", ".parquet", ".xlsx")
"""Suffixes of the formats that `save` writes."""
EXACT = 2**53
"""Largest magnitude below which every whole number is exact as a float."""


def check(path: str | PathLike[str], *others: str) -> str:
    """Returns the suffix of a path, which must be one of `SUFFIXES` or of the others."""
    suffix = given.path(path).suffix.lower()
    if suffix not in (*SUFFIXES, *others):
        raise ParameterError(f'path "{path}": "{suffix}" must be one of {", ".join((*SUFFIXES, *others))}')
    return suffix


def save(columns: Mapping[str, NDArray[Any]], path: str | PathLike[str]) -> None:
    """Writes columns in the format of the path's suffix. Raises MissingError without the library of it."""
    match check(path):
        case ".csv":
            with Path(path).open("w", encoding="utf-8", newline="") as file:
                rows = csv.writer(file, lineterminator="\n")
                rows.writerow(columns)
                rows.writerows(zip(*map(texts, columns.values()), strict=True))
        case ".parquet":
            need("pyarrow")
            need("pandas").DataFrame(columns).to_parquet(path, index=False)
        case _:
            need("openpyxl")
            need("pandas").DataFrame(columns).to_excel(path, index=False)


def html(title: str, columns: Mapping[str, Sequence[Any]], rows: int = 20) -> str:
    """Returns the first rows of a table for a notebook."""
    count = max(map(len, columns.values()), default=0)
    head = "".join(f"<th>{escape(name)}</th>" for name in columns)
    cells = zip(*(column[:rows] for column in columns.values()), strict=True)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell_text(cell), quote=False)}</td>' for cell in row)}</tr>" for row in cells)
    rest = f"<p>and {count - rows} more rows</p>" if count > rows else ""
    return f"<p>{escape(title)}</p><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{rest}"


def cell_text(value: Any) -> str:
    """Returns a value as it stands in a table of a notebook."""
    if isinstance(value, float | np.floating):
        return "" if np.isnan(value) else f"{value:.5g}"
    return "" if value is None else str(value)


def texts(values: NDArray[Any]) -> list[str]:
    """Returns each value as the shortest text that reads back as the same; "" for NaN and `None`."""
    if values.dtype == object:
        return ["" if value is None or value != value else str(value) for value in values]  # noqa: PLR0124 - NaN
    found = values.astype(str)
    if values.dtype.kind == "f":
        found[np.isnan(values)] = ""
    shown: list[str] = found.tolist()
    return shown


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
