"""How the time of a drive passes while somebody waits: on a bench by simulating, on a bus by the clock."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from narx import _core
from narx.errors import BusError, NoAnswerError

if TYPE_CHECKING:
    import can

    from narx.description import Description

POLL = 0.001
"""On a bench, simulated time between two looks at what is waited for, s."""


class Link(ABC):
    """A master and its time."""

    def __init__(self, master: _core.Master) -> None:
        self.master = master
        self.description: Description | None = None
        """What the drive says of itself; `None` where that is not known, or known to be what this package says of its own drive."""
        self.is_described = False
        """Whether the drive was asked for that."""
        self.downloads = False
        """Words of a download are expected."""
        self._chunks: list[tuple[int, bytes]] = []

    @property
    @abstractmethod
    def now(self) -> float:
        """The master's time, s."""

    @abstractmethod
    def wait(self, done: Callable[[], bool], timeout: float) -> bool:
        """Lets time pass until `done`, at most `timeout` s: whether it was done."""

    def start(self, rpm: float) -> None:
        """Asks for a speed as soon as the drive takes a start."""
        self.master.start(rpm)

    @property
    def start_pending(self) -> bool:
        """Whether a start was asked for of which the drive does not yet know."""
        return self.master.start_pending

    def stop(self) -> None:
        """Asks for Standby."""
        self.master.stop()

    def take_chunks(self) -> list[tuple[int, bytes]]:
        """Words of the download that have come: their place, and their bytes."""
        chunks, self._chunks = self._chunks + self.master.poll_chunks(), []
        return chunks

    def wake(self) -> None:
        """Something new is to be sent."""

    def close(self) -> None:
        """Lets go of the bus."""


class FreeLink(Link):
    """A master that is on no bench: a start waits in the link until the drive takes it."""

    def __init__(self, master: _core.Master) -> None:
        super().__init__(master)
        self._starter = Starter(master)

    def start(self, rpm: float) -> None:
        self._starter.start(rpm)
        self.wake()

    @property
    def start_pending(self) -> bool:
        return self._starter.pending

    def stop(self) -> None:
        self._starter.cancel()
        self.master.stop()
        self.wake()


class BenchLink(Link):
    """The bus of a bench: whoever waits simulates."""

    def __init__(self, bench: _core.Bench) -> None:
        super().__init__(bench.master)
        self._bench = bench
        # Its drive is this package's own.
        self.is_described = True

    @property
    def now(self) -> float:
        return self._bench.time

    def wait(self, done: Callable[[], bool], timeout: float) -> bool:
        end = self.now + timeout
        while not done():
            if self.now >= end:
                return False
            self._bench.advance(POLL)
        return True


class BusLink(FreeLink):
    """A bus of python-can. Frames come by a notifier's thread and go by one of its own, so that set-points do not stop when
    nobody waits."""

    def __init__(self, bus: can.BusABC, master: _core.Master) -> None:
        super().__init__(master)
        # python-can is an extra.
        import can

        from narx._listener import Listener

        self._bus = bus
        self._begin = time.monotonic()
        self._changed = threading.Condition()
        self._error: Exception | None = None
        self._closed = False
        known = can.Notifier.find_instances(bus)
        self._own_notifier = not known
        self._notifier = known[0] if known else can.Notifier(bus, [], timeout=0.1)
        self._listener = Listener(self._hear, self._fail)
        self._notifier.add_listener(self._listener)
        self._thread = threading.Thread(target=self._talk, name="narx master", daemon=True)
        self._thread.start()

    @property
    def now(self) -> float:
        return time.monotonic() - self._begin

    def wait(self, done: Callable[[], bool], timeout: float) -> bool:
        end = self.now + timeout
        with self._changed:
            while not done():
                self._check()
                left = end - self.now
                if left <= 0.0:
                    return False
                # Time-outs of the master end a wait without a frame.
                self._changed.wait(min(left, 0.05))
        return True

    def wake(self) -> None:
        self._check()
        with self._changed:
            self._changed.notify_all()

    def close(self) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._thread.join()
        if self._own_notifier:
            self._notifier.stop()
        else:
            self._notifier.remove_listener(self._listener)

    def _check(self) -> None:
        if self._error is not None:
            raise BusError(f"the bus does not work any more: {self._error}") from self._error
        if self._closed:
            raise BusError("the drive's connection was closed")

    def _hear(self, message: can.Message) -> None:
        if message.is_error_frame or message.is_fd:
            return
        with self._changed:
            handle(self.master, message, self.now)
            if self.downloads:
                # The master has room for a few, and whoever waits for them may come late: what is dropped is sent once more.
                self._chunks += self.master.poll_chunks()
            self._changed.notify_all()

    def _fail(self, error: Exception) -> None:
        """Whatever the adapter raises is for who waits next."""
        with self._changed:
            self._error = self._error or error
            self._changed.notify_all()

    def _talk(self) -> None:
        with self._changed:
            while not self._closed:
                try:
                    self._starter.poll(self.now)
                    send_due(self.master, self._bus, self.now)
                except Exception as error:
                    self._fail(error)
                    return
                due = self.master.next_poll(self.now) - self.now
                self._changed.wait(min(max(due, 0.0005), 0.05))


