"""The bus as WebSocket for the web page."""

from __future__ import annotations

import json
import signal
from contextlib import suppress
from typing import Annotated

import typer

import narx
from narx.bridge import PORT
from narx.cli.app import JSON, Connection, app, examples
from narx.drive import let_go, opened


@app.command(
    epilog=examples(
        "narx -i socketcan -c can0 serve",
        "narx -i narx -c demo -o motor=ec45-flat-50w-18v -o supply_voltage=18 -o mode=hall serve",
        "narx -i kvaser -c 0 serve --host 192.168.1.5 --token secret --json",
    )
)
def serve(
    host: Annotated[str, typer.Option(help="Address that it listens at; 127.0.0.1 is reached from this machine only.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port; 0 takes a free one.")] = PORT,
    token: Annotated[str | None, typer.Option(help="Password of the clients; without it a random one.")] = None,
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Serves the bus as WebSocket, to the web page or any other client, until Ctrl-C.

    Whoever has the token commands the drive. A drive stops by itself when its master falls silent.
    """
    # A shell ignores SIGINT in background commands.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    c = Connection
    bus = opened(c.interface, c.channel, c.bitrate, c.options)
    try:
        with suppress(KeyboardInterrupt), narx.Bridge(bus, host, port, token) as bridge:
            if as_json:
                print(json.dumps({"url": bridge.url, "port": bridge.port, "token": bridge.token}), flush=True)
            else:
                print(f"{c.interface} {c.channel} at {bridge.url}", flush=True)
            bridge.wait()
    finally:
        let_go(bus)
