"""Tables as files."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from narx.errors import ParameterError

if TYPE_CHECKING:
    from pandas import DataFrame

SUFFIXES = (".csv", ".parquet", ".xlsx")
"""What `save` writes."""


def check(path: str | PathLike[str], *others: str) -> str:
    """The suffix of a path, which must be one of `SUFFIXES` or of the others."""
    suffix = Path(path).suffix.lower()
    if suffix not in (*SUFFIXES, *others):
        raise ParameterError(f'path "{path}": "{suffix}" must be one of {", ".join((*SUFFIXES, *others))}')
    return suffix


def save(frame: DataFrame, path: str | PathLike[str]) -> None:
    """Writes a frame in the form that the suffix of the path names."""
    match check(path):
        case ".csv":
            frame.to_csv(path, index=False)
        case ".parquet":
            frame.to_parquet(path, index=False)
        case _:
            frame.to_excel(path, index=False)
