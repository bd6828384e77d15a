"""Parameters of a drive."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

import narx
from narx.cli.app import JSON, app, connected, examples, out
from narx.parameters import read_file

params = typer.Typer(no_args_is_help=True, help="Parameters of a drive: get, set, dump, load and compare.")
app.add_typer(params, name="params")


def names(incomplete: str) -> list[str]:
    """Returns names of parameters, for completion."""
    folded = incomplete.casefold()
    return [row.name for row in narx.Parameters.rows.values() if row.name.casefold().startswith(folded)]


def number(text: str) -> float | str:
    """Converts a text to the number that it spells as a JSON number; returns any other text unchanged, so
    that the parameter refuses it with its range."""
    with suppress(ValueError):
        return float(text) if text.isascii() and "_" not in text else text
    return text


@params.command("get", epilog=examples('narx params get "Motor pair poles" 266', "narx params get 266 --json"))
def params_get(
    names: Annotated[list[str], typer.Argument(help="Names or numbers.", autocompletion=names)],
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Reads parameters by name or number."""
    with connected() as drive:
        rows = [drive.parameters.row(key(name)) for name in names]
        values = {row.name: drive.parameters[row.number] for row in rows}
    if as_json:
        print(json.dumps(values))
        return
    for row in rows:
        out.print(f"{row.number} {row.name}: {values[row.name]:g} {row.unit}".rstrip(), highlight=False)


@params.command("set", epilog=examples('narx params set "Phase current limit" 4.5 --store'))
def params_set(
    name: Annotated[str, typer.Argument(help="Name or number.", autocompletion=names)],
    value: Annotated[Any, typer.Argument(help="In the parameter's unit.", parser=number, metavar="VALUE")],
    store: Annotated[bool, typer.Option("--store", help="Keep it over a restart.")] = False,
) -> None:
    """Writes a parameter; with --store the drive keeps it."""
    with connected() as drive:
        drive.parameters[key(name)] = value
        if store:
            drive.parameters.store()


@params.command("list", epilog=examples("narx params list resistance", "narx params list --json"))
def params_list(
    text: Annotated[str, typer.Argument(help="Part of a name, category or description.")] = "",
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Lists all parameters; needs no drive."""
    folded = text.casefold()
    rows = [
        row
        for row in narx.Parameters.rows.values()
        if folded in f"{row.name} {row.category} {row.description}".casefold()
    ]
    if as_json:
        print(json.dumps([asdict(row) for row in rows]))
        return
    table = Table("number", "name", "unit", "range", "factory", "access")
    for row in rows:
        table.add_row(
            str(row.number), row.name, row.unit, f"{row.min:g} to {row.max:g}", f"{row.factory:g}", row.access
        )
    out.print(table)


@params.command("dump", epilog=examples("narx params dump drive.json", "narx params dump | jq"))
def params_dump(path: Annotated[Path | None, typer.Argument(help="JSON file; else it is printed.")] = None) -> None:
    """Reads everything that configures the drive."""
    with connected() as drive:
        if path is not None:
            drive.parameters.save(path)
            return
        print(json.dumps(drive.parameters.to_dict(), indent=2, ensure_ascii=False))


@params.command("load", epilog=examples("narx params load drive.json --store"))
def params_load(path: Path, store: Annotated[bool, typer.Option("--store")] = False) -> None:
    """Writes the parameters that differ from a file of `dump`; all values are checked first."""
    with connected() as drive:
        for name in drive.parameters.load_file(path):
            out.print(name, highlight=False)
        if store:
            drive.parameters.store()


@params.command("diff", epilog=examples("narx params diff drive.json || echo not the same"))
def params_diff(path: Path, as_json: Annotated[bool, JSON] = False) -> None:
    """Compares the drive with a file of `dump`; exit code 1 when they differ."""
    with connected() as drive:
        found = drive.parameters.diff(read_file(path))
    if as_json:
        print(json.dumps(found))
    else:
        for name, (there, here) in found.items():
            out.print(f"{name}: {there:g} in the file, {here:g} on the drive", highlight=False)
    raise typer.Exit(1 if found else 0)


def key(name: str) -> str | int:
    """Returns a parameter's name, or its number."""
    return int(name) if name.isascii() and name.isdecimal() else name
