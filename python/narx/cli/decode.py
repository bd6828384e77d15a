"""Logs of CAN frames."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

import narx
from narx.cli.app import JSON, app, err, examples, out
from narx.log_file import read_candump


@app.command(epilog=examples("narx decode bus.log", "narx decode --summary bus.blf", "narx decode --csv bus.log > values.csv", "candump -L -n 100 can0 | narx decode -"))
def decode(
    path: Annotated[Path, typer.Argument(help="A log of frames; - reads candump text from the standard input.")],
    as_json: Annotated[bool, JSON] = False,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print a row for each value: time, message, signal, value, unit.")] = False,
    summary: Annotated[bool, typer.Option("--summary", help="Print a table of the messages alone.")] = False,
    encoder: Annotated[
        list[int] | None, typer.Option(help="Node-id of a TX-Driver of two channels whose PDOs have the encoder in them.")
    ] = None,
) -> None:
    """Decodes a log of CAN frames (candump, ASC, BLF, CSV, ...), a line for each message. Lines that are
    no frame are printed to the error output; the exit code is then 1."""
    nodes = encoder or ()
    if str(path) == "-":
        found = read_candump(sys.stdin.buffer.read(), None, None, nodes)
    else:
        found = narx.read_log(path, slave=None, monitor=None, encoders=nodes)
    if summary:
        print(json.dumps(summary_of(found))) if as_json else out.print(table_of_log(found))
    elif as_csv:
        rows = csv.writer(sys.stdout, lineterminator="\n")
        rows.writerow(["time", "message", "signal", "value", "unit"])
        for time, message in found.messages():
            rows.writerows([time, message.name, name, plain(value), message.units[name]] for name, value in message.values.items())
    else:
        for time, message in found.messages():
            print(json_line(time, message) if as_json else line(time, message))
    for error in found.errors:
        place = f"{path}:{error.line}" if error.line else str(path)
        err.print(f"narx: {place}: {error.reason}{f': {error.text}' if error.text else ''}", highlight=False, markup=False, soft_wrap=True)
    raise typer.Exit(1 if found.errors else 0)


def json_line(time: float, message: narx.Message | narx.NodeMessage) -> str:
    """Formats a message as JSON, for other programs."""
    fields = {name: sorted(value) if isinstance(value, frozenset) else value for name, value in message.values.items()}
    return json.dumps({"time": time, "message": message.name, **fields}, ensure_ascii=False)


def line(time: float, message: narx.Message | narx.NodeMessage) -> str:
    """Formats a message as text. The arrow `->` marks messages of the master, `<-` messages to it."""
    from_device = message.from_drive if isinstance(message, narx.Message) else message.from_node
    fields = (f"{name} {plain(value)} {message.units[name]}".rstrip() for name, value in message.values.items())
    return f"{time:.6f} {'<-' if from_device else '->'} {message.name}: {', '.join(fields)}"


def plain(value: Any) -> Any:
    """Formats a set of faults as words."""
    return " ".join(sorted(value)) or "none" if isinstance(value, frozenset) else value


def summary_of(found: narx.CanLog) -> dict[str, Any]:
    """Returns the number of frames of each kind in a log."""
    others = {"unknown": found.unknown, "malformed": found.malformed, "error frames": found.error_frames}
    return {
        "frames": len(found),
        "messages": found.counts,
        **{name: len(frames) for name, frames in others.items()},
        "errors": len(found.errors),
    }


def table_of_log(found: narx.CanLog) -> Table:
    """Builds the table for `--summary`, with the rate of each message."""
    table = Table("message", "frames", "per second", title=f"{len(found)} frames, {len(found.errors)} errors")
    for name, count in found.counts.items():
        time = found.table(name).time
        span = time[-1] - time[0]
        table.add_row(name, str(count), f"{(count - 1) / span:.1f}" if span > 0 else "")
    for name in ("unknown", "malformed", "error frames"):
        if count := summary_of(found)[name]:
            table.add_row(name, str(count), "")
    return table
