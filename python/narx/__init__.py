"""The narx drive for BLDC motors: on a simulated bench, on any CAN adapter, and in its recordings; the same bits as the firmware.

>>> import narx
>>> bench = narx.Bench(narx.Motor.preset("ec45-flat-50w-18v"), supply_voltage=18.0, mode="hall")
>>> bench.drive.start(3000)
>>> trace = bench.run(1.0)
>>> trace["speed"][-1]
>>> narx.replay(trace.recording()).identical
True
"""

from narx import blocks
from narx._core import Load, Motor, NodeState, State, dbc, eds, xml
from narx.bench import Bench
from narx.drive import Drive, Info, Measurement, Measurements, connect, devices
from narx.errors import (
    AbortError,
    BusError,
    NarxError,
    NoAnswerError,
    ParameterError,
    RecordingError,
    RefusedError,
    SignalError,
    StartError,
)
from narx.log import Log
from narx.messages import Message, decode
from narx.parameters import Parameters
from narx.recording import Replay, replay
from narx.scope import Scope, ScopeState, Trigger
from narx.trace import Trace
from narx.tx_driver import Reading, TxDriver

__all__ = [
    "AbortError",
    "Bench",
    "BusError",
    "Drive",
    "Info",
    "Load",
    "Log",
    "Measurement",
    "Measurements",
    "Message",
    "Motor",
    "NarxError",
    "NoAnswerError",
    "NodeState",
    "ParameterError",
    "Parameters",
    "Reading",
    "RecordingError",
    "RefusedError",
    "Replay",
    "Scope",
    "ScopeState",
    "SignalError",
    "StartError",
    "State",
    "Trace",
    "Trigger",
    "TxDriver",
    "blocks",
    "connect",
    "dbc",
    "decode",
    "devices",
    "eds",
    "replay",
    "xml",
]
