"""A CAN bus as WebSocket: any adapter of python-can for a web page, on this machine or another."""

from __future__ import annotations

import asyncio
import hmac
import json
import secrets
import socket
import struct
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self
from urllib.parse import parse_qs, quote, urlsplit

from narx import _core
from narx.errors import BusError, ParameterError
from narx.extras import need

if TYPE_CHECKING:
    import can

EXTENDED, REMOTE = 1 << 31, 1 << 30
HEAD = struct.Struct("<IB")
QUEUE = 10_000
"""Largest number of frames that wait for a client; one that reads no faster is disconnected."""
SEND_BUFFER = 65_536
"""Bytes that the system holds for a client."""
MESSAGE_MAX = 64
"""Longest message that is received, bytes."""
POLICY, TOO_SLOW = 1008, 1013
"""Close codes of RFC 6455: a wrong token; a client that does not read."""
CLOSE = 2.0
"""Longest wait for a client's end of the connection, s."""
PORT = 8765


def encode(message: can.Message) -> bytes:
    """Converts a frame to a message of the WebSocket: identifier (u32, little-endian; bit 31 = extended, bit
    30 = remote), number of data bytes (u8), data."""
    number = message.arbitration_id | EXTENDED * message.is_extended_id | REMOTE * message.is_remote_frame
    return HEAD.pack(number, message.dlc) + (b"" if message.is_remote_frame else bytes(message.data))


def decode(data: bytes) -> can.Message:
    """Converts a message of the WebSocket to a frame. Raises ParameterError for one that is none."""
    if len(data) < HEAD.size:
        raise ParameterError(f"{len(data)} bytes: must be {HEAD.size} or more, identifier (4), length (1) and data")
    head, length = HEAD.unpack_from(data)
    extended, remote, number = bool(head & EXTENDED), bool(head & REMOTE), head & (REMOTE - 1)
    most = 0x1FFF_FFFF if extended else 0x7FF
    if number > most:
        raise ParameterError(f"identifier {number:#x}: must be {most:#x} or less")
    if length > 8:
        raise ParameterError(f"length {length}: must be 8 or less")
    carried = 0 if remote else length
    if len(data) - HEAD.size != carried:
        raise ParameterError(f"{len(data) - HEAD.size} data bytes: must be {carried}, as its length says")
    message: can.Message = need("can").Message(
        arbitration_id=number, is_extended_id=extended, is_remote_frame=remote, dlc=length, data=data[HEAD.size :] or None
    )
    return message


