"""The external log memory."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress

from narx.cli.app import JSON, app, connected, err, examples, out

log = typer.Typer(no_args_is_help=True, help="The external log memory of a drive.")
app.add_typer(log, name="log")


@log.command("show", epilog=examples("narx log show", "narx log show --json"))
def log_show(as_json: Annotated[bool, JSON] = False) -> None:
    """Prints the logged values and the fill level of the memory."""
    with connected() as drive:
        found = {"records": len(drive.log), "capacity": drive.log.capacity, "values": drive.log.slots}
    if as_json:
        print(json.dumps(found))
        return
    out.print(f"{found['records']} of {found['capacity']} records", highlight=False)
    for name, kind in found["values"].items():  # type: ignore[attr-defined]
        out.print(f"  {name}: {kind}", highlight=False)


@log.command(
    "download",
    epilog=examples("narx log download records.parquet", "narx log download last.csv --first 1000 --count 50"),
)
def log_download(
    to: Annotated[Path, typer.Argument(help=".csv, .parquet or .xlsx.")],
    first: Annotated[int, typer.Option(help="The first record.")] = 0,
    count: Annotated[int | None, typer.Option(help="How many; else all from there.")] = None,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Saves records as .csv, .parquet or .xlsx."""
    with connected() as drive, Progress(console=err) as bar:
        task = bar.add_task("download", total=None)
        trace = drive.log.download(
            first, count, lambda received, total: bar.update(task, completed=received, total=total)
        )
    trace.save(to)
    if as_json:
        print(json.dumps({"records": len(trace), "file": str(to)}))
        return
    out.print(f"{len(trace)} records in {to}", highlight=False)


@log.command("erase", epilog=examples("narx log erase --yes"))
def log_erase(yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False) -> None:
    """Erases every record."""
    if not yes:
        typer.confirm("Erase every record of the log?", abort=True)
    with connected() as drive:
        drive.log.erase()
