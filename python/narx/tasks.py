"""Tasks of a sweep: the built-in experiment, or a function. Tasks are sent to other processes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeAlias

from narx import _core
from narx.trace import Trace
from narx.variants import EXPERIMENT, Variant, arguments

Function: TypeAlias = Callable[[Variant], Any]
Result: TypeAlias = dict[str, Any]


class Task(Protocol):
    """Work that a sweep does with its variants."""

    def chunk(self, variants: Sequence[Variant]) -> list[Result]:
        """Returns the results of some variants."""

    def replay(self, variant: Variant) -> Any:
        """Runs one variant again and returns its full result."""


class Start:
    """The built-in experiment: a start, and its figures."""

    def chunk(self, variants: Sequence[Variant]) -> list[Result]:
        results: list[Result] = [{}] * len(variants)
        self.run(variants, results.__setitem__, threads=1)
        return results

    def run(self, variants: Sequence[Variant], tell: Callable[[int, Result], None], threads: int | None = None) -> None:
        """Runs variants on threads without Python's lock; `tell` is called with place and result of each as
        it ends."""
        places, experiments = [], []
        for place, variant in enumerate(variants):
            try:
                experiments.append(self.experiment(variant))
                places.append(place)
            except Exception as error:  # An invalid variant must not end the others.
                tell(place, failure(error))

        def ended(number: int, figures: Result | str) -> None:
            tell(places[number], {"outcome": "error", "error": figures} if isinstance(figures, str) else figures)

        _core.run_experiments(experiments, ended, threads)

    def replay(self, variant: Variant) -> Trace:
        return Trace(*self.experiment(variant).run())

    @staticmethod
    def experiment(variant: Variant) -> _core.Experiment:
        return _core.Experiment(**arguments(variant.point, variant.seed, EXPERIMENT))


class Call:
    """A function of the user's."""

    def __init__(self, function: Function) -> None:
        self.function = function

    def chunk(self, variants: Sequence[Variant]) -> list[Result]:
        return [self.call(variant) for variant in variants]

    def call(self, variant: Variant) -> Result:
        try:
            found = self.function(variant)
        except (Exception, SystemExit) as error:  # A variant that fails must not end the others.
            return failure(error)
        named = found if isinstance(found, Mapping) else {} if found is None else {"result": found}
        return {"outcome": "ok"} | dict(named)

    def replay(self, variant: Variant) -> Any:
        return self.function(variant)


def failure(error: BaseException) -> Result:
    """Returns the result of a variant that raised an error."""
    return {"outcome": "error", "error": f"{type(error).__name__}: {error}"}


def run_chunk(task: Task, variants: Sequence[Variant]) -> list[Result]:
    """Runs some variants; executors call it."""
    return task.chunk(variants)