class SteppedLink(FreeLink):
    """A bus whose time passes when it is read (`can.Bus(interface="narx", realtime=False)`): whoever waits reads it."""

    def __init__(self, bus: Any, master: _core.Master) -> None:
        super().__init__(master)
        self._bus = bus

    @property
    def now(self) -> float:
        return float(self._bus.time)

    def wait(self, done: Callable[[], bool], timeout: float) -> bool:
        end = self.now + timeout
        while not done():
            now = self.now
            if now >= end:
                return False
            self._starter.poll(now)
            send_due(self.master, self._bus, now)
            due = min(self.master.next_poll(now) - now, end - now, 0.01)
            message = self._bus.recv(max(due, 0.0005))
            if message is not None:
                handle(self.master, message, self.now)
        return True


class Starter:
    """A start that waits until the drive takes it: it must have been asked for Standby since it last stopped or booted."""

    def __init__(self, master: _core.Master) -> None:
        self._master = master
        self._rpm: float | None = None
        self._asked: float | None = None

    @property
    def pending(self) -> bool:
        return self._rpm is not None

    def start(self, rpm: float) -> None:
        self._rpm, self._asked = rpm, None

    def cancel(self) -> None:
        self._rpm = None

    def poll(self, now: float) -> None:
        state = self._master.state
        if self._rpm is None or state is None:
            return
        if state in (_core.State.INITIALIZATION, _core.State.STANDBY):
            if self._asked is None:
                self._master.stop()
            if self._asked is None or state is _core.State.INITIALIZATION:
                self._asked = now
            if now < self._asked + 2 * self._master.setpoint_period:
                return
        self._master.start(self._rpm)
        self._rpm = None


def handle(master: _core.Master, message: can.Message, now: float) -> None:
    """Gives a frame to the master."""
    data = bytes(message.dlc) if message.is_remote_frame else bytes(message.data)
    master.handle_frame(now, message.arbitration_id, message.is_extended_id, message.is_remote_frame, data)


def send_due(master: _core.Master, bus: can.BusABC, now: float) -> None:
    """Sends what is due."""
    import can

    while (frame := master.poll_frame(now)) is not None:
        number, extended, remote, data = frame
        bus.send(
            can.Message(
                arbitration_id=number, is_extended_id=extended, is_remote_frame=remote, dlc=len(data),
                data=None if remote else data,
            )
        )  # fmt: skip


def ask(link: Link, begin: Callable[[], None], timeout: float = 5.0) -> int:
    """Makes a request and waits for its answer."""
    answer: list[int] = []

    def done() -> bool:
        value = link.master.poll_answer()
        if value is not None:
            answer.append(value)
        return bool(answer)

    begin()
    link.wake()
    if not link.wait(done, timeout):
        raise NoAnswerError(f"the drive does not answer within {timeout:g} s")
    return answer[0]
