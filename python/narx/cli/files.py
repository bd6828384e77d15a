"""Files: logs of frames, recordings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

import narx
from narx.cli.app import JSON, app, examples, out


@app.command()
def decode(path: Path, as_json: Annotated[bool, JSON] = False) -> None:
    """Decodes a log of CAN frames (candump, ASC, BLF, CSV, ...), a line for each message."""
    import can

    for frame in can.LogReader(path):
        message = narx.decode(frame)
        if message is None:
            continue
        if as_json:
            fields = {name: sorted(value) if isinstance(value, frozenset) else value for name, value in message.values.items()}
            print(json.dumps({"time": frame.timestamp, "message": message.name, **fields}, ensure_ascii=False))
            continue
        fields_text = ", ".join(
            f"{name} {' '.join(sorted(value)) or 'none' if isinstance(value, frozenset) else value} {message.units[name]}".rstrip()
            for name, value in message.values.items()
        )
        print(f"{frame.timestamp:.6f} {'<-' if message.from_drive else '->'} {message.name}: {fields_text}")


@app.command(epilog=examples("narx replay run.narxrec", "narx replay run.narxrec --to answers.parquet --json"))
def replay(
    recording: Annotated[Path, typer.Argument(help="A .narxrec file.")],
    to: Annotated[Path | None, typer.Option(help="Save what it answered.")] = None,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Runs a drive through a recording; exit code 1 when it does not answer the same bits."""
    run = narx.replay(recording)
    if to is not None:
        run.save(to)
    if as_json:
        print(json.dumps({"ticks": run.ticks, "digest": f"{run.digest:016x}", "identical": run.identical}))
    else:
        out.print(f"{run.ticks} ticks, digest {run.digest:016x}: {'identical' if run.identical else 'not identical'}")
    raise typer.Exit(0 if run.identical else 1)
