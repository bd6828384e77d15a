"""The command `narx`: the functions of the package as shell commands, with one file for each group of
commands."""

from __future__ import annotations

import sys
import warnings
from typing import TextIO

import narx
from narx.cli import bench, coefficients, decode, live, log, motor, params, replay, scope, sweep, update  # noqa: F401
from narx.cli.app import app, err


def tell(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None, line: str | None = None
) -> None:
    """Prints a warning in one line."""
    err.print(f"narx: {message}", highlight=False, markup=False, soft_wrap=True)


def main() -> None:
    """Runs a command. An error of narx is printed in one line, with exit code 2."""
    warnings.showwarning = tell
    try:
        app(prog_name="narx")
    except (narx.NarxError, OSError) as error:
        err.print(f"narx: {error}", highlight=False, markup=False, soft_wrap=True)
        sys.exit(2)
    except ImportError as error:
        err.print(f"narx: {error}: pip install 'narx\\[can]'", highlight=False)
        sys.exit(2)
