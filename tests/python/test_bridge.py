"""The bridge from a CAN bus to a WebSocket."""

import json
import re
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import can
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

import narx
from narx import bridge as module
from narx.bridge import decode, encode

FRAMES = [
    (can.Message(arbitration_id=0x123, is_extended_id=False, data=b"\1\2"), "23010000 02 0102"),
    (can.Message(arbitration_id=0x1ABCDEF, is_extended_id=True, data=bytes(8)), "efcdab81 08 0000000000000000"),
    (can.Message(arbitration_id=0x7FF, is_extended_id=False, is_remote_frame=True, dlc=3), "ff070040 03"),
    (can.Message(arbitration_id=0, is_extended_id=True, data=b""), "00000080 00"),
]


@pytest.mark.parametrize(("frame", "text"), FRAMES)
def test_a_frame_is_a_message(frame: can.Message, text: str) -> None:
    data = bytes.fromhex(text)
    assert encode(frame) == data
    assert decode(data).equals(frame, timestamp_delta=None, check_channel=False, check_direction=False)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "0 bytes: must be 5 or more"),
        ("00080000 00", "identifier 0x800: must be 0x7ff or less"),
        ("000000a0 00", "identifier 0x20000000: must be 0x1fffffff or less"),
        ("23010000 09 000000000000000000", "length 9: must be 8 or less"),
        ("23010000 02 01", "1 data bytes: must be 2"),
        ("23010040 02 0102", "2 data bytes: must be 0"),
    ],
)
def test_a_message_that_is_no_frame(text: str, message: str) -> None:
    with pytest.raises(narx.ParameterError, match=message):
        decode(bytes.fromhex(text))


@pytest.fixture
def bus() -> Iterator[can.BusABC]:
    with can.Bus(interface="virtual", channel="bridge") as bus:
        yield bus


@pytest.fixture
def node() -> Iterator[can.BusABC]:
    """Another node on the bus."""
    with can.Bus(interface="virtual", channel="bridge") as bus:
        yield bus


def error(client: ClientConnection) -> str:
    found = client.recv(10)
    assert isinstance(found, str) and list(told := json.loads(found)) == ["error"]
    return str(told["error"])


def until(done: Callable[[], object]) -> None:
    """Waits until something is so."""
    for _ in range(1000):
        if done():
            return
        time.sleep(0.01)
    pytest.fail("it did not become so")


def test_frames_go_both_ways_and_to_other_clients(bus: can.BusABC, node: can.BusABC) -> None:
    with narx.Bridge(bus, port=0) as bridge, connect(bridge.url) as first, connect(bridge.url) as second:
        until(lambda: bridge.clients == 2)
        assert repr(bridge) == f"<narx.Bridge at ws://127.0.0.1:{bridge.port}: 2 clients>"
        for frame, text in FRAMES:
            node.send(frame)
            assert first.recv(10) == second.recv(10) == bytes.fromhex(text)
            first.send(bytes.fromhex(text))
            received = node.recv(10)
            assert received is not None and received.equals(frame, timestamp_delta=None, check_channel=False, check_direction=False)
            # The other client sees it, the sender does not.
            assert second.recv(10) == bytes.fromhex(text)
        with pytest.raises(TimeoutError):
            first.recv(0.05)
    assert repr(bridge).endswith("closed>")
    bridge.close()
    # The bus is still open.
    node.send(FRAMES[0][0])
    assert bus.recv(10) is not None


def test_what_is_refused_is_told_and_the_next_frame_is_taken(bus: can.BusABC, node: can.BusABC) -> None:
    with narx.Bridge(bus, port=0) as bridge, connect(bridge.url) as client:
        client.send("hello")
        assert error(client) == "a text message: must be binary, one frame"
        client.send(b"\1\2")
        assert error(client).startswith("2 bytes: must be 5 or more")
        client.send(bytes.fromhex("23010000020102"))
        assert node.recv(10) is not None
        client.send(bytes(65))
        with pytest.raises(ConnectionClosed) as caught:
            client.recv(10)
        assert caught.value.rcvd is not None and caught.value.rcvd.code == 1009


