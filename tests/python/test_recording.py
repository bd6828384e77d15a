"""Recordings replay to the digest that they contain."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import narx
from conftest import VECTORS


def test_there_are_vectors() -> None:
    assert len(VECTORS) >= 30


def test_vector(vector: Path) -> None:
    replay = narx.replay(vector.read_bytes())
    assert replay.identical and replay.digest == replay.recorded_digest
    assert replay.ticks == len(replay) == len(replay["duty"]) > 0
    assert replay.same_behaviour and replay.label == vector.stem


def test_prefixes_lead_to_the_whole() -> None:
    whole = narx.replay(VECTORS[0])
    part = narx.replay(VECTORS[0], until=whole.ticks // 2)
    assert part.ticks == whole.ticks // 2 and part.digest != whole.digest
    assert part.identical is None and part.recorded_digest is None
    for name in part:
        assert np.array_equal(part[name], whole[name][: part.ticks], equal_nan=True)
    assert part.outputs is not None and part.outputs.startswith(f"tick {part.ticks - 1}: duty ")
    assert narx.replay(VECTORS[0], until=10**9).digest == whole.digest
    nothing = narx.replay(VECTORS[0], until=0)
    assert nothing.ticks == len(nothing) == 0 and nothing.outputs is None


def test_transcripts_of_nodes_run_again() -> None:
    files = sorted(VECTORS[0].parent.glob("transcripts/*.narxrec"))
    assert len(files) >= 10
    for file in files:
        replay = narx.replay(file)
        assert replay.identical and replay.ticks > 1000 and replay.label == file.stem
        assert list(replay) == [] and len(replay) == 0 and replay.outputs is None
        part = narx.replay(file, until=1000)
        assert part.ticks == 1000 and part.identical is None and part.digest != replay.digest


def test_bytes_paths_and_strings_are_recordings() -> None:
    path = VECTORS[0]
    digests = {narx.replay(form).digest for form in (path, str(path), path.read_bytes(), bytearray(path.read_bytes()))}
    assert len(digests) == 1
    assert narx.replay(path).recording() == path.read_bytes()


def test_damage_is_told() -> None:
    recording = VECTORS[0].read_bytes()
    with pytest.raises(narx.RecordingError, match="truncated: the file ends at byte"):
        narx.replay(recording[:-3])
    with pytest.raises(narx.RecordingError, match="not a narx recording"):
        narx.replay(b"something else")
    changed = bytearray(recording)
    changed[len(changed) // 2] ^= 1
    with pytest.raises(narx.RecordingError, match="corrupt: the check value at byte"):
        narx.replay(changed)
    with pytest.raises(FileNotFoundError, match="missing.narxrec"):
        narx.replay("missing.narxrec")
    with pytest.raises(narx.ParameterError, match="until -1: must be"):
        narx.replay(recording, until=-1)
    with pytest.raises(narx.ParameterError, match="recording 17: must be the path of a file"):
        narx.replay(17)  # type: ignore[arg-type]


def test_replayer_program(tmp_path: Path) -> None:
    broken = tmp_path / "broken.narxrec"
    broken.write_bytes(b"narxrec\n\x01")
    first, last = VECTORS[0], VECTORS[-1]

    def run(*arguments: str | Path) -> tuple[int, list[str]]:
        program = [sys.executable, str(Path(__file__).with_name("replay.py")), *map(str, arguments)]
        done = subprocess.run(program, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout.splitlines()

    code, lines = run(first, broken, last)
    assert code == 1 and len(lines) == 3
    for path, text in ((first, lines[0]), (last, lines[2])):
        replay = narx.replay(path)
        assert text == f"{path.stem} {replay.ticks} {replay.digest:016x} {replay.recorded_digest:016x}"
    assert lines[1].startswith("broken error truncated")
    code, lines = run("--ticks", "7", first)
    replay = narx.replay(first, until=7)
    assert (code, lines) == (0, [f"{first.stem} 7 {replay.digest:016x} - {replay.outputs}"])
