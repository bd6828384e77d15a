"""The command `narx`: the functions of the package as shell commands, with one file for each group of
commands."""

from __future__ import annotations

import sys
import warnings
from typing import TextIO

import narx
from narx.cli import bench, coefficients, decode, fmu, live, log, motor, params, replay, scope, serve, sweep, update  # noqa: F401
from narx.cli.app import app, err


def tell(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None, line: str | None = None
) -> None:
    """Prints a warning in one line."""
    err.print(f"narx: {message}", highlight=False, markup=False, soft_wrap=True)


def refuse_other_digits(arguments: list[str]) -> None:
    """Raises ParameterError for a number in digits other than 0 to 9, which Python would take as well."""
    for argument in arguments:
        text = argument.rpartition("=")[2]
        if not text.isascii() and is_number(text):
            raise narx.ParameterError(f"{argument}: must have digits 0 to 9")


def is_number(text: str) -> bool:
    """Returns whether Python reads the text as a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def main() -> None:
    """Runs a command. An error of narx is printed in one line, with exit code 2."""
    warnings.showwarning = tell
    try:
        refuse_other_digits(sys.argv[1:])
        app(prog_name="narx")
    except (narx.NarxError, OSError) as error:
        err.print(f"narx: {error}", highlight=False, markup=False, soft_wrap=True)
        sys.exit(2)
