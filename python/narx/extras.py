"""Libraries that an extra of the package installs."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from narx.errors import MissingError

EXTRAS = {
    "asammdf": "files",
    "can": "can",
    "matplotlib": "plot",
    "openpyxl": "tables",
    "pandas": "pandas",
    "polars": "files",
    "pyarrow": "tables",
    "serial": "can",
    "tqdm": "progress",
    "websockets": "serve",
    "xarray": "files",
}
"""Extra that installs each library, by the name of its module."""


def need(module: str) -> Any:
    """Imports a module of an optional library. Raises MissingError with the command that installs it."""
    library = module.partition(".")[0]
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != library:
            raise
        raise MissingError(f"{library} is not installed: pip install 'narx[{EXTRAS[library]}]'") from None