@pytest.mark.parametrize("query", ["", "?token=", "?token=wrong", "?other=secret"])
def test_a_token_is_needed(bus: can.BusABC, node: can.BusABC, query: str) -> None:
    with narx.Bridge(bus, port=0, token="s/ecret&") as bridge:
        assert bridge.url.endswith("/?token=s%2Fecret%26") and bridge.token == "s/ecret&"
        with connect(f"ws://127.0.0.1:{bridge.port}/{query}") as client:
            with suppress(ConnectionClosed):
                client.send(bytes.fromhex("23010000020102"))
            assert error(client) == "token: is not the one that `narx serve` prints"
            with pytest.raises(ConnectionClosed) as caught:
                client.recv(10)
            assert caught.value.rcvd is not None and caught.value.rcvd.code == 1008
        assert node.recv(0.05) is None and bridge.clients == 0
        with connect(bridge.url) as client:
            until(lambda: bridge.clients == 1)


def test_tokens_are_random_and_listening_is_local(bus: can.BusABC) -> None:
    with narx.Bridge(bus, port=0) as first, narx.Bridge(bus, port=0) as second:
        assert first.token != second.token and len(first.token) >= 16
        own = socket.gethostbyname(socket.gethostname())
        if not own.startswith("127."):
            with pytest.raises(OSError):
                socket.create_connection((own, first.port), 1).close()
        with pytest.raises(narx.BusError, match=f"host 127.0.0.1, port {first.port}: .*in use"):
            narx.Bridge(bus, port=first.port)
    for arguments, message in [({"port": 65536}, "port 65536: must be a whole number from 0 to 65535"), ({"token": ""}, "token '': must be a text"), ({"host": 5}, "host 5: must be a text")]:
        with pytest.raises(narx.ParameterError, match=message):
            narx.Bridge(bus, **arguments)  # type: ignore[arg-type]
    with pytest.raises(narx.ParameterError, match="bus 5: must be a bus of python-can"):
        narx.Bridge(5)  # type: ignore[arg-type]
    with pytest.raises(narx.BusError, match="host no.such.host.invalid, port 0: "):
        narx.Bridge(bus, "no.such.host.invalid", 0)


def test_a_client_that_does_not_read_is_disconnected(bus: can.BusABC, node: can.BusABC, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "QUEUE", 50)
    with narx.Bridge(bus, port=0) as bridge, connect(bridge.url) as reads, socket.socket() as idle:
        idle.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        idle.connect(("127.0.0.1", bridge.port))
        idle.sendall(f"GET /?token={bridge.token} HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        until(lambda: bridge.clients == 2)
        for count in range(50_000):
            node.send(can.Message(arbitration_id=0x123, is_extended_id=False, data=struct.pack("<Q", count)))
            assert reads.recv(10) == bytes.fromhex("2301000008") + struct.pack("<Q", count)
            if bridge.clients == 1:
                break
        assert bridge.clients == 1


class Broken(can.BusABC):
    """An adapter that is pulled out."""

    def __init__(self) -> None:
        super().__init__("broken")

    def _recv_internal(self, timeout: float | None) -> Any:
        raise can.CanOperationError("the adapter is gone")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise can.CanOperationError("the adapter is gone")


def test_an_adapter_that_fails_ends_it() -> None:
    with narx.Bridge(Broken(), port=0) as bridge, pytest.raises(narx.BusError, match="the adapter is gone"):
        bridge.wait()


def test_the_command_serves_a_virtual_drive() -> None:
    command = [sys.executable, "-c", "import narx.cli; narx.cli.main()", "-i", "narx", "-c", "served", "-o", "motor=ec45-flat-50w-18v", "-o", "supply_voltage=18", "-o", "mode=hall", "serve", "--port", "0", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        told = json.loads(program.stdout.readline())
        assert re.fullmatch(r"ws://127\.0\.0\.1:\d+/\?token=.+", told["url"]) and str(told["port"]) in told["url"] and told["token"] in told["url"]
        seen: dict[str, narx.Message] = {}
        with connect(told["url"]) as client:
            until(lambda: see(client, seen) and "STATUS_WORD" in seen)
        program.terminate()
        assert program.wait(10) == 0


def see(client: ClientConnection, seen: dict[str, narx.Message]) -> bool:
    """Receives a frame and keeps its message."""
    data = client.recv(10)
    assert isinstance(data, bytes)
    message = narx.decode(decode(data))
    if isinstance(message, narx.Message):
        seen[message.name] = message
    return True
