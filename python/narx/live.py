"""A plot in a notebook that grows while a bench runs."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from narx import _core, given
from narx.errors import ParameterError, RefusedError
from narx.extras import need
from narx.rows import checked
from narx.trace import Trace

if TYPE_CHECKING:
    from narx.bench import Bench

PICTURES = 1000
"""Largest number of pictures of a run."""


def live(bench: Bench, seconds: float, signals: tuple[str, ...], refresh: float, every: int) -> Trace:
    """Runs a bench and draws what it has so far every `refresh` s."""
    from narx.bench import RunInterrupted

    seconds, refresh = given.seconds(seconds), _core.number("refresh", refresh, "s", 1e-3)
    every = _core.whole_number("every", every, 1, 1_000_000)
    if seconds > PICTURES * refresh:
        raise ParameterError(f"refresh {refresh:g} s: must be {seconds / PICTURES:g} s or more, for {PICTURES} pictures in {seconds:g} s")
    chosen = checked(signals, [name for name, _ in bench._bench.signals()])[1:] if signals else None
    need("matplotlib")
    notebook = sys.modules.get("IPython")
    if notebook is None or notebook.get_ipython() is None:
        raise RefusedError("live: there is no notebook here; run(...).plot(...) draws when a run has ended")
    handle: Any = None
    parts: list[Trace] = []
    for step in steps(seconds, refresh, every / bench._pwm_rate):
        try:
            parts.append(bench.run(step, signals=chosen, every=every, progress=False))
        except RunInterrupted as interrupted:
            raise RunInterrupted(joined([*parts, interrupted.trace])) from None
        figure = joined(parts).plot(*signals)
        if handle is None:
            handle = notebook.display.display(figure, display_id=True)
        else:
            handle.update(figure)
    return joined(parts)


def steps(seconds: float, refresh: float, row: float) -> Iterator[float]:
    """Yields the durations between pictures, s: whole rows, so that these are equidistant."""
    step = max(round(refresh / row), 1) * row
    while seconds > 1.5 * step:
        yield step
        seconds -= step
    yield seconds


def joined(parts: list[Trace]) -> Trace:
    """Returns the traces of runs that follow each other as one; its recording is that of the last."""
    last = parts[-1]
    return Trace({name: np.concatenate([part[name] for part in parts]) for name in last}, last.signals, last.recording())
