"""Registers: what the model knows of each, and what stops a run."""

from collections.abc import Callable

SECOND = 408_000_000_000
"""Units of time in a second: clocks of 170, 150, 85, 75, 24, 16 and 8 MHz have whole numbers of them."""
NANOSECOND = SECOND // 1_000_000_000
NEVER = 1 << 62


class Stopped(Exception):
    """An access or a state that the chip has no defined behaviour for, or that the model does not know."""


class Register:
    """A word of a peripheral. `known`: bits that the model knows; a 1 in any other one stops the run."""

    def __init__(
        self,
        peripheral: "Peripheral",
        name: str,
        known: int,
        value: int = 0,
        read: Callable[[], int] | None = None,
        write: Callable[[int], None] | None = None,
    ) -> None:
        self.peripheral, self.name, self.known, self.value = peripheral, name, known, value
        self._read, self._write = read, write
        self.wrong_read: Callable[[int], int] | None = None
        """A deliberate fault of the driver: changes what it reads."""
        self.wrong_write: Callable[[int], int] | None = None
        """A deliberate fault of the driver: changes what it writes."""

    def read(self) -> int:
        value = self.value if self._read is None else self._read()
        return value if self.wrong_read is None else self.wrong_read(value)

    def write(self, value: int) -> None:
        if self.wrong_write is not None:
            value = self.wrong_write(value)
        if value & ~self.known:
            raise Stopped(f"{self}: writes {value:#010x}, of which the model knows {self.known:#010x}")
        if self._write is None:
            self.value = value
        else:
            self._write(value)

    def __str__(self) -> str:
        return f"{self.peripheral.name}.{self.name}"


class Peripheral:
    """A peripheral with its registers. Its next event is at `due`; `step` carries it out."""

    due = NEVER
    takes_halfwords = False
    """Its registers are read and written as half-words, too."""

    def __init__(self, chip: "object", name: str, base: int) -> None:
        self.chip, self.name, self.base = chip, name, base
        self.is_clocked = True
        self.registers: dict[str, Register] = {}

    def register(
        self,
        offset: int,
        name: str,
        known: int,
        value: int = 0,
        read: Callable[[], int] | None = None,
        write: Callable[[int], None] | None = None,
    ) -> Register:
        register = Register(self, name, known, value, read, write)
        self.registers[name] = register
        self.chip.map[self.base + offset] = register
        return register

    def read_only(self, offset: int, name: str, read: Callable[[], int]) -> Register:
        def refuse(value: int) -> None:
            raise Stopped(f"{self.name}.{name} is read-only")

        return self.register(offset, name, 0xFFFF_FFFF, read=read, write=refuse)

    def write_only(self, offset: int, name: str, known: int, write: Callable[[int], None]) -> Register:
        return self.register(offset, name, known, read=lambda: 0, write=write)

    def step(self) -> None:
        """Carries out the event that is due, and tells the chip when the next one is."""

    def undefined(self, what: str) -> None:
        raise Stopped(f"{self.name}: {what}")
