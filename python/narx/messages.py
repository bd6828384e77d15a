"""Messages as they stand in frames: of the drive's protocol (PROTOCOL.md, sections 1 to 6), and of TX-Drivers (section 10)."""

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
    """As the specification's Figure 14 prints it."""
    opcode: int
    from_drive: bool
    """Sent by a drive, else by its master."""
    source: int
    destination: int
    values: Mapping[str, Any]
    """By field: numbers in their units, names of what has names, sets of fault names."""
    units: Mapping[str, str]
    """By field; "" for plain numbers."""

    def __getitem__(self, field: str) -> Any:
        return self.values[field]


@dataclass(frozen=True)
class NodeMessage:
    """A decoded message of a TX-Driver or its master (eddyCAN)."""

    name: str
    """As the specification's Table 3 prints it: "PDO1", "SDO answer", "Heartbeat", ..."""
    from_node: bool
    """Sent by a node, else by its master."""
    values: Mapping[str, Any]
    """By signal: numbers in their units, names of what has names. What a PDO does not carry is not there."""
    units: Mapping[str, str]
    """By signal; "" for plain numbers."""

    @property
    def node(self) -> int | None:
        """The node-id of whoever sends or is meant: 0 for all of them, `None` where none is."""
        return self.values.get("Node")

    def __getitem__(self, signal: str) -> Any:
        return self.values[signal]


STANDARD_MAX = 0x7FF
"""Largest identifier of 11 bits."""


def decode(
    message: can.Message | int,
    data: bytes | None = None,
    /,
    *,
    extended: bool | None = None,
    encoder: bool = False,
) -> Message | NodeMessage | None:
    """The message in a frame of python-can, or in an identifier and its data; `None` if neither protocol has such a frame.

    29-bit identifiers are the drive's (NarMotion-X), those of 11 bits TX-Drivers' (eddyCAN). extended: whether an identifier has 29
    bits; else those up to 7FFh have 11. encoder: a PDO of 8 bytes has the encoder's value in it beside two positions of 24 bits; no
    frame tells that. Raises ParameterError for an identifier without data.
    """
    if isinstance(message, int):
        if data is None:
            raise ParameterError(f"identifier {message:#x}: its data is missing")
        return decode_parts(message, message > STANDARD_MAX if extended is None else extended, False, bytes(data), encoder)
    if message.is_error_frame or message.is_fd:
        return None
    payload = bytes(message.dlc) if message.is_remote_frame else bytes(message.data)
    return decode_parts(message.arbitration_id, message.is_extended_id, message.is_remote_frame, payload, encoder)


def decode_parts(number: int, extended: bool, remote: bool, data: bytes, encoder: bool) -> Message | NodeMessage | None:
    """The message in a frame of these parts; a remote frame has as many bytes as it asks for."""
    if extended:
        decoded = _core.decode(number, True, remote, data)
        return None if decoded is None else Message(*decoded)
    found = _core.decode_node(number, remote, data, encoder)
    return None if found is None else NodeMessage(*found)
