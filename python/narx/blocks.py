"""The drive's stations one by one, for teaching, tests and other drives: the same code as in the drive, so the same bits.

>>> import numpy as np
>>> pi = narx.blocks.Pi(proportional=0.5, integral=20.0, step_rate=1000, minimum=0.0, maximum=24.0)
>>> voltage = pi.run(np.full(100, 3.0))

Values are floats in the units that each block names; they are rounded to its fixed point once, at the boundary, and what was really taken can be read
(`pi.integral`). `step` takes one value, `run` an array of shape (n,), a row per step. State goes on from call to call.
"""

from narx._core import (
    Commutation,
    Hall,
    HallReading,
    Pi,
    Ramp,
    Step,
    ZeroCrossing,
    ZeroCrossingReading,
)

__all__ = [
    "Commutation",
    "Hall",
    "HallReading",
    "Pi",
    "Ramp",
    "Step",
    "ZeroCrossing",
    "ZeroCrossingReading",
]
