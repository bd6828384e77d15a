"""Links: a master and the passing of time during a call that waits, simulated on a bench, real on a bus."""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeAlias

from narx import _core
from narx.errors import BusError, NoAnswerError, RefusedError

if TYPE_CHECKING:
    import can

    from narx.bench import Bench
    from narx.description import Description

POLL = 0.001
"""Simulated time between two checks of the awaited condition on a bench, s."""


Setup: TypeAlias = tuple[int, float, float, float, int, int, int]
"""Settings of a record: channels, samples, prescaler, before; kind, signal and level of the trigger, raw."""
NO_SETUP: Setup = (0, 0, 0, 0, 0, 0, 0)


class Link(ABC):
    """A master and its time."""

    def __init__(self, master: _core.Master) -> None:
        self.master = master
        self.description: Description | None = None
        """Description of the drive; `None` while unknown, or if it is the one of this package."""
        self.is_described = False
        """True once the drive was asked for its description."""
        self.recording = threading.Lock()
        """Held while a call records with the scope or erases the log: the master does one of them at a time."""
        self.cancelled = threading.local()
        """Has `event` in a thread whose waiting is over as soon as that is set."""
        self.downloads = False
        """True while words of a download are expected."""
        self._chunks: list[tuple[int, bytes]] = []

    @property
    @abstractmethod
    def now(self) -> float:
        """The master's time, s."""

    @abstractmethod
    def wait(self, done: Callable[[], bool], timeout: float) -> bool:
        """Lets time pass until `done`, at most `timeout` s; returns whether it was done."""

    def begin(self, job: str, rpm: float | None = None) -> None:
        """Begins a job: "start" at a speed, "calibrate hall" or "reboot"."""
        self.master.begin(job, rpm)
        self.wake()

    def stop(self) -> None:
        """Requests Standby."""
        self.master.stop()
        self.wake()

    def take_chunks(self) -> list[tuple[int, bytes]]:
        """Returns the words of the download that have arrived: their place, and their bytes."""
        chunks, self._chunks = self._chunks + self.master.poll_chunks(), []
        return chunks

    def wake(self) -> None:
        """Makes the link send new frames now; called after a command or request."""

    def close(self) -> None:
        """Releases the bus."""

    def check_cancelled(self) -> None:
        """Raises CancelledError in a thread whose waiting is over."""
        event = getattr(self.cancelled, "event", None)
        if event is not None and event.is_set():
            raise CancelledError


class BenchLink(Link):
    """The bus of a bench: a call that waits runs the simulation."""

    def __init__(self, bench: Bench) -> None:
        super().__init__(bench._bench.master)
        self._bench = bench
        # The drive of a bench has the tables of this package.
        self.is_described = True

    @property
    def now(self) -> float:
        return self._bench.time

    def wait(self, done: Callable[[], bool], timeout: float) -> bool:
        end = self.now + timeout
        while not done():
            if self.now >= end:
                return False
            self._bench._courses.advance(POLL)
        return True


class BusLink(Link):
    """A bus of python-can. A notifier's thread receives frames, and the link's own thread sends them, so that
    set-points continue when no call waits."""

    def __init__(self, bus: can.BusABC, master: _core.Master) -> None:
        super().__init__(master)
        # Imported here, because python-can is an optional dependency.
        import can

        from narx._listener import Listener

        self._bus = bus
        self._begin = time.monotonic()
        self._changed = threading.Condition()
        self._error: Exception | None = None
        self._closed = False
        known = can.Notifier.find_instances(bus)
        self._own_notifier = not known
        self._listener = Listener(self._receive, self._fail)
        if known:
            self._notifier = known[0]
            self._notifier.add_listener(self._listener)
        else:
            # With its listener, because an error before one is there ends it in silence.
            self._notifier = can.Notifier(bus, [self._listener], timeout=0.1)
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
                self.check_cancelled()
                left = end - self.now
                if left <= 0.0:
                    return False
                # Woken now and then, because a time-out of the master ends a wait without a frame.
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

    @contextmanager
    def listening(self, receive: Callable[[can.Message], None]) -> Iterator[None]:
        """Passes every frame on as well, from the notifier's thread."""
        from narx._listener import Listener

        listener = Listener(receive, self._fail)
        self._notifier.add_listener(listener)
        try:
            yield
        finally:
            self._notifier.remove_listener(listener)

    def _check(self) -> None:
        if self._error is not None:
            raise BusError(f"the bus does not work any more: {self._error}") from self._error
        if self._closed:
            raise BusError("the drive's connection was closed")

    def _receive(self, message: can.Message) -> None:
        if message.is_error_frame or message.is_fd:
            return
        with self._changed:
            handle(self.master, message, self.now)
            if self.downloads:
                # The master buffers only a few chunks and requests dropped ones again; a late call would lose
                # some.
                self._chunks += self.master.poll_chunks()
            self._changed.notify_all()

    def _fail(self, error: Exception) -> None:
        """Keeps an error of the adapter; the next call that waits raises it."""
        with self._changed:
            self._error = self._error or error
            self._changed.notify_all()

    def _talk(self) -> None:
        with self._changed:
            while not self._closed:
                try:
                    send_due(self.master, self._bus, self.now)
                except Exception as error:
                    self._fail(error)
                    return
                due = self.master.next_poll(self.now) - self.now
                self._changed.wait(min(max(due, 0.0005), 0.05))


class SteppedLink(Link):
    """A bus whose time passes when it is read (`can.Bus(interface="narx", realtime=False)`): a call that
    waits reads it."""

    def __init__(self, bus: Any, master: _core.Master) -> None:
        super().__init__(master)
        self._bus = bus
        if hasattr(bus, "attach"):
            bus.attach(self.poll)

    @property
    def now(self) -> float:
        return float(self._bus.time)

    def poll(self, now: float) -> float:
        """Sends the frames that are due; returns the time of the next one."""
        send_due(self.master, self._bus, now)
        return self.master.next_poll(now)

    def close(self) -> None:
        if hasattr(self._bus, "detach"):
            self._bus.detach()

    def wait(self, done: Callable[[], bool], timeout: float) -> bool:
        end = self.now + timeout
        while not done():
            self.check_cancelled()
            now = self.now
            if now >= end:
                return False
            due = min(self.poll(now) - now, end - now, 0.01)
            message = self._bus.recv(max(due, 0.0005))
            if message is not None:
                handle(self.master, message, self.now)
        return True


def record(link: Link, job: str, setup: Setup = NO_SETUP, within: float = 0.0) -> None:
    """Carries out a job of the scope or the log, which ends by itself; raises its error, or RefusedError while
    another thread carries out one."""
    if not link.recording.acquire(blocking=False):
        raise RefusedError(f"{job}: another thread records with the scope, or erases the log")
    try:
        link.master.begin_record(job, setup, within)
        link.wake()
        link.wait(link.master.poll_record, math.inf)
    finally:
        link.recording.release()


def handle(master: _core.Master, message: can.Message, now: float) -> None:
    """Passes a frame to the master."""
    data = bytes(message.dlc) if message.is_remote_frame else bytes(message.data)
    master.handle_frame(now, message.arbitration_id, message.is_extended_id, message.is_remote_frame, data)


def send_due(master: _core.Master, bus: can.BusABC, now: float) -> None:
    """Sends the frames that are due."""
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
    """Makes a request and waits for its answer, at most `timeout` s."""
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
