"""Frames of TX-Drivers agree with python-canopen and the EDS files that are committed."""

from pathlib import Path
from typing import Any

import can
import canopen
import pytest
from canopen.emcy import EmcyConsumer
from canopen.nmt import NMT_COMMANDS
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import stamped, write

import narx

DOCS = Path(__file__).parents[2] / "docs"
MM = 2**27
# By EDS: bytes of a PDO, and raw value of 1 mm in a position.
LAYOUTS = {"single": (4, MM), "single-encoder": (6, MM), "dual": (8, MM), "dual-encoder": (8, MM >> 8)}
STATES = {0: "boot-up", 4: "stopped", 5: "operational", 127: "pre-operational"}


@pytest.mark.parametrize("layout", LAYOUTS)
@given(node=st.integers(1, 127), number=st.integers(1, 3), data=st.binary(min_size=8, max_size=8))
@settings(max_examples=25, deadline=None)
def test_positions_are_those_of_the_eds(layout: str, node: int, number: int, data: bytes) -> None:
    length, millimetre = LAYOUTS[layout]
    pdo = objects(layout).tpdo[number]
    pdo.data = bytearray(data[:length])
    expected = {variable.name: variable.raw if variable.name == "Encoder" else variable.raw / millimetre for variable in pdo.map}
    frame = can.Message(arbitration_id=0x80 + 0x100 * number + node, data=data[:length], is_extended_id=False)
    decoded = narx.decode(frame, encoder=layout == "dual-encoder")
    assert isinstance(decoded, narx.NodeMessage)
    assert (decoded.name, decoded.node, decoded.from_node) == (f"PDO{number}", node, True)
    assert decoded.values == {"Node": node, **expected}
    assert decoded.units.get("Position 1") == "mm"


nodes: dict[str, Any] = {}


def objects(layout: str) -> Any:
    """Returns a node of python-canopen that knows its PDOs."""
    if layout not in nodes:
        nodes[layout] = canopen.Network().add_node(1, str(DOCS / f"eddycan-{layout}.eds"))
        nodes[layout].tpdo.read(from_od=True)
    return nodes[layout]


class Wire(canopen.Network):
    """Stores the frames that python-canopen sends."""

    def __init__(self) -> None:
        super().__init__()
        self.frames: list[can.Message] = []

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        self.frames.append(can.Message(arbitration_id=can_id, data=bytes(data), is_extended_id=False, is_remote_frame=remote))


@pytest.mark.parametrize("code", NMT_COMMANDS.values())
def test_commands_are_those_that_python_canopen_sends(code: int) -> None:
    wire = Wire()
    node = wire.add_node(5, str(DOCS / "eddycan-single.eds"))
    node.nmt.send_command(code)
    wire.sync.transmit()
    command, sync = map(narx.decode, wire.frames)
    known = {1: "start", 2: "stop", 128: "pre-operational", 129: "reset"}
    if code in known:
        assert isinstance(command, narx.NodeMessage) and command.values == {"Node": 5, "Command": known[code]}
    else:
        # Table 11 of the specification has no command that resets the communication alone.
        assert command is None
    assert isinstance(sync, narx.NodeMessage) and (sync.name, sync.node, sync.from_node) == ("SYNC", None, False)


@given(index=st.integers(0, 0xFFFF), subindex=st.integers(0, 255), value=st.integers(0, 0xFFFFFFFF), size=st.integers(1, 4))
@settings(max_examples=50, deadline=None)
def test_entries_are_written_as_python_canopen_writes_them(index: int, subindex: int, value: int, size: int) -> None:
    wire = Wire()
    node = wire.add_node(9, str(DOCS / "eddycan-single.eds"))
    node.sdo.RESPONSE_TIMEOUT, node.sdo.MAX_RETRIES = 0.0, 1
    data = (value & (1 << 8 * size) - 1).to_bytes(size, "little")
    with pytest.raises(canopen.SdoCommunicationError):
        node.sdo.download(index, subindex, data)
    request = narx.decode(wire.frames[0])
    assert isinstance(request, narx.NodeMessage) and not request.from_node
    names = {"Entry": request["Entry"], "Action": "write", "Value": int.from_bytes(data, "little")}
    assert request.values == {"Node": 9, "Index": index, "Subindex": subindex, **names}


