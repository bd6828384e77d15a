"""Experiments of a test bench, one call each: maps, steps, frequency responses, and what a drive does when
supply, temperature or shaft leave it no way. Each returns a `Result`: a table with figures and a plot.

Those that take a bench work on copies of it: the bench itself stays as it is. Points of a table are measured side
by side on every core.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from narx import _core, errors, given, table
from narx._core import Motor, State
from narx.bench import Bench
from narx.courses import LoadCourse
from narx.errors import NarxError, ParameterError, RefusedError, SignalError, StartError
from narx.extras import need
from narx.names import suggestion
from narx.signals import Limiter
from narx.sweep import Sweep, sweep
from narx.trace import Trace
from narx.variants import Variant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

__all__ = [
    "Result", "brown_out", "derating", "frequency_response", "load_step", "stall", "step_response", "torque_speed_map"
]  # fmt: skip

RADIANS = np.pi / 30.0
"""rad/s of 1 rpm."""
RUNNING = (State.OPEN_LOOP, State.SENSORLESS_CLOSED_LOOP, State.HALL_CLOSED_LOOP)
BAND = 0.02
"""Band around the final value in which a response has settled, share of the set-point."""
STEP, STEPS = 0.002, 100
"""Shortest time between two values of an injected sine, s, and their largest number in a period."""


class Result:
    """Result of an experiment: columns by name (`result["speed"]` is a numpy array of shape (rows,)), and
    figures."""

    def __init__(
        self,
        name: str,
        columns: Mapping[str, NDArray[Any]],
        units: Mapping[str, str],
        figures: Mapping[str, float] | None = None,
        draw: Callable[[Result, Figure], None] | None = None,
        notes: Sequence[str] = (),
    ) -> None:
        self.name = name
        """Name of the experiment."""
        self.figures = dict(figures or {})
        """Figures by name; the unit is in `units`."""
        self.units = dict(units)
        """Units of columns and figures that have one."""
        self.notes = list(notes)
        """Remarks on how far the result holds, a sentence each."""
        self._columns = dict(columns)
        self._draw = draw

    def __getitem__(self, column: str) -> NDArray[Any]:
        try:
            return self._columns[column]
        except (KeyError, TypeError):
            names = ", ".join(self._columns)
            raise SignalError(f'there is no column "{column}"{suggestion(str(column), self._columns)}; there are {names}') from None

    def __contains__(self, column: object) -> bool:
        return column in self._columns

    def __iter__(self) -> Any:
        return iter(self._columns)

    def __len__(self) -> int:
        """Number of rows."""
        return max(map(len, self._columns.values()), default=0)

    def __repr__(self) -> str:
        shown = [f"{name} {value:.4g} {self.units.get(name, '')}".rstrip() for name, value in self.figures.items()]
        return f"<narx.experiments.Result {self.name}: {', '.join(shown) or f'{len(self)} rows'}>"

    def _repr_html_(self) -> str:
        return table.html(repr(self).strip("<>"), self._columns)  # type: ignore[arg-type]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._columns)

    def to_pandas(self) -> Any:
        """Returns the columns as a pandas data frame. Raises MissingError without pandas."""
        return need("pandas").DataFrame(self._columns)

    def save(self, path: str) -> None:
        """Writes the table: `.csv`, `.parquet` or `.xlsx`. Raises ParameterError for any other name."""
        table.save(self._columns, path)

    def plot(self) -> Figure:
        """Draws the result. Raises MissingError without matplotlib."""
        need("matplotlib")
        from matplotlib.figure import Figure

        from narx.plot import shown

        figure = shown(Figure(figsize=(9.0, 5.0), layout="constrained"))
        (self._draw or draw_columns)(self, figure)
        return figure


def torque_speed_map(
    motor: Motor | str,
    supply_voltage: float | None = None,
    speeds: int | Iterable[float] = 6,
    torques: int | Iterable[float] = 5,
    *,
    progress: bool | None = None,
    **options: Any,
) -> Result:
    """Measures speed, power and efficiency at every combination of speed and load torque, as a data sheet's map.

    motor, supply_voltage and options are those of `narx.Bench`; mode is "hall" unless given. speeds: mechanical
    rpm, or the number of speeds over the operating range. torques: N m, or the number of torques up to the
    largest one of the operating range.

    Columns: the requested "setpoint" (rpm) and "load" (N m); "outcome", "running" where the drive holds the speed
    within 2 %; means of 0.2 s: "speed" (rpm), "torque" (N m, electromagnetic), "supply_power" (W, of the ideal
    source), "bus_power" (W, into the bridge), "load_power" (W, at the coupling), "efficiency" (load over supply),
    "efficiency_bus" (load over bus), "current" (A, rms of the phases), "duty", "winding_temperature" (degrees
    Celsius, at the end). Figures: the best efficiency with its speed and torque. Raises ParameterError for
    arguments that a bench refuses.
    """
    options = {"mode": "hall"} | options
    bench = Bench(motor, supply_voltage, **options)
    able = bench.motor.operating_range(bench.supply_voltage, options["mode"], options.get("pwm_rate", 10_000))
    if isinstance(speeds, int):
        speeds = np.round(np.linspace(able.speed_min, able.speed_max, points("speeds", speeds)))
    if isinstance(torques, int):
        torques = np.linspace(0.0, max(able.torque), points("torques", torques))

    def measure(variant: Variant) -> dict[str, Any]:
        branch = bench.copy()
        return operating_point(branch, variant["setpoint"], variant["load"])

    swept = sweep(measure, grid={"setpoint": floats("speeds", speeds), "load": floats("torques", torques)}, progress=progress)
    columns = columns_of(swept)
    good = columns["outcome"] == "running"
    best = int(np.argmax(np.where(good, columns["efficiency"], -1.0)))
    figures = {name: float(columns[column][best]) for name, column in (
        ("best_efficiency", "efficiency"), ("best_speed", "speed"), ("best_torque", "load"))} if good.any() else {}  # fmt: skip
    units = {
        "setpoint": "rpm", "load": "N m", "speed": "rpm", "torque": "N m", "supply_power": "W", "bus_power": "W",
        "load_power": "W", "current": "A", "winding_temperature": "degC", "best_speed": "rpm", "best_torque": "N m",
    }  # fmt: skip
    return Result("torque_speed_map", columns, units, figures, draw_map, bench.notes)


def operating_point(bench: Bench, rpm: float, torque: float) -> dict[str, Any]:
    """Measures a bench that was powered up at a speed, rpm, and a load torque, N m."""
    bench.drive.start(round(rpm))
    bench.set_load(torque)
    for _ in range(10):
        speed = bench.run(0.2, signals=["speed"])["speed"].mean()
        if abs(speed - rpm) < 0.005 * abs(rpm):
            break
    trace = bench.run(0.2)
    seconds = len(trace) * (trace.time[1] - trace.time[0])
    speed = float(trace["speed"].mean())
    supply = float(trace["energy_in"][-1] - trace["energy_in"][0]) / (trace.time[-1] - trace.time[0])
    bus = float((trace["bus_voltage"].astype(float) * trace["bus_current"]).mean())
    load = float((trace["position"][-1] - trace["position"][0]) / (seconds or 1.0)) * torque
    currents = [trace[f"current_{phase}"].astype(float) for phase in "abc"]
    held = abs(speed - rpm) <= BAND * abs(rpm) and bench.drive.state in RUNNING
    return {
        "outcome": "running" if held else "fault" if bench.drive.faults else "limited",
        "speed": speed, "torque": float(trace["torque"].mean()), "supply_power": supply, "bus_power": bus,
        "load_power": load, "efficiency": share(load, supply), "efficiency_bus": share(load, bus),
        "current": float(np.sqrt(np.mean(np.square(currents)))), "duty": float(trace["duty"].mean()),
        "winding_temperature": float(trace["winding_temperature"][-1]),
    }  # fmt: skip


def step_response(bench: Bench, rpm: float, seconds: float = 1.0) -> Result:
    """Measures the response of a running bench to a step of the set-point to `rpm`, mechanical rpm, for
    `seconds`.

    Columns are those of a trace; "time" (s) counts from the command. Figures: "rise_time" (s, from 10 % to 90 % of
    the step), "overshoot" (share of the step), "settling_time" (s, until the speed stays within 2 % of the
    set-point), "error" (rpm, mean of the last quarter less set-point), "peak_current" (A). A time that is never
    reached is NaN. Raises RefusedError for a bench whose motor does not run, ParameterError for a set-point that
    the drive would clamp.
    """
    branch = running(bench)
    before = float(branch.run(0.05, signals=["speed"])["speed"].mean())
    branch.drive.set_speed(abs(rpm)) if rpm * before > 0 else branch.drive.start(rpm)
    trace = since(branch.run(given.seconds(seconds)))
    time, progress = trace.time, (trace["speed"] - before) / ((rpm - before) or 1.0)
    figures = {
        "rise_time": first(time, progress >= 0.9) - first(time, progress >= 0.1),
        "overshoot": max(float(progress.max()) - 1.0, 0.0),
        "settling_time": settled(time, trace["speed"], rpm, BAND * abs(rpm)),
        "error": float(trace["speed"][-len(trace) // 4 :].mean()) - rpm,
        "peak_current": float(trace["peak_current"].max()),
    }
    units = trace.signals | {"rise_time": "s", "settling_time": "s", "error": "rpm"}
    return Result("step_response", dict(trace.items()), units, figures, draw_steps)


def load_step(bench: Bench, load: LoadCourse, seconds: float = 1.0) -> Result:
    """Measures the response of a running bench to another load, as of `Bench.set_load`, for `seconds`.

    Columns are those of a trace; "time" (s) counts from the step. Figures: "dip" (rpm, largest difference of the
    speed from the one before), "dip_time" (s), "recovery_time" (s, until the speed stays within 2 % of the one
    before; NaN if it never does), "error" (rpm, mean of the last quarter less the speed before), "peak_current"
    (A). Raises RefusedError for a bench whose motor does not run, ParameterError for a load that is none.
    """
    branch = running(bench)
    before = float(branch.run(0.05, signals=["speed"])["speed"].mean())
    branch.set_load(load)
    trace = since(branch.run(given.seconds(seconds)))
    difference = np.abs(trace["speed"] - before)
    figures = {
        "dip": float(difference.max()),
        "dip_time": float(trace.time[int(difference.argmax())]),
        "recovery_time": settled(trace.time, trace["speed"], before, BAND * abs(before)),
        "error": float(trace["speed"][-len(trace) // 4 :].mean()) - before,
        "peak_current": float(trace["peak_current"].max()),
    }
    units = trace.signals | {"dip": "rpm", "dip_time": "s", "recovery_time": "s", "error": "rpm"}
    return Result("load_step", dict(trace.items()), units, figures, draw_steps)


def frequency_response(
    bench: Bench,
    frequencies: Iterable[float] | None = None,
    amplitude: float = 0.02,
    *,
    progress: bool | None = None,
) -> Result:
    """Measures the speed loop of a running bench by a sine on its set-point, one frequency at a time.

    frequencies: Hz, 0.1 to 100; by default 16 from 0.5 to 20. amplitude: of the sine, share of the set-point, 0.001
    to 0.2; less where the drive's ramp (parameter 99) could not follow.

    Columns: "frequency" (Hz); "gain" and "phase" (degrees), closed loop, of the speed against the set-point behind
    the drive's ramp; "loop_gain" and "loop_phase" (degrees), open loop: closed / (1 - closed) of the speed that the
    drive measures, which comes later than the true one. Figures:
    "bandwidth" (Hz, closed-loop gain of -3 dB), "crossover" (Hz, loop gain of 1), "phase_margin" (degrees); NaN
    where the frequencies do not contain it. Raises RefusedError for a bench whose motor does not run,
    ParameterError for a frequency or amplitude out of range.
    """
    base = running(bench)
    chosen = np.geomspace(0.5, 20.0, 16) if frequencies is None else np.sort(floats("frequencies", frequencies))
    for frequency in chosen:
        _core.number("frequency", frequency, "Hz", 0.1, 100.0)
    amplitude = _core.number("amplitude", amplitude, "", 0.001, 0.2)
    setpoint = float(base.run(0.05, signals=["setpoint"])["setpoint"][-1])
    rate = float(base.drive.parameters["Speed setpoint rate"])

    def measure(variant: Variant) -> dict[str, Any]:
        frequency = float(variant["frequency"])
        swing = min(amplitude * abs(setpoint), 0.5 * rate / (2.0 * np.pi * frequency))
        true, measured = closed_loop(base.copy(), abs(setpoint), swing, frequency)
        return {"real": true.real, "imaginary": true.imag, "measured_real": measured.real, "measured_imaginary": measured.imag}

    columns = columns_of(sweep(measure, grid={"frequency": chosen}, progress=progress))
    closed = columns["real"] + 1j * columns["imaginary"]
    measured = columns["measured_real"] + 1j * columns["measured_imaginary"]
    loop = measured / (1.0 - measured)
    phase = np.degrees(np.unwrap(np.angle(loop)))
    # The phase of a loop with an integrator begins between -180 and 0 degrees.
    phase -= 360.0 * np.ceil(phase[0] / 360.0) if phase[0] > 0 else 0.0
    columns = {
        "frequency": columns["frequency"], "gain": np.abs(closed), "phase": np.degrees(np.unwrap(np.angle(closed))),
        "loop_gain": np.abs(loop), "loop_phase": phase,
    }  # fmt: skip
    crossover = crossing(columns["frequency"], columns["loop_gain"], 1.0)
    figures = {
        "bandwidth": crossing(columns["frequency"], columns["gain"], np.sqrt(0.5)),
        "crossover": crossover,
        "phase_margin": float("nan") if np.isnan(crossover)
        else 180.0 + float(np.interp(np.log(crossover), np.log(columns["frequency"]), phase)),
    }  # fmt: skip
    units = {"frequency": "Hz", "phase": "deg", "loop_phase": "deg", "bandwidth": "Hz", "crossover": "Hz", "phase_margin": "deg"}
    return Result("frequency_response", columns, units, figures, draw_bode)


def closed_loop(bench: Bench, setpoint: float, swing: float, frequency: float) -> tuple[complex, complex]:
    """Returns true speed over set-point at a frequency, Hz, and that of the measured speed. setpoint, swing: rpm."""
    periods = int(np.ceil(max(6.0, 0.6 * frequency)))
    skipped = int(np.ceil(max(2.0, 0.2 * frequency)))
    begin, parts = bench.time, []
    while (now := bench.time - begin) < periods / frequency:
        rpm = setpoint + swing * np.sin(2.0 * np.pi * frequency * now)
        # Not `drive.set_speed`, which reads the limits from the drive and takes time for it.
        bench.drive._master.set_speed(round(rpm))
        parts.append(bench.run(max(STEP, 1.0 / (STEPS * frequency)), signals=["setpoint", "speed", "speed_estimated"]))
    names = ("time", "setpoint", "speed", "speed_estimated")
    time, given, *speeds = (np.concatenate([part[name] for part in parts]).astype(float) for name in names)
    chosen = (time - begin > skipped / frequency) & (time - begin <= periods / frequency)
    turning = np.exp(-2j * np.pi * frequency * time[chosen])
    of_setpoint, true, measured = (((values[chosen] - values[chosen].mean()) * turning).mean() for values in (given, *speeds))
    return complex(true / of_setpoint), complex(measured / of_setpoint)


def brown_out(
    bench: Bench, voltages: Iterable[float], durations: Iterable[float], *, recovery: float = 1.0, progress: bool | None = None
) -> Result:
    """Lets the supply of a running bench dip to every voltage, V, for every duration, s, and observes `recovery` s
    afterwards.

    Columns: "voltage" (V), "duration" (s); "outcome": "running" if the motor is in closed loop at its speed again,
    "fault", or "standby"; "faults"; "speed_min" (rpm), "bus_voltage_min" (V), "recovery_time" (s from the end of
    the dip until the speed stays within 2 %, NaN if it never does). Figures: "survived", the share that runs
    again. Raises RefusedError for a bench whose motor does not run, ParameterError for a value out of range.
    """
    base = running(bench)
    nominal = base.supply_voltage
    recovery = given.seconds(recovery)

    def measure(variant: Variant) -> dict[str, Any]:
        branch, duration = base.copy(), float(variant["duration"])
        before = float(branch.run(0.05, signals=["speed"])["speed"].mean())
        branch.set_supply(variant["voltage"])
        dip = branch.run(duration)
        branch.set_supply(nominal)
        after = since(branch.run(recovery))
        return outcome(branch, before, after) | {
            "speed_min": float(min(np.abs(dip["speed"]).min(initial=np.inf), np.abs(after["speed"]).min(initial=np.inf))),
            "bus_voltage_min": float(min(dip["bus_voltage"].min(initial=np.inf), after["bus_voltage"].min(initial=np.inf))),
            "recovery_time": settled(after.time, after["speed"], before, BAND * abs(before)),
        }

    grid = {"voltage": floats("voltages", voltages), "duration": floats("durations", durations)}
    columns = columns_of(sweep(measure, grid=grid, progress=progress))
    units = {"voltage": "V", "duration": "s", "speed_min": "rpm", "bus_voltage_min": "V", "recovery_time": "s"}
    return Result("brown_out", columns, units, {"survived": float((columns["outcome"] == "running").mean())})


def derating(bench: Bench, ambients: Iterable[float], seconds: float = 3.0, *, progress: bool | None = None) -> Result:
    """Brings the surroundings of a running bench to each temperature, degrees Celsius, for `seconds`.

    Columns: "ambient" (degrees Celsius); "outcome" as of `brown_out`, "limited" if the motor turns below its speed;
    "faults"; "speed" (rpm) and "torque" (N m), means of the last quarter; "limited" (share of the last quarter in
    which a limit, and not the speed loop, determines the voltage). Figures: "derates_from" and "faults_from" (degrees Celsius, NaN
    if none of the temperatures does). Raises RefusedError for a bench whose motor does not run, ParameterError for a
    temperature out of range.
    """
    base = running(bench)
    seconds = given.seconds(seconds)

    def measure(variant: Variant) -> dict[str, Any]:
        branch = base.copy()
        before = float(branch.run(0.05, signals=["speed"])["speed"].mean())
        branch.inject("ambient", variant["ambient"])
        last = branch.run(seconds, signals=["speed", "torque", "limiter"])
        last = last.select(slice(-max(len(last) // 4, 1), None))
        return outcome(branch, before, last) | {
            "speed": float(last["speed"].mean()), "torque": float(last["torque"].mean()),
            "limited": float((~np.isin(last["limiter"], (Limiter.SPEED, Limiter.SLEW))).mean()),
        }  # fmt: skip

    columns = columns_of(sweep(measure, grid={"ambient": np.sort(floats("ambients", ambients))}, progress=progress))
    figures = {
        "derates_from": first(columns["ambient"], columns["outcome"] == "limited"),
        "faults_from": first(columns["ambient"], columns["outcome"] == "fault"),
    }
    units = {"ambient": "degC", "speed": "rpm", "torque": "N m", "derates_from": "degC", "faults_from": "degC"}
    return Result("derating", columns, units, figures)


def stall(bench: Bench, durations: Iterable[float], *, recovery: float = 3.0, progress: bool | None = None) -> Result:
    """Blocks the rotor of a running bench for every duration, s, and observes `recovery` s after its release. A
    drive that is then in Fault is asked for the same speed again.

    Columns: "duration" (s); "detection_time" (s until the drive leaves closed loop; NaN if it does not);
    "peak_current" (A, while blocked); "faults" (then); "outcome" as of `brown_out`, after the release;
    "restart_time" (s from the release until the speed stays within 2 %). Figures: "restarted", the share that runs
    again. Raises RefusedError for a bench whose motor does not run, ParameterError for a value out of range.
    """
    base = running(bench)
    recovery = given.seconds(recovery)

    def measure(variant: Variant) -> dict[str, Any]:
        branch = base.copy()
        mode = branch.drive.state
        before = float(branch.run(0.05, signals=["speed"])["speed"].mean())
        branch.inject("blocked-rotor")
        blocked = since(branch.run(float(variant["duration"])))
        faults = sorted(branch.drive.faults)
        branch.clear()
        begin = branch.time
        if branch.drive.state is State.FAULT or branch.drive.state is State.STANDBY:
            restart(branch, before)
        waited = branch.time - begin
        after = since(branch.run(recovery))
        return {
            "detection_time": first(blocked.time, blocked["state"] != int(mode or 0)),
            "peak_current": float(blocked["peak_current"].max(initial=0.0)),
        } | outcome(branch, before, after) | {
            "faults": ", ".join(faults),
            "restart_time": waited + settled(after.time, after["speed"], before, BAND * abs(before)),
        }  # fmt: skip

    columns = columns_of(sweep(measure, grid={"duration": floats("durations", durations)}, progress=progress))
    units = {"duration": "s", "detection_time": "s", "peak_current": "A", "restart_time": "s"}
    return Result("stall", columns, units, {"restarted": float((columns["outcome"] == "running").mean())})


def restart(bench: Bench, rpm: float) -> None:
    """Acknowledges a fault and starts again; a refusal or a failed start is the result."""
    bench.drive.stop()
    bench.run(0.2, trace=False)
    try:
        bench.drive.start(round(rpm))
    except (StartError, RefusedError):
        pass


def outcome(bench: Bench, before: float, after: Trace) -> dict[str, Any]:
    """Returns outcome and faults of a bench that ran at `before` rpm, with its last rows."""
    state, speed = bench.drive.state, float(after["speed"][-max(len(after) // 4, 1) :].mean()) if len(after) else before
    held = abs(speed - before) <= BAND * abs(before)
    name = "fault" if state is State.FAULT else "standby" if state not in RUNNING else "running" if held else "limited"
    return {"outcome": name, "faults": ", ".join(sorted(bench.drive.faults))}


def running(bench: Bench) -> Bench:
    """Returns a copy of a bench whose motor runs."""
    if not isinstance(bench, Bench):
        raise ParameterError(f"bench {bench!r}: must be a narx.Bench")
    copied = bench.copy()
    if copied.drive.state not in RUNNING:
        raise RefusedError(f"the motor does not run: start it, and let it reach its speed; {bench!r}")
    return copied


def since(trace: Trace) -> Trace:
    """Returns a trace whose time begins at 0 s."""
    columns = dict(trace.items())
    if len(trace):
        columns["time"] = trace.time - trace.time[0]
    return Trace(columns, trace.signals)


def columns_of(swept: Sweep) -> dict[str, NDArray[Any]]:
    """Returns the columns of a sweep without those of its bookkeeping. Raises the error of its first variant that
    has one."""
    for error in swept["error"]:
        if error:
            kind, _, message = str(error).partition(": ")
            raise getattr(errors, kind, NarxError)(message or kind)
    return {name: swept[name] for name in swept if name not in ("variant", "seed", "error")}


def floats(name: str, values: Iterable[float]) -> list[float]:
    """Returns the numbers of a list. Raises ParameterError for anything else."""
    found = [_core.number(name, value) for value in given.several(name, values)]
    if not found:
        raise ParameterError(f"{name}: must have a value")
    return found


def points(name: str, count: int) -> int:
    """Returns a number of points."""
    return _core.whole_number(name, count, 1, 1000)


def share(part: float, whole: float) -> float:
    """Returns a share; NaN of no more than nothing."""
    return part / whole if whole > 0 else float("nan")


def first(time: NDArray[Any], reached: NDArray[np.bool_]) -> float:
    """Returns the first time at which something is so; NaN if it never is."""
    return float(time[int(np.argmax(reached))]) if reached.any() else float("nan")


def settled(time: NDArray[Any], values: NDArray[Any], wanted: float, band: float) -> float:
    """Returns the time from which on the values stay within a band; NaN if the last one is outside."""
    outside = np.flatnonzero(np.abs(values - wanted) > band)
    if not len(values) or (len(outside) and outside[-1] == len(values) - 1):
        return float("nan")
    return float(time[outside[-1] + 1]) if len(outside) else 0.0


def crossing(frequency: NDArray[Any], gain: NDArray[Any], level: float) -> float:
    """Returns the frequency at which the gain falls below a level, on logarithmic scales; NaN if it does not."""
    below = np.flatnonzero((gain[:-1] >= level) & (gain[1:] < level))
    if not len(below):
        return float("nan")
    place = int(below[0])
    logs, ends = np.log(gain[place : place + 2]), np.log(frequency[place : place + 2])
    return float(np.exp(np.interp(np.log(level), logs[::-1], ends[::-1])))


def draw_columns(result: Result, figure: Figure) -> None:
    """Draws each number over the first column."""
    first_name, *rest = [name for name in result if result[name].dtype.kind in "iuf"]
    axes = figure.subplots(len(rest), sharex=True, squeeze=False)[:, 0]
    for name, axis in zip(rest, axes, strict=True):
        axis.plot(result[first_name], result[name], "o", markersize=3)
        label(axis, result, name)
    axes[-1].set_xlabel(titled(result, first_name))


def draw_map(result: Result, figure: Figure) -> None:
    """Draws lines of equal efficiency over speed and torque; points that the drive does not hold are crosses."""
    axis = figure.subplots()
    good = result["outcome"] == "running"
    speed, load, efficiency = (result[name][good] for name in ("setpoint", "load", "efficiency"))
    if len(np.unique(speed)) > 1 and len(np.unique(load)) > 1 and good.sum() > 3:
        filled = axis.tricontourf(speed, load, np.nan_to_num(efficiency), levels=20, cmap="viridis")
        figure.colorbar(filled, label="efficiency, load over supply")
    axis.plot(speed, load, "k.", markersize=4, label="held")
    axis.plot(result["setpoint"][~good], result["load"][~good], "rx", label="not held")
    axis.set_xlabel("speed [rpm]")
    axis.set_ylabel("load torque [N m]")
    axis.legend(loc="upper right", fontsize="small")


def draw_steps(result: Result, figure: Figure) -> None:
    """Draws speed, torque and current over time."""
    axes = figure.subplots(3, sharex=True)
    for names, axis in zip((("setpoint", "speed"), ("torque",), ("peak_current",)), axes, strict=True):
        for name in names:
            axis.plot(result["time"], result[name], linewidth=0.9, label=name)
        label(axis, result, names[-1])
    axes[0].legend(fontsize="small")
    axes[-1].set_xlabel("time [s]")


def draw_bode(result: Result, figure: Figure) -> None:
    """Draws gain and phase over frequency, of the closed and of the open loop."""
    gain, phase = figure.subplots(2, sharex=True)
    for prefix, text in (("", "closed"), ("loop_", "open")):
        gain.loglog(result["frequency"], result[f"{prefix}gain"], "o-", markersize=3, label=text)
        phase.semilogx(result["frequency"], result[f"{prefix}phase"], "o-", markersize=3, label=text)
    gain.axhline(1.0, color="grey", linewidth=0.8)
    phase.axhline(-180.0, color="grey", linewidth=0.8)
    for axis, text in ((gain, "gain"), (phase, "phase [deg]")):
        axis.set_ylabel(text)
        axis.grid(alpha=0.3, which="both")
    gain.legend(fontsize="small")
    phase.set_xlabel("frequency [Hz]")


def titled(result: Result, name: str) -> str:
    """Returns a name with its unit."""
    unit = result.units.get(name, "")
    return f"{name} [{unit}]" if unit else name


def label(axis: Axes, result: Result, name: str) -> None:
    """Labels an axis."""
    axis.set_ylabel(titled(result, name))
    axis.grid(alpha=0.3)


