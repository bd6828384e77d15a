"""Ports (RM0440, section 9)."""

from stm32g4.registers import Peripheral

INPUT, OUTPUT, ALTERNATE, ANALOG = range(4)
LOW, HIGH, OPEN = 0, 1, None


class Port(Peripheral):
    """GPIOx. `levels` has what drives a pin from outside."""

    def __init__(self, chip: object, letter: str) -> None:
        place = "ABC".index(letter)
        super().__init__(chip, f"GPIO{letter}", 0x4800_0000 + 0x400 * place)
        every = 0xFFFF_FFFF
        start = {"A": 0xABFF_FFFF, "B": 0xFFFF_FEBF, "C": every}[letter]
        self.modes = self.register(0x00, "MODER", every, value=start)
        # Push-pull.
        self.register(0x04, "OTYPER", 0x0)
        self.register(0x08, "OSPEEDR", every, value=0x0C00_0000 if letter == "A" else 0)
        self.pulls = self.register(0x0C, "PUPDR", every, value={"A": 0x6400_0000, "B": 0x100}.get(letter, 0))
        self.read_only(0x10, "IDR", self._input)
        self.outputs = self.register(0x14, "ODR", 0xFFFF)
        self.write_only(0x18, "BSRR", every, self._set)
        self.functions = [self.register(0x20, "AFRL", every), self.register(0x24, "AFRH", every)]
        self.letter = letter

    def _set(self, value: int) -> None:
        self.outputs.value = self.outputs.value & ~(value >> 16) | value & 0xFFFF

    def mode(self, pin: int) -> int:
        return self.modes.value >> 2 * pin & 3

    def function(self, pin: int) -> int | None:
        """Alternate function of a pin; None if it has none."""
        if self.modes.value >> 2 * pin & 3 != ALTERNATE:
            return None
        return self.functions[pin >> 3].value >> 4 * (pin & 7) & 0xF

    def output(self, pin: int) -> int | None:
        """Level that a pin drives; None if it drives none."""
        return self.outputs.value >> pin & 1 if self.mode(pin) == OUTPUT else OPEN

    def _input(self) -> int:
        value = 0
        outside = self.chip.levels(self.letter)
        modes, pulls = self.modes.value, self.pulls.value
        for pin in range(16):
            mode = modes >> 2 * pin & 3
            if mode == ANALOG:
                continue
            if mode == OUTPUT:
                level = self.outputs.value >> pin & 1
            elif (level := outside.get(pin)) is None:
                level = pulls >> 2 * pin & 3 == 1
            value |= level << pin
        return value