def test_names_of_entries_are_those_of_the_eds() -> None:
    for index, entry in canopen.import_od(str(DOCS / "eddycan-dual-encoder.eds"), node_id=1).items():
        if not 0x2000 <= index < 0x2200:
            continue
        request = narx.decode(0x601, bytes([0x40]) + index.to_bytes(2, "little") + bytes([1, 0, 0, 0, 0]))
        assert request is not None and request["Entry"] == entry.name and request["Action"] == "read"


def test_errors_and_states_are_those_of_python_canopen() -> None:
    told = EmcyConsumer()  # type: ignore[no-untyped-call]
    data = bytes([0x20, 0x81, 0x11, 1, 2, 3, 4, 5])
    told.on_emcy(0x82, data, 1.0)  # type: ignore[no-untyped-call]
    error = narx.decode(can.Message(arbitration_id=0x82, data=data, is_extended_id=False))
    assert isinstance(error, narx.NodeMessage) and error["Code"] == "CAN controller error passive" and told.log[0].code == 0x8120
    for state, name in STATES.items():
        heartbeat = narx.decode(0x702, bytes([state]))
        assert heartbeat is not None and heartbeat["State"] == name
    assert narx.decode(0x702, bytes([9])) is None and narx.decode(0x702, bytes(2)) is None and narx.decode(0x402, bytes(4)) is None


def test_identifiers_up_to_7ff_have_11_bits_unless_told() -> None:
    assert isinstance(narx.decode(0x182, bytes(4)), narx.NodeMessage)
    assert narx.decode(0x182, bytes(8), extended=True) is None
    assert isinstance(narx.decode(0x003, bytes(8), extended=True), narx.Message)
    request = narx.decode(can.Message(arbitration_id=0x382, is_extended_id=False, is_remote_frame=True, dlc=6))
    assert isinstance(request, narx.NodeMessage) and (request.name, request["Bytes"]) == ("PDO3 request", 6)


def test_a_log_has_a_table_of_each_node(tmp_path: Path) -> None:
    frames = [
        can.Message(arbitration_id=id, data=data, is_extended_id=False)
        for id, data in [
            (0x182, MM.to_bytes(4, "little")), (0x183, bytes(8)), (0x182, (MM // 2).to_bytes(4, "little")), (0x702, b"\x05"),
            (0x602, bytes.fromhex("2b0320000a000000")), (0x582, bytes.fromhex("6003200000000000")), (0x181, bytes(3)), (0x400, b""),
        ]
    ]  # fmt: skip
    path = write(tmp_path / "nodes.log", stamped(frames))
    log = narx.read_log(path)
    assert log.counts == {"PDO1": 3, "SDO answer": 1, "SDO request": 1, "Heartbeat": 1}
    assert (len(log.unknown), len(log.malformed)) == (1, 1)
    assert log["PDO1", 2]["Position 1"].tolist() == [1.0, 0.5] and log["PDO1", 3]["Position 2"].tolist() == [0.0]
    assert log["PDO1"]["Encoder"].tolist() == pytest.approx([float("nan")] * 3, nan_ok=True)
    assert narx.read_log(path, encoders=[3])["PDO1", 3]["Encoder"].tolist() == [0.0]
    assert log["SDO request"].series("Entry").text() == ["Update Time"] and log["SDO answer"].series("Outcome").text() == ["written"]
    assert log["Heartbeat"].series("State").text() == ["operational"]
    told = [message for _, message in log.messages()]
    assert told == [narx.decode(frame) for frame in frames[:6]]
    with pytest.raises(narx.SignalError, match="MEASUREMENT_1 is not a message of a node"):
        log["MEASUREMENT_1", 2]
