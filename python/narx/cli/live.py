"""Present state and identity of a drive."""

from __future__ import annotations

import json
from contextlib import suppress
from typing import Annotated, Any

import typer
from rich.live import Live
from rich.table import Table

import narx
from narx import given
from narx.cli.app import JSON, app, connected, examples, out
from narx.drive import name_of


@app.command(epilog=examples("narx devices", "narx devices --json"))
def devices(as_json: Annotated[bool, JSON] = False) -> None:
    """Lists the adapters that python-can finds."""
    found = narx.devices()
    if as_json:
        print(json.dumps(found, default=str))
        return
    for device in found:
        out.print(" ".join(f"{name}={value}" for name, value in device.items()))


@app.command(
    epilog=examples(
        "narx -i socketcan -c can0 monitor", "narx -i slcan -c socket://127.0.0.1:2000 monitor --seconds 2 --json"
    )
)
def monitor(
    seconds: Annotated[float | None, typer.Option(help="Ends after so long; else at Ctrl-C.")] = None,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Shows state, faults and measurements, live."""
    if seconds is not None:
        given.seconds(seconds)
    with connected() as drive:
        if as_json:
            drive.wait(1.0 if seconds is None else seconds)
            print(json.dumps(snapshot(drive)))
            return
        end = float("inf") if seconds is None else drive._link.now + seconds
        with suppress(KeyboardInterrupt), Live(console=out, refresh_per_second=10) as live:
            while drive._link.now < end:
                drive.wait(0.1)
                live.update(table_of(drive))


def snapshot(drive: narx.Drive) -> dict[str, Any]:
    """Returns the known values of a drive, for JSON."""
    return {
        "state": None if drive.state is None else drive.state.name.lower(),
        "faults": sorted(drive.faults),
        "diagnostics": [] if drive._master.silent else sorted(drive.diagnostics),
        "status": drive.status,
        "speed": drive.measurements.speed,
        "measurements": dict(drive.measurements),
    }


def table_of(drive: narx.Drive) -> Table:
    """Builds a table of the known values."""
    table = Table(title=name_of(drive.state) + (f": {', '.join(sorted(drive.faults))}" if drive.faults else ""))
    table.add_column("measurement")
    table.add_column("value", justify="right")
    table.add_column("unit")
    measurements = drive.measurements
    for name in measurements:
        known = measurements.full(name)
        table.add_row(name, f"{known.value:g}", known.unit)
    return table


@app.command(epilog=examples("narx -i socketcan -c can0 info", "narx -i socketcan -c can0 info --json"))
def info(as_json: Annotated[bool, JSON] = False) -> None:
    """Prints the identity of the drive: releases, serial number, address."""
    with connected() as drive:
        found = vars(drive.info)
    if as_json:
        print(json.dumps(found))
        return
    for name, value in found.items():
        out.print(f"{name.replace('_', ' ')}: {value}")
