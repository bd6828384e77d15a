"""What a notifier of python-can calls."""

import time
from collections.abc import Callable

import can


class Listener(can.Listener):
    """Passes on what is heard, and why nothing more is."""

    def __init__(self, hear: Callable[[can.Message], None], fail: Callable[[Exception], None]) -> None:
        self._hear = hear
        self._fail = fail

    def on_message_received(self, msg: can.Message) -> None:
        """A message has come."""
        self._hear(msg)

    def on_error(self, exc: Exception) -> None:
        """The bus cannot be read any more."""
        self._fail(exc)
        # The notifier tries again at once, and an adapter that is gone will say the same.
        time.sleep(0.1)
