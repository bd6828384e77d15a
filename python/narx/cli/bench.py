"""A virtual drive for other programs."""

from __future__ import annotations

import json
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

import narx
from narx import _core, given
from narx.cli.app import JSON, MODE, MOTOR, app, examples


@app.command(
    epilog=examples(
        "narx bench --mode hall",
        "narx bench --motor bly172s-24v --supply 24 --load 0.05 --tx-drivers 2,5:dual --verbose",
        "narx bench --tcp 0 --pty --link /tmp/narx --json",
    )
)
def bench(
    motor: Annotated[str, MOTOR] = "ec45-flat-50w-18v",
    mode: Annotated[str, MODE] = "sensorless",
    supply: Annotated[float | None, typer.Option(help="Supply voltage, V; else the motor's nominal one.")] = None,
    load: Annotated[float, typer.Option(help="Load torque on the shaft, N m.")] = 0.0,
    pwm_rate: Annotated[int, typer.Option(help="PWM frequency, Hz, 8000 to 50 000.")] = 20_000,
    seed: Annotated[int, typer.Option(help="Seed of all noise.")] = 1,
    tx_drivers: Annotated[
        str | None,
        typer.Option(
            help="Node-ids of TX-Drivers on the same bus, with commas between, :dual behind those with two channels."
        ),
    ] = None,
    tcp: Annotated[
        str, typer.Option(help="PORT that only this machine reaches, or HOST:PORT; port 0 takes a free one.")
    ] = "2000",
    pty: Annotated[bool, typer.Option("--pty", help="Offer a pseudo-terminal, too.")] = False,
    link: Annotated[Path | None, typer.Option(help="A symbolic link to the pseudo-terminal.")] = None,
    speed: Annotated[float, typer.Option(help="Simulated time over real time; 0 runs as fast as possible.")] = 1.0,
    seconds: Annotated[float | None, typer.Option(help="End after this simulated time, s; without it at Ctrl-C.")] = None,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Print the drive's state every second, and clients that connect or disconnect.")
    ] = False,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Serves a virtual drive in real time: slcan over TCP (up to 32 clients) and a pseudo-terminal.

    With --json the first line lists the addresses.
    """
    if link is not None and not pty:
        raise typer.BadParameter(f"{link}: needs --pty", param_hint="--link")
    # A shell ignores SIGINT in background commands, and both signals must end the program so that it removes
    # its link.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    with suppress(KeyboardInterrupt):
        preset = given.motor(motor)
        # Limited to the supply voltages of the drive (Table 1).
        volts = min(max(preset.nominal_voltage or 24.0, 18.0), 60.0) if supply is None else supply
        served = _core.Server(
            preset,
            volts,
            narx.Load(constant=load),
            mode,
            seed=seed,
            pwm_rate=pwm_rate,
            tx_drivers=tx_drivers,
            speed=speed,
            seconds=seconds,
        )
        doors = {"tcp": served.listen(tcp)} | ({"pty": served.open_terminal(link)} if pty else {})
        if as_json:
            print(json.dumps({**doors, "notes": served.notes}), flush=True)
        else:
            lines = [f"{motor}: {mode}, {volts:g} V supply, {load:g} N m load, {pwm_rate / 1000:g} kHz PWM", *(f"  {note}" for note in served.notes)]
            lines += [f"{door}  {served.call(channel)}" for door, channel in doors.items()]
            # `print` does not wrap lines, so that a program can search the output line by line.
            print(*lines, sep="\n", flush=True)
        while served.step():
            news = served.take_news()
            if verbose and news:
                print(*news, sep="\n", file=sys.stderr if as_json else sys.stdout, flush=True)
