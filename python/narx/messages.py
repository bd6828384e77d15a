"""Decoded messages: of the drive's protocol (PROTOCOL.md, sections 1 to 6), and of TX-Drivers
(section 10)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from narx import _core
from narx.errors import ParameterError

if TYPE_CHECKING:
    import can


@dataclass(frozen=True)
class Message:
    """A decoded message of the drive or its master."""

    name: str
    """Name in the specification's Figure 14."""
    opcode: int
    from_drive: bool
    """True if a drive sends it, false if its master does."""
    source: int
    destination: int
    values: Mapping[str, Any]
    """Values by field: numbers in their units, names of named values, sets of fault names."""
    units: Mapping[str, str]
    """Units by field; "" for plain numbers."""

    def __getitem__(self, field: str) -> Any:
        return self.values[field]


@dataclass(frozen=True)
class NodeMessage:
    """A decoded message of a TX-Driver or its master (eddyCAN)."""

    name: str
    """Name in the specification's Table 3: "PDO1", "SDO answer", "Heartbeat", ..."""
    from_node: bool
    """True if a node sends it, false if its master does."""
    values: Mapping[str, Any]
    """Values by signal: numbers in their units, names of named values. Signals that a PDO does not carry are
    absent."""
    units: Mapping[str, str]
    """Units by signal; "" for plain numbers."""

    @property
    def node(self) -> int | None:
        """Node-id of the sender or of the addressed node: 0 for all nodes, `None` if the message has none."""
        return self.values.get("Node")

    def __getitem__(self, signal: str) -> Any:
        return self.values[signal]


STANDARD_MAX = 0x7FF
"""Largest identifier of 11 bits."""
EXTENDED_MAX = 0x1FFF_FFFF
"""Largest identifier of 29 bits."""


def decode(
    message: can.Message | int,
    data: bytes | None = None,
    /,
    *,
    extended: bool | None = None,
    encoder: bool = False,
) -> Message | NodeMessage | None:
    """Decodes a frame of python-can, or an identifier and its data; `None` if neither protocol has such a
    frame.

    29-bit identifiers are the drive's (NarMotion-X), 11-bit ones those of TX-Drivers (eddyCAN). extended:
    whether an identifier has 29 bits; by default those up to 7FFh have 11. encoder: a PDO of 8 bytes contains
    the encoder's value and two positions of 24 bits; the frame itself does not show this. Raises
    ParameterError for an identifier without data.
    """
    if isinstance(message, int):
        number = _core.whole_number("identifier", message, 0, EXTENDED_MAX)
        if data is None:
            raise ParameterError(f"identifier {number:#x}: its data is missing")
        if not isinstance(data, bytes | bytearray | memoryview):
            raise ParameterError(f"identifier {number:#x}: its data {data!r} must be bytes")
        return decode_parts(number, number > STANDARD_MAX if extended is None else extended, False, bytes(data), encoder)
    if not hasattr(message, "arbitration_id"):
        raise ParameterError(f"message {message!r}: must be a can.Message, or an identifier with its data")
    if message.is_error_frame or message.is_fd:
        return None
    payload = bytes(message.dlc) if message.is_remote_frame else bytes(message.data)
    return decode_parts(message.arbitration_id, message.is_extended_id, message.is_remote_frame, payload, encoder)


def decode_parts(number: int, extended: bool, remote: bool, data: bytes, encoder: bool) -> Message | NodeMessage | None:
    """Decodes a frame given by its parts; a remote frame has as many bytes as it requests."""
    if extended:
        decoded = _core.decode(number, True, remote, data)
        return None if decoded is None else Message(*decoded)
    found = _core.decode_node(number, remote, data, encoder)
    return None if found is None else NodeMessage(*found)
