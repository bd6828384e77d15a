"""Coefficients for programs in C."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import typer

import narx
from narx import given
from narx.cli.app import MODE, MOTOR, app, examples


@app.command(
    epilog=examples(
        "narx coefficients drive.json --board board.toml > coefficients.h",
        "narx coefficients --motor bly172s-24v --mode hall --supply 24 --name pump",
    )
)
def coefficients(
    parameters: Annotated[
        Path | None, typer.Argument(help="JSON file of `narx params dump`; without it those of a preset.")
    ] = None,
    motor: Annotated[str | None, MOTOR] = None,
    mode: Annotated[str | None, MODE] = None,
    supply: Annotated[float | None, typer.Option(help="Supply voltage, V; else the motor's nominal one.")] = None,
    board: Annotated[
        Path | None, typer.Option(help="TOML file with the fields of narx_board_t that differ from the default board.")
    ] = None,
    name: Annotated[str, typer.Option(help="Name of the constant.")] = "coefficients",
) -> None:
    """Prints the coefficients of a motor's control as a C header, for narx_motor_init; needs no drive."""
    if parameters is None:
        preset = given.motor(motor or "ec45-flat-50w-18v")
        volts = (preset.nominal_voltage or 24.0) if supply is None else supply
        chosen = cast("Literal['sensorless', 'hall', 'open-loop']", mode or "sensorless")
        values: dict[str, Any] = preset.commission(volts, chosen)
    else:
        for option, value in [("--motor", motor), ("--mode", mode), ("--supply", supply)]:
            if value is not None:
                raise typer.BadParameter("belongs to a preset, and a file of parameters was given", param_hint=option)
        values = read(parameters, json.loads)
    print(narx.coefficients(values, None if board is None else read(board, tomllib.loads), name), end="")


def read(path: Path, loads: Any) -> dict[str, Any]:
    """Reads a file of names and values."""
    try:
        values = loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise narx.ParameterError(f'file "{path}": {error}') from None
    if not isinstance(values, dict):
        raise narx.ParameterError(f'file "{path}": must contain names and values')
    return values
