"""A TX-Driver, seen from its master: an eddyCAN node on a bench, or on any bus of python-can."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Literal, Self, cast

from narx import _core, given
from narx._core import NodeState
from narx.bench import Bench
from narx.errors import AbortError, NoAnswerError, ParameterError
from narx.link import BenchLink, BusLink, Link, SteppedLink
from narx.objects import Object, Objects
from narx.trace import Trace

if TYPE_CHECKING:
    import can

BITRATES = (50_000, 100_000, 250_000, 500_000, 1_000_000)
"""Bit rates by their index in 2001h (Table 6), bit/s."""
ANSWER = 1.0
"""Longest wait for requested positions, s."""
SYNC_MIN, SYNC_MAX = 1e-4, 3600.0
"""Limits of the time between two SYNCs, s."""
RESTART = 3.0
"""Longest wait for the boot-up after a reset, s."""
ENCODER = ("Basic Config Register", "Encoder Resolution")
"""Entries that convert the encoder's counts to a position."""
UNITS = {"time": "s", "position_1": "mm", "position_2": "mm", "encoder": "", "encoder_position": "mm"}


@dataclass(frozen=True)
class Reading:
    """Measurement of a TX-Driver at one instant."""

    positions: tuple[float, ...]
    """Position of each channel, mm: -16 to 16 in steps of 2^-27."""
    encoder: int | None
    """Encoder counts, four to a period; `None` if PDOs do not carry them (bit 1 of 2004h). -32768 to 32767
    for a linear encoder, from 0 on for a rotary one."""
    trigger: str
    """"timer" (PDO1, at its update time), "sync" (PDO2) or "remote" (PDO3, on request)."""
    time: float
    """Time of reception, s: on a bench its simulated time, else since the connection."""
    encoder_position: float | None = None
    """Position of a linear encoder, mm: its counts times its resolution (2009h). `None` for a rotary one,
    without an encoder, and before `start` has read the type of the node's encoder."""


