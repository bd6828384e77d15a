"""Replays recordings: `[--ticks N] FILE...` prints `STEM TICKS DIGEST RECORDED` for each file, in order.

With `--ticks N` only the first N ticks run; RECORDED is then `-`, followed by the outputs of the last tick.
"""

import argparse
import sys
from pathlib import Path

import narx


def line(path: Path, ticks: int | None) -> str:
    """Returns the line with the result of one file's replay."""
    replay = narx.replay(path, until=ticks)
    recorded = "-" if replay.recorded_digest is None else f"{replay.recorded_digest:016x}"
    outputs = "" if ticks is None or replay.outputs is None else f" {replay.outputs}"
    return f"{path.stem} {replay.ticks} {replay.digest:016x} {recorded}{outputs}"


def main(arguments: list[str]) -> int:
    """Replays all files, and returns the exit code: 1 if any of them could not be replayed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ticks", type=int, metavar="N", help="replay the first N ticks only")
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE")
    options = parser.parse_args(arguments)
    code = 0
    for path in options.files:
        try:
            print(line(path, options.ticks))
        except (narx.NarxError, OSError) as error:
            print(f"{path.stem} error {error}")
            code = 1
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
