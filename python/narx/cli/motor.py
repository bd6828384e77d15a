"""Commands for the motor. Each waits for the drive's result."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Annotated, Literal, cast

import typer

import narx
from narx import given
from narx.cli.app import JSON, MODE, SUPPLY, app, connected, err, examples, motors, out
from narx.drive import name_of

STOP_MAX = 10.0
"""Longest wait for Standby, s."""


@app.command(epilog=examples("narx -i socketcan -c can0 start 2000", "narx start 1500 --seconds 5 --json"))
def start(
    rpm: Annotated[float, typer.Argument(help="Speed, rpm; for reverse, --reverse.")],
    reverse: Annotated[bool, typer.Option("--reverse", help="Turn in reverse.")] = False,
    seconds: Annotated[float | None, typer.Option(help="Stops after this time, s; else at Ctrl-C.")] = None,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Starts the motor, runs it, and stops it at the end.

    A drive stops by itself when its master falls silent, so this command stays until Ctrl-C.
    """
    timeout = math.inf if seconds is None else given.seconds(seconds)
    with connected() as drive:
        drive.start(-rpm if reverse else rpm)
        try:
            tell(drive, as_json)
            with suppress(KeyboardInterrupt):
                drive.wait_for(lambda: False, timeout)
        finally:
            rest(drive)


@app.command(epilog=examples("narx -i socketcan -c can0 stop", "narx stop --json"))
def stop(as_json: Annotated[bool, JSON] = False) -> None:
    """Stops the motor and acknowledges a fault; ends when the drive is in Standby."""
    with connected() as drive:
        rest(drive)
        tell(drive, as_json)


@app.command("calibrate-hall", epilog=examples("narx calibrate-hall", "narx -i socketcan -c can0 calibrate-hall --yes"))
def calibrate_hall(
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Calibrates the hall sensors: the motor turns one electrical revolution each way."""
    if not yes:
        typer.confirm("The motor will turn. Calibrate?", abort=True)
    with connected() as drive:
        drive.calibrate_hall(run=True)
        tell(drive, as_json)


@app.command(epilog=examples("narx identify 8", "narx -i socketcan -c can0 identify 4 --current 3 --to my-motor.toml --yes"))
def identify(
    pole_pairs: Annotated[int | None, typer.Argument(help="Pole pairs of the motor. Without them you count turns.", show_default=False)] = None,
    current: Annotated[float | None, typer.Option(help="Largest phase current, A.")] = None,
    bridge: Annotated[float | None, typer.Option(help="Resistance of two switches of the drive, ohm.")] = None,
    hold: Annotated[bool, typer.Option("--hold", help="Do not turn: resistance and inductance alone.")] = False,
    halls: Annotated[bool, typer.Option("--halls", help="Calibrate the hall sensors, too.")] = False,
    to: Annotated[Path | None, typer.Option("--to", help="File for the figures (.toml), for `narx commission` and `--motor`.")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Measures the motor: resistance, inductance, torque constant, inertia and friction. Its shaft must be free."""
    if not yes:
        typer.confirm("The motor will be held." if hold else "The motor will turn. Is its shaft free?", abort=True)
    with connected() as drive:
        found = drive.identify(pole_pairs, current, bridge, not hold, halls, None if as_json else lambda stage: err.print(f"{stage} ..."), marks())
        if to is not None:
            found.save(to)
        print(json.dumps(asdict(found)) if as_json else found, flush=True)


def marks() -> Callable[[], bool]:
    """Returns the function that says whether Enter was pressed since the last time; the first call asks for it."""
    pressed: Queue[bytes] = Queue()

    def read() -> None:
        # Past the buffer of sys.stdin, whose lock would keep the program from ending.
        while line := os.read(sys.stdin.fileno(), 1024):
            pressed.put(line)

    reader = Thread(target=read, daemon=True)

    def mark() -> bool:
        if reader.ident is None:
            err.print("The shaft turns slowly. Choose a mark on it, and press Enter each time that it passes the same place, three times.")
            reader.start()
        if pressed.empty():
            return False
        pressed.get()
        return True

    return mark


@app.command(
    epilog=examples(
        "narx -i socketcan -c can0 commission my-motor.toml --supply 24 --mode hall",
        "narx commission my-motor.toml --supply 24 --speed-min 500 --bandwidth 6",
        "narx commission bly172s-24v --supply 24 --to drive.json",
    )
)
def commission(
    motor: Annotated[str, typer.Argument(help="A preset, or a file of figures (.toml), as `narx identify --to` writes it.", autocompletion=motors)],
    supply: Annotated[float, SUPPLY],
    mode: Annotated[str, MODE] = "sensorless",
    speed_min: Annotated[
        float | None, typer.Option(help="Slowest set-point, rpm; the speed loop is as fast as it allows with 60 degrees of phase margin.")
    ] = None,
    bandwidth: Annotated[float | None, typer.Option(help="Bandwidth of the speed loop, Hz; needs --speed-min.")] = None,
    pwm_rate: Annotated[int, typer.Option(help="PWM frequency of the drive, Hz.")] = 10_000,
    to: Annotated[Path | None, typer.Option("--to", help="File for the parameters (JSON), for `narx params load`; then no drive is needed.")] = None,
    store: Annotated[bool, typer.Option("--store", help="Keep them over a restart.")] = False,
) -> None:
    """Writes the parameters of a motor into the drive."""
    if bandwidth is not None and speed_min is None:
        raise typer.BadParameter("needs --speed-min", param_hint="--bandwidth")
    if to is not None and store:
        raise typer.BadParameter("belongs to a drive, and --to needs none", param_hint="--store")
    chosen = given.motor(motor)
    computed = chosen.commission(supply, cast("Literal['sensorless', 'hall', 'open-loop']", mode), pwm_rate)
    # Addresses, calibration and the board's own limits stay as they are.
    values = {name: computed[name] for name in narx.COMMISSIONED}
    if speed_min is not None:
        loop = chosen.speed_loop(speed_min, bandwidth)
        values |= loop.parameters
        err.print(f"speed loop: {loop.bandwidth:.1f} Hz, phase margin {loop.phase_margin:.0f} degrees from {speed_min:g} rpm on")
    if to is not None:
        to.write_text(json.dumps(values, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
        return
    with connected() as drive:
        changed = drive.parameters.load(values)
        if store:
            drive.parameters.store()
    out.print(f"{len(changed)} parameters changed")


@app.command(epilog=examples("narx reboot", "narx -i socketcan -c can0 reboot --json"))
def reboot(as_json: Annotated[bool, JSON] = False) -> None:
    """Restarts a stopped drive; ends when it is ready again."""
    with connected() as drive:
        drive.reboot()
        tell(drive, as_json)


def rest(drive: narx.Drive) -> None:
    """Stops the motor and waits for Standby."""
    drive.stop()
    if not drive.wait_for(lambda: drive.state is narx.State.STANDBY, STOP_MAX):
        raise narx.NoAnswerError(f"no Standby within {STOP_MAX:g} s: the drive is in {name_of(drive.state)}")


def tell(drive: narx.Drive, as_json: bool) -> None:
    """Prints the state of the drive and its speed."""
    state, speed = name_of(drive.state), drive.measurements.speed
    if as_json:
        print(json.dumps({"state": None if drive.state is None else drive.state.name.lower(), "speed": speed}), flush=True)
        return
    out.print(f"{state}" if speed is None else f"{state}, {speed:g} rpm", highlight=False)
