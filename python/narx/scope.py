"""The virtual scope of a drive: it records signals of the control tick, tick by tick."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from os import PathLike
from typing import Self

import numpy as np

from narx import _core, given
from narx.description import describe
from narx.download import download
from narx.errors import ParameterError, RefusedError, SignalError
from narx.link import Link, Setup, ask, record
from narx.names import suggestion
from narx.parameters import Parameters
from narx.trace import Trace

CHANNELS, SAMPLING_TIME, BEFORE = 22, 25, 26
STATE, TRIGGER, TRIGGER_LEVEL, INPUTS, WORDS = 260, 290, 292, 300, 301


class ScopeState(IntEnum):
    """State of the scope (parameter 260)."""

    IDLE = 0
    ARMED = 1
    RECORDING = 2
    DONE = 3


@dataclass(frozen=True)
class Trigger:
    """Condition that begins a record (parameters 290 to 292). An armed scope can also be forced, whatever its
    trigger is."""

    kind: int
    signal: str | None = None
    value: float = 0.0

    @classmethod
    def forced(cls) -> Self:
        """Returns a trigger that only `force` fires."""
        return cls(0)

    @classmethod
    def above(cls, signal: str, value: float) -> Self:
        """Returns a trigger that fires while the signal is above the value, in its unit."""
        return cls(1, signal, value)

    @classmethod
    def below(cls, signal: str, value: float) -> Self:
        """Returns a trigger that fires while the signal is below the value, in its unit."""
        return cls(2, signal, value)

    @classmethod
    def rising(cls, signal: str, value: float) -> Self:
        """Returns a trigger that fires when the signal rises through the value, in its unit."""
        return cls(3, signal, value)

    @classmethod
    def falling(cls, signal: str, value: float) -> Self:
        """Returns a trigger that fires when the signal falls through the value, in its unit."""
        return cls(4, signal, value)

    @classmethod
    def state_change(cls) -> Self:
        """Returns a trigger that fires when the drive changes its state."""
        return cls(5)

    @classmethod
    def fault(cls) -> Self:
        """Returns a trigger that fires when a bit of FAULT_WORD is set."""
        return cls(6)


@dataclass(frozen=True)
class ScopeRecording:
    """The scope's record of the inputs of every control tick, as a recording."""

    recording: bytes
    """Bytes of the recording, for `narx.replay` or a `.narxrec` file."""
    first_tick: int
    """Number of its first tick since the drive's power-up."""
    agrees: bool | None
    """True if the replay's state equals the drive's own at the record's second checkpoint; `None` if the
    record has none."""

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the recording as a `.narxrec` file."""
        given.path(path).write_bytes(self.recording)


class Scope:
    """Arms, forces and reads the scope. A record survives faults and further starts until the scope is armed
    again."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._parameters = Parameters(link)

    @property
    def _signals(self) -> dict[str, tuple[int, str, float]]:
        return describe(self._link).signals

    @property
    def signals(self) -> dict[str, str]:
        """Signals that can be recorded: name -> unit."""
        return {name: unit for name, (_, unit, _) in self._signals.items()}

    @property
    def state(self) -> ScopeState:
        """Present state of the scope."""
        return ScopeState(int(self._parameters[STATE]))

    def arm(
        self,
        signals: Iterable[str],
        samples: int = 256,
        prescaler: int = 1,
        trigger: Trigger | None = None,
        before: int = 0,
    ) -> None:
        """Sets the scope up and arms it.

        signals: names of `signals`, four in a tick. samples: of each signal; all signals together fill at
        most the drive's memory (parameter 305, one word a sample). prescaler: control ticks from one sample
        to the next, at least one for every four signals. trigger: `None` waits for `force`. before: samples
        from before the trigger, fewer than `samples`. Raises ParameterError or SignalError for settings that
        the drive does not support, RefusedError while the scope is armed or recording.
        """
        record(self._link, "arm scope", self._setup(self._channels(signals), samples, prescaler, trigger, before))

    def arm_inputs(self, ticks: int = 400, trigger: Trigger | None = None, before: int = 0) -> None:
        """Sets the scope up to record the inputs of every control tick instead of signals, and arms it;
        `download_recording` makes a recording of them.

        ticks: length of the record, limited by the memory: 34 to 68 ms in 8 KiB, even if more is requested.
        before: ticks from before the trigger, fewer than `ticks`.
        """
        record(self._link, "arm scope", self._setup(0, ticks, 1, trigger, before))

    def _channels(self, signals: Iterable[str]) -> int:
        """Returns the sum of the signals' bits."""
        bits = {self._signals[known(name, self._signals)][0] for name in given.several("signals", signals)}
        if not bits:
            raise ParameterError("signals: must name at least one signal")
        return sum(1 << bit for bit in bits)

    def _setup(self, channels: int, samples: int, prescaler: int, trigger: Trigger | None, before: int) -> Setup:
        """Returns the settings of a record of signals, or without channels of inputs."""
        trigger = trigger or Trigger.forced()
        to_raw = describe(self._link).core.to_raw
        bit, level = 0, 0
        if trigger.signal is not None:
            bit, _, base = self._signals[known(trigger.signal, self._signals)]
            level = to_raw(TRIGGER_LEVEL, _core.number("trigger value", trigger.value) / base)
        return channels, samples, prescaler, before, to_raw(TRIGGER, trigger.kind), bit, level

    def force(self) -> None:
        """Triggers the armed scope now. Raises RefusedError if it is not armed."""
        if not self._link.recording.locked():
            record(self._link, "force scope")
        elif self.state is ScopeState.ARMED:
            # Another thread awaits the record: it is forced beside that call.
            ask(self._link, lambda: self._link.master.request("trigger scope"))

    def wait(self, timeout: float = 10.0) -> None:
        """Lets time pass until the record is complete, or raises NoAnswerError after `timeout` s."""
        record(self._link, "await scope", within=timeout)

    def download(self, progress: Callable[[int, int], None] | bool | None = None) -> Trace:
        """Downloads the record: a row per sample, `time` in s from the trigger. progress: called with the
        number of words received and the total; or whether to show a progress bar, as of `narx.read_log`. Raises RefusedError while there is none."""
        self._expect_record(inputs=False)
        channels = int(self._parameters[CHANNELS])
        signals = self._signals
        names = [name for name, (bit, _, _) in signals.items() if channels >> bit & 1]
        words = int(self._parameters[WORDS])
        step, before = self._parameters[SAMPLING_TIME], int(self._parameters[BEFORE])
        data = download(self._link, "scope", count=words, progress=progress)
        samples = np.frombuffer(data, ">i2")
        table = samples[: len(samples) // len(names) * len(names)].reshape(-1, len(names)) / 4096.0
        time = (np.arange(len(table)) - min(before, len(table))) * step
        columns = {"time": time} | {name: table[:, at] * signals[name][2] for at, name in enumerate(names)}
        units = {"time": "s"} | {name: signals[name][1] for name in names}
        return Trace(columns, units)

    def download_recording(self, progress: Callable[[int, int], None] | bool | None = None) -> ScopeRecording:
        """Downloads the record of inputs, as a recording that `narx.replay` runs again bit for bit. progress:
        as of `download`.

        Raises RecordingError for a record of another version of narx, or one that is damaged.
        """
        self._expect_record(inputs=True)
        data = download(self._link, "scope", count=int(self._parameters[WORDS]), progress=progress)
        return ScopeRecording(*_core.scope_recording(data, "recorded by the scope"))

    def capture(
        self,
        signals: Iterable[str],
        samples: int = 256,
        prescaler: int = 1,
        trigger: Trigger | None = None,
        before: int = 0,
        timeout: float = 10.0,
    ) -> Trace:
        """Arms the scope (see `arm`), waits for the trigger at most `timeout` s, or forces it without one,
        and downloads the record."""
        self._capture(self._setup(self._channels(signals), samples, prescaler, trigger, before), trigger, timeout)
        return self.download()

    def record(
        self, ticks: int = 400, trigger: Trigger | None = None, before: int = 0, timeout: float = 10.0
    ) -> ScopeRecording:
        """Records inputs (see `arm_inputs`), waits for the trigger at most `timeout` s, or forces it without
        one, and downloads the recording. ticks, before: control ticks."""
        self._capture(self._setup(0, ticks, 1, trigger, before), trigger, timeout)
        return self.download_recording()

    def _capture(self, setup: Setup, trigger: Trigger | None, timeout: float) -> None:
        if trigger is not None and trigger.kind == 0:
            # Something else forces the scope.
            record(self._link, "arm scope", setup)
            record(self._link, "await scope", within=timeout)
        else:
            record(self._link, "capture scope", setup, timeout)

    def _expect_record(self, inputs: bool) -> None:
        if (state := self.state) is not ScopeState.DONE:
            raise RefusedError(f"the scope is {state.name.lower()}: no record is stored")
        if bool(self._parameters[INPUTS]) is not inputs:
            kind, call = ("signals", "download") if inputs else ("inputs", "download_recording")
            raise RefusedError(f"the scope has recorded {kind}: {call}() reads it")


def known(name: str, signals: Iterable[str]) -> str:
    """Returns the published name of a signal; case does not matter."""
    folded = {signal.casefold(): signal for signal in signals}
    try:
        return folded[str(name).casefold()]
    except KeyError:
        raise SignalError(f'there is no scope signal "{name}"{suggestion(name, folded.values())}') from None
