"""The identification of a motor: its figures, measured by its drive."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from os import PathLike
from typing import Any

from narx import _core, given
from narx.errors import NarxError, ParameterError, RefusedError
from narx.link import Link

POLL = 0.005
"""Time from one look to the next, s."""


@dataclass(frozen=True)
class Figure:
    """A measured figure. The truth is within `uncertainty` of `value` for about 95 of 100 motors."""

    value: float
    uncertainty: float

    def __float__(self) -> float:
        return self.value


@dataclass(frozen=True)
class Halls:
    """How hall sensors are wired: the values of three parameters of the drive, which has them from then on."""

    order: int
    """Permutation of the lines, 0 to 5 (parameter 262)."""
    polarity: int
    """Lines that are inverted, a bit each (parameter 263)."""
    offset: float
    """Offset of the edges, electrical degrees (parameter 80)."""


@dataclass(frozen=True)
class Identified:
    """The figures of a motor as its drive has measured them, at the temperature that the motor had. Those of a
    rotor that was not allowed to turn are `None`."""

    pole_pairs: int
    """As given."""
    supply_voltage: float
    """Bus voltage without load, V."""
    current: float
    """Largest phase current of the identification: the given one, or what the heat allows, A."""
    resistance: Figure
    """Line to line, ohm."""
    inductance: Figure
    """Line to line, H."""
    torque_constant: Figure | None = None
    """N m/A, which is the back-EMF constant, V s/rad."""
    inertia: Figure | None = None
    """Of the rotor and what is coupled to it, kg m2."""
    friction: Figure | None = None
    """At `speed`, N m."""
    static_friction: float | None = None
    """Its constant part, N m."""
    viscous_friction: float | None = None
    """Its part that grows with the speed, N m s/rad."""
    speed: float | None = None
    """Speed to which `friction` belongs, rad/s."""
    temperature: float | None = None
    """Ambient temperature at the drive when the measurement began, degrees Celsius: that of a motor that has rested in the
    same room. Copper has 3.9 % more resistance for each 10 K more."""
    halls: Halls | None = None
    """How the hall sensors are wired; `None` if they were not asked for."""

    def motor(self, **others: Any) -> _core.Motor:
        """Returns the motor for `narx.Bench`, `narx.sweep` and `commission`. others: further figures of
        `narx.Motor`, such as rated_current, which no drive can measure.

        Raises RefusedError if the rotor was not allowed to turn.
        """
        return _core.Motor(**self._figures() | others)

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the figures as a motor's file (TOML), which `narx.Bench`, `narx bench --motor`, `narx commission`
        and `narx sweep` take."""
        lines = [f"{name} = {value!r}" for name, value in self._figures().items()]
        given.path(path).write_text("\n".join(["# Measured by the drive.", *lines, ""]))

    def _figures(self) -> dict[str, float]:
        if self.torque_constant is None or self.inertia is None:
            raise RefusedError("the rotor was not allowed to turn: torque constant and inertia were not measured")
        return {
            "pole_pairs": self.pole_pairs,
            "resistance": self.resistance.value,
            "inductance": self.inductance.value,
            "torque_constant": self.torque_constant.value,
            "inertia": self.inertia.value,
            "static_friction": self.static_friction or 0.0,
            "viscous_friction": self.viscous_friction or 0.0,
        }

    def __str__(self) -> str:
        rows = [
            ("resistance", self.resistance, 1, "ohm"),
            ("inductance", self.inductance, 1e3, "mH"),
            ("torque constant", self.torque_constant, 1e3, "mN m/A"),
            ("inertia", self.inertia, 1e7, "g cm2"),
            ("friction", self.friction, 1e3, "mN m"),
        ]
        lines = [
            f"{name:16} {figure.value * scale:10.4g} +- {figure.uncertainty * scale:.2g} {unit}"
            for name, figure, scale, unit in rows
            if figure is not None
        ]
        lines.insert(0, f"{'pole pairs':16} {self.pole_pairs:10d}")
        if self.temperature is not None:
            lines.append(f"{'ambient':16} {self.temperature:10.1f} degC")
        if self.halls is not None:
            lines.append(f"{'hall sensors':16} order {self.halls.order}, polarity {self.halls.polarity}, offset {self.halls.offset:+.2f} deg")
        return "\n".join(lines)


def identify(
    link: Link,
    pole_pairs: int | None,
    current: float | None,
    bridge: float | None,
    turn: bool,
    halls: bool,
    progress: Callable[[str], None] | None,
    mark: Callable[[], bool] | None,
) -> Identified:
    """Identifies the motor; see `narx.Drive.identify`."""
    if pole_pairs is None and mark is None and turn:
        raise ParameterError("pole_pairs is missing: give it, or mark, with which the drive counts them")
    identification = _core.Identification(pole_pairs, current, bridge, turn, halls)
    stage = ""
    try:
        while (figures := identification.step(link.master)) is None:
            if progress is not None and identification.stage != stage:
                stage = identification.stage
                progress(stage)
            if identification.stage == "counting" and mark is not None and mark():
                identification.mark(link.master)
            link.wake()
            link.wait(lambda: False, POLL)
    finally:
        if not identification.has_ended:
            end(link, identification)
    calibrated = figures.pop("halls", None)
    known: dict[str, Any] = {name: Figure(*value) if isinstance(value, tuple) else value for name, value in figures.items()}
    return Identified(**known, halls=None if calibrated is None else Halls(*calibrated))


def end(link: Link, identification: _core.Identification) -> None:
    """Ends an identification that was interrupted: the motor stops and the parameters get their values back."""
    identification.abort(link.master)
    # Its error is that of the interruption, which the caller raises.
    with suppress(NarxError):
        while identification.step(link.master) is None:
            link.wake()
            link.wait(lambda: False, POLL)
