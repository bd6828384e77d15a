"""Sweeps: many variants of a bench, on every core or on any executor, as one table."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from itertools import islice
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from narx import _core, table
from narx.errors import ParameterError, SignalError
from narx.extras import need
from narx.names import suggestion
from narx.parameters import Parameters
from narx.progress import bar
from narx.tasks import Call, Function, Result, Start, Task, failure, run_chunk
from narx.variants import Grid, Variant, check, expand

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from pandas import DataFrame

IN_FLIGHT = 256
"""Largest number of unanswered messages to an executor: it limits the memory of a sweep of any length."""
CHUNK_MAX = 64
"""Largest number of variants in a message."""
GOOD = ("ok", "running")
"""Outcomes that are not failures."""


class Sweep:
    """The table of a sweep, a row for each variant in order: `sweep["speed"]` is a numpy array of shape
    (rows,).

    Columns: "variant" and "seed", the varied names, "outcome", "error", and the results. A missing value is
    NaN, None or "".
    """

    def __init__(
        self, task: Task, variants: Sequence[Variant], results: Sequence[Result], interrupted: bool = False
    ) -> None:
        self._task = task
        self._variants = list(variants)
        self._results = list(results)
        self.interrupted = interrupted
        """True if the sweep was interrupted; the table then has the variants that had ended."""
        self._columns = columns_of(self._variants, self._results)

    def __getitem__(self, column: str) -> NDArray[Any]:
        try:
            return self._columns[column]
        except KeyError:
            hint = suggestion(column, self._columns)
            raise SignalError(f'there is no column "{column}"{hint}; there are {", ".join(self._columns)}') from None

    def __contains__(self, column: object) -> bool:
        return column in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """Number of rows."""
        return len(self._variants)

    def __repr__(self) -> str:
        return f"<narx.Sweep of {len(self)} variants, {len(self.failures)} failed: {', '.join(self)}>"

    def _repr_html_(self) -> str:
        title = f"narx.Sweep of {len(self)} variants, {len(self.failures)} failed"
        return table.html(title, self._columns)  # type: ignore[arg-type]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._columns)

    @property
    def variants(self) -> list[Variant]:
        """The variants that were run, in the order of the rows."""
        return list(self._variants)

    @property
    def varied(self) -> list[str]:
        """The columns that come from the grid."""
        return list(dict.fromkeys(str(name) for variant in self._variants for name in variant))

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one."""
        figures = {name: unit for name, unit in _core.experiment_figures() if unit and isinstance(self._task, Start)}
        parameters = {row.name: row.unit for row in Parameters.rows.values() if row.unit}
        return {name: unit for name, unit in (parameters | figures).items() if name in self._columns}

    @property
    def failures(self) -> Sweep:
        """The rows with an error, or whose motor does not run at the end, or runs at another set-point than
        the requested one ("clamped": "setpoint" and "accepted" have both, rpm)."""
        return self.where(~np.isin(self["outcome"].astype(str), GOOD))

    def where(self, chosen: NDArray[np.bool_]) -> Sweep:
        """Selects the rows where a mask of shape (rows,) is true: `sweep.where(sweep["ripple"] > 0.05)`.
        Raises ParameterError for a mask of another length."""
        mask = np.asarray(chosen)
        if mask.dtype != bool or mask.ndim != 1:
            raise ParameterError(f"mask {chosen!r}: must be an array of bool")
        if len(mask) != len(self):
            raise ParameterError(f"a mask of {len(mask)} values for {len(self)} rows")
        rows = np.flatnonzero(mask)
        return Sweep(
            self._task, [self._variants[row] for row in rows], [self._results[row] for row in rows], self.interrupted
        )

    def replay(self, variant: int) -> Any:
        """Runs a variant again by its number in the column "variant", bit for bit.

        Returns the trace of the built-in experiment since power-up, with its recording; or the result of the
        sweep's function, whose errors are raised. Raises ParameterError for a number that is not in the
        table.
        """
        for known in self._variants:
            if known.index == variant:
                return self._task.replay(known)
        raise ParameterError(f"variant {variant}: is not one of the {len(self)} here")

    def to_dict(self) -> list[dict[str, Any]]:
        """Returns the rows as dictionaries of Python's own values."""
        columns = [(name, column.tolist()) for name, column in self._columns.items()]
        return [{name: values[row] for name, values in columns} for row in range(len(self))]

    def to_pandas(self) -> DataFrame:
        """Returns the columns as a pandas data frame."""
        frame: DataFrame = need("pandas").DataFrame(self._columns)
        return frame

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the table: `.csv`, `.parquet` or `.xlsx`."""
        table.check(path)
        table.save(self._columns, path)


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C during a sweep: `sweep` has the variants that had ended."""

    def __init__(self, sweep: Sweep) -> None:
        super().__init__(f"interrupted after {len(sweep)} variants")
        self.sweep = sweep


