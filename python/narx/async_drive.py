"""A drive for asyncio: the names of `narx.Drive`, and every call that takes time is awaited."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from narx._core import State
from narx.drive import Drive, Measurements, connect
from narx.errors import RefusedError
from narx.link import BusLink
from narx.messages import Message, NodeMessage, decode

if TYPE_CHECKING:
    import can

T = TypeVar("T")


class AsyncDrive:
    """A drive whose calls are awaited: `await drive.start(3000)`, `await drive.wait_for(lambda: ...)`. All methods of
    `narx.Drive` are here with the same arguments, units and errors.

    `state`, `faults`, `fault`, `status`, `connected` and `measurements` are read at once, as there; `info` and
    `diagnostics` ask the drive, so they are awaited: `await drive.info`. `parameters`, `scope` and `log` have the
    methods and properties of `narx.Drive`'s, awaited as well: `await drive.parameters["Phase current limit"]`,
    `await drive.parameters.set("Phase current limit", 4.5)`, `await drive.log.download()`.

    Requests of several tasks are made one after the other; `stop` overtakes them. A cancelled call waits no
    longer, but what it has requested stays requested: `stop` takes a start back.
    """

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._requests = asyncio.Lock()

    @property
    def state(self) -> State | None:
        """State of the drive; `None` while unknown."""
        return self._drive.state

    @property
    def faults(self) -> set[str]:
        """Names of the set bits of the fault word."""
        return self._drive.faults

    @property
    def fault(self) -> str | None:
        """Meaning of the extended code of the last critical fault; `None` without a fault."""
        return self._drive.fault

    @property
    def status(self) -> dict[str, Any]:
        """The fields of the last STATUS_WORD."""
        return self._drive.status

    @property
    def connected(self) -> bool:
        """True if the drive was heard of lately, as `narx.Drive.connected`."""
        return self._drive.connected

    @property
    def measurements(self) -> Measurements:
        """Last measurements of the drive, in their units."""
        return self._drive.measurements

    @property
    def parameters(self) -> AsyncPart:
        """The drive's parameters by name or number, awaited, in their units."""
        return AsyncPart(self, lambda: self._drive.parameters)

    @property
    def scope(self) -> AsyncPart:
        """The virtual scope, awaited."""
        return AsyncPart(self, lambda: self._drive.scope)

    @property
    def log(self) -> AsyncPart:
        """The external log memory, awaited."""
        return AsyncPart(self, lambda: self._drive.log)

    async def stop(self) -> None:
        """Requests Standby at once, even while another task waits for a start; as `narx.Drive.stop`."""
        self._drive.stop()

    async def wait(self, seconds: float) -> None:
        """Lets time pass, s, while other tasks run; as `narx.Drive.wait`."""
        await self._passing(partial(self._drive.wait, seconds))

    async def wait_for(self, done: Callable[[], bool], timeout: float = 10.0) -> bool:
        """Lets time pass until `done`, at most `timeout` s, while other tasks run; returns whether it was done.
        `done` is called in another thread; as `narx.Drive.wait_for`."""
        return await self._passing(partial(self._drive.wait_for, done, timeout))

    async def messages(self) -> AsyncIterator[Message | NodeMessage]:
        """Yields every message on the drive's bus as it arrives, decoded; frames that no table has are left out.
        Raises RefusedError on a bus with `realtime=False`."""
        if not isinstance(self._drive._link, BusLink):
            raise RefusedError("messages: a bus with realtime=False is read by the calls that wait")
        queue: asyncio.Queue[can.Message] = asyncio.Queue()
        loop = asyncio.get_running_loop()

        def receive(message: can.Message) -> None:
            loop.call_soon_threadsafe(queue.put_nowait, message)

        with self._drive._link.listening(receive):
            while True:
                message = decode(await queue.get())
                if message is not None:
                    yield message

    def __getattr__(self, name: str) -> Any:
        return member(self, self._drive, name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *(name for name in dir(Drive) if not name.startswith("_"))})

    def __repr__(self) -> str:
        return repr(self._drive).replace("narx.Drive", "narx.AsyncDrive")

    async def _passing(self, call: Callable[[], T]) -> T:
        """Makes a call that only lets time pass. A bus that is read by it is read by one at a time."""
        if isinstance(self._drive._link, BusLink):
            return await self._in_thread(call)
        return await self._request(call)

    async def _request(self, call: Callable[[], T]) -> T:
        """Makes a call that asks the drive."""
        async with self._requests:
            return await self._in_thread(call)

    async def _in_thread(self, call: Callable[[], T]) -> T:
        """Makes a call in a thread; if this task is cancelled, the call ends, too."""
        link, over = self._drive._link, threading.Event()

        def work() -> T:
            link.cancelled.event = over
            try:
                return call()
            finally:
                # The next call in this thread is another one.
                link.cancelled.event = None

        task = asyncio.get_running_loop().run_in_executor(None, work)
        try:
            return await asyncio.shield(task)
        except asyncio.CancelledError:
            over.set()
            await asyncio.wait([task])
            task.exception()
            raise


class AsyncPart:
    """A part of a drive whose methods and properties are awaited."""

    def __init__(self, drive: AsyncDrive, part: Callable[[], Any]) -> None:
        self._drive = drive
        self._part = part

    def __getattr__(self, name: str) -> Any:
        return member(self._drive, self._part(), name)

    def __getitem__(self, key: Any) -> Awaitable[Any]:
        return self._drive._request(lambda: self._part()[key])

    async def set(self, key: Any, value: float) -> None:
        """Writes a value by its key, in its unit: `part[key] = value` of `narx.Drive`."""

        def write() -> None:
            self._part()[key] = value

        await self._drive._request(write)


def member(drive: AsyncDrive, target: Any, name: str) -> Any:
    """Returns a method as a function that is awaited, or a property as an awaitable."""
    if name.startswith("_"):
        raise AttributeError(name)
    found = getattr(type(target), name, None)
    if callable(found):
        return lambda *arguments, **options: drive._request(partial(getattr(target, name), *arguments, **options))
    if found is None:
        raise AttributeError(f"{type(target).__name__} has no {name}")
    return drive._request(lambda: getattr(target, name))


@asynccontextmanager
async def connect_async(*arguments: Any, **options: Any) -> AsyncIterator[AsyncDrive]:
    """Connects to a drive for asyncio: `async with narx.connect_async("socketcan", "can0") as drive`. Arguments,
    units and errors are those of `narx.connect`. At the end of the block the motor is stopped."""
    drive = await asyncio.to_thread(partial(connect, *arguments, **options))
    try:
        yield AsyncDrive(drive)
    finally:
        await asyncio.shield(asyncio.to_thread(drive.close))
