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
    )
)
def scope(
    signals: Annotated[list[str], typer.Argument(help="Names of scope signals.")],
    to: Annotated[Path, typer.Option(help=".csv, .parquet or .xlsx.")] = Path("scope.csv"),
    samples: Annotated[int, typer.Option(help="Of each signal.")] = 256,
    prescaler: Annotated[int, typer.Option(help="Control ticks from one sample to the next.")] = 1,
    before: Annotated[int, typer.Option(help="Samples from before the trigger.")] = 0,
    trigger: Annotated[
        str, typer.Option(help='now, fault, state, or like "HV Voltage > 20" (<, rising, falling)')
    ] = "now",
    timeout: Annotated[float, typer.Option(help="How long to wait for the trigger, s.")] = 10.0,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Captures signals of the control tick."""
    with connected() as drive:
        chosen = trigger_of(trigger)
        trace = drive.scope.capture(signals, samples, prescaler, chosen, before, timeout)
    trace.save(to)
    if as_json:
        print(json.dumps({"samples": len(trace), "file": str(to)}))
        return
    out.print(f"{len(trace)} samples in {to}", highlight=False)


def trigger_of(text: str) -> narx.Trigger | None:
    """The trigger that a text means; `None` is now."""
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
                return make(signal, float(value))
            except ValueError:
                break
    raise typer.BadParameter(f'"{text}": must be now, fault, state, or like "HV Voltage > 20"', param_hint="--trigger")
