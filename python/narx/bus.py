"""The virtual drive as a bus of python-can: `can.Bus(interface="narx")`."""

from __future__ import annotations

import itertools
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import can

from narx import _core, given
from narx.errors import NarxError, ParameterError, RefusedError
from narx.names import suggestion

QUEUE = 100_000
"""Largest number of frames that wait for a client that does not read."""
TICK = 1e-4
"""Control tick, s: the shortest time that can be simulated."""
STEP = 0.1
"""Simulated time between two checks for Ctrl-C, s."""


OPTIONS = ("motor", "supply_voltage", "load", "mode", "parameters", "ambient", "seed", "pwm_rate", "tx_drivers", "drives")
"""Options of the virtual drive."""
GENERIC = ("fd", "data_bitrate", "timing", "state", "single_handle")
"""Options that programs and configuration of python-can pass to every bus; the virtual drive has none of
them."""


FIRST = 171
"""Address of the first further drive; the next ones have the following addresses."""
SLAVE = 2
"""Number of the parameter with a drive's address."""


Master = Callable[[float], float]
"""A master on the bus: sends the frames that are due at a time, s, and returns the time of its next one."""


def further_drive(place: int, options: Any) -> dict[str, Any]:
    """Returns the arguments of a further drive on the bus."""
    if not isinstance(options, dict):
        raise ParameterError(f"drives {options!r}: must be dictionaries of the drive's options")
    known = (*OPTIONS[:-2], "slave")
    for name in options:
        if name not in known:
            raise ParameterError(f'drives: there is no option "{name}"{suggestion(str(name), known)}; there are {", ".join(known)}')
    found = {name: value for name, value in options.items() if name != "slave"}
    motor = given.motor(found.get("motor", "ec45-flat-50w-18v"))
    slave = _core.whole_number("slave", options.get("slave", FIRST + place), 0, 255)
    voltage = {} if motor.nominal_voltage is None else {"supply_voltage": motor.nominal_voltage}
    return voltage | found | {"motor": motor, "parameters": {**(found.get("parameters") or {}), SLAVE: slave}}


class World:
    """A bench that the buses of one channel share."""

    _all: ClassVar[dict[str, World]] = {}
    _guard: ClassVar[threading.Lock] = threading.Lock()
    _clients: ClassVar[itertools.count[int]] = itertools.count(1)

    def __init__(self, channel: str, realtime: bool, options: dict[str, Any]) -> None:
        motor = options.pop("motor", "ec45-flat-50w-18v")
        self.motor = motor
        self.options = options
        self.channel = channel
        self.realtime = realtime
        own = {name: value for name, value in options.items() if name != "drives"}
        self.bus = _core.VirtualBus(given.motor(motor), **own)
        for place, further in enumerate(given.several("drives", options.get("drives") or ())):
            self.bus.add_drive(**further_drive(place, further))
        self.queues: dict[int, deque[can.Message]] = {}
        self.own: set[int] = set()
        self.masters: dict[int, Master] = {}
        self.arrived = threading.Condition()
        self._over = threading.Event()
        self._thread: threading.Thread | None = None
        if realtime:
            self._thread = threading.Thread(target=self._run, name=f"narx {channel}", daemon=True)
            self._thread.start()

    @classmethod
    def join(cls, channel: str, realtime: bool, options: dict[str, Any]) -> tuple[World, int]:
        """Returns the world of a channel and a client number in it; makes the world if the channel is new."""
        with cls._guard:
            world = cls._all.get(channel)
            if world is None:
                world = cls._all[channel] = cls(channel, realtime, options)
            elif options and options | {"motor": world.motor} != world.options | {"motor": options.get("motor", world.motor)}:
                raise can.CanInitializationError(f'channel "{channel}" is there already, with other options')
            client = next(cls._clients)
            world.queues[client] = deque(maxlen=QUEUE)
            return world, client

    def leave(self, client: int) -> None:
        """Removes a client; the last one ends the world."""
        with self._guard:
            self.queues.pop(client, None)
            self.masters.pop(client, None)
            if self.queues:
                return
            self._all.pop(self.channel, None)
        self._over.set()
        if self._thread is not None:
            self._thread.join()

    def advance(self, until: float, until_frame: bool = False) -> None:
        """Simulates until the time `until`, s, or until a frame has passed if `until_frame`; at most until a
        master has a frame to send."""
        due = min((poll(self.bus.time) for poll in list(self.masters.values())), default=until)
        passed = self.bus.advance(min(until, max(due, self.bus.time + TICK)), until_frame)
        if not passed:
            return
        with self.arrived:
            for moment, sender, (number, extended, remote, data) in passed:
                for client, queue in list(self.queues.items()):
                    if client == sender and client not in self.own:
                        continue
                    queue.append(
                        can.Message(
                            timestamp=moment, arbitration_id=number, is_extended_id=extended, is_remote_frame=remote,
                            dlc=len(data), data=None if remote else data, channel=self.channel, is_rx=client != sender,
                        )
                    )  # fmt: skip
            self.arrived.notify_all()

    def _run(self) -> None:
        """Keeps simulated time in step with the clock. A delay of more than a second is not made up for."""
        origin = time.monotonic() - self.bus.time
        while not self._over.is_set():
            target = time.monotonic() - origin
            if target > self.bus.time + 1.0:
                origin += target - self.bus.time - 1.0
                target = self.bus.time + 1.0
            self.advance(min(target, self.bus.time + 0.02))
            if self.bus.time >= target:
                time.sleep(0.001)


