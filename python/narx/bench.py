"""The bench: a virtual drive and its motor."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Literal

from narx import _core, fmu, given, live
from narx._core import Load, Motor
from narx.courses import Course, Courses, LoadCourse
from narx.drive import Drive
from narx.link import BenchLink
from narx.progress import bar
from narx.rows import Rows
from narx.trace import Trace

STRETCH = 1.0
"""Simulated time between two steps of the progress bar, s."""
SUPPLY = 48.0
"""Supply voltage of a motor that is no preset's name, V."""


class Bench:
    """A virtual drive with its motor on a simulated bench, commanded over its CAN bus. The same arguments and
    calls give the same bits.

    The drive is commissioned for the motor and powers up; it stays in Standby until `drive.start`. motor: a
    `narx.Motor`, the name of a preset, or a file of figures (.toml). supply_voltage: V; without it a preset that is given by name has its
    nominal one, and any other motor 48 V. mode: "sensorless", "hall" or "open-loop". parameters: of the drive
    by name or number, in their units; they override those of commissioning. ambient: -55 to 250 degrees
    Celsius. seed: of all noise.
    recording: without it the bench is faster, but nothing can be replayed and there is no digest. pwm_rate:
    PWM frequency, 8 000 to 50 000 Hz; every period has one control tick.
    """

    def __init__(
        self,
        motor: Motor | str | PathLike[str],
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
        self._courses = Courses(self._bench)
        self._running = threading.RLock()
        self._motor, self._supply_voltage = whole, float(supply_voltage)
        self._drive = Drive(BenchLink(self))
        self._pwm_rate = pwm_rate
        self._about = f"{whole.name or 'motor'}, {supply_voltage:g} V, {mode}"

    def __repr__(self) -> str:
        return f"<narx.Bench of {self._about}: {self._drive._described()}>"

    def copy(self) -> Bench:
        """Returns a copy of the bench as it stands, to try several continuations of one experiment: the same
        calls give the same bits on both. Functions that give load or supply are shared. TX-Drivers are copied;
        a `narx.TxDriver` operates the node of its own bench only."""
        copied = Bench.__new__(Bench)
        copied._bench = self._bench.copy()
        copied._running = threading.RLock()
        copied._courses = self._courses.copy(copied._bench)
        copied._motor, copied._supply_voltage, copied._about = self._motor, self._supply_voltage, self._about
        copied._pwm_rate = self._pwm_rate
        copied._drive = Drive(BenchLink(copied))
        return copied

    @property
    def motor(self) -> Motor:
        """The motor."""
        return self._motor

    @property
    def supply_voltage(self) -> float:
        """Supply voltage at power-up, V."""
        return self._supply_voltage

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
        """Limits of the drive that restrict this motor, a sentence each; and whether the winding has been
        hotter than the motor's `max_winding_temperature`."""
        return self._bench.notes

    def run(
        self,
        seconds: float,
        trace: bool = True,
        *,
        signals: Sequence[str] | None = None,
        every: int = 1,
        to: str | PathLike[str] | None = None,
        progress: bool | None = None,
    ) -> Trace:
        """Runs the simulation for `seconds`, to the nearest control tick, and returns the rows of this run,
        one per tick. Without `trace` it keeps no rows, which is faster.

        For long runs: signals: names of those to keep besides "time". every: keeps one row of this many ticks.
        to: a .parquet file, to which rows are written as the run goes on instead of into the trace; the
        memory stays the same whatever the length. progress: whether to show a progress bar of tqdm; by
        default after 1 s, if tqdm is installed and the output is a terminal or a notebook. Raises
        SignalError for a signal that does not exist, ParameterError for another argument out of range, and
        MissingError without the library of a file. Ctrl-C raises RunInterrupted, whose `.trace` has the rows
        so far.
        """
        seconds = given.seconds(seconds)
        # A bar that would advance once says nothing.
        progress = False if progress is None and seconds <= STRETCH else progress
        # Runs of two threads follow each other, each with its own rows.
        with self._running, Rows(self._bench, trace, signals, every, to, seconds) as rows, bar(seconds, "s", progress) as step:
            end = self.time + seconds
            try:
                while (left := end - self.time) > STRETCH:
                    self._courses.advance(STRETCH)
                    rows.pass_on()
                    step(STRETCH)
                self._courses.advance(max(left, 0.0))
            except KeyboardInterrupt:
                raise RunInterrupted(rows.end()) from None
            step(left)
            return rows.end()

    def live(self, seconds: float, *signals: str, refresh: float = 0.1, every: int = 10) -> Trace:
        """Runs the simulation for `seconds`, and in a notebook draws the rows so far again and again; returns
        the rows.

        signals: those to keep and draw, as of `Trace.plot`; without names it keeps all. refresh: simulated
        time from one picture to the next, s. every: keeps one row of this many ticks. Raises RefusedError
        outside of a notebook, MissingError without matplotlib, SignalError for a signal that does not exist,
        and ParameterError for another argument out of range. Ctrl-C (the notebook's Stop) raises
        RunInterrupted, whose `.trace` has the rows so far.
        """
        return live.live(self, seconds, signals, refresh, every)

    def fmu(self, path: str | PathLike[str], version: Literal[2, 3] = 3) -> None:
        """Writes this bench as an FMU for other simulation tools: FMI 2.0 or 3.0, co-simulation, for Linux on
        x86-64. It powers up as this bench did, with the same arguments.

        Inputs: "run" (true requests Drive, false Standby), "speed_request" (rpm), "load_torque" and
        "machine_torque" (N m), "supply_voltage" (V). Outputs: every signal of a trace but the time, by its
        name and in its unit, as a double of the value of which a trace keeps 32 bits; codes are integers.
        A step of time runs the control ticks up to its end, to the nearest. Faults, TX-Drivers and what was
        changed on this bench since it powered up are not in it. Raises ParameterError for another version,
        and MissingError for a package that was built for another system.
        """
        fmu.save(self._bench, path, version, 1.0 / self._pwm_rate)

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

    def set_load(self, load: LoadCourse) -> None:
        """Replaces the load on the shaft.

        load: a `narx.Load`; a number, which is a torque that opposes the motion, N m; a function of the time since power-up (s) that returns one of them; or a pair of times
        (s) and torques (N m), between which torques are interpolated. A load that changes is set every
        millisecond. `narx.Load(machine=...)` is a dynamometer, which can drive the shaft. Raises ParameterError for any other, and during a run for a value out of range.
        """
        self._courses.set_load(load)

    def set_supply(
        self, voltage: Course | None = None, resistance: float | None = None, may_sink: bool | None = None
    ) -> None:
        """Changes the supply; what is `None` stays.

        voltage: open-circuit voltage, 0 to 80 V; a number, a function of the time since power-up (s), or a
        pair of times (s) and voltages, as of `set_load`. resistance: of the source, 0 to 100 ohm; 0.1 at
        first. may_sink: takes current back, as a battery does; at first it does not, and a motor that brakes
        pumps the bus up. Raises ParameterError for a value out of range.
        """
        self._bench.set_supply(resistance=resistance, may_sink=may_sink)
        self._courses.set_supply(voltage)

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


class RunInterrupted(KeyboardInterrupt):
    """Ctrl-C during a run: `trace` has the rows so far, and the bench goes on from there."""

    def __init__(self, trace: Trace) -> None:
        super().__init__(f"interrupted after {len(trace)} rows")
        self.trace = trace
