"""Messages of the drive's protocol as they stand in frames (PROTOCOL.md, sections 1 to 6)."""

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
    """A decoded message."""

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


def decode(message: can.Message | int, data: bytes | None = None, /) -> Message | None:
    """The message in a frame of python-can, or in a 29-bit identifier and its data; `None` if the protocol has no such message."""
    if isinstance(message, int):
        if data is None:
            raise ParameterError(f"identifier {message:#x}: its data is missing")
        parts = (message, True, False, bytes(data))
    else:
        if message.is_error_frame or message.is_fd:
            return None
        payload = bytes(message.dlc) if message.is_remote_frame else bytes(message.data)
        parts = (message.arbitration_id, message.is_extended_id, message.is_remote_frame, payload)
    decoded = _core.decode(*parts)
    return None if decoded is None else Message(*decoded)
