"""The bench: a virtual drive and its motor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from narx import _core
from narx._core import Load, Motor
from narx.drive import Drive
from narx.link import BenchLink
from narx.trace import Trace


class Bench:
    """A virtual drive with its motor on a simulated bench, commanded over its CAN bus. Same arguments and calls, same bits.

    The drive is commissioned for the motor and powers up; it stays in Standby until `drive.start`. supply_voltage: V. mode: "sensorless",
    "hall" or "open-loop". parameters: of the drive by name or number, in their units; they win over those of commissioning. ambient:
    degrees Celsius. seed: of all noise.
    """

    def __init__(
        self,
        motor: Motor,
        supply_voltage: float = 48.0,
        load: Load | None = None,
        mode: Literal["sensorless", "hall", "open-loop"] = "sensorless",
        parameters: Mapping[str, float] | Mapping[int, float] | Mapping[str | int, float] | None = None,
        ambient: float = 25.0,
        seed: int = 1,
    ) -> None:
        self._bench = _core.Bench(motor, supply_voltage, load, mode, parameters, ambient, seed)
        self._drive = Drive(BenchLink(self._bench))

    @property
    def drive(self) -> Drive:
        """The drive on this bench. Calls that wait advance simulated time."""
        return self._drive

    @property
    def time(self) -> float:
        """Time since power-up, s."""
        return self._bench.time

    @property
    def notes(self) -> list[str]:
        """Where a limit of the drive holds the motor back, in words."""
        return self._bench.notes

    def run(self, seconds: float) -> Trace:
        """Lets `seconds` pass, to the nearest control tick, and returns the rows of this run, one per tick."""
        # Rows of calls that waited belong to no run.
        self._bench.drop_rows()
        self._bench.advance(seconds)
        columns, units, recording = self._bench.take_run()
        return Trace(columns, units, recording)
