"""Pictures of traces with matplotlib."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from narx._core import State

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from narx.trace import Trace

PANELS = [["setpoint", "speed"], ["current_a", "current_b", "current_c", "bus_current"], ["duty"]]
"""What is drawn of a run when nothing is chosen."""
ROWS = 20_000
"""More rows than this are drawn by the smallest and largest value of each of half as many stretches."""
STATES = {
    State.INITIALIZATION: "#9e9e9e",
    State.STANDBY: "#bdbdbd",
    State.ROTOR_LOCK: "#ffb74d",
    State.OPEN_LOOP: "#fff176",
    State.SENSORLESS_CLOSED_LOOP: "#aed581",
    State.HALL_CLOSED_LOOP: "#81c784",
    State.FAULT: "#e57373",
    State.SENSORLESS_AUTO_RESTART: "#ff8a65",
}


def plot(trace: Trace, signals: Iterable[str] = ()) -> Figure:
    """One panel for each unit of the signals; bands behind them are the drive's states, where the trace has those."""
    from matplotlib.figure import Figure

    chosen = list(signals)
    panels = by_unit(trace, chosen) if chosen else [[name for name in panel if name in trace] for panel in PANELS]
    panels = [panel for panel in panels if panel] or by_unit(trace, [name for name in trace if name != "time"])
    figure = Figure(figsize=(9.0, 1.0 + 2.0 * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), sharex=True, squeeze=False)[:, 0]
    units = trace.signals
    for panel, axis in zip(panels, axes, strict=True):
        for name in panel:
            axis.plot(*envelope(trace.time, trace[name]), label=name, linewidth=0.9)
        unit = units[panel[0]]
        axis.set_ylabel(f"{panel[0]}{f' [{unit}]' if unit else ''}" if len(panel) == 1 else f"[{unit}]")
        axis.grid(alpha=0.3)
        axis.margins(x=0.0)
        if len(panel) > 1:
            axis.legend(loc="upper right", ncols=len(panel), fontsize="small")
        if "state" in trace:
            bands(axis, trace.time, trace["state"])
    axes[-1].set_xlabel("time [s]")
    if "state" in trace:
        seen = [State(int(state)) for state in np.unique(trace["state"])]
        patches = [axes[0].axvspan(0, 0, color=STATES[state], alpha=0.4, label=words(state)) for state in seen]
        figure.legend(handles=patches, loc="outside upper center", ncols=len(seen), fontsize="small", frameon=False)
    return figure


def by_unit(trace: Trace, names: list[str]) -> list[list[str]]:
    """Signals of the same unit share a panel."""
    panels: dict[str, list[str]] = {}
    for name in names:
        trace[name]  # Names the one that does not exist.
        panels.setdefault(trace.signals[name] or name, []).append(name)
    return list(panels.values())


def bands(axis: Axes, time: NDArray[np.float64], states: NDArray[np.float32 | np.float64]) -> None:
    """Colours the background by the state."""
    if len(states) == 0:
        return
    edges = np.flatnonzero(np.diff(states)) + 1
    for first, last in zip([0, *edges], [*edges, len(states) - 1], strict=True):
        axis.axvspan(time[first], time[last], color=STATES[State(int(states[first]))], alpha=0.25, linewidth=0)


def envelope(
    time: NDArray[np.float64], values: NDArray[np.float32 | np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float32 | np.float64]]:
    """The values, or where there are too many to be seen their smallest and largest in each of a number of stretches: no peak is lost."""
    if len(values) <= ROWS:
        return time, values
    width = -(-len(values) // (ROWS // 2))
    whole = len(values) // width * width
    stretches = values[:whole].reshape(-1, width)
    pairs = np.stack([stretches.min(axis=1), stretches.max(axis=1)], axis=1).ravel()
    moments = np.repeat(time[:whole:width], 2)
    return np.concatenate([moments, time[whole:]]), np.concatenate([pairs, values[whole:]])


def words(state: State) -> str:
    """A state's name as people write it."""
    return state.name.replace("_", " ").capitalize()
