"""A model of the STM32G4 as the images of two boards see it, and the boards around it.

The processor is executed instruction by instruction (unicorn); a peripheral is a file here. Registers cite the
section of ST's reference manual RM0440. An access that the model does not know stops the run with its address and
the source line.
"""

from stm32g4.chip import Chip
from stm32g4.registers import SECOND, Stopped

__all__ = ["SECOND", "Chip", "Stopped"]