class TxDriver:
    """A TX-Driver. Nothing is sent before the first command or request.

    bus: any bus of python-can, which `close` leaves open, or a `narx.Bench` with the node on it
    (`bench.add_tx_driver`). node_id: 1 to 127. channels: sensors of the driver, 1 or 2. timeout: for one
    answer, s; a request is sent three times. Raises ParameterError for a node-id out of range.

    A node powers up Pre-operational: then its `parameters` can be read and written. `start` makes it
    Operational: then it sends positions.
    """

    def __init__(
        self, bus: can.BusABC | Bench, node_id: int, channels: Literal[1, 2] = 1, timeout: float = 0.1
    ) -> None:
        self._closed = False
        self._channels = channels
        if isinstance(bus, Bench):
            self._master = bus._bench.tx_master(node_id, channels, timeout)
            self._link: Link = BenchLink(bus)
        else:
            self._master = _core.TxMaster(node_id, channels, timeout)
            # A link calls only methods that both kinds of master have.
            master = cast(_core.Master, self._master)
            stepped = not getattr(bus, "realtime", True)
            self._link = SteppedLink(bus, master) if stepped else BusLink(bus, master)

    @property
    def node_id(self) -> int:
        """Node-id, 1 to 127."""
        return self._master.node_id

    @property
    def channels(self) -> int:
        """Number of sensors of the driver, 1 or 2."""
        return self._channels

    @property
    def parameters(self) -> Objects:
        """The node's object dictionary by name, index, or (index, subindex), in units."""
        return Objects(self._ask)

    def start(self) -> None:
        """Makes the node Operational: it sends positions, and refuses SDOs. Before that it reads whether the
        PDOs carry the encoder, and the encoder's type. Raises NoAnswerError if the node does not answer."""
        if self.state is not NodeState.STOPPED and not self._answers():
            raise NoAnswerError(self._silence("does not answer"))
        self._command("start")

    def stop(self) -> None:
        """Makes the node Stopped: it reacts to nothing but NMT."""
        self._command("stop")

    def preoperational(self) -> None:
        """Makes the node Pre-operational: its parameters can be read and written, and it sends no
        positions."""
        self._command("pre-operational")

    def reset(self, wait: bool = True) -> None:
        """Restarts the node. With `wait`, returns when its boot-up is received, or raises NoAnswerError after
        3 s."""
        boots = self._master.boots
        self._command("reset")
        if wait and not self._link.wait(lambda: self._master.boots != boots, RESTART):
            raise NoAnswerError(f"no frame of node {self.node_id} was received within {RESTART:g} s after its reset")

    @property
    def state(self) -> NodeState | None:
        """State in the last heartbeat or boot-up; `None` before the first. A node sends a heartbeat every 2 s
        if `heartbeat` is set."""
        state = self._master.state
        return None if state is None else NodeState(state)

    @property
    def connected(self) -> bool:
        """True if a frame of the node was received within 5 s."""
        return self._master.is_present(self._link.now)

    @property
    def errors(self) -> set[str]:
        """Errors that the node has reported (Table 13) since the connection, or since `clear_errors`."""
        return {meaning or f"error {code:04X}h" for code, meaning in self._master.errors()}

    def clear_errors(self) -> None:
        """Clears `errors`."""
        self._master.clear_errors()

    @property
    def malformed(self) -> int:
        """Number of the node's frames that cannot be decoded: most likely it has another number of
        channels."""
        return self._master.malformed

    @property
    def reading(self) -> Reading | None:
        """The last positions received, without a request; `None` before the first."""
        last = self._master.reading
        return None if last is None else self._reading(last)

    def read(self) -> Reading:
        """Requests the positions now (PDO3). Raises NoAnswerError within a second if none come: only an
        Operational node sends them."""
        before = self._master.asked
        self._master.ask_positions()
        self._link.wake()
        self._link.wait(lambda: self._master.asked != before, ANSWER)
        asked = self._master.asked
        if asked is None or asked == before:
            raise NoAnswerError(self._silence(f"sends no positions within {ANSWER:g} s"))
        return self._reading(asked)

    @property
    def positions(self) -> tuple[float, ...]:
        """Positions of each channel, mm, requested now."""
        return self.read().positions

    @property
    def encoder(self) -> int | None:
        """Counts of the encoder, requested now; `None` if PDOs do not carry them."""
        return self.read().encoder

    def sync(self) -> None:
        """Sends a SYNC: every Operational node of the bus samples now and sends PDO2."""
        self._master.sync()
        self._link.wake()

    def record(self, seconds: float, period: float | None = None) -> Trace:
        """Records every position received for `seconds`: "time" (s), "position_1", "position_2" (mm),
        "encoder" (counts) and "encoder_position" (mm, of a linear encoder), arrays of shape (n,).

        period: time between two SYNCs, 0.0001 to 3600 s. Without it no SYNC is sent: the node sends by itself
        (parameter "Update Time", ms). Raises ParameterError for a time or period out of range.
        """
        seconds = given.seconds(seconds)
        if period is not None:
            period = _core.number("period", period, "s", SYNC_MIN, SYNC_MAX)
        self._master.keep(True)
        try:
            end = self._link.now + seconds
            while period is not None and self._link.now < end:
                self.sync()
                self._link.wait(lambda: False, min(period, end - self._link.now))
            self._link.wait(lambda: False, max(end - self._link.now, 0.0))
        finally:
            columns = self._master.take_rows()
        return Trace(columns, {name: UNITS[name] for name in columns})

    @property
    def encoder_position(self) -> float | None:
        """Position of a linear encoder, mm, requested now: `Reading.encoder_position`."""
        return self.read().encoder_position

    @property
    def comparators(self) -> tuple[float, float]:
        """Thresholds of both outputs, fractions of the measuring range, 0 to 1 (2007h); both can be set."""
        return self.parameters["Comparator 1"], self.parameters["Comparator 2"]

    @comparators.setter
    def comparators(self, fractions: tuple[float, float]) -> None:
        first, second = given.several("comparators", fractions)
        # `load` checks both before it writes the first.
        self.parameters.load({"Comparator 1": first, "Comparator 2": second})

    @property
    def heartbeat(self) -> bool:
        """True if the node sends a heartbeat every 2 s (bit 2 of 2004h); can be set."""
        return bool(int(self.parameters["Can Config Register"]) & 4)

    @heartbeat.setter
    def heartbeat(self, on: bool) -> None:
        self._configure(4, on)

    @property
    def sends_encoder(self) -> bool:
        """True if the node's PDOs carry the encoder (bit 1 of 2004h); can be set."""
        return bool(int(self.parameters["Can Config Register"]) & 2)

    @sends_encoder.setter
    def sends_encoder(self, on: bool) -> None:
        self._configure(2, on)

    def reset_encoder(self) -> None:
        """Sets the present position of a linear encoder to 0 (200Ah)."""
        self.parameters["Reset Encoder"] = 1

    def set_node_id(self, node_id: int) -> None:
        """Gives the node another node-id, 1 to 127, and restarts it; from then on this is the master of the
        new node-id. Raises NoAnswerError if no frame of the node is received within 3 s."""
        self.parameters["Node-ID"] = node_id
        self._command("reset")
        self._master.node_id = node_id
        end = self._link.now + RESTART
        # Its boot-up may have come before the loop, or may come late; only an answer proves that it is there.
        while not self._answers():
            if self._link.now >= end:
                raise NoAnswerError(f"no frame of node {node_id} was received within {RESTART:g} s after its restart")

    def set_bitrate(self, bitrate: int) -> None:
        """Gives the node another bit rate, bit/s: 50, 100, 250, 500 or 1000 kbit/s. It takes effect after a
        `reset`. This bus keeps its own bit rate, so the node must then be accessed through another one."""
        if bitrate not in BITRATES or isinstance(bitrate, bool):
            raise ParameterError(f"bitrate {bitrate} bit/s: must be one of {', '.join(map(str, BITRATES))}")
        self.parameters["Bitrate Index"] = BITRATES.index(bitrate)

    def wait(self, seconds: float) -> None:
        """Lets time pass, s: simulated time on a bench, else real time. Raises ParameterError for a time that
        is negative or not finite."""
        self._link.wait(lambda: False, given.seconds(seconds))

    def wait_for(self, done: Callable[[], bool], timeout: float = 10.0) -> bool:
        """Lets time pass until `done`, at most `timeout` s, which may be infinite; returns whether it was
        done. Raises ParameterError for a time-out that is negative or NaN."""
        return self._link.wait(done, given.timeout(timeout))

    def close(self) -> None:
        """Releases the bus; the node stays in its state. A second call does nothing."""
        if not self._closed:
            self._closed = True
            self._link.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        state = self.state
        return f"<narx.TxDriver {self.node_id}, {'state unknown' if state is None else state.name.replace('_', ' ').lower()}>"

    def _reading(self, received: tuple[list[float], int, float | None, str, float]) -> Reading:
        positions, encoder, length, trigger, time = received
        counts, length = (encoder, length) if self._master.encoder else (None, None)
        return Reading(tuple(positions[: self._channels]), counts, trigger, time, length)

    def _configure(self, bit: int, on: bool) -> None:
        register = int(self.parameters["Can Config Register"])
        self.parameters["Can Config Register"] = register | bit if on else register & ~bit

    def _answers(self) -> bool:
        """Returns whether the node answers, even with a refusal, and reads whether its PDOs carry the
        encoder."""
        try:
            if int(self.parameters["Can Config Register"]) & 2:
                # The master evaluates the answers about the encoder.
                for name in ENCODER:
                    self.parameters[name]
        except AbortError:
            # An Operational node refuses SDOs.
            return True
        except NoAnswerError:
            return False
        return True

    def _command(self, command: str) -> None:
        self._master.command(command)
        self._link.wake()
        # Whoever changes the master next, as `set_node_id` does, must not lose the command.
        self._link.wait(lambda: self._master.has_sent, math.inf)

    def _ask(self, row: Object, raw: int | None) -> int:
        answer: list[int] = []

        def done() -> bool:
            value = self._master.poll_answer()
            if value is not None:
                answer.append(value)
            return bool(answer)

        self._master.request(row.index, row.subindex, raw)
        self._link.wake()
        # The master's own time-out ends the wait earlier, with an error.
        if not self._link.wait(done, 60.0):
            raise NoAnswerError(self._silence("does not answer"))
        return answer[0]

    def _silence(self, what: str) -> str:
        state = self.state
        known = "" if state is None else f"; it was last received in {state.name.replace('_', ' ').capitalize()}"
        return f"node {self.node_id} {what}{known}"
