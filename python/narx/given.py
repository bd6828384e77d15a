"""Checks of what a user passes, beside those of numbers (`_core.number`, `_core.whole_number`)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import Any

from narx import _core
from narx._core import Load, Motor
from narx.errors import ParameterError


def seconds(value: float) -> float:
    """Returns a duration, s."""
    return _core.number("seconds", value, "s", 0)


def timeout(value: float) -> float:
    """Returns a longest wait, s; infinity waits for ever."""
    return math.inf if value == math.inf else _core.number("timeout", value, "s", 0)


def motor(value: Motor | str) -> Motor:
    """Returns a motor, or the preset of a name."""
    if isinstance(value, str):
        return Motor.preset(value)
    if not isinstance(value, Motor):
        raise ParameterError(f"motor {value!r}: must be a narx.Motor or the name of a preset")
    return value


def path(value: str | PathLike[str], name: str = "path") -> Path:
    """Returns a path. Raises ParameterError for any other value, and for a text with a zero byte."""
    try:
        found = Path(value)
    except TypeError:
        raise ParameterError(f"{name} {value!r}: must be the path of a file") from None
    if "\0" in str(found):
        raise ParameterError(f"{name} {str(value)!r}: must be the path of a file, without a zero byte")
    return found


def load(value: Load) -> Load:
    """Returns a load."""
    if not isinstance(value, Load):
        raise ParameterError(f"load {value!r}: must be a narx.Load")
    return value


def several(name: str, value: Iterable[Any]) -> list[Any]:
    """Returns the values of a list; a single value or a text is an error."""
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        raise ParameterError(f"{name} {value!r}: must be a list")
    return list(value)
