"""Recordings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

import narx
from narx.cli.app import JSON, app, examples, out


@app.command(epilog=examples("narx replay run.narxrec", "narx replay run.narxrec --to answers.parquet --json"))
def replay(
    recording: Annotated[Path, typer.Argument(help="A .narxrec file.")],
    to: Annotated[Path | None, typer.Option(help="Save what it answered.")] = None,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Runs a drive through a recording; exit code 1 if its outputs are not the same bits."""
    run = narx.replay(recording)
    if to is not None:
        run.save(to)
    if as_json:
        print(json.dumps({"ticks": run.ticks, "digest": f"{run.digest:016x}", "identical": run.identical}))
    else:
        out.print(f"{run.ticks} ticks, digest {run.digest:016x}: {'identical' if run.identical else 'not identical'}")
    raise typer.Exit(0 if run.identical else 1)
