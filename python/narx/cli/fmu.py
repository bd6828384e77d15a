"""FMUs for simulation tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, cast

import typer

import narx
from narx.cli.app import MODE, MOTOR, app, examples, out


@app.command(epilog=examples("narx fmu pump.fmu --motor bly172s-24v --mode hall", "narx fmu pump.fmu --supply 20 --load 0.05 --version 2"))
def fmu(
    path: Annotated[Path, typer.Argument(help="File to write.")],
    motor: Annotated[str, MOTOR] = "ec45-flat-50w-18v",
    mode: Annotated[str, MODE] = "sensorless",
    supply: Annotated[float | None, typer.Option(help="Supply voltage, V; else the motor's nominal one.")] = None,
    load: Annotated[float, typer.Option(help="Constant load, N m.")] = 0.0,
    version: Annotated[int, typer.Option(help="2 or 3, of FMI.")] = 3,
) -> None:
    """Writes a drive with its motor as an FMU (co-simulation, Linux on x86-64); needs no drive."""
    chosen = cast("Literal['sensorless', 'hall', 'open-loop']", mode)
    bench = narx.Bench(motor, supply, narx.Load(constant=load), chosen)
    bench.fmu(path, cast("Literal[2, 3]", version))
    out.print(f"{path}: FMI {version}.0 of {bench._about}")
