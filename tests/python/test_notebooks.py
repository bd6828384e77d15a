"""The notebooks run with this package from top to bottom.

They show a picture after each plot, and are kept without output.
"""

import base64
import re
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).parents[2] / "python" / "notebooks"
PICTURES = {
    "01-first-spin": 3,
    "02-speed-loop": 3,
    "03-sensorless-start": 2,
    "04-hall-calibration": 2,
    "05-fault": 3,
    "06-field-log": 1,
    "07-shaft-displacement": 3,
    "08-sweep-on-dask": 1,
    "09-motor-without-data-sheet": 3,
}
"""Number of pictures that each notebook shows."""
PLOTS = re.compile(r"\.(plot|subplots)\(")
CELL_MAX = 300
"""Time-out of a cell, s; only a cell that hangs takes that long."""
METADATA = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}


def pictures(cell: nbformat.NotebookNode) -> list[bytes]:
    """Returns the pictures that a cell shows."""
    return [base64.b64decode(output.data["image/png"]) for output in cell.get("outputs", ()) if "image/png" in output.get("data", ())]


def width_and_height(png: bytes) -> tuple[int, int]:
    """Returns the width and height of a picture, in pixels."""
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    return int.from_bytes(png[16:20]), int.from_bytes(png[20:24])


def test_every_notebook_is_tested_and_listed() -> None:
    names = sorted(path.stem for path in ROOT.glob("*.ipynb"))
    assert names == sorted(PICTURES)
    listed = re.findall(r"\(([^)]+)\.ipynb\)", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert listed == names


@pytest.mark.parametrize("name", PICTURES)
def test_notebook(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Use the kernel of this environment, whatever kernels the user has configured.
    monkeypatch.setenv("JUPYTER_PREFER_ENV_PATH", "1")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    work = tmp_path / "work"
    work.mkdir()
    notebook = nbformat.read(ROOT / f"{name}.ipynb", as_version=4)  # type: ignore[no-untyped-call]
    claims = notebook.cells[-1]
    assert claims.source.startswith("# The results of this notebook, as limits.\n") and "\nassert " in claims.source
    NotebookClient(notebook, timeout=CELL_MAX, kernel_name="python3", resources={"metadata": {"path": str(work)}}).execute()
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert len(pictures(cell)) == bool(PLOTS.search(cell.source)), cell.source
            told = "".join(output.text for output in cell.outputs if output.get("name") == "stderr")
            assert "Warning" not in told, told
    shown = [png for cell in notebook.cells for png in pictures(cell)]
    assert len(shown) == PICTURES[name]
    for png in shown:
        width, height = width_and_height(png)
        assert 400 <= width <= 1200 and 300 <= height <= 1200 and len(png) > 10_000


def test_notebooks_are_kept_without_what_they_have_shown() -> None:
    """The committed notebooks have no output. docs/COMMANDS.md says how to correct a difference."""
    paths = sorted(ROOT.glob("*.ipynb"))
    done = subprocess.run([sys.executable, "-m", "nbstripout", "--verify", *map(str, paths)], check=False)
    assert done.returncode == 0
    for path in paths:
        text = path.read_text(encoding="utf-8")
        notebook = nbformat.reads(text, as_version=nbformat.NO_CONVERT)  # type: ignore[no-untyped-call]
        nbformat.validate(notebook)
        assert (notebook.nbformat, notebook.nbformat_minor, notebook.metadata) == (4, 5, METADATA), path.name
        assert text == nbformat.writes(notebook) + "\n", path.name  # type: ignore[no-untyped-call]
        assert 6 <= len(notebook.cells) <= 18, path.name
