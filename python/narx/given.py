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


def motor(value: Motor | str | PathLike[str]) -> Motor:
    """Returns a motor, the preset of a name, or the motor of a file (.toml)."""
    if isinstance(value, Motor):
        return value
    if isinstance(value, PathLike) or (isinstance(value, str) and value.endswith(".toml")):
        return motor_file(path(value))
    if not isinstance(value, str):
        raise ParameterError(f"motor {value!r}: must be a narx.Motor, the name of a preset, or a file of figures (.toml)")
    return Motor.preset(value)


def motor_file(file: Path) -> Motor:
    """Returns the motor of a file with the arguments of `narx.Motor`, as `narx.Identified.save` writes it."""
    import tomllib

    try:
        return Motor(**tomllib.loads(file.read_text(encoding="utf-8")))
    except (TypeError, ValueError) as error:
        # A name that `narx.Motor` does not have, one that is missing, or text that is no TOML.
        raise ParameterError(f"{file}: {error}") from None


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
