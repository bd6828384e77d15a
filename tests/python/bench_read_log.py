"""Measures the speed of `narx.read_log`, compared with python-can's reader and cantools on the same file.

Prints the ratio and both rates in frames a second, then the same in words. The log repeats the traffic of a
virtual drive and its master.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import can
import cantools
import numpy as np
from cantools.database.can import Database

import narx
from narx import _core

FRAMES = 1_000_000
ROUNDS = 3
"""Runs of each reader, in turns.

Other work on the machine can only slow a run down, so the fastest run counts.
"""

Columns = dict[str, dict[str, np.ndarray[tuple[int], np.dtype[np.float64]]]]


def frames() -> list[tuple[float, int, bytes]]:
    """Returns two seconds of a drive's bus.

    The drive sends its broadcasts, and a master sends a set-point every 50 ms.
    """
    bus = _core.VirtualBus(narx.Motor.preset("ec45-flat-50w-18v"), 18.0, mode="hall")
    database = cantools.database.load_string(narx.dbc())
    assert isinstance(database, Database)
    setpoint, request = (database.get_message_by_name(name).frame_id for name in ("MOTOR_CMD_SET", "REQUEST_WORD"))
    seen = []
    for step in range(1, 41):
        bus.send(0, setpoint, True, False, (100 * step).to_bytes(2, "big") + bytes(6))
        bus.send(0, request, True, False, bytes([0, 0, 0, step > 20, 0, 0, 0, 0]))
        seen += bus.advance(step * 0.05, False)
    return [(at, number, data) for at, _, (number, _, _, data) in seen]


def write(path: Path, pattern: list[tuple[float, int, bytes]]) -> None:
    """Writes the pattern again and again until the log has `FRAMES` frames."""
    duration = pattern[-1][0] + 1e-3
    with path.open("w") as file:
        for row in range(FRAMES):
            turn, place = divmod(row, len(pattern))
            at, number, data = pattern[place]
            file.write(f"({1436509052.0 + turn * duration + at:.6f}) can0 {number:08X}#{data.hex().upper()}\n")


def ours(path: Path) -> Columns:
    """Reads the log with narx: a column for each signal of each message."""
    log = narx.read_log(path)
    assert len(log) == FRAMES and not log.errors
    return {name: dict(log[name].items()) for name in log}


def theirs(path: Path) -> Columns:
    """Reads the log with python-can and cantools, into the same columns."""
    database = cantools.database.load_string(narx.dbc())
    assert isinstance(database, Database)
    names = {message.frame_id: message.name for message in database.messages}
    columns: dict[str, dict[str, list[float]]] = {}
    for message in can.CanutilsLogReader(path):
        decoded = database.decode_message(message.arbitration_id, message.data, decode_choices=False)  # type: ignore[arg-type]
        table = columns.setdefault(names[message.arbitration_id], {})
        table.setdefault("time", []).append(message.timestamp)
        for name, value in decoded.items():  # type: ignore[union-attr]
            table.setdefault(name, []).append(value)  # type: ignore[arg-type]
    return {name: {signal: np.array(values) for signal, values in table.items()} for name, table in columns.items()}


def timed(read: Callable[[Path], Columns], path: Path) -> tuple[float, Columns]:
    """Calls `read`, and returns the seconds that it took and its result."""
    begun = time.perf_counter()
    columns = read(path)
    return time.perf_counter() - begun, columns


def assert_same(ours: Columns, theirs: Columns) -> None:
    """Asserts that both readers have found the same values."""
    folded = {message: {fold(name): column for name, column in table.items()} for message, table in ours.items()}
    assert ours.keys() == theirs.keys()
    for message, table in theirs.items():
        for name, column in table.items():
            assert np.allclose(folded[message][fold(name)], column, rtol=1e-12, atol=0.0), (message, name)


def fold(name: str) -> str:
    """Returns letters and digits only: the names in the data base have `_` between them."""
    return "".join(filter(str.isalnum, name)).casefold()


def main() -> None:
    """Measures both readers and prints the results."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "million.log"
        write(path, frames())
        seconds: dict[str, list[float]] = {"ours": [], "theirs": []}
        for turn in range(ROUNDS):
            for name, read in (("ours", ours), ("theirs", theirs)):
                took, columns = timed(read, path)
                seconds[name].append(took)
                if turn == 0 and name == "ours":
                    first = columns
                elif turn == 0:
                    assert_same(first, columns)
    own, reference = FRAMES / min(seconds["ours"]), FRAMES / min(seconds["theirs"])
    print(f"{own / reference:.1f} {own:.0f} {reference:.0f}")
    print(f"{FRAMES} frames: {own:.0f} a second, {own / reference:.1f} times python-can with cantools ({reference:.0f})")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
