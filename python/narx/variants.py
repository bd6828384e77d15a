"""Variants of a sweep: a grid, expanded into variants, each with a seed of its own."""

from __future__ import annotations

import inspect
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, Union

import numpy as np

from narx import _core, given
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
"""Name -> value, or several values, of which every combination is a variant; or a list of the variants
themselves."""


def arguments_of(call: Any) -> tuple[str, ...]:
    """Returns the names of the arguments of a compiled function or class."""
    return tuple(inspect.signature(call).parameters)


VARIANTS_MAX = 10_000_000
"""Largest number of variants: their table takes some 10 GB."""
SEED_MAX = 2**64 - 1
"""Largest seed."""
WHOLE = ("motor", "load", "parameters")
"""Arguments of a bench that are built from several names of a grid."""
MOTOR = arguments_of(Motor)
LOAD = {f"load_{name}": name for name in arguments_of(Load)}
BENCH = tuple(name for name in arguments_of(_core.Bench) if name not in WHOLE)
EXPERIMENT = tuple(name for name in arguments_of(_core.Experiment) if name not in WHOLE)


@dataclass(frozen=True)
class Variant(Mapping[str | int, Any]):
    """One variant of a sweep: a mapping of the grid's names to their values in it."""

    index: int
    """Number of the variant in the sweep."""
    seed: int
    """Seed of all noise on its bench, and for random values of your own."""
    point: Mapping[str | int, Any]
    """Names and values that are varied."""

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
        """Returns the bench of this variant, with its seed. `defaults` are arguments as in a grid; the
        variant's own values override them.

        Names that belong neither to motor, load or bench nor to the drive's parameters are ignored.
        """
        all_given = [*defaults.items(), *self.point.items()]
        known = {name: value for name, value in all_given if is_known(name, BENCH)}
        return Bench(**arguments(known, self.seed, BENCH))


def expand(grid: Grid, samples: int, seed: int) -> list[Variant]:
    """Returns the variants of a grid, each `samples` times. A value that is None counts as not given, and so
    does NaN in a list of variants, as a table has it. Raises ParameterError for NaN among the values of a
    name, and for more than `VARIANTS_MAX` variants."""
    samples = _core.whole_number("samples", samples, 1)
    seed = _core.whole_number("seed", seed, 0, SEED_MAX)
    points = itertools.chain.from_iterable(itertools.repeat(point, samples) for point in points_of(grid, samples))
    variants = [variant(index, point, seed) for index, point in enumerate(points)]
    if not variants:
        raise ParameterError("the grid has no variant")
    return variants


def variant(index: int, point: Mapping[str | int, Any], seed: int) -> Variant:
    """Makes a variant of a point. Its seed is the point's own, or is derived from the sweep's seed and the
    variant's number."""
    values = {name: value for name, value in point.items() if name != "seed"}
    own = point.get("seed")
    if own is None:
        # 15 digits are exact in every table format and in other programs.
        own = int(np.random.SeedSequence([seed, index]).generate_state(1, np.uint64)[0]) >> 16
    return Variant(index, _core.whole_number("seed", own, 0, SEED_MAX), values)


def points_of(grid: Grid, samples: int = 1) -> Iterable[dict[str | int, Any]]:
    """Returns every combination of the grid's values, or the listed variants."""
    if isinstance(grid, Mapping):
        axes = {name: axis(name, values) for name, values in grid.items()}
        limit(math.prod(map(len, axes.values())) * samples)
        return (plain(dict(zip(axes, values, strict=True))) for values in itertools.product(*axes.values()))
    listed = grid.to_dict("records") if hasattr(grid, "to_dict") else given.several("grid", grid)
    limit(len(listed) * samples)
    for row in listed:
        if not isinstance(row, Mapping):
            raise ParameterError(f"variant {row!r}: must be a mapping of names to values")
    return (plain(dict(row)) for row in listed)


def axis(name: str | int, values: Any) -> list[Any]:
    """Returns the values of a name: several if `values` can be iterated, else one."""
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        values = [values]
    found = list(itertools.islice(values, VARIANTS_MAX + 1))
    if not found:
        raise ParameterError(f'"{name}" has no values to vary')
    if any(is_nan(value) for value in found):
        raise ParameterError(f'"{name}" nan: must not be NaN; None is a value that is not given')
    return found


def limit(count: int) -> None:
    """Raises ParameterError for more variants than fit in memory."""
    if count > VARIANTS_MAX:
        raise ParameterError(f"{count} variants: must be at most {VARIANTS_MAX}")


def is_nan(value: Any) -> bool:
    """Returns whether a value is a number that is none."""
    return isinstance(value, float | np.floating) and bool(np.isnan(value))


def plain(point: dict[Any, Any]) -> dict[str | int, Any]:
    """Removes values that are not given, and converts numbers of numpy to Python's own."""
    own = {name: value.item() if isinstance(value, np.generic) else value for name, value in point.items()}
    return {name: value for name, value in own.items() if value is not None and not is_nan(value)}


def is_known(name: str | int, own: Sequence[str]) -> bool:
    """Returns whether a name belongs to motor, load or parameters, or to `own`."""
    if isinstance(name, str) and (name in own or name in MOTOR or name in LOAD or name in ("motor", "load")):
        return True
    try:
        _core.parameter_number(name)
    except ParameterError:
        return False
    return True


def check(variants: Iterable[Variant]) -> None:
    """Raises ParameterError for a name that an experiment does not know, before anything runs."""
    names = dict.fromkeys(name for variant in variants for name in variant)
    for name in names:
        if not is_known(name, EXPERIMENT):
            known = ["motor", "load", *EXPERIMENT, *MOTOR, *LOAD, *(row.name for row in Parameters.rows.values())]
            raise ParameterError(f'there is no "{name}" to vary{suggestion(name, known)}')


def arguments(values: Mapping[str | int, Any], seed: int, own: Sequence[str]) -> dict[str, Any]:
    """Returns the keyword arguments of a bench or an experiment, whose own names are `own`."""
    rest = dict(values)
    motor = motor_of(rest.pop("motor", None), {name: rest.pop(name) for name in MOTOR if name in rest})
    load = load_of(rest.pop("load", None), {LOAD[name]: rest.pop(name) for name in LOAD if name in rest})
    taken = {name: rest.pop(name) for name in own if name in rest}
    return {"motor": motor, "load": load, "parameters": rest, "seed": seed} | taken


def motor_of(motor: Motor | str | None, changes: Mapping[str, Any]) -> Motor:
    """Returns a motor or a preset with changes, or one that is built from its data alone."""
    if motor is None:
        try:
            return Motor(**changes)
        except TypeError as error:
            raise ParameterError(
                f'"motor" is missing, a preset or a narx.Motor, or all of its figures: {error}'
            ) from None
    whole = given.motor(motor)
    return whole.replace(**changes) if changes else whole


def load_of(load: Load | None, changes: Mapping[str, Any]) -> Load | None:
    """Returns a load with changes."""
    if load is not None:
        given.load(load)
    if not changes:
        return load
    whole = load or Load()
    return Load(**{name: getattr(whole, name) for name in LOAD.values()} | dict(changes))
