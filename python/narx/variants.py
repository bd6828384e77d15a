"""What a sweep varies: a grid, expanded into variants, each with a seed of its own."""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, Union

import numpy as np

from narx import _core
from narx._core import Load, Motor
from narx.bench import Bench
from narx.errors import ParameterError, SignalError
from narx.names import suggestion
from narx.parameters import Parameters

if TYPE_CHECKING:
    from pandas import DataFrame

Grid: TypeAlias = Union[
    Mapping[str, Any], Mapping[int, Any], Mapping[str | int, Any], Sequence[Mapping[str, Any]], "DataFrame"
]
"""Name -> value, or values to vary, of which every combination is a variant; or the variants themselves, one by one."""


def arguments_of(call: Any) -> tuple[str, ...]:
    """The arguments of something compiled."""
    return tuple(inspect.signature(call).parameters)


WHOLE = ("motor", "load", "parameters")
"""Arguments of a bench that are made of several names of a grid."""
MOTOR = arguments_of(Motor)
LOAD = {f"load_{name}": name for name in arguments_of(Load)}
BENCH = tuple(name for name in arguments_of(_core.Bench) if name not in WHOLE)
EXPERIMENT = tuple(name for name in arguments_of(_core.Experiment) if name not in WHOLE)


@dataclass(frozen=True)
class Variant(Mapping[str | int, Any]):
    """One variant of a sweep: a mapping of the names of its grid to their values here."""

    index: int
    """Its number in the sweep."""
    seed: int
    """Of all noise on its bench, and for draws of one's own."""
    point: Mapping[str | int, Any]
    """What is varied."""

    def __getitem__(self, name: str | int) -> Any:
        try:
            return self.point[name]
        except KeyError:
            known = [*map(str, self.point)]
            raise SignalError(f'the variant has no "{name}"{suggestion(name, known)}') from None

    def __contains__(self, name: object) -> bool:
        return name in self.point

    def __iter__(self) -> Iterator[str | int]:
        return iter(self.point)

    def __len__(self) -> int:
        return len(self.point)

    def bench(self, **defaults: Any) -> Bench:
        """The bench of this variant, with its seed: `defaults` are arguments as in a grid, which the variant's own values override.

        Names that belong neither to motor, load or bench nor to the drive's parameters are left to the caller.
        """
        all_given = [*defaults.items(), *self.point.items()]
        known = {name: value for name, value in all_given if is_known(name, BENCH)}
        return Bench(**arguments(known, self.seed, BENCH))


def expand(grid: Grid, samples: int, seed: int) -> list[Variant]:
    """The variants of a grid, each `samples` times. A value that is None or NaN is not given."""
    if samples < 1:
        raise ParameterError(f"samples {samples}: must be a whole number, 1 or more")
    if seed < 0:
        raise ParameterError(f"seed {seed}: must be a whole number, 0 or more")
    points = itertools.chain.from_iterable(itertools.repeat(point, samples) for point in points_of(grid))
    variants = [variant(index, point, seed) for index, point in enumerate(points)]
    if not variants:
        raise ParameterError("the grid has no variant")
    return variants


def variant(index: int, point: Mapping[str | int, Any], seed: int) -> Variant:
    """A point with its seed: its own, or one that follows from those of the sweep and from its place."""
    values = {name: value for name, value in point.items() if name != "seed"}
    own = point.get("seed")
    if own is None:
        # 15 digits survive every table and every other program.
        own = int(np.random.SeedSequence([seed, index]).generate_state(1, np.uint64)[0]) >> 16
    return Variant(index, int(own), values)


def points_of(grid: Grid) -> Iterable[dict[str | int, Any]]:
    """Every combination, or what was listed."""
    if isinstance(grid, Mapping):
        axes = {name: axis(name, values) for name, values in grid.items()}
        return (given(dict(zip(axes, values, strict=True))) for values in itertools.product(*axes.values()))
    listed = grid.to_dict("records") if hasattr(grid, "to_dict") else grid
    for row in listed:
        if not isinstance(row, Mapping):
            raise ParameterError(f"variant {row!r}: must be a mapping of names to values")
    return (given(dict(row)) for row in listed)


def axis(name: str | int, values: Any) -> list[Any]:
    """The values of a name: several of anything that can be gone through, else one."""
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        return [values]
    found = list(values)
    if not found:
        raise ParameterError(f'"{name}" has no values to vary')
    return found


def given(point: dict[Any, Any]) -> dict[str | int, Any]:
    """Without what is not given; numbers of numpy as Python's own."""
    plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in point.items()}
    return {name: value for name, value in plain.items() if value is not None and value == value}  # noqa: PLR0124


def is_known(name: str | int, own: Sequence[str]) -> bool:
    """Whether a name belongs to motor, load or parameters, or to those given."""
    if isinstance(name, str) and (name in own or name in MOTOR or name in LOAD or name in ("motor", "load")):
        return True
    try:
        _core.parameter_number(name)
    except ParameterError:
        return False
    return True


def check(variants: Iterable[Variant]) -> None:
    """Refuses a name that an experiment does not know, before anything runs."""
    names = dict.fromkeys(name for variant in variants for name in variant)
    for name in names:
        if not is_known(name, EXPERIMENT):
            known = ["motor", "load", *EXPERIMENT, *MOTOR, *LOAD, *(row.name for row in Parameters.rows.values())]
            raise ParameterError(f'there is no "{name}" to vary{suggestion(name, known)}')


def arguments(values: Mapping[str | int, Any], seed: int, own: Sequence[str]) -> dict[str, Any]:
    """Keyword arguments of a bench or an experiment, whose own names are `own`."""
    rest = dict(values)
    motor = motor_of(rest.pop("motor", None), {name: rest.pop(name) for name in MOTOR if name in rest})
    load = load_of(rest.pop("load", None), {LOAD[name]: rest.pop(name) for name in LOAD if name in rest})
    taken = {name: rest.pop(name) for name in own if name in rest}
    return {"motor": motor, "load": load, "parameters": rest, "seed": seed} | taken


def motor_of(motor: Motor | str | None, changes: Mapping[str, Any]) -> Motor:
    """A motor or a preset with changes, or one of figures alone."""
    if motor is None:
        try:
            return Motor(**changes)
        except TypeError as error:
            raise ParameterError(
                f'"motor" is missing, a preset or a narx.Motor, or all of its figures: {error}'
            ) from None
    whole = Motor.preset(motor) if isinstance(motor, str) else motor
    return whole.replace(**changes) if changes else whole


def load_of(load: Load | None, changes: Mapping[str, Any]) -> Load | None:
    """A load with changes."""
    if not changes:
        return load
    whole = load or Load()
    return Load(**{name: getattr(whole, name) for name in LOAD.values()} | dict(changes))
