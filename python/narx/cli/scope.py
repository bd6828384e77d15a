"""The virtual scope."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

import narx
from narx.cli.app import JSON, app, connected, examples, out


@app.command(
    epilog=examples(
        'narx scope Duty "HV Voltage" --trigger "HV Voltage > 20" --before 100 --to capture.csv',
        "narx scope Duty --trigger fault",
        "narx scope --trigger fault --before 300 --samples 400 --to fault.narxrec",
    )
)
def scope(
    signals: Annotated[list[str] | None, typer.Argument(help="Names of scope signals.")] = None,
    to: Annotated[
        Path, typer.Option(help=".csv, .parquet or .xlsx; .narxrec records the inputs of every tick instead, for `narx replay`.")
    ] = Path("scope.csv"),
    samples: Annotated[int, typer.Option(help="Of each signal; ticks of a .narxrec.")] = 256,
    prescaler: Annotated[int, typer.Option(help="Control ticks from one sample to the next.")] = 1,
    before: Annotated[int, typer.Option(help="Samples from before the trigger.")] = 0,
    trigger: Annotated[
        str, typer.Option(help='now, fault, state, or like "HV Voltage > 20" (<, rising, falling)')
    ] = "now",
    timeout: Annotated[float, typer.Option(help="How long to wait for the trigger, s.")] = 10.0,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Captures signals of the control tick, or its inputs."""
    with connected() as drive:
        chosen = trigger_of(trigger)
        if to.suffix.lower() == ".narxrec":
            record = drive.scope.record(samples, chosen, before, timeout)
            record.save(to)
            rows = narx.replay(record.recording).ticks
        else:
            trace = drive.scope.capture(signals or [], samples, prescaler, chosen, before, timeout)
            trace.save(to)
            rows = len(trace)
    if as_json:
        print(json.dumps({"samples": rows, "file": str(to)}))
        return
    out.print(f"{rows} samples in {to}", highlight=False)


def trigger_of(text: str) -> narx.Trigger | None:
    """Returns the trigger that a text names; `None` triggers at once."""
    simple = {"now": None, "fault": narx.Trigger.fault(), "state": narx.Trigger.state_change()}
    if text in simple:
        return simple[text]
    for word, make in (
        (" > ", narx.Trigger.above),
        (" < ", narx.Trigger.below),
        (" rising ", narx.Trigger.rising),
        (" falling ", narx.Trigger.falling),
    ):
        signal, found, value = text.partition(word)
        if found:
            try:
                return make(signal, float(value if value.isascii() else ""))
            except ValueError:
                break
    raise typer.BadParameter(f'"{text}": must be now, fault, state, or like "HV Voltage > 20"', param_hint="--trigger")