class Bridge:
    """A bus of python-can as WebSocket, for the web page or any other client, until `close`.

    bus: a bus; `close` leaves it open. host: address that it listens at; 127.0.0.1 is reached from this
    machine only. port: 0 takes a free one. token: password that each client gives as `?token=`; without it
    a random one is made. Raises BusError if it cannot listen, ParameterError for a port that is none,
    MissingError without websockets.

    A binary message is one frame: identifier (u32, little-endian; bit 31 = extended, bit 30 = remote), number
    of data bytes (u8), data; a remote frame has none. A client receives the frames of the bus and of the other
    clients. Whatever is refused is answered with a text message, `{"error": "..."}`: a wrong token (then the
    connection is closed with code 1008), a message that is no frame, a frame that the bus does not take. A
    client that lets 10 000 frames wait is disconnected with code 1013.
    """

    def __init__(self, bus: can.BusABC, host: str = "127.0.0.1", port: int = PORT, token: str | None = None) -> None:
        self._can = need("can")
        self._server = need("websockets.asyncio.server")
        self._closed = need("websockets.exceptions").ConnectionClosed
        self._port = _core.whole_number("port", port, 0, 65535)
        if not isinstance(bus, self._can.BusABC):
            raise ParameterError(f"bus {bus!r}: must be a bus of python-can")
        if not isinstance(host, str):
            raise ParameterError(f"host {host!r}: must be a text")
        if token is not None and not (isinstance(token, str) and token):
            raise ParameterError(f"token {token!r}: must be a text, or None for a random one")
        self._bus, self._host = bus, host
        self._token = secrets.token_urlsafe(12) if token is None else token
        self._clients: dict[Any, asyncio.Queue[bytes | str]] = {}
        self._loop = asyncio.new_event_loop()
        self._over: asyncio.Event
        self._error: Exception | None = None
        begun: Future[int] = Future()
        self._thread = threading.Thread(target=self._run, args=(begun,), name="narx bridge", daemon=True)
        self._thread.start()
        try:
            self._port = begun.result()
        except (OSError, UnicodeError) as error:
            self._thread.join()
            raise BusError(f"host {host}, port {port}: {getattr(error, 'strerror', None) or error}") from None

    @property
    def port(self) -> int:
        """The port that it listens at."""
        return self._port

    @property
    def token(self) -> str:
        """The token that clients give."""
        return self._token

    @property
    def url(self) -> str:
        """Address for a client, with the token."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"ws://{host}:{self._port}/?token={quote(self._token, safe='')}"

    @property
    def clients(self) -> int:
        """Number of clients that are connected."""
        return len(self._clients)

    def wait(self, seconds: float | None = None) -> None:
        """Waits for `seconds`, s, or for ever. Raises BusError when the adapter does not work any more."""
        # In steps, so that Ctrl-C arrives on every system.
        left = float("inf") if seconds is None else _core.number("seconds", seconds, "s", 0)
        while self._thread.is_alive() and left > 0:
            self._thread.join(min(left, 0.2))
            left -= 0.2
        if self._error is not None:
            raise BusError(f"the bus does not work any more: {self._error}") from self._error

    def close(self) -> None:
        """Disconnects the clients and stops listening. A second call does nothing."""
        if self._thread.is_alive():
            with suppress(RuntimeError):  # The loop has just ended.
                self._loop.call_soon_threadsafe(self._over.set)
            self._thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        state = f"{self.clients} clients" if self._thread.is_alive() else "closed"
        return f"<narx.Bridge at ws://{self._host}:{self._port}: {state}>"

    def _run(self, begun: Future[int]) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            try:
                runner.run(self._serve(begun))
            except Exception as error:
                if begun.done():
                    self._error = self._error or error
                else:
                    begun.set_exception(error)

    async def _serve(self, begun: Future[int]) -> None:
        from narx._listener import Listener

        self._over = asyncio.Event()
        listener = Listener(self._from_thread(self._received), self._from_thread(self._failed))
        async with self._server.serve(self._talk, self._host, self._port, max_size=MESSAGE_MAX, compression=None, close_timeout=CLOSE) as server:
            for listening in server.sockets:
                # Connections inherit it. A larger buffer would only make the frames of a slow client older.
                listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
            known = self._can.Notifier.find_instances(self._bus)
            if known:
                notifier = known[0]
                notifier.add_listener(listener)
            else:
                # With its listener, because an error before one is there ends it in silence.
                notifier = self._can.Notifier(self._bus, [listener], timeout=0.1)
            begun.set_result(server.sockets[0].getsockname()[1])
            try:
                await self._over.wait()
            finally:
                # Stopping waits for the notifier's thread, which may wait for this loop.
                notifier.remove_listener(listener)
                if not known:
                    await asyncio.to_thread(notifier.stop)

    def _from_thread(self, act: Callable[[Any], None]) -> Callable[[Any], None]:
        """Returns a function for the notifier's thread that makes the loop call `act`."""

        def call(given: Any) -> None:
            with suppress(RuntimeError):  # The loop has ended.
                self._loop.call_soon_threadsafe(act, given)

        return call

    def _received(self, message: can.Message) -> None:
        if not (message.is_error_frame or message.is_fd):
            self._pass_on(encode(message))

    def _failed(self, error: Exception) -> None:
        self._error = self._error or error
        self._over.set()

    def _pass_on(self, data: bytes, sender: Any = None) -> None:
        for client, queue in list(self._clients.items()):
            if client is sender:
                continue
            try:
                queue.put_nowait(data)
            except asyncio.QueueFull:
                self._clients.pop(client)
                self._close(client, TOO_SLOW, f"{QUEUE} frames wait: this client does not read")

    def _close(self, client: Any, code: int, reason: str) -> None:
        """Closes a connection without waiting for it."""
        task = asyncio.ensure_future(client.close(code, reason))
        task.add_done_callback(lambda done: done.cancelled() or done.exception())

    async def _talk(self, client: Any) -> None:
        """Serves a client."""
        given = parse_qs(urlsplit(client.request.path).query).get("token", [""])[0]
        if not hmac.compare_digest(given.encode(), self._token.encode()):
            await client.send(refusal("token: is not the one that `narx serve` prints"))
            await client.close(POLICY, "wrong token")
            return
        queue: asyncio.Queue[bytes | str] = asyncio.Queue(QUEUE)
        self._clients[client] = queue
        writer = asyncio.create_task(self._write(client, queue))
        try:
            async for data in client:
                try:
                    await self._take(client, data)
                except (ParameterError, self._can.CanError, OSError) as error:
                    await client.send(refusal(str(error)))
        except self._closed:
            pass
        finally:
            self._clients.pop(client, None)
            writer.cancel()

    async def _write(self, client: Any, queue: asyncio.Queue[bytes | str]) -> None:
        """Sends what waits for a client, until it disconnects."""
        with suppress(self._closed):
            while True:
                await client.send(await queue.get())

    async def _take(self, client: Any, data: bytes | str) -> None:
        """Sends a client's frame."""
        if isinstance(data, str):
            raise ParameterError("a text message: must be binary, one frame")
        frame = decode(data)
        # An adapter may block until its queue has room.
        await asyncio.to_thread(self._bus.send, frame)
        self._pass_on(data, client)


def refusal(reason: str) -> str:
    """Returns the message for a refusal."""
    return json.dumps({"error": reason})
