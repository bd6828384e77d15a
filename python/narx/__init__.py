"""The narx drive for BLDC motors on a simulated bench, and its recordings: the same bits as the firmware.

>>> import narx
>>> bench = narx.Bench(narx.Motor.preset("ec45-flat-50w-18v"), supply_voltage=18.0, mode="hall")
>>> bench.drive.start(3000)
>>> trace = bench.run(1.0)
>>> trace["speed"][-1]
>>> narx.replay(trace.recording()).identical
True
"""

from narx._core import Bench, Drive, Load, Motor, Replay, State, Trace, replay
from narx.errors import NarxError, ParameterError, RecordingError, SignalError, StartError

__all__ = [
    "Bench",
    "Drive",
    "Load",
    "Motor",
    "NarxError",
    "ParameterError",
    "RecordingError",
    "Replay",
    "SignalError",
    "StartError",
    "State",
    "Trace",
    "replay",
]
