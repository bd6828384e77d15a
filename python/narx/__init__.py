"""The narx drive for BLDC motors: on a simulated bench, on any CAN adapter, and in its recordings. The bench
and the replay compute the same bits as the firmware.

>>> import narx
>>> bench = narx.Bench(narx.Motor.preset("ec45-flat-50w-18v"), supply_voltage=18.0, mode="hall")
>>> bench.drive.start(3000)
>>> trace = bench.run(1.0)
>>> trace["speed"][-1]
>>> narx.replay(trace.recording()).identical
True
"""

from narx import blocks, experiments
from narx._core import COMMISSIONED, Load, Motor, NodeState, OperatingRange, Plant, SpeedLoop, State, __version__, coefficients, dbc, eds, xml
from narx.async_drive import AsyncDrive, AsyncPart, connect_async
from narx.bench import Bench, RunInterrupted
from narx.bridge import Bridge
from narx.can_log import CanLog
from narx.columns import Frames, LogError, Series, Table
from narx.drive import Drive, Info, Measurement, Measurements, connect, devices
from narx.errors import (
    AbortError,
    BusError,
    DescriptionWarning,
    ImageError,
    MissingError,
    NarxError,
    NarxWarning,
    NoAnswerError,
    ParameterError,
    RecordingError,
    RefusedError,
    SignalError,
    SpeedWarning,
    StartError,
)
from narx.identification import Figure, Halls, Identified
from narx.log import Log
from narx.log_file import read_log
from narx.messages import Message, NodeMessage, decode
from narx.parameters import Parameters
from narx.recording import Replay, replay
from narx.scope import Scope, ScopeRecording, ScopeState, Trigger
from narx.signals import Crossing, Fault, Limiter
from narx.sweep import Sweep, SweepInterrupted, sweep
from narx.trace import Trace
from narx.tx_driver import Reading, TxDriver
from narx.variants import Variant

__all__ = [
    "COMMISSIONED",
    "AbortError",
    "AsyncDrive",
    "AsyncPart",
    "Bench",
    "Bridge",
    "BusError",
    "CanLog",
    "Crossing",
    "DescriptionWarning",
    "Drive",
    "Fault",
    "Figure",
    "Frames",
    "Halls",
    "Identified",
    "ImageError",
    "Info",
    "Limiter",
    "Load",
    "Log",
    "LogError",
    "Measurement",
    "Measurements",
    "Message",
    "MissingError",
    "Motor",
    "NarxError",
    "NarxWarning",
    "NoAnswerError",
    "NodeMessage",
    "NodeState",
    "OperatingRange",
    "ParameterError",
    "Parameters",
    "Plant",
    "Reading",
    "RecordingError",
    "RefusedError",
    "Replay",
    "RunInterrupted",
    "Scope",
    "ScopeRecording",
    "ScopeState",
    "Series",
    "SignalError",
    "SpeedLoop",
    "SpeedWarning",
    "StartError",
    "State",
    "Sweep",
    "SweepInterrupted",
    "Table",
    "Trace",
    "Trigger",
    "TxDriver",
    "Variant",
    "__version__",
    "blocks",
    "coefficients",
    "connect",
    "connect_async",
    "dbc",
    "decode",
    "devices",
    "eds",
    "experiments",
    "read_log",
    "replay",
    "sweep",
    "xml",
]
