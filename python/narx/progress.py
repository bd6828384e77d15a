"""Progress bars of tqdm."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from narx.errors import MissingError
from narx.extras import need

DELAY = 1.0
"""A bar is shown once its work has taken this long, s."""


@contextmanager
def bar(total: float | None, unit: str, progress: bool | None) -> Iterator[Callable[[float], Any]]:
    """Shows a progress bar; yields the function that advances it. `None` shows it if tqdm is installed and the
    output is a terminal or a notebook; True raises MissingError without tqdm."""
    hidden = progress is False or (progress is None and not is_watched())
    try:
        tqdm = None if hidden else need("tqdm.auto").tqdm
    except MissingError:
        if progress:
            raise
        tqdm = None
    if tqdm is None:
        yield lambda _: None
        return
    style = "{l_bar}{bar}| {n:.4g}/{total:.4g} {unit} [{elapsed}<{remaining}]" if total else None
    with tqdm(
        total=total, unit=unit, bar_format=style, delay=0.0 if progress else DELAY, disable=None if progress is None else False
    ) as shown:
        yield shown.update


def is_watched() -> bool:
    """Returns whether the output is a terminal or a notebook."""
    return "ipykernel" in sys.modules or (sys.stderr is not None and sys.stderr.isatty())


@contextmanager
def counted(unit: str, progress: Callable[[int, int], None] | bool | None) -> Iterator[Callable[[int, int], None] | None]:
    """Yields the function to call with what is done and the total: `progress` if it is one, else that of a
    progress bar, as of `bar`."""
    if callable(progress):
        yield progress
        return
    with bar(1.0, unit, progress) as step:
        last = 0.0

        def tell(done: int, total: int) -> None:
            nonlocal last
            share = done / total if total else 1.0
            step(share - last)
            last = share

        yield tell
