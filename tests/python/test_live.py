"""A plot that grows while a bench runs: in the kernel of a notebook, and refused outside of one."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

import narx

CELL = """
import narx
bench = narx.Bench("ec45-flat-50w-18v", mode="hall")
bench.drive.start(2000, wait=False)
trace = bench.live(0.5, "speed", "setpoint", "current_a", refresh=0.1)
assert list(trace) == ["time", "speed", "setpoint", "current_a"] and len(trace) == 500
other = narx.Bench("ec45-flat-50w-18v", mode="hall")
other.drive.start(2000, wait=False)
same = other.run(0.5, signals=["speed"], every=10)
assert (trace["speed"] == same["speed"]).all() and (trace.time == same.time).all()
assert narx.replay(trace.recording()).digest == bench.digest
"""


class Client(NotebookClient):
    """A client that keeps the pictures as they come."""

    def __init__(self, notebook: nbformat.NotebookNode, folder: Path) -> None:
        super().__init__(notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(folder)}})
        self.pictures: list[bytes] = []

    def process_message(self, msg: dict[str, Any], *arguments: Any) -> Any:
        if msg["msg_type"] in ("display_data", "update_display_data"):
            self.pictures.append(base64.b64decode(msg["content"]["data"]["image/png"]))
        return super().process_message(msg, *arguments)


def test_a_notebook_shows_one_picture_that_grows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("JUPYTER_PREFER_ENV_PATH", "1")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CELL)])  # type: ignore[no-untyped-call]
    client = Client(notebook, tmp_path)
    client.execute()
    assert len(set(client.pictures)) == len(client.pictures) == 5
    outputs = notebook.cells[0].outputs
    assert [output.output_type for output in outputs] == ["display_data"]
    assert base64.b64decode(outputs[0].data["image/png"]) == client.pictures[-1]


def test_arguments_are_checked_before_anything_runs(bench: narx.Bench) -> None:
    for arguments, options, error, message in [
        ((0.1,), {}, narx.RefusedError, "there is no notebook here"),
        ((0.1, "sped"), {}, narx.SignalError, 'did you mean "speed"'),
        ((-1.0,), {}, narx.ParameterError, "seconds -1 s"),
        ((1.0,), {"refresh": 0.0}, narx.ParameterError, "refresh 0 s"),
        ((600.0,), {"refresh": 0.1}, narx.ParameterError, "refresh 0.1 s: must be 0.6 s or more, for 1000 pictures in 600 s"),
        ((1.0,), {"every": 0}, narx.ParameterError, "every 0"),
    ]:  # fmt: skip
        with pytest.raises(error, match=message):
            bench.live(*arguments, **options)  # type: ignore[arg-type]
    assert bench.time == 0.0
