"""Signals of traces: descriptions, and the enumerations of those that are codes."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import Any

from narx import _core
from narx._core import State, Step

# Of type Any, because a type checker cannot see members that are made at run time.
_flags: Any = IntFlag
Fault: type[IntFlag] = _flags("Fault", {name.upper(): bit for name, bit in _core.fault_bits()}, module=__name__)
Fault.__doc__ = "Bits of the fault word (section 9, Table 9 of the specification)."


class Limiter(IntEnum):
    """Limit that determines the voltage in a tick."""

    OFF = 0
    """The bridge is off."""
    FIXED = 1
    """A fixed level: rotor lock or open loop."""
    SPEED = 2
    """The speed loop, without a limit."""
    CURRENT = 3
    """The bus current limit."""
    PHASE_CURRENT = 4
    POWER = 5
    TEMPERATURE = 6
    """The derating by temperature."""
    DUTY = 7
    """The largest duty cycle."""
    SLEW = 8
    """The slew limit of the duty cycle."""
    RETURN = 9
    """The bus must not be fed: the motor coasts."""
    FADE = 10
    """The voltage fades over zero crossings that were not seen."""


class Crossing(IntEnum):
    """Outcome of a step's zero crossing (parameter 287)."""

    NONE = 0
    ACCEPTED = 1
    TOO_EARLY = 2
    NOT_SEEN = 3
    HIDDEN = 4
    """Hidden by demagnetisation."""
    COASTING = 5
    """Observed while the bridge was off."""


ENUMS: dict[str, type[IntEnum] | type[IntFlag]] = {
    "state": State, "step": Step, "limiter": Limiter, "crossing": Crossing, "faults": Fault
}  # fmt: skip
"""Enumeration of each signal that is a code."""

DESCRIPTIONS = {
    "time": "end of the control tick, since power-up",
    "setpoint": "set-point of the speed loop, behind its ramp",
    "speed": "true mechanical speed at the end of the tick",
    "speed_estimated": "mechanical speed that the drive estimates, of hall sensors or back-EMF",
    "state": "state of the drive (narx.State)",
    "sector": "true electrical sector of the rotor, 0 to 5",
    "duty": "duty cycle of the switched leg, 0 to 1",
    "current_a": "current into phase A at the end of the tick",
    "current_b": "current into phase B at the end of the tick",
    "current_c": "current into phase C at the end of the tick",
    "bus_current": "mean of the tick, through the shunt between bus capacitor and bridge",
    "bus_voltage": "voltage of the bus capacitor at the end of the tick, before the on-time of the next one",
    "torque": "electromagnetic torque without cogging and friction, mean of the tick",
    "voltage_a": "voltage of terminal A against ground at the end of the tick",
    "voltage_b": "voltage of terminal B against ground at the end of the tick",
    "voltage_c": "voltage of terminal C against ground at the end of the tick",
    "angle": "true electrical angle of the rotor, 0 to 360",
    "hall": "levels of the hall lines, A is bit 0",
    "step": "switch pattern (narx.blocks.Step)",
    "limiter": "limit that determines the voltage (narx.Limiter)",
    "faults": "bits of the fault word (narx.Fault)",
    "position": "mechanical angle of the shaft since power-up",
    "energy_in": "energy of the ideal source since power-up, before the supply's own resistance",
    "energy_shaft": "electrical energy turned into mechanical energy since power-up, before friction",
    "winding_temperature": "temperature of the winding",
    "peak_current": "largest magnitude of a phase current in the tick, ripple included",
    "crossing": "outcome of the last step's zero crossing (narx.Crossing)",
    "crossing_margin": "distance of the last zero crossing from the end of its window",
    "bus_voltage_measured": "bus voltage that the drive has measured",
    "bus_current_measured": "bus current that the drive has measured",
    "voltage_a_measured": "voltage of terminal A that the drive has measured",
    "voltage_b_measured": "voltage of terminal B that the drive has measured",
    "voltage_c_measured": "voltage of terminal C that the drive has measured",
    "electrical_setpoint": "set-point of the speed loop, electrical revolutions",
    "electrical_speed_hall": "speed by the hall sensors, electrical revolutions",
    "electrical_speed_sensorless": "speed by the back-EMF, electrical revolutions",
}
"""Description of each signal of a run and of a replay."""
