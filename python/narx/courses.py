"""Loads and supplies as functions of time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias, Union

import numpy as np

from narx import _core
from narx._core import Load
from narx.errors import NarxError, ParameterError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

PERIOD = 0.001
"""Time between two values of a course, s."""

Course: TypeAlias = Union[float, Callable[[float], float], tuple["ArrayLike", "ArrayLike"]]
"""A number, a function of the time since power-up (s), or times (s, ascending) and values of equal length,
between which values are interpolated; before the first and after the last one these hold."""
LoadCourse: TypeAlias = Union[Load, float, Callable[[float], Load | float], tuple["ArrayLike", "ArrayLike"]]
"""The same for loads. A number is a torque that opposes the motion, N m: `Load(constant=...)`."""


def function(name: str, given: Course | LoadCourse) -> Callable[[float], float | Load] | None:
    """Returns a course as a function of time, s; `None` for a constant. Raises ParameterError for times and
    values that are none."""
    if callable(given):
        return given
    if not isinstance(given, tuple):
        return None
    if len(given) != 2:
        raise ParameterError(f"{name}: must be a pair of times and values, not {len(given)} arrays")
    try:
        time, values = (np.asarray(part, float) for part in given)
    except (OverflowError, TypeError, ValueError):
        raise ParameterError(f"{name}: times and values must be arrays of numbers") from None
    if time.ndim != 1 or time.shape != values.shape or not len(time):
        raise ParameterError(f"{name}: times of shape {time.shape} and values of shape {values.shape}: must be two arrays of one length")
    if not (np.isfinite(time).all() and np.isfinite(values).all()):
        raise ParameterError(f"{name}: times and values must be finite numbers")
    if (np.diff(time) < 0).any():
        row = int(np.flatnonzero(np.diff(time) < 0)[0]) + 1
        raise ParameterError(f"{name}: time {time[row]:g} s in row {row} is before {time[row - 1]:g} s: must ascend")
    return lambda now: float(np.interp(now, time, values))


def load(given: object) -> Load:
    """Returns a load; a number is a torque that opposes the motion, N m."""
    if isinstance(given, Load):
        return given
    if isinstance(given, bool | str | bytes) or not np.isscalar(given):
        raise ParameterError(f"load {given!r}: must be a narx.Load, a torque in N m, a function of time, or times and torques")
    return Load(constant=given)  # type: ignore[arg-type]


class Courses:
    """Load and supply of a bench that change over time."""

    def __init__(self, bench: _core.Bench) -> None:
        self._bench = bench
        self._load: Callable[[float], float | Load] | None = None
        self._supply: Callable[[float], float | Load] | None = None

    def copy(self, bench: _core.Bench) -> Courses:
        """Returns the same courses for another bench."""
        copied = Courses(bench)
        copied._load, copied._supply = self._load, self._supply
        return copied

    def set_load(self, given: LoadCourse) -> None:
        """Replaces the load."""
        found = function("load", given)
        if found is None:
            self._bench.set_load(load(given))
        self._load = found

    def set_supply(self, given: Course | None) -> None:
        """Replaces the supply's voltage; `None` leaves it."""
        if given is None:
            return
        found = function("voltage", given)
        if found is None:
            self._bench.set_supply(voltage=given)  # type: ignore[arg-type]
        self._supply = found

    def advance(self, seconds: float) -> None:
        """Runs the bench for `seconds`; sets load and supply every millisecond."""
        if self._load is None and self._supply is None:
            self._bench.advance(seconds)
            return
        end = self._bench.time + _core.number("seconds", seconds, "s", 0)
        while True:
            now = self._bench.time
            self._apply(now)
            left = end - now
            if left <= 1.5 * PERIOD:
                self._bench.advance(max(left, 0.0))
                return
            self._bench.advance(PERIOD)

    def _apply(self, now: float) -> None:
        try:
            if self._load is not None:
                self._bench.set_load(load(self._load(now)))
            if self._supply is not None:
                self._bench.set_supply(voltage=self._supply(now))  # type: ignore[arg-type]
        except NarxError as error:
            raise ParameterError(f"at {now:.4f} s: {error}") from None
