"""The model's bus for python-can: time passes while somebody reads it, so `narx.Drive(bus)` operates the chip."""

from collections.abc import Callable
from typing import Any

import can

from stm32g4.chip import Chip
from stm32g4.fdcan import Frame
from stm32g4.registers import SECOND


class ChipBus(can.BusABC):
    """The other end of the chip's bus."""

    realtime = False

    def __init__(self, chip: Chip) -> None:
        super().__init__(channel="chip")
        self.chip = chip
        self.channel_info = "model of the STM32G4"

    @property
    def time(self) -> float:
        return self.chip.time

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        data = bytes(msg.dlc) if msg.is_remote_frame else bytes(msg.data)
        self.chip.bus.send(Frame(msg.arbitration_id, msg.is_extended_id, msg.is_remote_frame, data))

    def recv(self, timeout: float | None = None) -> can.Message | None:
        chip = self.chip
        end = chip.time + (timeout or 0.0)
        while True:
            while chip.bus.passed:
                time, is_host, frame = chip.bus.passed.popleft()
                if not is_host:
                    return can.Message(
                        timestamp=time / SECOND, arbitration_id=frame.identifier, is_extended_id=frame.extended,
                        is_remote_frame=frame.remote, dlc=len(frame.data), data=None if frame.remote else frame.data,
                    )  # fmt: skip
            if chip.time >= end - 1e-9:
                return None
            chip.run(end - chip.time, lambda: bool(chip.bus.passed))

    def attach(self, poll: Callable[[float], float]) -> None:
        """A master is on the bus; its calls let time pass."""

    def detach(self) -> None:
        """It has left."""

    def _recv_internal(self, timeout: float | None) -> tuple[Any, bool]:
        return self.recv(timeout), False

    def shutdown(self) -> None:
        super().shutdown()
