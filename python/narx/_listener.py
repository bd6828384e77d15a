"""Listener for a notifier of python-can."""

import time
from collections.abc import Callable

import can


class Listener(can.Listener):
    """Passes on received messages, and the error that ends reception."""

    def __init__(self, receive: Callable[[can.Message], None], fail: Callable[[Exception], None]) -> None:
        self._receive = receive
        self._fail = fail

    def on_message_received(self, msg: can.Message) -> None:
        """Passes on a received message."""
        self._receive(msg)

    def on_error(self, exc: Exception) -> None:
        """Passes on the error after which the bus cannot be read any more."""
        self._fail(exc)
        # The notifier tries again at once, and an adapter that was removed would raise the same error in a
        # tight loop.
        time.sleep(0.1)
