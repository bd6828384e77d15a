"""Parts that the commands share: the program, its two outputs, and the connection to the drive."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Annotated, Any

import typer
from rich.console import Console
from typer.core import TyperGroup

import narx

HELP = "The command `narx`: what the package does, from a shell."
EXIT_CODES = "Exit codes: 0 done; 1 done, with a difference or a failure in what was looked at; 2 an error, told in one line; 130 Ctrl-C."

class Group(TyperGroup):
    """The commands. One whose reader has closed the pipe (`| head`) ends well."""

    def invoke(self, ctx: Any) -> Any:
        """Runs a command."""
        try:
            try:
                return super().invoke(ctx)
            finally:
                sys.stdout.flush()
        except BrokenPipeError:
            # The interpreter flushes its buffer again when it ends, where nobody reads it either.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(0) from None


app = typer.Typer(
    cls=Group, no_args_is_help=True, rich_markup_mode="markdown", pretty_exceptions_enable=False, help=HELP, epilog=EXIT_CODES
)
out, err = Console(), Console(stderr=True)

JSON = typer.Option("--json", help="Print JSON for other programs.")


def examples(*lines: str) -> str:
    """Formats command lines for the end of a help text."""
    return "\n\n".join(["**Examples**", *(f"`{line}`" for line in lines)])


def motors(incomplete: str) -> list[str]:
    """Returns presets, for completion."""
    return [name for name in narx.Motor.presets() if name.startswith(incomplete)]


MOTOR = typer.Option("--motor", help="A preset, or a file of figures (.toml).", autocompletion=motors)
MODE = typer.Option(
    "--mode", help="sensorless, hall or open-loop.", autocompletion=lambda: ["sensorless", "hall", "open-loop"]
)
SUPPLY = typer.Option("--supply", help="Supply voltage, V.")


class Connection:
    """Connection to the drive of all commands: options that stand before the command."""

    interface = "socketcan"
    channel = "can0"
    bitrate = 500_000
    slave = 170
    monitor = 85
    silent = False
    options: dict[str, Any] = {}  # noqa: RUF012


def print_version(wanted: bool) -> None:
    """Prints the version and ends."""
    if wanted:
        print(f"narx {narx.__version__}")
        raise typer.Exit


@app.callback()
def connection(
    interface: Annotated[str, typer.Option("-i", "--interface", help="Interface of python-can.")] = "socketcan",
    channel: Annotated[str, typer.Option("-c", "--channel", help="Its channel.")] = "can0",
    bitrate: Annotated[int, typer.Option(help="Bit rate of the bus.")] = 500_000,
    slave: Annotated[int, typer.Option(help="Address of the drive.")] = 170,
    monitor: Annotated[int, typer.Option(help="Address of this master.")] = 85,
    silent: Annotated[bool, typer.Option("--silent", help="Transmit nothing.")] = False,
    option: Annotated[
        list[str] | None, typer.Option("-o", "--option", help="Further NAME=VALUE of the interface.")
    ] = None,
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=print_version, help="Print the version and end.")
    ] = False,
) -> None:
    """Operates narx drives, on any adapter that python-can knows.

    The options of this help stand before the command. The virtual drive needs no adapter: `narx -i narx -c
    demo -o motor=ec45-flat-50w-18v -o supply_voltage=18 -o mode=hall monitor`; `narx bench` serves one to
    other programs.
    """
    Connection.interface, Connection.channel, Connection.bitrate = interface, channel, bitrate
    Connection.slave, Connection.monitor, Connection.silent = slave, monitor, silent
    Connection.options = dict(parsed(text) for text in option or [])


def parsed(text: str) -> tuple[str, Any]:
    """Parses NAME=VALUE; the value becomes a number if it looks like one."""
    name, found, value = text.partition("=")
    if not found:
        raise typer.BadParameter(f"{text}: must be NAME=VALUE", param_hint="--option")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value


@contextmanager
def connected(bootloader: bool = False) -> Iterator[narx.Drive]:
    """Connects to the drive. At the end it does not stop the motor, which another program may have
    started. bootloader: the drive may be one whose bootloader receives, which does not answer here."""
    c = Connection
    connect = partial(
        narx.connect, c.interface, c.channel, c.slave, c.monitor, c.bitrate, silent=c.silent, read_parameters=False, **c.options
    )
    silence: narx.NoAnswerError | None = None
    try:
        drive = connect()
    except narx.NoAnswerError as error:
        if not bootloader:
            raise
        silence, drive = error, connect(timeout=0)
    try:
        yield drive
    except narx.NoAnswerError:
        if silence is not None and drive._master.last_received is None:
            # Not even a bootloader is there.
            raise silence from None
        raise
    finally:
        drive.close(stop=False)
