"""The drive's blocks one by one, for teaching, tests and other drives. They are the code of the drive and
compute the same bits.

>>> import numpy as np
>>> pi = narx.blocks.Pi(proportional=0.5, integral=20.0, step_rate=1000, minimum=0.0, maximum=24.0)
>>> voltage = pi.run(np.full(100, 3.0))

Values are floats in the units that each block names. They are rounded once to the block's fixed point; the
rounded value can be read (`pi.integral`). `step` takes one value, `run` an array of shape (n,), a row per
step. The state is kept from call to call.
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
