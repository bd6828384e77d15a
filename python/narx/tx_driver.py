"""A TX-Driver as its master sees it: an eddyCAN node on a bench, or on any bus of python-can."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Literal, Self, cast

from narx import _core
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
"""Longest wait for positions that were asked for, s."""
RESTART = 3.0
"""Longest wait for the boot-up after a reset, s."""
ENCODER = ("Basic Config Register", "Encoder Resolution")
"""What must be known to make a position of an encoder's counts."""
UNITS = {"time": "s", "position_1": "mm", "position_2": "mm", "encoder": "", "encoder_position": "mm"}


@dataclass(frozen=True)
class Reading:
    """What a TX-Driver has measured at one instant."""

    positions: tuple[float, ...]
    """Of each channel, mm: -16 to 16 in steps of 2^-27."""
    encoder: int | None
    """Counts, four to a period; `None` if PDOs do not carry them (bit 1 of 2004h). Of a linear encoder -32768 to 32767, of a rotary one from 0 on."""
    trigger: str
    """"timer" (PDO1, its update time), "sync" (PDO2) or "remote" (PDO3, asked for)."""
    time: float
    """When it was heard, s: the time of the bench, or since the connection."""
    encoder_position: float | None = None
    """Position of a linear encoder, mm: its counts times its resolution (2009h). `None` of a rotary one, without an encoder, and while `start` has not read what
    the node's encoder is."""


