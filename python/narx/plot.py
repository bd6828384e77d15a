"""Plots of traces with matplotlib."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from narx._core import State
from narx.extras import need

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from narx.trace import Trace

PANELS = [
    ["setpoint", "speed"],
    ["electrical_setpoint", "electrical_speed_hall", "electrical_speed_sensorless"],
    ["current_a", "current_b", "current_c", "bus_current", "bus_current_measured"],
    ["duty"],
]
"""Panels of a run when no signals are given."""
ROWS = 20_000
"""Longest signal that is drawn whole. Longer ones are drawn by the smallest and largest value of each of half
as many stretches."""
LABEL = 22
"""Number of characters in a line of a label beside a panel; longer labels are wrapped."""
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
CROSSINGS = {
    1: ("accepted", "#2e7d32"),
    2: ("too early", "#f9a825"),
    3: ("not seen", "#c62828"),
    4: ("hidden", "#6a1b9a"),
    5: ("coasting", "#1565c0"),
}
"""Outcomes of a step's zero crossing (parameter 287), with label and colour. A hidden one is hidden by
demagnetisation; a coasting one was observed while the bridge was off."""
SENSORLESS = (State.OPEN_LOOP, State.SENSORLESS_CLOSED_LOOP, State.SENSORLESS_AUTO_RESTART)


def plot(trace: Trace, signals: Iterable[str] = ()) -> Figure:
    """Draws one panel for each unit of the signals. Bands behind them show the drive's states, if the trace
    has them. A run without sensors also shows the outcome of each zero crossing."""
    need("matplotlib")
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    chosen = list(signals)
    panels = by_unit(trace, chosen) if chosen else [[name for name in panel if name in trace] for panel in PANELS]
    panels = [panel for panel in panels if panel] or by_unit(trace, [name for name in trace if name != "time"])
    time, kinds = crossings(trace) if "crossing" in (chosen or trace) else (np.empty(0), np.empty(0, np.int64))
    if len(time):
        panels = [panel for panel in panels if panel != ["crossing"]]
    heights = [2.0] * len(panels) + [1.0] * bool(len(time))
    figure = shown(Figure(figsize=(9.0, 1.0 + sum(heights)), layout="constrained"))
    axes = figure.subplots(len(heights), sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    units = trace.signals
    if len(time):
        strip(axes[-1], time, kinds)
    for panel, axis in zip(panels, axes, strict=False):
        for name in panel:
            style = "steps-post" if is_code(trace[name], units[name]) else "default"
            axis.plot(*envelope(trace.time, trace[name]), label=name, linewidth=0.9, drawstyle=style)
        unit = units[panel[0]]
        label = f"{panel[0]}{f' [{unit}]' if unit else ''}" if len(panel) == 1 else f"[{unit}]"
        axis.set_ylabel(textwrap.fill(label, LABEL))
        axis.grid(alpha=0.3)
        axis.margins(x=0.0)
        if len(panel) > 1:
            # The legend is above the panel, where it hides no curve.
            axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(panel), fontsize="small", frameon=False, borderpad=0.0)
        if "state" in trace:
            bands(axis, trace.time, trace["state"])
    axes[-1].set_xlabel("time [s]")
    if "state" in trace:
        seen = [State(int(state)) for state in np.unique(trace["state"])]
        patches = [Patch(color=STATES[state], alpha=0.4, label=words(state)) for state in seen]
        figure.legend(handles=patches, loc="outside upper center", ncols=len(seen), fontsize="small", frameon=False)
    return figure


def shown(figure: Figure) -> Figure:
    """Returns the figure, which a notebook now shows. Notebooks show only figures of pyplot by themselves, and
    those stay open until they are closed."""
    figure._repr_png_ = partial(png, figure)  # type: ignore[attr-defined]
    return figure


def png(figure: Figure) -> bytes:
    """Renders a figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def crossings(trace: Trace) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Returns the times, s, and outcomes (`CROSSINGS`) of the steps' zero crossings, where the drive runs
    without sensors.

    An accepted crossing has the time of the tick that saw it. A step with the same outcome as the one before
    has the time of its end.
    """
    missing = [name for name in ("crossing", "crossing_margin", "step", "state") if name not in trace]
    if missing or len(trace) < 2:
        return np.empty(0), np.empty(0, np.int64)
    kind = trace["crossing"]
    news = (np.diff(kind) != 0) | (np.diff(trace["crossing_margin"]) != 0)
    ends = np.flatnonzero(np.diff(trace["step"]))
    told = np.cumsum(news)
    silent = ends[1:][told[ends[1:]] == told[ends[:-1]]]
    rows = np.union1d(np.flatnonzero(news) + 1, silent)
    rows = rows[(kind[rows] > 0) & np.isin(trace["state"][rows], SENSORLESS)]
    return trace.time[rows], kind[rows].astype(np.int64)


def strip(axis: Axes, time: NDArray[np.float64], kinds: NDArray[np.int64]) -> None:
    """Draws a line of marks for each outcome of a zero crossing."""
    seen = [kind for kind in CROSSINGS if (kinds == kind).any()]
    for line, kind in enumerate(seen):
        moments = time[kinds == kind]
        axis.plot(moments, np.full(len(moments), -line), "|", color=CROSSINGS[kind][1], markersize=7.0)
    axis.set_yticks([-line for line in range(len(seen))], [CROSSINGS[kind][0] for kind in seen], fontsize="small")
    axis.set_ylim(0.6 - len(seen), 0.6)
    axis.set_title("zero crossings", loc="left", fontsize="small", pad=2.0)


def by_unit(trace: Trace, names: list[str]) -> list[list[str]]:
    """Groups signals of the same unit, which share a panel."""
    panels: dict[str, list[str]] = {}
    for name in names:
        trace[name]  # Raises an error that names a signal which does not exist.
        panels.setdefault(trace.signals[name] or name, []).append(name)
    return list(panels.values())


def is_code(values: NDArray[np.float32 | np.float64], unit: str) -> bool:
    """Returns whether a signal is a count or a code, which has no values in between."""
    return not unit and bool(np.all(values == np.rint(values)))


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
    """Returns the values, or if there are too many, the smallest and largest in each of a number of
    stretches, so that no peak is lost."""
    if len(values) <= ROWS:
        return time, values
    width = -(-len(values) // (ROWS // 2))
    whole = len(values) // width * width
    stretches = values[:whole].reshape(-1, width)
    pairs = np.stack([stretches.min(axis=1), stretches.max(axis=1)], axis=1).ravel()
    moments = np.repeat(time[:whole:width], 2)
    return np.concatenate([moments, time[whole:]]), np.concatenate([pairs, values[whole:]])


def words(state: State) -> str:
    """Returns a state's name in words."""
    return state.name.replace("_", " ").capitalize()