def sweep(
    function_or_grid: Function | Grid,
    executor: Executor | None = None,
    *,
    grid: Grid | None = None,
    samples: int = 1,
    seed: int = 1,
    progress: bool | None = None,
    chunk: int | None = None,
) -> Sweep:
    """Runs many variants, on every core of this machine or on an executor, and returns their results as a
    table.

    A grid alone runs the built-in experiment: power up, request `rpm`, run for `seconds` (2) from there, with
    `fault` (`fault_value`, `fault_phase`, `fault_high`) injected `fault_time` s later; a start that fails is
    a result like any other, and so is a set-point that the drive clamps (outcome "clamped"; "accepted" is the
    one in use, rpm). "notes" are the sentences of `Bench.notes`, the winding's temperature at the end. The grid can vary the arguments of Motor and Bench, those of Load with the prefix
    `load_`, `motor` and `load` as a whole, and the drive's parameters by name or number. A function is called
    with a `Variant` of `grid` and returns its results by name; an error that it raises, also SystemExit, is
    the outcome of its row. It runs on threads, which use all cores because a bench releases Python's lock.

    grid: name -> value or values, of which every combination is a variant; or a list or data frame of
    variants. samples: runs of each, with seeds of their own. seed: all those seeds are derived from it; a
    column "seed" in the grid overrides it. executor: any of `concurrent.futures`, of Dask
    (`Client.get_executor()`), ...: functions and results must pickle. chunk: number of variants in one task
    of the executor. progress: whether to show a progress bar of tqdm; by default it is shown if tqdm is
    installed and the output is a terminal or a notebook.

    Raises ParameterError for variants that cannot be run, SweepInterrupted at Ctrl-C.
    """
    task: Task
    if callable(function_or_grid):
        task, chosen = Call(function_or_grid), {} if grid is None else grid
    elif grid is not None:
        raise ParameterError("grid: only together with a function; otherwise pass the grid as the first argument")
    else:
        task, chosen = Start(), function_or_grid
    if chunk is not None:
        chunk = _core.whole_number("chunk", chunk, 1)
    variants = expand(chosen, samples, seed)
    if isinstance(task, Start):
        check(variants)
    results: dict[int, Result] = {}
    with bar(len(variants), "variant", progress) as step:

        def tell(place: int, result: Result) -> None:
            results[place] = result
            step(1)

        try:
            if executor is not None:
                size = chunk or min(-(-len(variants) // IN_FLIGHT), CHUNK_MAX)
                through(executor, task, variants, size, tell)
            elif isinstance(task, Start):
                task.run(variants, tell)
            else:
                on_threads(task, variants, tell)
        except KeyboardInterrupt:
            places = sorted(results)
            done = Sweep(
                task, [variants[place] for place in places], [results[place] for place in places], interrupted=True
            )
            raise SweepInterrupted(done) from None
    return Sweep(task, variants, [results[place] for place in range(len(variants))])


def on_threads(task: Task, variants: Sequence[Variant], tell: Callable[[int, Result], None]) -> None:
    """Runs single variants on as many threads as there are cores. After Ctrl-C the running ones end by
    themselves."""
    pool = ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="narx sweep")
    try:
        through(pool, task, variants, 1, tell)
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def through(
    executor: Executor, task: Task, variants: Sequence[Variant], size: int, tell: Callable[[int, Result], None]
) -> None:
    """Runs variants on an executor, `size` of them in a message. An error of the executor itself becomes the
    result of all variants in the message."""
    left = iter(range(0, len(variants), size))
    waiting: dict[Future[list[Result]], range] = {}
    try:
        while True:
            for begin in islice(left, IN_FLIGHT - len(waiting)):
                places = range(begin, min(begin + size, len(variants)))
                part = [variants[place] for place in places]
                try:
                    waiting[executor.submit(run_chunk, task, part)] = places
                except Exception as error:  # The workers of the pool are gone.
                    settle(places, [failure(error)] * len(places), tell)
            if not waiting:
                return
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                places = waiting.pop(future)
                try:
                    results = future.result()
                except Exception as error:  # A value does not pickle, or the worker died.
                    results = [failure(error)] * len(places)
                settle(places, results, tell)
    finally:
        for future in waiting:
            future.cancel()


def settle(places: Iterable[int], results: Iterable[Result], tell: Callable[[int, Result], None]) -> None:
    """Passes each result on with its place."""
    for place, result in zip(places, results, strict=True):
        tell(place, result)


def columns_of(variants: Sequence[Variant], results: Sequence[Result]) -> dict[str, NDArray[Any]]:
    """Converts variants and results to columns."""
    columns: dict[str, NDArray[Any]] = {
        "variant": np.array([variant.index for variant in variants], np.int64),
        "seed": np.array([variant.seed for variant in variants], np.uint64),
    }
    values: dict[str, list[Any]] = {}
    for row, (variant, result) in enumerate(zip(variants, results, strict=True)):
        named = {str(name): value for name, value in variant.point.items()}
        for name, value in (named | {"outcome": "", "error": ""} | result).items():
            if name not in values:
                values[name] = [None] * len(variants)
            values[name][row] = table.plain(value)
    return columns | {name: table.column(found) for name, found in values.items() if name not in columns}
