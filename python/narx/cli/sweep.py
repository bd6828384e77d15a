"""Many variants of a start as one table."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

import narx
from narx import table
from narx.cli.app import JSON, MODE, MOTOR, SUPPLY, app, err, examples, out
from narx.tasks import Start
from narx.variants import VARIANTS_MAX, check, expand, points_of

SHOWN = 10
"""Largest number of failures that are listed."""


@app.command(
    epilog=examples(
        "narx sweep --motor ec45-flat-50w-18v --mode hall --set rpm=1000:4000:7 --set load_constant=0,0.01,0.02 --to sweep.csv",
        'narx sweep --motor bly172s-24v --supply 24 --set "Phase current limit=2,4,6" --samples 20',
        "narx sweep grid.toml --json > rows.jsonl",
        "narx sweep grid.toml --replay 17 --to variant17.narxrec",
    )
)
def sweep(
    grid: Annotated[
        Path | None,
        typer.Argument(
            help="A .toml or .json file: names to values or lists of them; in JSON also a list of variants."
        ),
    ] = None,
    motor: Annotated[str | None, MOTOR] = None,
    mode: Annotated[str | None, MODE] = None,
    supply: Annotated[float | None, SUPPLY] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="NAME=VALUE,VALUE or NAME=FIRST:LAST:COUNT; any name that narx.sweep varies."),
    ] = None,
    samples: Annotated[int, typer.Option(help="Runs of each variant, with seeds of their own.")] = 1,
    seed: Annotated[int, typer.Option(help="What all seeds follow from.")] = 1,
    to: Annotated[
        Path | None,
        typer.Option(help="Save the table as .csv, .parquet or .xlsx; with --replay the trace, or .narxrec."),
    ] = None,
    replay: Annotated[
        int | None, typer.Option(help="Run only this variant, by its number, and keep its trace.")
    ] = None,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Starts many variants of a motor on every core; exit code 1 when one of them does not run at the end.

    Ctrl-C keeps what has ended by then. With --json a line for each variant.
    """
    chosen = read(grid)
    options = {"motor": motor, "mode": mode, "supply_voltage": supply}
    changes = {name: value for name, value in options.items() if value is not None} | dict(map(setting, settings or []))
    points: Any = (
        {**chosen, **changes}
        if isinstance(chosen, dict)
        else [{**row, **point} for row in chosen for point in points_of(changes)]
    )
    if replay is not None:
        again(points, samples, seed, replay, to)
        return
    if to is not None:
        table.check(to)
    try:
        found = narx.sweep(points, samples=samples, seed=seed)
    except narx.SweepInterrupted as interrupted:
        found = interrupted.sweep
    if to is not None:
        found.save(to)
    if as_json:
        for row in found.to_dict():
            print(json.dumps({name: None if value != value else value for name, value in row.items()}))  # noqa: PLR0124
    else:
        show(found, to)
    raise typer.Exit(130 if found.interrupted else 1 if len(found.failures) else 0)


def read(path: Path | None) -> Any:
    """Reads a grid from a file."""
    match path and path.suffix.lower():
        case None:
            return {}
        case ".toml":
            load: Any = tomllib.loads
        case ".json":
            load = json.loads
        case suffix:
            raise typer.BadParameter(f'{path}: "{suffix}" must be .toml or .json', param_hint="GRID")
    assert path is not None
    try:
        return load(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise typer.BadParameter(f"{path}: {error}", param_hint="GRID") from None


def setting(text: str) -> tuple[str | int, list[Any]]:
    """Parses a name with its values."""
    name, found, values = text.partition("=")
    if not found or not values:
        raise typer.BadParameter(f"{text}: must be NAME=VALUE,VALUE or NAME=FIRST:LAST:COUNT", param_hint="--set")
    key = int(name) if name.isascii() and name.isdecimal() else name
    first, *rest = values.split(":")
    if len(rest) == 2:
        try:
            if not values.isascii():
                raise ValueError
            begin, end, count = float(first), float(rest[0]), int(rest[1])
        except ValueError:
            raise typer.BadParameter(f"{text}: FIRST:LAST:COUNT must be numbers", param_hint="--set") from None
        if not 1 <= count <= VARIANTS_MAX:
            raise typer.BadParameter(f"{text}: COUNT must be from 1 to {VARIANTS_MAX}", param_hint="--set")
        return key, np.linspace(begin, end, count).tolist()
    return key, [value_of(value) for value in values.split(",")]


def value_of(text: str) -> Any:
    """Converts a text to a number or a flag if it looks like one."""
    try:
        value = json.loads(text)
    except ValueError:
        return text
    return value if isinstance(value, bool | int | float) and math.isfinite(value) else text


def again(points: Any, samples: int, seed: int, number: int, to: Path | None) -> None:
    """Runs one variant again and saves its trace."""
    variants = expand(points, samples, seed)
    check(variants)
    if not 0 <= number < len(variants):
        raise typer.BadParameter(f"{number}: must be from 0 to {len(variants) - 1}", param_hint="--replay")
    trace = Start().replay(variants[number])
    run = narx.replay(trace.recording())
    if to is not None:
        trace.save(to)
    out.print(
        f"variant {number}: {len(trace)} ticks, digest {run.digest:016x}{f', in {to}' if to else ''}",
        highlight=False,
        soft_wrap=True,
    )


def show(found: narx.Sweep, to: Path | None) -> None:
    """Prints the counts and the first failures."""
    names, counts = np.unique(found["outcome"].astype(str), return_counts=True)
    text = ", ".join(f"{count} {name}" for name, count in zip(names, counts, strict=True))
    out.print(f"{len(found)} variants: {text}{f'; in {to}' if to else ''}", highlight=False, soft_wrap=True)
    failures = found.failures.to_dict()
    if not failures:
        return
    varied = [name for name in found.varied if len(set(map(str, found[name]))) > 1]
    rows = Table("variant", *varied, "outcome", "why")
    for row in failures[:SHOWN]:
        why = row["error"] or row.get("cause") or row.get("faults") or ""
        rows.add_row(*(str(row[name]) for name in ("variant", *varied, "outcome")), why)
    err.print(rows)
    if len(failures) > SHOWN:
        err.print(f"and {len(failures) - SHOWN} more", highlight=False)
