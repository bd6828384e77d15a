"""The bench: a virtual drive and its motor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from narx import _core, given
from narx._core import Load, Motor
from narx.drive import Drive
from narx.link import BenchLink
from narx.trace import Trace


SUPPLY = 48.0
"""Supply voltage of a motor that is no preset's name, V."""


class Bench:
    """A virtual drive with its motor on a simulated bench, commanded over its CAN bus. The same arguments and
    calls give the same bits.

    The drive is commissioned for the motor and powers up; it stays in Standby until `drive.start`. motor: a
    `narx.Motor`, or the name of a preset. supply_voltage: V; without it a preset that is given by name has its
    nominal one, and any other motor 48 V. mode: "sensorless", "hall" or "open-loop". parameters: of the drive
    by name or number, in their units; they override those of commissioning. ambient: -55 to 250 degrees
    Celsius. seed: of all noise.
    recording: without it the bench is faster, but nothing can be replayed and there is no digest. pwm_rate:
    PWM frequency, 8 000 to 50 000 Hz; every period has one control tick.
    """

    def __init__(
        self,
        motor: Motor | str,
        supply_voltage: float | None = None,
        load: Load | None = None,
        mode: Literal["sensorless", "hall", "open-loop"] = "sensorless",
        parameters: Mapping[str, float] | Mapping[int, float] | Mapping[str | int, float] | None = None,
        ambient: float = 25.0,
        seed: int = 1,
        recording: bool = True,
        pwm_rate: int = 10_000,
    ) -> None:
        load = None if load is None else given.load(load)
        whole = given.motor(motor)
        if supply_voltage is None:
            supply_voltage = (whole.nominal_voltage if isinstance(motor, str) else None) or SUPPLY
        self._bench = _core.Bench(whole, supply_voltage, load, mode, parameters, ambient, seed, pwm_rate, recording)
        self._drive = Drive(BenchLink(self._bench))
        self._about = f"{whole.name or 'motor'}, {supply_voltage:g} V, {mode}"

    def __repr__(self) -> str:
        return f"<narx.Bench of {self._about}: {self._drive._described()}>"

    @property
    def drive(self) -> Drive:
        """The drive on this bench. Calls that wait advance simulated time."""
        return self._drive

    @property
    def time(self) -> float:
        """Time since power-up, s."""
        return self._bench.time

    @property
    def digest(self) -> int:
        """Digest of all outputs of the drive since it last booted, as in its recording; 0 without a
        recording."""
        return self._bench.digest

    @property
    def notes(self) -> list[str]:
        """Limits of the drive that restrict this motor, a sentence each."""
        return self._bench.notes

    def run(self, seconds: float, trace: bool = True) -> Trace:
        """Runs the simulation for `seconds`, to the nearest control tick, and returns the rows of this run,
        one per tick. Without `trace` it keeps no rows, which is faster."""
        # Removes rows of earlier calls that waited: they belong to no run.
        self._bench.drop_rows()
        self._bench.advance(seconds, trace)
        columns, units, recording = self._bench.take_run()
        return Trace(columns, units, recording)

    def inject(
        self, fault: str, value: float | None = None, phase: Literal["A", "B", "C"] | None = None, high: bool = False
    ) -> None:
        """Injects a fault, until `clear`. A fault is a physical cause, not the fault bit that results from
        it.

        "ambient" (value in degrees Celsius), "supply" (V), "leak" (a resistor across the bus, ohm), "driver",
        "open-phase", "hall-swapped" (phase), "hall-stuck" (phase, high), "hall-glitches" (value per second),
        "hall-supply-lost", "blocked-rotor", "pressure" (V behind the amplifier), "break" (the hardware's
        break input), "dsi1", "dsi2".
        """
        self._bench.set_fault(str(fault).replace("_", "-"), True, value, phase, high)

    def clear(self, fault: str | None = None, phase: Literal["A", "B", "C"] | None = None) -> None:
        """Removes one fault of `inject`, or all faults."""
        if fault is None:
            self._bench.clear_faults()
        else:
            self._bench.set_fault(str(fault).replace("_", "-"), False, None, phase, False)

    def add_tx_driver(
        self, node_id: int, channels: Literal[1, 2] = 1, encoder: int | None = None, measuring_range: float = 2.0
    ) -> None:
        """Connects an eddyCAN TX-Driver to the drive's bus. Its sensors measure the distance of the shaft's
        surface, a quarter of a revolution apart.

        node_id: 1 to 127. encoder: counts per revolution of an incremental encoder on the shaft.
        measuring_range: mm. It powers up Pre-operational with factory values.
        """
        self._bench.add_tx_driver(node_id, channels, encoder, measuring_range)

    def set_load(self, load: Load) -> None:
        """Replaces the load on the shaft."""
        self._bench.set_load(given.load(load))

    def set_input(self, name: str, value: float) -> None:
        """Sets a slow input of the board to a value: one of `inputs`, in the unit of its measured
        quantity."""
        self._bench.set_input(name, value)

    @property
    def inputs(self) -> list[str]:
        """Names of the board's slow inputs: "asi" (V), "accel_x" (g), "pressure" (mV), "rail14_v" (V), ..."""
        return self._bench.inputs()

    @property
    def faults(self) -> list[str]:
        """Names of the faults that `inject` knows."""
        return self._bench.faults()