class TxDriver:
    """A TX-Driver. Nothing is sent until something is asked for.

    bus: any bus of python-can, which stays its owner's, or a `narx.Bench` with the node on it (`bench.add_tx_driver`). node_id: 1 to 127. channels: sensors of
    the driver, 1 or 2. timeout: for one answer, s; a request is sent three times. Raises ParameterError for a node-id that cannot be.

    A node powers up Pre-operational: then its `parameters` can be read and written. `start` makes it Operational: then it sends positions.
    """

    def __init__(
        self, bus: can.BusABC | Bench, node_id: int, channels: Literal[1, 2] = 1, timeout: float = 0.1
    ) -> None:
        self._closed = False
        self._channels = channels
        if isinstance(bus, Bench):
            self._master = bus._bench.tx_master(node_id, channels, timeout)
            self._link: Link = BenchLink(bus._bench)
        else:
            self._master = _core.TxMaster(node_id, channels, timeout)
            # Of a master a link wants no more than both kinds have.
            master = cast(_core.Master, self._master)
            stepped = not getattr(bus, "realtime", True)
            self._link = SteppedLink(bus, master) if stepped else BusLink(bus, master)

    @property
    def node_id(self) -> int:
        """Its address, 1 to 127."""
        return self._master.node_id

    @property
    def channels(self) -> int:
        """Sensors of the driver, 1 or 2."""
        return self._channels

    @property
    def parameters(self) -> Objects:
        """The node's object dictionary by name, index, or (index, subindex), in units."""
        return Objects(self._ask)

    def start(self) -> None:
        """Makes it Operational: it sends positions, and refuses SDOs. Whether its PDOs carry the encoder, and what that is, is read before. Raises NoAnswerError if
        it is not there."""
        if self.state is not NodeState.STOPPED and not self._answers():
            raise NoAnswerError(self._silence("does not answer"))
        self._command("start")

    def stop(self) -> None:
        """Makes it Stopped: it answers nothing but NMT."""
        self._command("stop")

    def preoperational(self) -> None:
        """Makes it Pre-operational: its parameters can be read and written, and it sends no positions."""
        self._command("pre-operational")

    def reset(self, wait: bool = True) -> None:
        """Restarts it: with `wait`, until its boot-up is heard, or NoAnswerError after 3 s."""
        boots = self._master.boots
        self._command("reset")
        if wait and not self._link.wait(lambda: self._master.boots != boots, RESTART):
            raise NoAnswerError(f"node {self.node_id} was not heard within {RESTART:g} s after its reset")

    @property
    def state(self) -> NodeState | None:
        """The state of its last heartbeat or boot-up; `None` before one was heard. A node tells it every 2 s if `heartbeat` is set."""
        state = self._master.state
        return None if state is None else NodeState(state)

    @property
    def connected(self) -> bool:
        """Whether it was heard within 5 s."""
        return self._master.is_present(self._link.now)

    @property
    def errors(self) -> set[str]:
        """What it has complained of (Table 13) since the connection, or `clear_errors`."""
        return {meaning or f"error {code:04X}h" for code, meaning in self._master.errors()}

    def clear_errors(self) -> None:
        """Forgets what it has complained of."""
        self._master.clear_errors()

    @property
    def malformed(self) -> int:
        """Frames of the node that mean nothing: most likely it has another number of channels."""
        return self._master.malformed

    @property
    def reading(self) -> Reading | None:
        """The last positions, without asking; `None` before any was heard."""
        last = self._master.reading
        return None if last is None else self._reading(last)

    def read(self) -> Reading:
        """Asks for the positions now (PDO3). Raises NoAnswerError within a second if there are none: only an Operational node sends them."""
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
        """Positions of each channel, mm, asked for now."""
        return self.read().positions

    @property
    def encoder(self) -> int | None:
        """Counts of the encoder, asked for now; `None` if PDOs do not carry them."""
        return self.read().encoder

    def sync(self) -> None:
        """Sends a SYNC: every Operational node of the bus samples now and sends PDO2."""
        self._master.sync()
        self._link.wake()

    def record(self, seconds: float, period: float | None = None) -> Trace:
        """Keeps every position that is heard for `seconds`: "time" (s), "position_1", "position_2" (mm), "encoder" (counts) and "encoder_position" (mm, of a linear
        encoder), arrays of shape (n,).

        period: a SYNC is sent every so many s. Without, the node sends by itself (parameter "Update Time", ms).
        """
        if period is not None and period <= 0.0:
            raise ParameterError(f"period {period} s: must be above 0")
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
        """Position of a linear encoder, mm, asked for now: `Reading.encoder_position`."""
        return self.read().encoder_position

    @property
    def comparators(self) -> tuple[float, float]:
        """Thresholds of both outputs, fractions of the measuring range, 0 to 1 (2007h); both can be set."""
        return self.parameters["Comparator 1"], self.parameters["Comparator 2"]

    @comparators.setter
    def comparators(self, fractions: tuple[float, float]) -> None:
        first, second = fractions
        # Both are checked before the first is written.
        self.parameters.load({"Comparator 1": first, "Comparator 2": second})

    @property
    def heartbeat(self) -> bool:
        """Whether it sends a heartbeat every 2 s (bit 2 of 2004h); can be set."""
        return bool(int(self.parameters["Can Config Register"]) & 4)

    @heartbeat.setter
    def heartbeat(self, on: bool) -> None:
        self._configure(4, on)

    @property
    def sends_encoder(self) -> bool:
        """Whether its PDOs carry the encoder (bit 1 of 2004h); can be set."""
        return bool(int(self.parameters["Can Config Register"]) & 2)

    @sends_encoder.setter
    def sends_encoder(self, on: bool) -> None:
        self._configure(2, on)

    def reset_encoder(self) -> None:
        """The present place of a linear encoder becomes 0 (200Ah)."""
        self.parameters["Reset Encoder"] = 1

    def set_node_id(self, node_id: int) -> None:
        """Gives the node another address, 1 to 127, and restarts it with that; from then on this is its master. Raises NoAnswerError if it is not heard
        within 3 s."""
        self.parameters["Node-ID"] = node_id
        self._command("reset")
        self._master.node_id = node_id
        end = self._link.now + RESTART
        # Its boot-up may have been heard before, or may come late: an answer is the proof.
        while not self._answers():
            if self._link.now >= end:
                raise NoAnswerError(f"node {node_id} was not heard within {RESTART:g} s after its restart")

    def set_bitrate(self, bitrate: int) -> None:
        """Gives the node another bit rate, bit/s: 50, 100, 250, 500 or 1000 kbit/s. It acts after a `reset`; this bus keeps its own, so that the node is
        heard on another one then."""
        if bitrate not in BITRATES:
            raise ParameterError(f"bitrate {bitrate} bit/s: must be one of {', '.join(map(str, BITRATES))}")
        self.parameters["Bitrate Index"] = BITRATES.index(bitrate)

    def wait(self, seconds: float) -> None:
        """Lets time pass: simulated on a bench, else that of the clock."""
        self._link.wait(lambda: False, seconds)

    def wait_for(self, done: Callable[[], bool], timeout: float = 10.0) -> bool:
        """Lets time pass until `done`, at most `timeout` s: whether it was done."""
        return self._link.wait(done, timeout)

    def close(self) -> None:
        """Lets go of the bus; the node goes on as it is. The second time nothing happens."""
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

    def _reading(self, heard: tuple[list[float], int, float | None, str, float]) -> Reading:
        positions, encoder, length, trigger, time = heard
        counts, length = (encoder, length) if self._master.encoder else (None, None)
        return Reading(tuple(positions[: self._channels]), counts, trigger, time, length)

    def _configure(self, bit: int, on: bool) -> None:
        register = int(self.parameters["Can Config Register"])
        self.parameters["Can Config Register"] = register | bit if on else register & ~bit

    def _answers(self) -> bool:
        """Whether it answers, if only that it does not want to; what its PDOs carry is known then."""
        try:
            if int(self.parameters["Can Config Register"]) & 2:
                # The master keeps what it hears of the encoder.
                for name in ENCODER:
                    self.parameters[name]
        except AbortError:
            # It is Operational.
            return True
        except NoAnswerError:
            return False
        return True

    def _command(self, command: str) -> None:
        self._master.command(command)
        self._link.wake()
        # It is on the bus before anything else is.
        self._link.wait(lambda: False, 0.002)

    def _ask(self, row: Object, raw: int | None) -> int:
        answer: list[int] = []

        def done() -> bool:
            value = self._master.poll_answer()
            if value is not None:
                answer.append(value)
            return bool(answer)

        self._master.request(row.index, row.subindex, raw)
        self._link.wake()
        # The master gives up by itself, and says so.
        if not self._link.wait(done, 60.0):
            raise NoAnswerError(self._silence("does not answer"))
        return answer[0]

    def _silence(self, what: str) -> str:
        state = self.state
        known = "" if state is None else f"; it was last heard in {state.name.replace('_', ' ').capitalize()}"
        return f"node {self.node_id} {what}{known}"