class NarxBus(can.BusABC):
    """A virtual drive on its bus. Buses of one process with the same channel share one drive.

    motor: a preset's name or a `narx.Motor`. supply_voltage, load, mode, parameters, ambient, seed and
    pwm_rate are those of `narx.Bench`. tx_drivers: node-ids of eddyCAN TX-Drivers beside it, each of one
    channel and with an encoder of 4096 counts on the shaft. drives: further drives on the bus, a dictionary
    each with the same options (by default the motor's nominal voltage) and `slave`, the address, 171 and
    following unless given; `narx.Drive(bus, slave=171)` operates the first of them. A frame of a further drive
    arrives one frame's time later than on a real bus. realtime: simulated time keeps step with the
    clock; without it, time passes only during a call that receives, as fast as it can be simulated. Once a
    `narx.Drive` or `narx.TxDriver` is on the channel, only their calls let time pass, and the frames of each
    are sent when they are due; any other bus receives what has passed.
    """

    def __init__(
        self,
        channel: Any = "virtual",
        can_filters: can.typechecking.CanFilters | None = None,
        realtime: bool = True,
        receive_own_messages: bool = False,
        bitrate: int = 500_000,
        **options: Any,
    ) -> None:
        if bitrate != 500_000:
            raise can.CanInitializationError(f"bitrate {bitrate}: the drive's bus has 500000")
        if options.get("fd"):
            raise can.CanInitializationError("fd True: the drive's bus has no CAN FD")
        for name in options:
            if name not in (*OPTIONS, *GENERIC):
                raise can.CanInitializationError(
                    f'there is no option "{name}"{suggestion(name, OPTIONS)}; there are channel, can_filters, realtime, '
                    f"receive_own_messages, bitrate, {', '.join(OPTIONS)}"
                )
        options = {name: value for name, value in options.items() if name in OPTIONS}
        try:
            self._world, self._client = World.join(str(channel), realtime, options)
        except NarxError as error:
            raise can.CanInitializationError(str(error)) from error
        self.realtime = self._world.realtime
        self.channel_info = f"narx virtual drive: {channel}"
        if receive_own_messages:
            self._world.own.add(self._client)
        super().__init__(channel=channel, can_filters=can_filters)

    @property
    def time(self) -> float:
        """Simulated time since power-up, s."""
        return self._world.bus.time

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Queues a frame; it takes part in the arbitration from now on."""
        if msg.is_fd or msg.is_error_frame:
            raise can.CanOperationError("the virtual drive's bus has neither CAN FD nor error frames to send")
        data = bytes(msg.dlc) if msg.is_remote_frame else bytes(msg.data)
        try:
            taken = self._world.bus.send(
                self._client, msg.arbitration_id, msg.is_extended_id, msg.is_remote_frame, data
            )
        except NarxError as error:
            raise can.CanOperationError(str(error)) from error
        if not taken:
            raise can.CanOperationError("the queue of frames to send is full")

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Returns the next frame, or `None` after `timeout` s of the bus's time: by the clock with realtime,
        and while only others let time pass."""
        masters = self._world.masters
        if self.realtime or (masters and self._client not in masters):
            return super().recv(timeout)
        # Own loop, because the base class measures time-outs by the clock.
        queue = self._queue()
        end = float("inf") if timeout is None else self.time + timeout
        while True:
            while not queue and end - self.time > TICK / 2:
                self._world.advance(min(end, self.time + STEP), until_frame=True)
            if not queue:
                return None
            message = queue.popleft()
            if self._matches_filters(message):
                return message

    def attach(self, master: Master) -> None:
        """Makes this bus that of a master, whose calls let time pass. It receives the bus's frames alone."""
        if can.Notifier.find_instances(self):
            raise RefusedError("a can.Notifier reads this bus: without realtime the drive and a listener need a can.Bus each")
        self._world.masters[self._client] = master

    def detach(self) -> None:
        """Removes the master."""
        self._world.masters.pop(self._client, None)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        queue = self._queue()
        with self._world.arrived:
            self._world.arrived.wait_for(lambda: bool(queue), timeout)
        return (queue.popleft() if queue else None), False

    def _queue(self) -> deque[can.Message]:
        queue = self._world.queues.get(self._client)
        if queue is None:
            raise can.CanOperationError("the bus was shut down")
        return queue

    def shutdown(self) -> None:
        """Leaves the bus."""
        if not self._is_shutdown:
            super().shutdown()
            self._world.leave(self._client)

    @staticmethod
    def _detect_available_configs() -> Sequence[can.typechecking.AutoDetectedConfig]:
        return [{"interface": "narx", "channel": "virtual"}]
